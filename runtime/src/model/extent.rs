//! How far a posed model reaches, without looking at its vertices every frame.

use crate::bounds::Hull;
use glam::{Mat4, Vec3};
use pelage_formats::MeshView;

/// Extent of a model's skin before its joints move it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Extent {
    /// Without skeleton: a box.
    Rigid(Box),
    /// With a skeleton: for each joint the box of the vertices that follow it, in mesh space, empty where none does. A blended vertex lies
    /// between where its joints put it, so the boxes, moved by their joints, hold it.
    Jointed(Vec<Box>),
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
            return Self::Rigid(points().fold(Box::EMPTY, Box::with));
        }
        let mut boxes = Vec::new();
        for (point, skin) in points().zip(mesh.skin()) {
            for (joint, _) in skin.joints.into_iter().zip(skin.weights).filter(|(_, weight)| *weight > 0.0) {
                let joint = usize::from(joint);
                boxes.resize(boxes.len().max(joint + 1), Box::EMPTY);
                boxes[joint] = boxes[joint].with(point);
            }
        }
        Self::Jointed(boxes)
    }

    /// Adds the posed skin in world space to `hull`, grown by `margin_m` of model space.
    pub(crate) fn add_to(&self, hull: &mut Hull, joints: &[Mat4], world_from_model: Mat4, margin_m: f32) {
        let axes = [world_from_model.x_axis, world_from_model.y_axis, world_from_model.z_axis];
        let scale = axes.map(|axis| axis.truncate().length()).into_iter().fold(0.0, f32::max);
        let mut add = |matrix: Mat4, bounds: &Box| {
            let corners = bounds.corners().map(|corner| (world_from_model * matrix).transform_point3(corner));
            // An empty box has no corners; of a joint that is not finite nothing is drawn either.
            hull.0.extend(corners.into_iter().filter(|c| c.is_finite()).map(|c| (c, margin_m * scale)));
        };
        match self {
            Self::Rigid(bounds) => add(Mat4::IDENTITY, bounds),
            Self::Jointed(boxes) => joints.iter().zip(boxes).for_each(|(matrix, bounds)| add(*matrix, bounds)),
        }
    }
}
