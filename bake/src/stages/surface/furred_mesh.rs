//! Furred part of a repaired mesh.

use super::topology::{NONE, Topology};

/// Furred part of a repaired mesh.
pub(super) struct FurredMesh {
    pub(super) topology: Topology,
    /// Index of the mesh triangle of each face.
    pub(super) triangles: Vec<u32>,
}

impl FurredMesh {
    pub(super) fn new(whole: Topology, furred: &[bool]) -> Self {
        let triangles: Vec<u32> = (0..furred.len() as u32).filter(|t| furred[*t as usize]).collect();
        if triangles.len() == furred.len() {
            return Self { topology: whole, triangles };
        }
        let mut face_of = vec![NONE; furred.len()];
        triangles.iter().enumerate().for_each(|(f, t)| face_of[*t as usize] = f as u32);
        let twin = |h: u32| match whole.twins[h as usize] {
            NONE => NONE,
            twin if face_of[twin as usize / 3] == NONE => NONE,
            twin => 3 * face_of[twin as usize / 3] + twin % 3,
        };
        let faces = triangles.iter().map(|t| whole.faces[*t as usize]).collect();
        let twins = triangles.iter().flat_map(|t| (3 * t..3 * t + 3).map(twin)).collect();
        Self { topology: Topology::new(whole.points, faces, twins), triangles }
    }
}
