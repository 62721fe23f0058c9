#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
use super::*;
use glam::DVec2;
use glam::{DVec3, Vec3};
use pelage_bake::strands::{PosedMaterial, PosedVertex};
use pelage_truth::Lens;

/// Returns a mesh surface of one material; normals point away from the origin.
fn skin(positions: &[DVec3], triangles: &[[u32; 3]], double_sided: bool) -> PosedMesh {
    let vertex = |p: &DVec3| PosedVertex {
        position_ws: *p,
        normal_ws: p.normalize_or(DVec3::Z),
        color: glam::Vec4::ONE,
        ..PosedVertex::default()
    };
    PosedMesh {
        measured_ws: Vec::new(),
        vertices: positions.iter().map(vertex).collect(),
        same_place: (0..positions.len() as u32).collect(),
        triangles: triangles.to_vec(),
        material_of: vec![0; triangles.len()],
        materials: vec![PosedMaterial { base_color: glam::Vec4::ONE, double_sided, ..PosedMaterial::default() }],
    }
}

/// Returns a box whose faces share no vertices, as with hard normals.
fn cuboid(center: DVec3, half: DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let mut normal = DVec3::ZERO;
            normal[axis] = sign;
            let (mut u, mut v) = (DVec3::ZERO, DVec3::ZERO);
            u[(axis + 1) % 3] = 1.0;
            v[(axis + 2) % 3] = sign;
            let base = positions.len() as u32;
            positions.extend([-u - v, u - v, u + v, v - u].map(|corner| center + (normal + corner) * half));
            triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
        }
    }
    (positions, triangles)
}

fn sphere(rings: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let sectors = 2 * rings;
    let mut positions = Vec::new();
    for i in 0..=rings {
        for j in 0..=sectors {
            let (theta, phi) = (
                f64::from(i) * std::f64::consts::PI / f64::from(rings),
                f64::from(j % sectors) * std::f64::consts::TAU / f64::from(sectors),
            );
            // All vertices of a pole have one position, and the last column has the positions of the first, so the
            // surface is closed.
            let ring = if i == 0 || i == rings { 0.0 } else { theta.sin() };
            positions.push(DVec3::new(ring * phi.cos(), theta.cos(), -ring * phi.sin()));
        }
    }
    let at = |i: u32, j: u32| i * (sectors + 1) + j;
    let quads = (0..rings).flat_map(|i| (0..sectors).map(move |j| (i, j)));
    let triangles = quads
        .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]);
    (positions.clone(), triangles.collect())
}

fn both(a: (Vec<DVec3>, Vec<[u32; 3]>), b: (Vec<DVec3>, Vec<[u32; 3]>)) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let shift = a.0.len() as u32;
    let triangles = a.1.into_iter().chain(b.1.into_iter().map(|t| t.map(|v| v + shift))).collect();
    ([a.0, b.0].concat(), triangles)
}

/// Returns a camera that shows four metres of the plane through the origin on a hundred pixels.
fn camera(eye: Vec3) -> TrueCamera {
    TrueCamera { eye_ws: eye, target_ws: Vec3::ZERO, up_ws: Vec3::Y, lens: Lens::Orthographic { height_m: 4.0 } }
}

const SIZE: (u32, u32) = (100, 100);

fn seen(mesh: &(Vec<DVec3>, Vec<[u32; 3]>), eye: Vec3) -> VisibleLines {
    seen_with(mesh, eye, &LineParams::default(), false)
}

fn seen_with(mesh: &(Vec<DVec3>, Vec<[u32; 3]>), eye: Vec3, params: &LineParams, double_sided: bool) -> VisibleLines {
    let lines = TrueLines::new(skin(&mesh.0, &mesh.1, double_sided)).unwrap();
    lines.visible_from(&camera(eye), SIZE, params).unwrap()
}

/// Returns the lengths of all kinds in the order of [`LineKind::ALL`], metres.
fn lengths(lines: &VisibleLines) -> [f64; 4] {
    LineKind::ALL.map(|kind| lines.length_px(kind) / 25.0)
}

#[track_caller]
fn near(found: [f64; 4], expected: [f64; 4], within: f64) {
    assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() <= within), "{found:?}, expected {expected:?}");
}

#[test]
fn a_cube_shows_its_outline_and_three_creases() {
    let cube = cuboid(DVec3::ZERO, DVec3::ONE);
    // Seen along the space diagonal, all edges are equally foreshortened. Six form the outline, three meet in the
    // middle, and three are hidden.
    let edge = 2.0 * (2.0f64 / 3.0).sqrt();
    near(lengths(&seen(&cube, Vec3::splat(5.0))), [6.0 * edge, 0.0, 3.0 * edge, 0.0], 0.05);
    // Faces seen edge-on count as facing away. From slightly to the side, one crease appears, and the outline has six
    // edges again.
    near(lengths(&seen(&cube, Vec3::new(0.0, 0.0, 5.0))), [8.0, 0.0, 0.0, 0.0], 0.05);
    let (s, c) = (1.0f64 / 26f64.sqrt(), 5.0f64 / 26f64.sqrt());
    near(lengths(&seen(&cube, Vec3::new(1.0, 0.0, 5.0))), [4.0 + 4.0 * (s + c), 0.0, 2.0, 0.0], 0.05);
    // With a crease angle above that of the cube's edges, only the outline is left.
    let blunt = LineParams { crease_deg: 91.0, ..LineParams::default() };
    near(lengths(&seen_with(&cube, Vec3::splat(5.0), &blunt, false)), [6.0 * edge, 0.0, 0.0, 0.0], 0.05);
    let lines = seen(&cube, Vec3::splat(5.0));
    assert!(lines.mask(&[LineKind::Crease]).contains(50, 50) && !lines.mask(&[LineKind::Silhouette]).contains(50, 50));
}

#[test]
fn invalid_crease_angles_are_refused() {
    let lines = TrueLines::new(PosedMesh::default()).unwrap();
    for crease_deg in [-1.0, 181.0, f64::NAN] {
        let params = LineParams { crease_deg, ..LineParams::default() };
        let error = lines.visible_from(&camera(Vec3::Z), SIZE, &params).unwrap_err().to_string();
        assert!(error.contains("crease_deg") && error.contains("0..=180"), "{error}");
    }
    assert!(lines.visible_from(&camera(Vec3::Z), SIZE, &LineParams::default()).unwrap().segments.is_empty());
}

#[test]
fn hidden_lines_are_removed() {
    let (small, large) = (DVec3::splat(0.5), DVec3::new(1.5, 1.5, 0.1));
    // In front of a plate, the outline of a small cube is a contour. Behind the plate, the cube is hidden.
    let before = both(cuboid(DVec3::Z, small), cuboid(DVec3::ZERO, large));
    near(lengths(&seen(&before, Vec3::new(0.0, 0.0, 5.0))), [12.0, 4.0, 0.0, 0.0], 0.05);
    let behind = both(cuboid(DVec3::NEG_Z, small), cuboid(DVec3::ZERO, large));
    near(lengths(&seen(&behind, Vec3::new(0.0, 0.0, 5.0))), [12.0, 0.0, 0.0, 0.0], 0.05);
    // The cube behind the plate protrudes sideways by 0.4 m. One metre of the plate's edge in front of the cube is a
    // contour.
    let aside = both(cuboid(DVec3::new(1.4, 0.0, -1.0), small), cuboid(DVec3::ZERO, large));
    near(lengths(&seen(&aside, Vec3::new(0.0, 0.0, 5.0))), [11.0 + 1.8, 1.0, 0.0, 0.0], 0.05);
}

#[test]
fn sphere_outline_is_a_circle_from_edges_and_from_normals() {
    let ball = sphere(32);
    let eye = Vec3::new(1.0, 2.0, 4.5);
    let round = std::f64::consts::TAU;
    let middle = DVec2::splat(50.0);
    let radii = |lines: &VisibleLines| {
        let ends = lines.segments.iter().flat_map(|s| [s.from_px, s.to_px]);
        ends.fold((f64::INFINITY, 0.0f64), |(least, most), p| {
            (least.min(p.distance(middle)), most.max(p.distance(middle)))
        })
    };
    let edges = seen(&ball, eye);
    let [silhouette, contour, crease, border] = lengths(&edges);
    // The poles' triangles and the seam are neither creases nor borders. The contour edges zigzag around the circle.
    assert!((silhouette + contour) / round > 0.99 && (silhouette + contour) / round < 1.3, "{silhouette} {contour}");
    assert_eq!((crease, border), (0.0, 0.0));
    let (least, most) = radii(&edges);
    assert!(least > 24.5 && most <= 25.0 + 1e-9, "distances from the centre: {least} to {most} pixels");

    let params = LineParams { contour: ContourForm::Interpolated, ..LineParams::default() };
    let smooth = seen_with(&ball, eye, &params, false);
    let [silhouette, contour, ..] = lengths(&smooth);
    assert!(((silhouette + contour) / round - 1.0).abs() < 0.02, "{silhouette} {contour}");
    let (least, most) = radii(&smooth);
    assert!(least > 24.5 && most <= 25.0 + 1e-9, "distances from the centre: {least} to {most} pixels");
    // Every pixel of each mask is within 1.5 pixels of the other mask.
    let (a, b) = (edges.mask(&LineKind::ALL), smooth.mask(&LineKind::ALL));
    let far = |of: &Mask, to: &Mask| {
        let distances = to.distances();
        of.pixels.iter().zip(distances).filter(|(set, _)| **set).map(|(_, d)| d).fold(0.0, f64::max)
    };
    assert!(far(&a, &b) <= 1.5 && far(&b, &a) <= 1.5, "{} {}", far(&a, &b), far(&b, &a));
}

#[test]
fn open_edges_are_border_lines() {
    let square = (
        vec![
            DVec3::new(-1.0, -1.0, 0.0),
            DVec3::new(1.0, -1.0, 0.0),
            DVec3::new(1.0, 1.0, 0.0),
            DVec3::new(-1.0, 1.0, 0.0),
        ],
        vec![[0, 1, 2], [0, 2, 3]],
    );
    let (front, back) = (Vec3::new(0.0, 0.0, 5.0), Vec3::new(0.0, 0.0, -5.0));
    near(lengths(&seen(&square, front)), [0.0, 0.0, 0.0, 8.0], 0.05);
    // From behind, the square is not visible unless its material is double-sided.
    near(lengths(&seen(&square, back)), [0.0; 4], 0.0);
    let params = LineParams::default();
    near(lengths(&seen_with(&square, back, &params, true)), [0.0, 0.0, 0.0, 8.0], 0.05);
    // Two sheets back to back share every edge position but are still two sheets, so none of their inner edges is a
    // line. At the outer edges, their faces are paired as the two sides of a leaf.
    let mut leaf = square.clone();
    leaf.1.extend(square.1.iter().map(|t| [t[0], t[2], t[1]]));
    let found = lengths(&seen(&leaf, front));
    near(found, [8.0, 0.0, 0.0, 0.0], 0.05);
    // A triangle without area between two others does not make a gap.
    let mut sliver = square;
    sliver.1.push([0, 2, 2]);
    near(lengths(&seen(&sliver, front)), [0.0, 0.0, 0.0, 8.0], 0.05);
}

#[test]
fn perspective_enlarges_near_lines_and_clips_behind_the_camera() {
    let cube = cuboid(DVec3::ZERO, DVec3::ONE);
    let lines = TrueLines::new(skin(&cube.0, &cube.1, false)).unwrap();
    let look = |eye: Vec3, target: Vec3| {
        let lens = Lens::Perspective { fov_y_rad: 1.0 };
        lines
            .visible_from(
                &TrueCamera { eye_ws: eye, target_ws: target, up_ws: Vec3::Y, lens },
                SIZE,
                &LineParams::default(),
            )
            .unwrap()
    };
    // Only the near face is visible, 4 m in front of the eye.
    let front = look(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO);
    let scale = 50.0 / (0.5f64.tan() * 4.0);
    assert!((front.length_px(LineKind::Silhouette) - 8.0 * scale).abs() < 1.0, "{front:?}");
    assert!(look(Vec3::new(0.0, 0.0, 5.0), Vec3::new(0.0, 0.0, 9.0)).segments.is_empty());
    // From a close viewpoint, edges run past the eye and out of the picture; only the parts inside it are visible.
    let near = look(Vec3::new(1.2, 1.3, 0.4), Vec3::new(0.9, 1.0, -0.5));
    assert!(!near.segments.is_empty());
    let inside = |p: DVec2| (-1e-6..=100.0 + 1e-6).contains(&p.x) && (-1e-6..=100.0 + 1e-6).contains(&p.y);
    assert!(near.segments.iter().all(|s| inside(s.from_px) && inside(s.to_px)), "{near:?}");
}
