use super::*;

/// Makes a strip of squares along x in the xy plane, 0.1 m per side, with two triangles per square. A separate triangle
/// is one metre above the middle of the strip.
fn strip(squares: u32) -> Topology {
    let mut points: Vec<DVec3> =
        (0..=squares).flat_map(|i| [0.0, 0.1].map(|y| DVec3::new(0.1 * f64::from(i), y, 0.0))).collect();
    let mut faces: Vec<[u32; 3]> =
        (0..squares).flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 1], [2 * i + 2, 2 * i + 3, 2 * i + 1]]).collect();
    let alone = points.len() as u32;
    let middle = 0.05 * f64::from(squares);
    points.extend([[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]].map(|[x, y]| DVec3::new(middle + x, y, 1.0)));
    faces.push([alone, alone + 1, alone + 2]);
    let edge = |f: usize, k: usize| [faces[f][k], faces[f][(k + 1) % 3]];
    let twin = |[a, b]: [u32; 2]| {
        let all = || (0..faces.len()).flat_map(|f| (0..3).map(move |k| (f, k)));
        all().find(|(f, k)| edge(*f, *k) == [b, a]).map_or(u32::MAX, |(f, k)| (3 * f + k) as u32)
    };
    let twins = (0..faces.len()).flat_map(|f| (0..3).map(move |k| (f, k))).map(|(f, k)| twin(edge(f, k))).collect();
    Topology::new(points, faces, twins)
}

fn mark(places: &[(Vec3, Vec3)], reach_m: Option<f32>) -> CombMark {
    CombMark { name: "m".into(), places: places.to_vec(), reach_m }
}

#[test]
fn mark_with_a_reach_fades_to_the_default_direction() {
    let skin = strip(40);
    let marks = [mark(&[(Vec3::new(2.0, 0.05, 0.01), Vec3::Y)], Some(0.8))];
    let mut warnings = Vec::new();
    let wishes = spread(&skin, &marks, Vec3::X, &mut warnings);
    let at = |x: f64| wishes[2 * (x / 0.1) as usize];
    assert!(at(2.0).y > 0.999 && at(2.1).y > 0.99, "{} {}", at(2.0), at(2.1));
    assert!((0.1..0.9).contains(&at(2.4).y) && at(2.4).y > at(2.5).y, "{} {}", at(2.4), at(2.5));
    assert_eq!([at(0.5), at(3.5)], [DVec3::X; 2]);
    assert_eq!(wishes[80], DVec3::X, "the triangle apart is a metre away");
    // With this reach, the mark also affects the separate triangle, straight through space.
    let far = spread(&skin, &[mark(&[(Vec3::new(2.0, 0.05, 0.01), Vec3::Y)], Some(4.0))], Vec3::X, &mut warnings);
    assert!(far[80].y > 0.9, "{}", far[80]);
    assert_eq!(warnings, [""; 0]);
}

#[test]
fn nearest_direction_of_a_line_applies() {
    let skin = strip(40);
    let line = [(Vec3::new(1.0, 0.0, 0.0), Vec3::Y), (Vec3::new(3.0, 0.0, 0.0), Vec3::NEG_Y)];
    let wishes = spread(&skin, &[mark(&line, Some(0.4))], Vec3::X, &mut Vec::new());
    assert!(wishes[20].y > 0.999 && wishes[60].y < -0.999 && wishes[40] == DVec3::X);
}

#[test]
fn marks_with_a_reach_override_marks_without() {
    let skin = strip(40);
    let marks = [
        mark(&[(Vec3::new(0.5, 0.0, 0.0), Vec3::Y)], None),
        mark(&[(Vec3::new(3.5, 0.0, 0.0), Vec3::NEG_Y)], Some(0.4)),
    ];
    let wishes = spread(&skin, &marks, Vec3::X, &mut Vec::new());
    assert!(wishes[2].y > 0.999 && wishes[40].y > 0.999, "as far as there is no other: {}", wishes[40]);
    assert!(wishes[70].y < -0.999, "{}", wishes[70]);
}

#[test]
fn nearest_face_agrees_with_an_exhaustive_search() {
    let skin = strip(40);
    let faces = Faces::new(&skin);
    for k in 0..200 {
        let at = DVec3::new(f64::from(k) * 0.03 - 1.0, f64::from(k % 7) * 0.1 - 0.3, f64::from(k % 5) * 0.3);
        let away = |f: &u32| faces.centers[*f as usize].distance_squared(at);
        let all = (0..faces.centers.len() as u32).min_by(|a, b| away(a).total_cmp(&away(b)));
        assert_eq!(faces.nearest(at), all, "{at}");
    }
}

#[test]
fn mark_along_the_normal_is_reported() {
    let mut warnings = Vec::new();
    let up = mark(&[(Vec3::new(2.0, 0.05, 0.0), Vec3::Z)], Some(0.5));
    spread(&strip(40), &[up], Vec3::X, &mut warnings);
    assert!(matches!(&warnings[..], [one] if one.contains("\"m\"") && one.contains("normal")), "{warnings:?}");
}
