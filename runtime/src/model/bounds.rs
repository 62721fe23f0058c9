//! Bounds of a posed model, computed without reading its vertices in every frame.

use crate::bounds::Hull;
use glam::{Mat4, Vec3};
use pelage_formats::{MeshView, MorphDelta, Morphs, Pose};

/// Bounds of a model's mesh surface before the joint transforms are applied.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ModelBounds {
    /// Bounding box of a model without a skeleton.
    Rigid(Aabb),
    /// Bounds per joint of a model with a skeleton. A skinned vertex is a weighted mean of its positions under single
    /// joints, so the union of the transformed boxes contains it.
    Jointed(Vec<JointBounds>),
}

/// Bounds of the vertices that follow a joint, in mesh space.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct JointBounds {
    /// Box of these vertices with morph targets at rest; empty if no vertex follows the joint.
    vertices: Aabb,
    /// Morph targets in ascending order, each with the bounds of its vertices' offsets at weight 1. These bounds
    /// contain the origin, because other vertices do not move.
    moves: Vec<(u32, Aabb)>,
}

/// Axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Aabb {
    min: Vec3,
    max: Vec3,
}

impl Aabb {
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

impl JointBounds {
    const NOTHING: Self = Self { vertices: Aabb::EMPTY, moves: Vec::new() };

    fn add(&mut self, point: Vec3, deltas: &[MorphDelta]) {
        self.vertices = self.vertices.with(point);
        for delta in deltas {
            let at = self.moves.binary_search_by_key(&delta.target, |(target, _)| *target).unwrap_or_else(|at| {
                self.moves.insert(at, (delta.target, Aabb::EMPTY.with(Vec3::ZERO)));
                at
            });
            self.moves[at].1 = self.moves[at].1.with(delta.position.into());
        }
    }

    /// Returns the box of the vertices with morph targets displaced by `shifts` from rest; without targets, the box at
    /// rest.
    fn shifted(&self, shifts: &[f32]) -> Aabb {
        let shift_of = |target: u32| shifts.get(target as usize).copied().unwrap_or(0.0);
        self.moves.iter().fold(self.vertices, |all, (target, reach)| {
            let ends = [reach.min, reach.max].map(|end| end * shift_of(*target));
            Aabb { min: all.min + ends[0].min(ends[1]), max: all.max + ends[0].max(ends[1]) }
        })
    }
}

impl ModelBounds {
    /// Returns the bounds of a mesh and its morph targets. `jointed`: the mesh follows a skeleton.
    pub(crate) fn of(mesh: &MeshView<'_>, morphs: Option<&Morphs>, jointed: bool) -> Self {
        let points = || mesh.geometry().map(|v| Vec3::from(v.position));
        if !jointed {
            return Self::Rigid(points().fold(Aabb::EMPTY, Aabb::with));
        }
        let mut joints: Vec<JointBounds> = Vec::new();
        for (vertex, (point, skin)) in points().zip(mesh.skin()).enumerate() {
            let deltas = morphs.map_or(&[][..], |morphs| morphs.of_vertex(vertex));
            for (joint, _) in skin.joints.into_iter().zip(skin.weights).filter(|(_, weight)| *weight > 0.0) {
                let joint = usize::from(joint);
                joints.resize(joints.len().max(joint + 1), JointBounds::NOTHING);
                joints[joint].add(point, deltas);
            }
        }
        Self::Jointed(joints)
    }

    /// Adds the bounds of the posed surface in world space to `hull`, widened by `margin_m`, which is in model space.
    pub(crate) fn add_to(&self, hull: &mut Hull, pose: &Pose, world_from_model: Mat4, margin_m: f32) {
        let axes = [world_from_model.x_axis, world_from_model.y_axis, world_from_model.z_axis];
        let scale = axes.map(|axis| axis.truncate().length()).into_iter().fold(0.0, f32::max);
        let mut add = |matrix: Mat4, bounds: Aabb| {
            let corners = bounds.corners().map(|corner| (world_from_model * matrix).transform_point3(corner));
            // An empty box gives no corners; with a non-finite joint, nothing is drawn either.
            hull.0.extend(corners.into_iter().filter(|c| c.is_finite()).map(|c| (c, margin_m * scale)));
        };
        match self {
            Self::Rigid(bounds) => add(Mat4::IDENTITY, *bounds),
            Self::Jointed(joints) => {
                pose.joints.iter().zip(joints).for_each(|(matrix, joint)| add(*matrix, joint.shifted(&pose.shifts)));
            }
        }
    }
}
