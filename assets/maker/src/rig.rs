//! Skeletons built from bones: joints in rest pose, skin weights, and keys of clips.

use std::collections::BTreeSet;

use glam::{DQuat, DVec3};

use super::{
    glb::{Channel, Interpolation, Joint, Target, Weights},
    trimesh::TriMesh,
};

/// Returns weights bound to one joint only.
pub const fn bound_to(joint: u8) -> Weights {
    [(joint, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)]
}

/// Bone: the segment of the body that a joint moves.
#[derive(Clone, Copy, Debug)]
pub struct Bone {
    /// Name of its joint.
    pub name: &'static str,
    /// Index of the parent bone, which comes earlier.
    pub parent: Option<u8>,
    /// Position of the joint, metres.
    pub from: DVec3,
    /// Position of the far end, metres.
    pub to: DVec3,
    /// Radius of the flesh around the bone, metres. Surface points within this radius have distance 0 to the bone.
    pub thickness: f64,
}

impl Bone {
    /// Creates a bone from its joint `name` at `from` to its far end at `to`.
    pub const fn new(name: &'static str, parent: Option<u8>, from: DVec3, to: DVec3, thickness: f64) -> Self {
        Self { name, parent, from, to, thickness }
    }

    /// Returns the distance of `p` to the flesh, metres; 0 inside.
    fn distance(&self, p: DVec3) -> f64 {
        let along = self.to - self.from;
        let t = ((p - self.from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        ((p - (self.from + along * t)).length() - self.thickness).max(0.0)
    }
}

/// Returns the joints in rest pose. They have translations only, so every inverse bind matrix is a translation too.
pub fn skeleton(bones: &[Bone]) -> Vec<Joint> {
    let joint = |bone: &Bone| {
        let origin = bone.parent.map_or(DVec3::ZERO, |p| bones[p as usize].from);
        Joint {
            name: bone.name.into(),
            parent: bone.parent.map(usize::from),
            translation: bone.from - origin,
            world: bone.from,
        }
    };
    bones.iter().map(joint).collect()
}

/// Computes skin weights from the distance to each bone, metres. A bone's weight is 1 / (distance² + `softness`²)². The
/// normalised weights are then smoothed over the mesh `rounds` times.
pub fn weights(mesh: &TriMesh, bones: &[Bone], softness: f64, rounds: usize) -> Vec<Weights> {
    let own = |&p: &DVec3| {
        let near = |bone: &Bone| {
            let d = bone.distance(p);
            let d2 = d * d + softness * softness;
            1.0 / (d2 * d2)
        };
        let mut row: Vec<f64> = bones.iter().map(near).collect();
        normalise(&mut row);
        row
    };
    let mut dense: Vec<Vec<f64>> = mesh.positions.iter().map(own).collect();
    let mut rings = vec![BTreeSet::new(); mesh.positions.len()];
    for t in &mesh.triangles {
        for k in 0..3 {
            rings[t[k] as usize].insert(t[(k + 1) % 3] as usize);
        }
    }
    for _ in 0..rounds {
        dense = rings
            .iter()
            .zip(&dense)
            .map(|(ring, own)| {
                let mut row = own.clone();
                for &w in ring {
                    for (sum, x) in row.iter_mut().zip(&dense[w]) {
                        *sum += x;
                    }
                }
                normalise(&mut row);
                row
            })
            .collect();
    }
    dense.iter().map(|row| four_largest(row)).collect()
}

fn normalise(row: &mut [f64]) {
    let sum: f64 = row.iter().sum();
    for x in row {
        *x /= sum;
    }
}

fn four_largest(row: &[f64]) -> Weights {
    let mut order: Vec<usize> = (0..row.len()).collect();
    order.sort_by(|&a, &b| row[b].total_cmp(&row[a]));
    // Drops weights of at most one per cent, which have no visible effect.
    let kept: Vec<usize> = order.into_iter().take(4).filter(|&j| row[j] > 0.01).collect();
    let sum: f64 = kept.iter().map(|&j| row[j]).sum();
    let mut weights = [(0, 0.0); 4];
    for (slot, &j) in weights.iter_mut().zip(&kept) {
        *slot = (j as u8, row[j] / sum);
    }
    weights
}

/// Returns the rotation about a unit axis.
pub fn turn(axis: DVec3, degrees: f64) -> DQuat {
    let half = degrees * core::f64::consts::PI / 360.0;
    let (s, c) = (libm::sin(half), libm::cos(half));
    DQuat::from_xyzw(axis.x * s, axis.y * s, axis.z * s, c)
}

/// Creates linear rotation keys of a joint. `keys` are pairs of seconds and rotation.
pub fn rotations(joint: u8, keys: impl IntoIterator<Item = (f64, DQuat)>) -> Channel {
    let (times, turns): (Vec<f64>, Vec<DQuat>) = keys.into_iter().unzip();
    Channel {
        joint: joint.into(),
        target: Target::Rotation,
        interpolation: Interpolation::Linear,
        times,
        values: turns.iter().flat_map(DQuat::to_array).collect(),
    }
}
