//! Welding of vertices: by position, and by position and normal.

use glam::Vec3;
use pelage_import::mesh::RestPose;

/// Distance of positions that count as the same, as a share of the radius of the bounding sphere.
const SAME_POSITION: f32 = 1e-5;
/// Cosine of the angle between normals above which vertices at the same position are one: 60°. Beyond it, the surface
/// has a hard edge, which contours must not cross.
const SAME_NORMAL: f32 = 0.5;

/// Welded vertices of a mesh at rest.
#[derive(Clone, Debug, Default)]
pub(super) struct Weld {
    /// Index of the position of each vertex; equal for vertices at the same position.
    pub(super) places: Vec<u32>,
    /// Number of different positions.
    pub(super) place_count: usize,
    /// Representative of each vertex: a vertex at the same position with a similar normal.
    pub(super) representatives: Vec<u32>,
}

impl Weld {
    /// `radius`: radius of the bounding sphere, metres.
    pub(super) fn new(rest: &RestPose, radius: f32) -> Self {
        let cell = if radius > 0.0 { SAME_POSITION * radius } else { 1.0 };
        let key = |p: &Vec3| p.to_array().map(|x| (f64::from(x) / f64::from(cell)).round() as i64);
        let mut order: Vec<([i64; 3], u32)> = rest.positions.iter().map(key).zip(0..).collect();
        order.sort_unstable();
        let count = order.len();
        let mut weld = Self { places: vec![0; count], place_count: 0, representatives: vec![0; count] };
        for group in order.chunk_by(|a, b| a.0 == b.0) {
            for (_, v) in group {
                weld.places[*v as usize] = weld.place_count as u32;
            }
            weld.place_count += 1;
            weld.choose_representatives(group.iter().map(|(_, v)| *v), rest);
        }
        weld
    }

    /// Splits the vertices of one position by their normals. In each group, the vertex nearest to the mean normal is
    /// the representative.
    fn choose_representatives(&mut self, vertices: impl Iterator<Item = u32>, rest: &RestPose) {
        let normal = |v: u32| rest.normals[v as usize];
        let mut groups: Vec<(Vec3, Vec<u32>)> = Vec::new();
        for v in vertices {
            match groups.iter_mut().find(|(_, members)| normal(members[0]).dot(normal(v)) > SAME_NORMAL) {
                Some((sum, members)) => {
                    *sum += normal(v);
                    members.push(v);
                }
                None => groups.push((normal(v), vec![v])),
            }
        }
        for (sum, members) in groups {
            let best = members
                .iter()
                .copied()
                .max_by(|a, b| normal(*a).dot(sum).total_cmp(&normal(*b).dot(sum)).then_with(|| b.cmp(a)));
            for v in &members {
                self.representatives[*v as usize] = best.unwrap_or(*v);
            }
        }
    }
}
