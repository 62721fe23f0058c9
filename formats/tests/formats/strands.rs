//! The `STRN` section: round trip and rejected contents.

use crate::common::{Refusal, assert_refused, changed_sample_with, sample_manifest, sample_with, section_bytes};
use pelage_formats::*;

fn package(strands: &StrandsData) -> Result<Vec<u8>, FormatError> {
    sample_with(|writer| writer.strands(strands))
}

/// Returns two strands of three points, in two sets, because dry and wet hair are blended in the sample manifest.
fn strands() -> StrandsData {
    let point = |i: u32| StrandPoint {
        aside: [0.25 * i as f32, -0.5],
        height: 0.5 * (i % 3) as f32,
        radius: 0.01 - 0.005 * (i % 3) as f32,
        color: [10, 20, 30 + i as u8],
        visibility: [128, 127, 1, 255],
    };
    let sets = if sample_manifest().fur.wet.is_some() { 2 } else { 1 };
    StrandsData {
        points_per_strand: 3,
        roots: vec![[0.0, 0.999_99], [0.5, 0.25]],
        points: (0..6 * sets).map(point).collect(),
    }
}

#[test]
fn strands_survive_a_round_trip_within_their_precision() {
    let made = strands();
    let bytes = package(&made).unwrap();
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    let view = package.strands().unwrap().unwrap();
    assert_eq!((view.strand_count(), view.points_per_strand()), (2, 3));
    assert_eq!((view.has_wet(), view.points().len()), (made.points.len() == 12, made.points.len()));
    for (found, root) in view.roots().zip(&made.roots) {
        assert!((0..2).all(|k| (found[k] - root[k]).abs() < 1e-5), "{found:?}, expected {root:?}");
    }
    for (found, point) in view.points().zip(&made.points) {
        assert!((0..2).all(|k| (found.aside[k] - point.aside[k]).abs() <= view.reach() / 65534.0 * 1.01), "{found:?}");
        assert!((found.height - point.height).abs() < 1e-5 && (found.radius - point.radius).abs() < 1e-6, "{found:?}");
        assert_eq!((found.color, found.visibility), (point.color, point.visibility));
    }
    // Bytes that a reader in another language depends on.
    let section = section_bytes(&package, Tag::STRANDS);
    let sets = u32::from(view.has_wet()) + 1;
    let mut expected: Vec<u8> = [2u32, 3, sets, 0].into_iter().flat_map(u32::to_le_bytes).collect();
    let reach = 0.25 * (made.points.len() - 1) as f32;
    expected.extend([reach, 0.01, 0.0, 0.0].into_iter().flat_map(f32::to_le_bytes));
    expected.extend([0u16, 65535, 32768, 16384].into_iter().flat_map(u16::to_le_bytes));
    expected.resize(48, 0);
    let half = (-0.5 / reach * 32767.0).round() as i16;
    expected.extend([0i16, half].into_iter().flat_map(i16::to_le_bytes));
    expected.extend([0u16, 65535].into_iter().flat_map(u16::to_le_bytes));
    expected.extend([10, 20, 30, 0, 128, 127, 1, 255]);
    assert_eq!(section[..expected.len()], expected);
    assert_eq!(section.len(), 48 + 16 * made.points.len());
}

#[test]
fn strand_contents_are_checked() {
    let cases: [Refusal<StrandsData>; 8] = [
        (|s| s.roots.clear(), "for 0 strands of 3 points, expected one set or two"),
        (|s| s.points.truncate(s.points.len() - 1), "points for 2 strands of 3 points, expected one set or two"),
        (
            |s| (s.points_per_strand, s.roots, s.points) = (1, vec![[0.0; 2]], vec![s.points[0]; 2]),
            "of 1 points, expected",
        ),
        (
            |s| (s.points_per_strand, s.roots, s.points) = (34, vec![[0.0; 2]], vec![s.points[0]; 68]),
            "of 34 points, expected",
        ),
        (|s| s.roots[1][0] = 1.0, "a root is outside the tile"),
        (|s| s.points[2].aside[1] = f32::NAN, "a point is not finite"),
        (|s| s.points[2].height = 1.5, "outside the fur"),
        (|s| s.points[2].radius = -1.0, "outside the fur"),
    ];
    assert_refused(Tag::STRANDS, strands, &cases, package);
    let swap = |m: &mut Manifest| m.fur.wet = m.fur.wet.is_none().then(ShellTextures::default);
    let error = changed_sample_with(swap, |writer| writer.strands(&strands()));
    assert!(error.unwrap_err().to_string().contains("sets of points, expected"), "sets follow the manifest");
    let bytes = package(&strands()).unwrap();
    let few = Limits { strands: 1, ..Limits::default() };
    let found = Package::open(&bytes, &few).map(|package| package.strands().unwrap_err().to_string());
    assert!(found.is_ok_and(|found| found.contains("limit")), "strands are bounded");
}

#[test]
fn stored_strand_integers_survive_a_round_trip() {
    let bytes = package(&strands()).unwrap();
    let stored = Package::open(&bytes, &Limits::default()).unwrap().strands().unwrap().unwrap().stored();
    let mut changed = stored.clone();
    // Change the integers to values that encoding the decoded strands would not give.
    changed.scale = StrandScale { reach: 7.0, radius: 0.25 };
    (changed.points[1].aside, changed.points[4].height, changed.roots[0]) = ([i16::MIN, 3], 1, [5, 65535]);
    let write = |strands: &StoredStrands| sample_with(|writer| writer.stored_strands(strands));
    assert!(write(&stored).unwrap() == bytes, "the same strands, however they are written");
    let written = write(&changed).unwrap();
    let back = Package::open(&written, &Limits::default()).unwrap().strands().unwrap().unwrap().stored();
    assert_eq!(back, changed);
    assert_eq!(back.points[1].decoded(back.scale).aside[0], -7.0, "-32768 counts as -32767");
    let odd = StoredStrands { points: changed.points[1..].to_vec(), ..changed.clone() };
    assert!(write(&odd).unwrap_err().to_string().contains("expected one set or two"));
    changed.scale.reach = f32::NAN;
    assert!(write(&changed).unwrap_err().to_string().contains("reach is NaN"));
}
