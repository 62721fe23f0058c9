use super::*;
use crate::stability::surface::{grid, sphere};
use glam::vec3;

#[test]
fn points_are_distributed_by_area() {
    let model = sphere(24, 48);
    let rest = RestPose::of(&model.mesh, None);
    let points = spread(&rest, &model.mesh.triangles, 4000);
    assert_eq!(points.len(), 4000);
    // Archimedes: slices of a sphere of equal height have equal areas.
    for slice in 0..8 {
        let range = -1.0 + 0.25 * slice as f32..-0.75 + 0.25 * slice as f32;
        let share = points.iter().filter(|p| range.contains(&p.position_ws.y)).count() as f32 / 4000.0;
        assert!((share - 0.125).abs() < 0.01, "{range:?}: {share}");
    }
    for p in &points {
        assert!((p.position_ws.length() - 1.0).abs() < 0.02 && p.normal_ws.dot(p.face_ws) > 0.99);
        assert!(p.face_ws.dot(p.position_ws) > 0.99);
    }
    assert!(spread(&RestPose::default(), &[], 10).is_empty());
}

#[test]
fn iterated_distances_saturate_at_the_pass_count() {
    let (size, passes) = (32, 6);
    let inside = |x: usize, y: usize| x >= 10 && (4..28).contains(&y);
    let occluded: Vec<bool> = (0..size * size).map(|i| inside(i % size, i / size)).collect();
    let distances = iterated_distances(&occluded, size, passes);
    let at = |x: usize, y: usize| distances[y * size + x];
    assert_eq!([at(9, 16), at(10, 16), at(12, 16), at(15, 16), at(20, 16), at(31, 16)], [0.0, 1.0, 3.0, 6.0, 6.0, 6.0]);
    assert_eq!([at(20, 3), at(20, 4), at(20, 6)], [0.0, 1.0, 3.0]);
    // The lit area is a square in the corner of the map. From its convex corner, the shortest path into the shadow is
    // diagonal.
    let hole: Vec<bool> = (0..size * size).map(|i| i % size > 4 || i / size > 4).collect();
    let distances = iterated_distances(&hole, size, passes);
    assert!((distances[7 * size + 7] - 3.0 * std::f32::consts::SQRT_2).abs() < 1e-5);
}

#[test]
fn points_inside_the_model_are_excluded() {
    let mut model = sphere(24, 48);
    let outside = SampledSurface::new(&model).unwrap_or_else(|e| panic!("{e}")).points.len();
    assert_eq!(outside as u32, POINTS);
    // Adds a ball of half the radius inside the first one. It has a quarter of the first ball's area.
    let inner = model.mesh.clone();
    let first = model.mesh.positions.len() as u32;
    model.mesh.positions.extend(inner.positions.iter().map(|p| *p * 0.5));
    model.mesh.normals.extend(inner.normals);
    model.mesh.triangles.extend(inner.triangles.iter().map(|t| t.map(|i| i + first)));
    let seen = SampledSurface::new(&model).unwrap_or_else(|e| panic!("{e}")).points;
    assert!((f64::from(seen.len() as u32) / f64::from(POINTS) - 0.8).abs() < 0.01, "{}", seen.len());
    assert!(seen.iter().all(|p| p.position_ws.length() > 0.9));
}

#[test]
fn width_map_of_the_paper_is_half_at_a_straight_edge() {
    // The edge is between two texels of the reduced map, and the size is not a multiple of `shrink`.
    let (size, shrink) = (30, 4);
    let occluded: Vec<bool> = (0..size * size).map(|i| i % size >= 16).collect();
    let map = paper_width(&occluded, size, shrink);
    let row = |y: usize| &map[y * size..][..size];
    assert!((0.5 * (row(10)[15] + row(10)[16]) - 0.5).abs() < 1e-6, "{:?}", row(10));
    assert!(row(10).is_sorted() && row(10) == row(29));
    assert_eq!([row(3)[13], row(3)[18], row(3)[29]], [0.0, 1.0, 1.0]);
    assert!(row(3)[14] > 0.0 && row(3)[17] < 1.0);
}

/// Checks that a shape that casts no shadow on itself is fully lit. A ring must have umbra, penumbra and full light.
#[test]
fn reference_shadows_of_a_ball_and_a_ring_are_correct() {
    let light = vec3(0.2, 0.9, 0.1).normalize();
    let ball = SampledSurface::new(&sphere(24, 48)).unwrap_or_else(|e| panic!("{e}"));
    let truth = ball.truth(light, 0.1);
    let hidden: Vec<f64> = truth.iter().copied().filter(|share| *share < 1.0).collect();
    assert!(truth.len() > 1000 && hidden.is_empty(), "{} points, hidden {hidden:?}", truth.len());
    let torus = grid(96, 48, |a, b| glam::Quat::from_rotation_y(a) * vec3(1.0 + 0.4 * b.cos(), 0.4 * b.sin(), 0.0));
    let ring = SampledSurface::new(&torus).unwrap_or_else(|e| panic!("{e}"));
    let truth = ring.truth(vec3(1.0, 0.3, 0.0).normalize(), 0.1);
    let count = |range: std::ops::RangeInclusive<f64>| truth.iter().filter(|s| range.contains(s)).count();
    let (umbra, penumbra, lit) = (count(0.0..=UMBRA), count(PENUMBRA[0]..=PENUMBRA[1]), count(1.0..=1.0));
    assert!(umbra > 20 && penumbra > 20 && lit > 500, "{umbra} in the umbra, {penumbra} in the penumbra, {lit} lit");
    let mut measured = SoftShadowErrors::default();
    measured.add(&truth, &truth);
    let number = |x: Option<f64>| x.unwrap_or(f64::NAN);
    assert_eq!((number(measured.all.rmse()), number(measured.shadow.rmse())), (0.0, 0.0));
    assert!(number(measured.umbra.mean()) < UMBRA && measured.penumbra[0] == measured.penumbra[1]);
    // A method without any shadow lets all light into the umbra.
    let mut lit = SoftShadowErrors::default();
    lit.add(&vec![1.0; truth.len()], &truth);
    assert_eq!((number(lit.umbra.mean()), lit.penumbra[0]), (1.0, 0));
    assert!(number(lit.all.rmse()) > 0.1 && number(lit.shadow.rmse()) > number(lit.all.rmse()));
}

#[test]
fn soft_shadow_configurations_differ_and_rows_have_all_columns() {
    let all = configurations();
    assert_eq!((all[0].method, all[0].shadows), (Method::Centred, ShadowParams::default()));
    for (i, a) in all.iter().enumerate() {
        assert!(all[..i].iter().all(|b| b.shadows != a.shadows || b.method != a.method), "{a:?}");
        assert_eq!(cells(a, &SoftShadowErrors::default(), 1.0, "").len(), COLUMNS.len());
    }
    assert!(lights().iter().all(|l| l.is_normalized() && l.y > 0.5));
}
