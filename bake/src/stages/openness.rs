//! Openness: share of all directions in which the body does not occlude the hair at rest. Rays from the hair tips at
//! each vertex find where ears, legs and belly occlude the hair, and how far light wraps around rounded parts.
//!
//! The occluder is the mesh surface raised by half the height of its hair, which is about how deep light enters fur.

use super::triangle_tree::Occluders;
use glam::Vec3;
use obvhs::triangle::Triangle;
use pelage_formats::meaning::openness::Openness;
use pelage_formats::meaning::{normalize_or, posed, skin_matrix, tile_frame, to_tile};
use pelage_formats::{Animation, MeshData};
use pelage_import::mesh::RestPose;
use rayon::prelude::*;
use std::collections::HashMap;

/// Limits of the number of rays: maximum per vertex, minimum per vertex, and maximum for all vertices together.
const RAYS: (usize, usize, usize) = (128, 24, 4_000_000);
/// Golden angle, radians. Directions along a spiral with this step are distributed evenly over a sphere.
const GOLDEN_ANGLE: f32 = 2.399_963_2;
/// Height of the occluder above the mesh surface, as a share of the hair's height.
const HIDES_TO: f32 = 0.5;
/// Height above bare skin at which a ray begins, as a share of the model's radius.
const AWAY: f32 = 1e-3;

/// Returns the openness of each vertex, with the triangles of the mesh as occluders. `hides` returns whether a triangle
/// occludes; triangles with holes cut by a texture should not.
pub fn openness(mesh: &MeshData, animation: Option<&Animation>, hides: impl Fn(usize) -> bool) -> Vec<Openness> {
    let pose = animation.map(RestPose::pose).unwrap_or_default();
    let at_rest: Vec<_> = mesh
        .geometry
        .iter()
        .enumerate()
        .map(|(i, stored)| mesh.skin.get(i).map_or(*stored, |skin| posed(stored, skin_matrix(&pose, skin))))
        .map(|v| (Vec3::from(v.position), normalize_or(v.normal.into(), Vec3::Y), v.fur_height, v.tangent))
        .map(|(place, normal, height, tangent)| AtRest {
            tip: place + normal * height,
            hides: place + normal * (HIDES_TO * height),
            normal,
            tangent,
        })
        .collect();
    let facet = |corners: &[u32]| {
        let [a, b, c] = [corners[0], corners[1], corners[2]].map(|i| at_rest[i as usize].hides.into());
        Triangle { v0: a, v1: b, v2: c }
    };
    let facets: Vec<Triangle> = mesh
        .indices
        .chunks_exact(3)
        .enumerate()
        .filter(|(number, _)| hides(*number))
        .map(|(_, corners)| facet(corners))
        .collect();
    if facets.is_empty() {
        return vec![Openness::default(); at_rest.len()];
    }
    let occluders = Occluders::new(&facets);
    // Vertices of several patches share a position: each position is evaluated once.
    let mut numbers: HashMap<[u32; 6], usize> = HashMap::new();
    let mut places = Vec::new();
    let place_of: Vec<usize> = at_rest
        .iter()
        .map(|AtRest { tip, normal, .. }| {
            let [x, y, z] = tip.to_array().map(f32::to_bits);
            let [u, v, w] = normal.to_array().map(f32::to_bits);
            *numbers.entry([x, y, z, u, v, w]).or_insert_with(|| {
                places.push((*tip, *normal));
                places.len() - 1
            })
        })
        .collect();
    let rays = (RAYS.2 / places.len().max(1)).clamp(RAYS.1, RAYS.0);
    let ways = directions(rays);
    let (low, high) = places
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), (place, _)| (low.min(*place), high.max(*place)));
    let away = AWAY * (0.5 * (high - low).length());
    let found: Vec<(f32, Vec3)> =
        places.par_iter().map(|(place, normal)| open_share(&occluders, *place, *normal, &ways, away)).collect();
    at_rest
        .iter()
        .zip(place_of)
        .map(|(AtRest { normal, tangent: [x, y, z, handedness], .. }, place)| {
            let (share, middle) = found[place];
            let frame = tile_frame(*normal, Vec3::new(*x, *y, *z), *handedness);
            let mut middle = to_tile(frame, middle);
            middle.z = middle.z.max(0.0);
            let middle = normalize_or(middle, Vec3::Z);
            Openness { share, tangential: [middle.x, middle.y] }
        })
        .collect()
}

/// Vertex in the rest pose, and its hair.
struct AtRest {
    tip: Vec3,
    /// Position of the vertex on the occluder.
    hides: Vec3,
    normal: Vec3,
    tangent: [f32; 4],
}

/// Returns the share of all directions that is open from a point, and the unit vector along the mean of the open
/// directions.
fn open_share(occluders: &Occluders, place: Vec3, normal: Vec3, ways: &[Vec3], away: f32) -> (f32, Vec3) {
    let (along, across) = normal.any_orthonormal_pair();
    // The ray begins slightly above the surface, so that the surface occludes the directions below it.
    let from = place + normal * away;
    let mut middle = Vec3::ZERO;
    let mut open = 0;
    for way in ways {
        let way = along * way.x + across * way.y + normal * way.z;
        if occluders.is_open(from, way) {
            open += 1;
            middle += way;
        }
    }
    (open as f32 / ways.len() as f32, normalize_or(middle, normal))
}

/// Returns unit directions, evenly distributed by solid angle.
fn directions(count: usize) -> Vec<Vec3> {
    let direction = |i: usize| {
        let z = 1.0 - 2.0 * (i as f32 + 0.5) / count as f32;
        let (sin, cos) = libm::sincosf(GOLDEN_ANGLE * i as f32);
        let radius = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(radius * cos, radius * sin, z)
    };
    (0..count).map(direction).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_formats::GeometryVertex;

    /// Makes a mesh of points with normals and of triangles.
    fn mesh(points: &[([f32; 3], [f32; 3])], indices: &[u32]) -> MeshData {
        let vertex = |(position, normal): &([f32; 3], [f32; 3])| GeometryVertex {
            position: *position,
            normal: *normal,
            tangent: Vec3::from(*normal).any_orthonormal_vector().extend(1.0).into(),
            ..GeometryVertex::default()
        };
        MeshData { geometry: points.iter().map(vertex).collect(), indices: indices.to_vec(), ..MeshData::default() }
    }

    #[test]
    fn wall_hides_half_of_the_sky_at_its_foot() {
        // The point is on a floor beside a wall. Both are large enough to count as infinite.
        let (up, aside) = ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0]);
        let points = [
            ([0.05, 0.0, 0.0], up),
            ([0.0, 0.0, -100.0], aside),
            ([0.0, 0.0, 100.0], aside),
            ([0.0, 100.0, 100.0], aside),
            ([0.0, 100.0, -100.0], aside),
            ([100.0, 0.0, -100.0], up),
            ([100.0, 0.0, 100.0], up),
            ([-100.0, 0.0, -100.0], up),
            ([-100.0, 0.0, 100.0], up),
        ];
        let mesh = mesh(&points, &[1, 2, 3, 1, 3, 4, 7, 8, 6, 7, 6, 5]);
        let found = openness(&mesh, None, |_| true);
        assert!((found[0].share - 0.25).abs() < 0.03, "{:?}", found[0]);
        // A quarter of all directions is open, so their mean points midway between floor and wall.
        let frame = tile_frame(Vec3::Y, Vec3::from_slice(&mesh.geometry[0].tangent), 1.0);
        let middle = found[0].vector().normalize();
        assert!((middle.dot(to_tile(frame, Vec3::X)) - std::f32::consts::FRAC_1_SQRT_2).abs() < 0.05, "{middle}");
        // Without occluders, everything is open; a floor alone occludes half of all directions.
        assert_eq!(openness(&mesh, None, |_| false)[0], Openness::default());
        let floor = openness(&mesh, None, |triangle| triangle > 1)[0];
        assert!((floor.share - 0.5).abs() < 0.02 && floor.tangential.iter().all(|x| x.abs() < 0.05), "{floor:?}");
    }

    #[test]
    fn openness_on_a_ball_matches_the_formula_and_is_zero_inside() {
        let mut points = Vec::new();
        // The mesh is fine enough for its facets to be close to the ball.
        let (rings, around) = (48, 64);
        for ring in 0..=rings {
            for k in 0..around {
                let (sin, cos) = (std::f32::consts::PI * ring as f32 / rings as f32).sin_cos();
                let (s, c) = (std::f32::consts::TAU * k as f32 / around as f32).sin_cos();
                let place = [sin * c, cos, sin * s];
                points.push((place, place));
            }
        }
        let mut indices = Vec::new();
        for ring in 0..rings {
            for k in 0..around {
                let [a, b] = [ring * around + k, ring * around + (k + 1) % around];
                indices.extend([a, b, a + around, b, b + around, a + around]);
            }
        }
        points.push(([0.1, 0.2, 0.0], [0.0, 1.0, 0.0]));
        let mut ball = mesh(&points, &indices);
        let outside = |found: &[Openness]| found[around as usize..(rings * around) as usize].to_vec();
        let found = openness(&ball, None, |_| true);
        assert!(outside(&found).iter().all(|of| (of.share - 0.5).abs() < 0.04), "{found:?}");
        // A ray that hits an edge may pass between its triangles.
        assert!(found.last().expect("points").share < 0.01);
        // Hair is as high as half the ball's radius, so tips are at radius 1.5 and the occluder is at 1.25.
        ball.geometry.iter_mut().for_each(|vertex| vertex.fur_height = 0.5);
        let dip = (1.0 - (1.25_f32 / 1.5).powi(2)).sqrt();
        let found = openness(&ball, None, |_| true);
        assert!(outside(&found).iter().all(|of| (of.share - 0.5 * (1.0 + dip)).abs() < 0.05), "{dip} {found:?}");
    }
}
