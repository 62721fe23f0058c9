//! Meshes, parts and nodes that several unit tests use.

use glam::{Vec2, Vec3};
use pelage_formats::Node;
use pelage_import::mesh::{Mesh, MeshPart};
use std::f32::consts::{PI, TAU};

/// Returns a part without names and texture coordinates.
pub(crate) fn part(material: usize, first_triangle: usize, triangle_count: usize) -> MeshPart {
    MeshPart { material, first_triangle, triangle_count, ..MeshPart::default() }
}

/// Returns a node at the origin of its parent.
pub(crate) fn node(name: &str, parent: Option<u32>) -> Node {
    let (translation, rotation, scale) = ([0.0; 3], [0.0, 0.0, 0.0, 1.0], [1.0; 3]);
    Node { name: name.into(), parent, translation, rotation, scale }
}

pub(crate) fn on_threads<T: Send>(threads: usize, run: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run)
}

/// Builds a sphere of radius 1 m with poles on the y axis, white, without texture coordinates and parts. The vertices
/// along one meridian are duplicated.
pub(crate) fn ball(rings: u32, sides: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for (i, j) in (0..=rings).flat_map(|i| (0..=sides).map(move |j| (i, j))) {
        let (a, b) = (PI * i as f32 / rings as f32, TAU * (j % sides) as f32 / sides as f32);
        mesh.positions.push(Vec3::new(a.sin() * b.sin(), a.cos(), a.sin() * b.cos()));
    }
    for (i, j) in (0..rings).flat_map(|i| (0..sides).map(move |j| (i, j))) {
        let at = |i: u32, j: u32| i * (sides + 1) + j;
        mesh.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
        mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
    }
    mesh.normals = mesh.positions.iter().map(|p| p.normalize()).collect();
    let n = mesh.positions.len();
    (mesh.uvs, mesh.colors) = (vec![Vec2::ZERO; n], vec![[255; 4]; n]);
    mesh
}

/// Appends a sphere of 12 rings with poles on the y axis, without its lowest `missing` rings.
pub(crate) fn add_ball(mesh: &mut Mesh, center: Vec3, radius: f32, missing: u32) {
    let (rings, sides) = (12u32, 12u32);
    let base = mesh.positions.len() as u32;
    for (i, j) in (0..=rings).flat_map(|i| (0..sides).map(move |j| (i, j))) {
        let (a, b) = (i as f32 / rings as f32 * PI, j as f32 / sides as f32 * TAU);
        let ring = if i == 0 || i == rings { 0.0 } else { a.sin() };
        mesh.positions.push(center + radius * Vec3::new(ring * b.cos(), a.cos(), ring * b.sin()));
        mesh.normals.push(Vec3::Y);
        let at = |i: u32, j: u32| base + i * sides + j % sides;
        if i < rings - missing {
            mesh.triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
            mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
}

/// Builds a torus about the y axis with radii 0.3 m and 0.12 m, white and without parts. With texture coordinates, it
/// is a single chart, cut along both circles.
pub(crate) fn torus(rings: u32, sides: u32, with_uvs: bool) -> Mesh {
    let mut mesh = Mesh::default();
    let seam = u32::from(with_uvs);
    for (i, j) in (0..rings + seam).flat_map(|i| (0..sides + seam).map(move |j| (i, j))) {
        let (s, t) = (i as f32 / rings as f32, j as f32 / sides as f32);
        let (a, b) = (s * TAU, t * TAU);
        let out = Vec3::new(a.cos(), 0.0, a.sin());
        let normal = out * b.cos() + Vec3::Y * b.sin();
        mesh.positions.push(out * 0.3 + normal * 0.12);
        mesh.normals.push(normal);
        mesh.uvs.push(if with_uvs { Vec2::new(s, t) } else { Vec2::ZERO });
    }
    mesh.colors = vec![[255; 4]; mesh.positions.len()];
    let wrap = |k: u32, n: u32| k % (n + seam);
    let at = |i: u32, j: u32| wrap(i, rings) * (sides + seam) + wrap(j, sides);
    for (i, j) in (0..rings).flat_map(|i| (0..sides).map(move |j| (i, j))) {
        mesh.triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
        mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
    }
    mesh
}
