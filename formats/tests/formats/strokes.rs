//! The `STRO` section: round trip and rejected contents.

use crate::common::{furless_manifest, sample_mesh, section_bytes};
use pelage_formats::*;

/// Returns a package of a square of four triangles, without hair, with a stroke pool.
fn package(pool: &StrokePool) -> Result<Vec<u8>, FormatError> {
    let parts = vec![Part { material: 0, first_index: 0, index_count: 12 }];
    let manifest = Manifest { parts, ..furless_manifest() };
    PackageWriter::new(manifest).mesh(&sample_mesh(false)).stroke_pool(pool).finish()
}

/// Returns two strokes: one on the surface and one along an axis.
fn pool() -> StrokePool {
    let anchor = |b| StrokeAnchor { vertices: [0, 1, 4], weights: [b, 65_535 - b] };
    let point = |k: usize, sides| StrokePoint {
        sides,
        offset_m: None,
        half_width_m: 0.01 * k as f32,
        darkness: k as f32 / 23.0,
    };
    let stroke = |kind, rank, pigment, other: fn(u16) -> u16| PaintStroke {
        kind,
        rank,
        seed: 0x1234_5678,
        pigment,
        points: (0..PaintStroke::POINTS).map(|k| point(k, [k as u16, other(k as u16)].map(anchor))).collect(),
    };
    let mut lock = stroke(StrokeKind::Lock, 0.5, None, |k| k);
    lock.points.iter_mut().enumerate().for_each(|(k, p)| p.offset_m = Some([0.0, 0.01 * k as f32, -0.5]));
    let strokes = vec![
        stroke(StrokeKind::Tuft, 0.0, Some([0.5, 0.25, 0.0]), |k| k),
        stroke(StrokeKind::Bone, 1.0, None, |k| 65_535 - k),
        lock,
    ];
    StrokePool { size_m: 1.5, strokes }
}

#[test]
fn strokes_survive_a_round_trip() {
    let bytes = package(&pool()).unwrap();
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    let opened = Package::open(&bytes, &Limits::default()).unwrap();
    assert_eq!(*opened.stroke_pool().unwrap().unwrap(), pool());
    // Bytes that a reader in another language depends on: size, number of strokes, then kind, rank and seed of the
    // first.
    let section = section_bytes(&opened, Tag::STROKES);
    let u32_at = |at: usize| u32::from_le_bytes(section[at..at + 4].try_into().unwrap());
    assert_eq!(f32::from_bits(u32_at(0)), 1.5);
    assert_eq!([4, 8, 12, 16, 20].map(u32_at), [3, 0, 6, 0, 0x1234_5678]);
    // A stroke has a header of 21 bytes, or 33 with a pigment, and 24 points of 41 bytes, or 53 with an offset.
    assert_eq!(section.len(), 12 + (33 + 24 * 41) + (21 + 24 * 41) + (21 + 24 * 53));
}

#[test]
fn package_without_strokes_has_no_pool() {
    let parts = vec![Part { material: 0, first_index: 0, index_count: 12 }];
    let writer = PackageWriter::new(Manifest { parts, ..furless_manifest() }).mesh(&sample_mesh(false));
    let bytes = writer.finish().unwrap();
    assert_eq!(Package::open(&bytes, &Limits::default()).unwrap().stroke_pool().unwrap(), None);
}

#[test]
fn stroke_contents_are_checked() {
    let with = |change: &dyn Fn(&mut StrokePool)| {
        let mut data = pool();
        change(&mut data);
        data
    };
    for (data, expected) in [
        (with(&|d| d.size_m = 0.0), "size_m is 0, expected"),
        (with(&|d| d.size_m = f32::INFINITY), "size_m is inf, expected"),
        (
            with(&|d| d.strokes = vec![d.strokes[0].clone(); StrokePool::MOST + 1]),
            "4097 strokes, expected at most 4096",
        ),
        (with(&|d| d.strokes[1].rank = 1.25), "strokes[1]: rank is 1.25, expected 0 to 1"),
        (with(&|d| d.strokes[0].rank = -0.5), "strokes[0]: rank is -0.5, expected 0 to 1"),
        (with(&|d| d.strokes[0].rank = f32::NAN), "strokes[0]: rank is NaN, expected 0 to 1"),
        (with(&|d| d.strokes[0].pigment = Some([0.0, 1.5, 0.0])), "strokes[0]: pigment has the component 1.5"),
        (with(&|d| d.strokes[1].points.truncate(23)), "strokes[1]: 23 points, expected 24"),
        (with(&|d| d.strokes[1].points.clear()), "strokes[1]: 0 points, expected 24"),
        (with(&|d| d.strokes[0].points[3].half_width_m = f32::NAN), "points[3]: half_width_m is NaN, expected"),
        (with(&|d| d.strokes[0].points[3].half_width_m = -0.1), "points[3]: half_width_m is -0.1, expected"),
        (with(&|d| d.strokes[0].points[23].darkness = 1.5), "points[23]: darkness is 1.5, expected 0 to 1"),
        (with(&|d| d.strokes[1].points[7].sides[1].vertices[2] = 5), "points[7]: vertex 5, expected less than the 5"),
        (with(&|d| d.strokes[1].points[7].sides[0].weights = [65_535, 1]), "points[7]: weights 65535 and 1, expected"),
    ] {
        let error = package(&data).unwrap_err();
        assert_eq!(error.section(), Some(Tag::STROKES));
        let error = error.to_string();
        assert!(error.contains(expected), "expected {expected:?} in: {error}");
    }
    // The limits themselves are valid.
    let full = with(&|d| d.strokes = vec![d.strokes[0].clone(); StrokePool::MOST]);
    assert!(package(&full).is_ok());
}

#[test]
fn every_truncation_of_strokes_is_detected() {
    let bytes = package(&pool()).unwrap();
    let opened = Package::open(&bytes, &Limits::default()).unwrap();
    let good = section_bytes(&opened, Tag::STROKES).to_vec();
    let rewrite = |section: Vec<u8>| {
        let parts = vec![Part { material: 0, first_index: 0, index_count: 12 }];
        let manifest = Manifest { parts, ..furless_manifest() };
        PackageWriter::new(manifest).mesh(&sample_mesh(false)).section(Tag::STROKES, section).finish()
    };
    assert_eq!(rewrite(good.clone()).unwrap(), bytes);
    for length in (0..good.len()).step_by(7).chain([good.len() - 1]) {
        assert_eq!(rewrite(good[..length].to_vec()).unwrap_err().section(), Some(Tag::STROKES), "cut to {length}");
    }
}
