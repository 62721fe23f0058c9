//! How far a posed model reaches, without looking at its vertices every frame.

use crate::light_view::Sphere;
use glam::{Mat4, Vec3};
use pelage_formats::MeshView;

/// Extent of a model's skin before its joints move it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Extent {
    /// Without skeleton: a sphere.
    Rigid(Sphere),
    /// With a skeleton: for each joint the box of the vertices that follow it, in mesh space. A blended vertex lies between where its joints
    /// put it, so the boxes, moved by their joints, hold it.
    Jointed(Vec<(usize, Box)>),
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Box {
    min: Vec3,
    max: Vec3,
}

impl Box {
    const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    fn with(self, point: Vec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    fn corners(self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, axis: usize| if i & bit == 0 { self.min[axis] } else { self.max[axis] };
            Vec3::new(pick(1, 0), pick(2, 1), pick(4, 2))
        })
    }
}

impl Extent {
    /// Of a mesh; `jointed` where it follows a skeleton.
    pub(crate) fn of(mesh: &MeshView<'_>, jointed: bool) -> Self {
        let points = || mesh.geometry().map(|v| Vec3::from(v.position));
        if !jointed {
            let bounds = points().fold(Box::EMPTY, Box::with);
            let center = 0.5 * (bounds.min + bounds.max);
            let radius = points().map(|p| p.distance(center)).fold(0.0, f32::max);
            return Self::Rigid(if center.is_finite() {
                Sphere { center, radius }
            } else {
                Sphere { center: Vec3::ZERO, radius: 0.0 }
            });
        }
        let mut boxes: Vec<(usize, Box)> = Vec::new();
        for (point, skin) in points().zip(mesh.skin()) {
            for (joint, weight) in skin.joints.into_iter().zip(skin.weights) {
                if weight <= 0.0 {
                    continue;
                }
                let joint = usize::from(joint);
                match boxes.iter_mut().find(|(j, _)| *j == joint) {
                    Some((_, bounds)) => *bounds = bounds.with(point),
                    None => boxes.push((joint, Box::EMPTY.with(point))),
                }
            }
        }
        Self::Jointed(boxes)
    }

    /// The sphere about the posed skin in world space, grown by `margin_m` of model space.
    pub(crate) fn sphere(&self, joints: &[Mat4], world_from_model: Mat4, margin_m: f32) -> Sphere {
        let (center, radius) = match self {
            Self::Rigid(sphere) => (sphere.center, sphere.radius),
            Self::Jointed(boxes) => {
                let moved = boxes.iter().filter_map(|(joint, bounds)| Some((joints.get(*joint)?, bounds)));
                let corners = moved.flat_map(|(matrix, b)| b.corners().map(|c| matrix.transform_point3(c)));
                let bounds = corners.filter(|c| c.is_finite()).fold(Box::EMPTY, Box::with);
                let size = (bounds.max - bounds.min).max(Vec3::ZERO);
                let center = bounds.min + 0.5 * size;
                if center.is_finite() { (center, 0.5 * size.length()) } else { (Vec3::ZERO, 0.0) }
            }
        };
        let scale = [world_from_model.x_axis, world_from_model.y_axis, world_from_model.z_axis]
            .map(|axis| axis.truncate().length())
            .into_iter()
            .fold(0.0, f32::max);
        Sphere { center: world_from_model.transform_point3(center), radius: (radius + margin_m) * scale }
    }
}
