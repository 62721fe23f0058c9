#![allow(missing_docs, clippy::unwrap_used, reason = "a test fails by panicking")]
//! Tests of the `surface` stage on meshes small enough to compute results by hand.

use glam::{Vec2, Vec3, vec2, vec3};
use pelage_bake::stages::surface::{Comb, Source, Surface, SurfaceParams, parameterize};
use pelage_import::BakeError;
use pelage_import::mesh::{Material, Mesh, MeshPart, Model};

/// Returns a model without shared vertices, as exporters without indices write it: three separate vertices per
/// triangle.
fn model(corners: &[(Vec3, Vec2)], normal: Vec3) -> Model {
    let n = corners.len();
    let mesh = Mesh {
        positions: corners.iter().map(|c| c.0).collect(),
        normals: vec![normal; n],
        uvs: corners.iter().map(|c| c.1).collect(),
        colors: vec![[255; 4]; n],
        triangles: (0..n as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        parts: vec![MeshPart {
            source: "mesh 0 \"body\", primitive 0".into(),
            names: Vec::new(),
            material: 0,
            first_triangle: 0,
            triangle_count: n / 3,
            has_uvs: true,
        }],
        ..Mesh::default()
    };
    let material = Material { name: "Coat".into(), ..Material::default() };
    Model { mesh, materials: vec![material], ..Model::default() }
}

fn own_uvs(tile_size_m: f32, furred: bool) -> SurfaceParams {
    let comb = Comb::Tangents;
    SurfaceParams { tile_size_m, furred: vec![furred], source: Source::Model, comb, ..SurfaceParams::default() }
}

fn surface(model: &Model) -> Surface {
    parameterize("m.glb", model, &own_uvs(0.25, true)).unwrap()
}

/// Returns a unit square in the plane z = 0 that faces +z; `uv` gives the texture coordinates.
fn square(uv: impl Fn(f32, f32) -> Vec2) -> Model {
    let corner = |x: f32, y: f32| (vec3(x, y, 0.0), uv(x, y));
    let corners = [corner(0., 0.), corner(1., 0.), corner(1., 1.), corner(0., 0.), corner(1., 1.), corner(0., 1.)];
    model(&corners, Vec3::Z)
}

#[test]
fn equal_corners_are_merged_and_the_tile_has_the_requested_size() {
    let s = surface(&square(|x, y| vec2(x, y) * 3.0));
    assert_eq!(s.mesh.positions.len(), 4, "the six corners have four positions");
    let (a, b) = (s.mesh.triangles[0][0] as usize, s.mesh.triangles[0][1] as usize);
    // A metre of the mesh surface is four tiles of 0.25 m, whatever the texture coordinates are.
    assert!(((s.tile_uvs[b] - s.tile_uvs[a]).length() - 4.0).abs() < 1e-5);
    for (tangent, normal) in s.tangents.iter().zip(&s.mesh.normals) {
        assert!((tangent.truncate() - Vec3::X).length() < 1e-6 && tangent.w == 1.0, "{tangent}");
        assert_eq!(*normal, Vec3::Z);
    }
    assert_eq!((s.measures.patches, s.measures.flipped_triangles), (1, 0));
    assert!(s.warnings.is_empty(), "{:?}", s.warnings);
}

#[test]
fn gltf_texture_coordinates_give_upright_frames() {
    // v points down, as in a painted texture, so the coordinates are mirrored when viewed from outside.
    let s = surface(&square(|x, y| vec2(x, 1.0 - y)));
    assert_eq!(s.measures.flipped_triangles, 0);
    for t in &s.tangents {
        assert_eq!(t.w, 1.0);
        // +v points down on the surface. With the normal towards the viewer, +u then points left.
        assert!((t.truncate() + Vec3::X).length() < 1e-6, "{t}");
    }
}

#[test]
fn mirrored_halves_get_their_own_frames() {
    // Both halves of the strip share the texture, as on most animals: u = |x|.
    let corner = |x: f32, y: f32| (vec3(x, y, 0.0), vec2(x.abs(), y));
    let mut corners =
        vec![corner(0., 0.), corner(2., 0.), corner(2., 1.), corner(0., 0.), corner(2., 1.), corner(0., 1.)];
    corners.extend([corner(-1., 0.), corner(0., 0.), corner(0., 1.), corner(-1., 0.), corner(0., 1.), corner(-1., 1.)]);
    let s = surface(&model(&corners, Vec3::Z));
    assert_eq!(s.mesh.positions.len(), 8, "the two vertices on the mirror line exist once for each side");
    for triangle in &s.mesh.triangles {
        let x: f32 = triangle.iter().map(|i| s.mesh.positions[*i as usize].x).sum();
        for i in triangle {
            let t = s.tangents[*i as usize];
            assert_eq!(t.w, x.signum(), "handedness");
            assert!((t.truncate() - Vec3::X * x.signum()).length() < 1e-6, "u grows away from the mirror line");
        }
    }
    assert_eq!(s.measures.flipped_triangles, 2);
    assert!(s.warnings.iter().any(|w| w.contains("33 %") && w.contains("mirrored")), "{:?}", s.warnings);
}

#[test]
fn normals_agree_across_hard_edges() {
    // The faces are two flat-shaded sides of a cube that meet at the edge x = 1, z = 0.
    let f = |p: Vec3| (p, vec2(p.x - p.z, p.y));
    let (a, b, c) = (vec3(0., 0., 0.), vec3(1., 0., 0.), vec3(1., 1., 0.));
    let mut m = model(&[f(a), f(b), f(c), f(b), f(vec3(1., 0., -1.)), f(c)], Vec3::Z);
    m.mesh.normals[3..].fill(Vec3::X);
    let s = surface(&m);
    let at_edge: Vec<Vec3> =
        (0..s.mesh.positions.len()).filter(|i| s.mesh.positions[*i] == b).map(|i| s.mesh.normals[i]).collect();
    assert!(at_edge.len() == 2 && at_edge[0] == at_edge[1], "{at_edge:?}");
    assert!((at_edge[0].length() - 1.0).abs() < 1e-6 && at_edge[0].x > 0.3 && at_edge[0].z > 0.3);
}

#[test]
fn a_furred_part_without_texture_coordinates_is_named() {
    let mut m = square(vec2);
    m.mesh.parts[0].has_uvs = false;
    let error = parameterize("m.glb", &m, &own_uvs(0.1, true)).unwrap_err();
    let text = error.to_string();
    assert!(matches!(error, BakeError::Input { .. }));
    for word in ["m.glb", "body", "primitive 0", "texture coordinates", "Coat", "model.bare"] {
        assert!(text.contains(word), "{text}");
    }
    assert!(parameterize("m.glb", &m, &own_uvs(0.1, false)).is_ok());
}

#[test]
fn collapsed_texture_coordinates_stay_finite() {
    let s = surface(&square(|_, _| vec2(0.5, 0.5)));
    assert!(s.tile_uvs.iter().all(|uv| uv.is_finite()) && s.tangents.iter().all(|t| t.is_finite()));
    for (t, n) in s.tangents.iter().zip(&s.mesh.normals) {
        assert!((t.truncate().length() - 1.0).abs() < 1e-5 && t.truncate().dot(*n).abs() < 1e-5);
    }
    assert!(s.warnings.iter().any(|w| w.contains("no area")), "{:?}", s.warnings);
}
