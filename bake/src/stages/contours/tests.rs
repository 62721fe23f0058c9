use super::*;
use crate::stages::fixtures::{ball, on_threads, part};
use crate::stages::groom::Colors;
use glam::{Vec2, Vec3};
use pelage_formats::{ContourMark, CreasePoint, PaintStroke, StrokeAnchor, StrokeKind, StrokePoint, StrokePool};
use pelage_import::mesh::{Mesh, RestPose};
use std::collections::BTreeMap;

fn contours_of(mesh: &Mesh) -> ContourMesh {
    contours_with(mesh, None)
}

fn contours_with(mesh: &Mesh, painting: Option<&StrokePool>) -> ContourMesh {
    let rest = RestPose { positions: mesh.positions.clone(), normals: mesh.normals.clone() };
    let radius = rest.positions.iter().map(|p| p.length()).fold(0.0, f32::max);
    let colors = Colors {
        materials: vec![crate::stages::groom::MaterialColor { factor: [0.2140, 0.2140, 0.2140, 1.0], image: None }],
        vertices: vec![[255; 4]; mesh.positions.len()],
        hair: vec![None],
        ..Colors::default()
    };
    let furred = &[false];
    contour_mesh(&ContourTarget {
        mesh,
        rest: &rest,
        radius,
        colors: &colors,
        furred,
        animation: None,
        ink: &[],
        painting,
    })
}

fn sphere() -> Mesh {
    let mut mesh = ball(24, 32);
    mesh.parts = vec![part(0, 0, mesh.triangles.len())];
    mesh
}

/// Returns a cube of edge 2 m with the normals of its faces.
fn cube() -> Mesh {
    let mut mesh = Mesh::default();
    for (axis, sign) in [(0, 1.0), (1, 1.0), (2, 1.0), (0, -1.0), (1, -1.0), (2, -1.0f32)] {
        let turn = |v: Vec3| match axis {
            0 => v,
            1 => Vec3::new(v.z, v.x, v.y),
            _ => Vec3::new(v.y, v.z, v.x),
        };
        let base = mesh.positions.len() as u32;
        for (y, z) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            mesh.positions.push(turn(Vec3::new(sign, sign * y, z)));
            mesh.normals.push(turn(Vec3::X * sign));
        }
        mesh.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
    }
    let count = mesh.positions.len();
    (mesh.uvs, mesh.colors) = (vec![Vec2::ZERO; count], vec![[255; 4]; count]);
    mesh.parts = vec![part(0, 0, mesh.triangles.len())];
    mesh
}

#[test]
fn closed_surface_has_two_faces_at_each_edge() {
    let contours = contours_of(&sphere());
    let mut uses = vec![[0; 2]; contours.edges.len()];
    for face in &contours.faces {
        for k in 0..3 {
            uses[face.edges[k] as usize][(face.flags >> k & 1) as usize] += 1;
        }
    }
    assert!(uses.iter().all(|uses| *uses == [1, 1]));
    assert_eq!(
        contours.edges.len() + 2,
        contours.faces.len() + (23 * 32 + 2),
        "Euler's formula for 23 rings and 2 poles"
    );
    assert!(contours.creases.is_empty());
    assert!((256..=1024).contains(&contours.most_nodes), "{}", contours.most_nodes);
    let mark = ContourMark { line: 255, emphasis: 0, darkness: 128, reserved: 0 };
    assert!(contours.marks.iter().all(|found| found.darkness.abs_diff(128) <= 1 && found.line == mark.line));
}

#[test]
fn contours_do_not_depend_on_threads() {
    let mesh = sphere();
    assert!(on_threads(1, || contours_of(&mesh)) == on_threads(4, || contours_of(&mesh)));
}

#[test]
fn cube_has_its_twelve_edges_as_creases() {
    let contours = contours_of(&cube());
    assert_eq!((contours.edges.len(), contours.faces.len()), (6 * 5, 12), "faces of a cube share no edges");
    let ends = contours.creases.iter().filter(|point| point.next == CreasePoint::NONE).count();
    assert_eq!(ends, 12);
    assert!(contours.creases.iter().all(|point| point.kind == CreasePoint::SHARP));
    assert_eq!(contours.creases.len(), 12 * (2.0f32 / (0.02 * 3f32.sqrt())).ceil() as usize + 12);
}

#[test]
fn boundary_of_a_hole_is_one_closed_line() {
    let mut mesh = sphere();
    // The first 64 triangles are the northern cap.
    mesh.triangles.drain(..64);
    mesh.parts = vec![part(0, 0, mesh.triangles.len())];
    let creases = contours_of(&mesh).creases;
    assert!(!creases.is_empty() && creases.iter().all(|point| point.kind == CreasePoint::BOUNDARY));
    let mut at = 0;
    let mut seen = BTreeMap::new();
    while seen.insert(at, ()).is_none() {
        at = creases[at as usize].next;
    }
    assert_eq!((at, seen.len()), (0, creases.len()));
}

#[test]
fn edge_of_three_faces_is_stored_twice() {
    let mut mesh = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z],
        normals: vec![Vec3::ONE.normalize(); 5],
        triangles: vec![[0, 1, 2], [1, 0, 3], [0, 1, 4], [2, 2, 1]],
        ..Mesh::default()
    };
    (mesh.uvs, mesh.colors, mesh.parts) = (vec![Vec2::ZERO; 5], vec![[255; 4]; 5], vec![part(0, 0, 4)]);
    let contours = contours_of(&mesh);
    assert_eq!((contours.faces.len(), contours.edges.len()), (3, 8));
    assert_eq!(contours.edges.iter().filter(|edge| **edge == [0, 1]).count(), 2);
}

#[test]
fn lines_make_way_for_bone_strokes() {
    let mesh = sphere();
    let nearest = |p: Vec3| {
        let off = |v: &u32| mesh.positions[*v as usize].distance(p);
        (0..mesh.positions.len() as u32).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap()
    };
    // A stroke along a quarter of the equator, about a sixth of it wide.
    let points = (0..PaintStroke::POINTS).map(|i| {
        let angle = std::f32::consts::FRAC_PI_2 * i as f32 / (PaintStroke::POINTS - 1) as f32;
        let v = nearest(Vec3::new(angle.cos(), 0.0, angle.sin()));
        let anchor = StrokeAnchor { vertices: [v; 3], weights: [0; 2] };
        StrokePoint { sides: [anchor; 2], offset_m: None, half_width_m: 0.25, darkness: 0.0 }
    });
    let bone = PaintStroke { kind: StrokeKind::Bone, points: points.collect(), ..PaintStroke::default() };
    let mut pool = StrokePool { size_m: 2.0, strokes: vec![bone] };
    let line_at = |pool: &StrokePool, angle: f32| {
        let marks = contours_with(&mesh, Some(pool)).marks;
        marks[nearest(Vec3::new(angle.cos(), 0.0, angle.sin())) as usize].line
    };
    let [root, middle, tip, far] = [0.0, 0.8, 1.5, 3.0].map(|angle| line_at(&pool, angle));
    assert!(root > 100 && middle < 30 && tip < 60 && far == 255, "{root} {middle} {tip} {far}");
    pool.strokes[0].kind = StrokeKind::Dark;
    assert_eq!(line_at(&pool, 0.8), 255, "other strokes leave the lines");
}
