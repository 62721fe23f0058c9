//! Where the hair is combed to: wishes per face, before they are smoothed into a field.

use super::skin::Skin;
use super::topology::{Key, Topology};
use crate::mesh::Mesh;
use glam::{DVec3, Vec3};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Where hair is combed to. Directions are in world space at rest; what counts is their share along the skin.
#[derive(Clone, Debug, PartialEq)]
pub enum Comb {
    /// One direction everywhere, any length but 0.
    Direction(Vec3),
    /// Down: −y.
    Gravity,
    /// Along +v of the model's texture coordinates, which is down in a texture painted upright.
    Tangents,
    /// One vector per vertex of the input mesh; its length, up to 1, is how much it counts.
    PerVertex(Vec<Vec3>),
    /// Directions at a few places, spread over the surface by the way between (formulas 6.1, after Praun et al. 2000).
    Marks(Vec<CombMark>),
    /// No direction: patches lie as they distort least, which suits hair that stands up (the isotropic mode of Lengyel et al. 2001).
    None,
}

impl Comb {
    /// The unit direction that holds everywhere; zero where there is no such.
    pub fn everywhere(&self) -> Vec3 {
        match self {
            Self::Direction(direction) => direction.normalize_or_zero(),
            Self::Gravity => Vec3::NEG_Y,
            Self::Tangents | Self::PerVertex(_) | Self::Marks(_) | Self::None => Vec3::ZERO,
        }
    }
}

/// A direction at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct CombMark {
    /// Name, for messages.
    pub name: String,
    /// Place near the skin, world space at rest, metres.
    pub at: Vec3,
    /// Direction there, any length but 0.
    pub direction: Vec3,
}

/// One wish per face of the skin; lengths up to 1.
pub(super) fn wishes(
    skin: &Skin,
    mesh: &Mesh,
    input_vertex: &[u32],
    comb: &Comb,
    warnings: &mut Vec<String>,
) -> Vec<DVec3> {
    match comb {
        Comb::Direction(_) | Comb::Gravity | Comb::None => {
            vec![comb.everywhere().as_dvec3().normalize_or_zero(); skin.triangles.len()]
        }
        Comb::Marks(marks) => spread(&skin.topology, marks, warnings),
        Comb::PerVertex(vectors) => {
            let at = |v: u32| vectors.get(input_vertex[v as usize] as usize).copied().unwrap_or(Vec3::ZERO).as_dvec3();
            let mean = |t: &u32| mesh.triangles[*t as usize].map(at).into_iter().sum::<DVec3>() / 3.0;
            skin.triangles
                .iter()
                .map(mean)
                .map(|w| if w.is_finite() { w.clamp_length_max(1.0) } else { DVec3::ZERO })
                .collect()
        }
        Comb::Tangents => (0..skin.triangles.len())
            .map(|f| {
                let uv = mesh.triangles[skin.triangles[f] as usize].map(|v| mesh.uvs[v as usize].as_dvec2());
                let p = skin.topology.corners(f);
                let (d1, d2) = (uv[1] - uv[0], uv[2] - uv[0]);
                // dP/dv, and by its sign right for mirrored charts too.
                let along_v = (p[2] - p[0]) * d1.x - (p[1] - p[0]) * d2.x;
                (along_v * d1.perp_dot(d2).signum()).normalize_or_zero()
            })
            .collect(),
    }
}

/// Shepard's inverse-distance weights with distances along the skin; other components measure straight through space.
fn spread(topology: &Topology, marks: &[CombMark], warnings: &mut Vec<String>) -> Vec<DVec3> {
    let n = topology.faces.len();
    let mut sums = vec![DVec3::ZERO; n];
    let mut weights = vec![0.0; n];
    let centers: Vec<DVec3> = (0..n).map(|f| topology.centroid(f)).collect();
    for mark in marks {
        let (at, direction) = (mark.at.as_dvec3(), mark.direction.as_dvec3().normalize_or_zero());
        let nearest =
            (0..n).min_by(|a, b| centers[*a].distance_squared(at).total_cmp(&centers[*b].distance_squared(at)));
        let Some(start) = nearest else { return sums };
        if direction.reject_from(topology.normals[start]).length() < 0.1 {
            warnings.push(format!(
                "surface.comb_marks: {:?} points along the skin's normal where it stands; its direction has hardly an effect",
                mark.name
            ));
        }
        let ways = ways_from(topology, &centers, start);
        for f in 0..n {
            let way = if ways[f].is_finite() { ways[f] } else { centers[f].distance(at) };
            let weight = 1.0 / (way * way).max(1e-12);
            sums[f] += direction * weight;
            weights[f] += weight;
        }
    }
    sums.iter().zip(weights).map(|(sum, weight)| if weight > 0.0 { *sum / weight } else { DVec3::ZERO }).collect()
}

/// Length of the shortest way over faces' centres from a face to each other; infinite where there is none.
fn ways_from(topology: &Topology, centers: &[DVec3], start: usize) -> Vec<f64> {
    let mut ways = vec![f64::INFINITY; centers.len()];
    ways[start] = 0.0;
    let mut heap = BinaryHeap::from([Reverse((Key(0.0), start))]);
    while let Some(Reverse((Key(way), f))) = heap.pop() {
        if way > ways[f] {
            continue;
        }
        for (_, g) in topology.neighbors(f) {
            let next = way + centers[f].distance(centers[g]);
            if next < ways[g] {
                ways[g] = next;
                heap.push(Reverse((Key(next), g)));
            }
        }
    }
    ways
}
