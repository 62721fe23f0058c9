//! The `SIMP` section: round trip and rejected contents.

use crate::common::{Refusal, assert_refused, furless_manifest, sample_mesh, section_bytes};
use pelage_formats::*;

/// Returns a package of one part with 12 indices, without hair, and with these lists.
fn package(levels: &[SimplifiedLevel]) -> Result<Vec<u8>, FormatError> {
    let parts = vec![Part { material: 0, first_index: 0, index_count: 12 }];
    let manifest = Manifest { parts, ..furless_manifest() };
    PackageWriter::new(manifest).mesh(&sample_mesh(false)).simplified(levels).finish()
}

fn lists() -> Vec<SimplifiedLevel> {
    let level = |deviation_m, triangles: usize| SimplifiedLevel {
        deviation_m,
        part_counts: vec![3 * triangles as u32],
        indices: [0, 1, 2].repeat(triangles),
    };
    vec![level(0.25, 2), level(0.5, 1)]
}

#[test]
fn simplified_levels_survive_a_round_trip() {
    let bytes = package(&lists()).unwrap();
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    let view = package.simplified().unwrap().unwrap();
    assert_eq!(view.deviations().collect::<Vec<_>>(), [0.25, 0.5]);
    assert_eq!([0, 1].map(|level| view.part_counts(level).collect::<Vec<_>>()), [vec![6], vec![3]]);
    assert_eq!(view.indices().collect::<Vec<_>>(), [0, 1, 2, 0, 1, 2, 0, 1, 2]);
    // Bytes that a reader in another language depends on.
    let mut expected: Vec<u8> = [2u32, 1, 9, 0].into_iter().flat_map(u32::to_le_bytes).collect();
    expected.extend([0.25f32, 0.5].into_iter().flat_map(f32::to_le_bytes));
    expected.extend([6u32, 3].into_iter().flat_map(u32::to_le_bytes));
    expected.extend([0u32, 1, 2].repeat(3).into_iter().flat_map(u32::to_le_bytes));
    assert_eq!(section_bytes(&package, Tag::SIMPLIFIED), expected);
}

#[test]
fn simplified_contents_are_checked() {
    let cases: [Refusal<Vec<SimplifiedLevel>>; 9] = [
        (|l| l.clear(), "0 lists, expected 1..=64"),
        (|l| l[0].deviation_m = 0.0, "deviation 0 is 0, expected a finite number above 0"),
        (|l| l[0].deviation_m = f32::NAN, "deviation 0 is NaN"),
        (|l| l[1].deviation_m = 0.25, "deviation 1 is 0.25, expected a finite number above 0.25"),
        (|l| l[1].part_counts = vec![3, 0], "lists with different numbers of parts"),
        (|l| l[1].part_counts[0] = 6, "the lists have 12 indices, expected 9, the index count of the section"),
        (|l| (l[0].part_counts[0], l[1].part_counts[0]) = (7, 2), "index count 0 is not a multiple of 3"),
        (|l| l[1].indices[2] = 1 << 20, "index 8 is out of range"),
        (
            |l| (l[0].part_counts[0], l[0].indices) = (15, [0, 1, 2].repeat(5)),
            "part 0 of list 0 has more indices than that part of the mesh",
        ),
    ];
    assert_refused(Tag::SIMPLIFIED, lists, &cases, |levels| package(levels));
    let mut levels = lists();
    levels.iter_mut().for_each(|level| level.part_counts.push(0));
    assert!(package(&levels).unwrap_err().to_string().contains("lists of 2 parts, expected 1, the"));
    let bytes = package(&lists()).unwrap();
    let few = Limits { indices: 8, ..Limits::default() };
    let found = Package::open(&bytes, &few).map(|package| package.simplified().unwrap_err().to_string());
    assert!(found.is_ok_and(|found| found.contains("limit")), "indices are bounded");
}
