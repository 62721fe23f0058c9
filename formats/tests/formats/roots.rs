//! The `ROOT` section: round trip and rejected contents.

use crate::common::{Refusal, assert_refused, sample_manifest, sample_with, section_bytes};
use pelage_formats::*;

fn info() -> RootsInfo {
    let asides = std::array::from_fn(|i| RootOffset { mean: [0.0, 0.02 * i as f32], along: 0.01 * i as f32 });
    RootsInfo { asides, uv_per_tile: vec![0.25; sample_manifest().materials.len()] }
}

fn package(info: &RootsInfo) -> Result<Vec<u8>, FormatError> {
    sample_with(|writer| writer.roots(info))
}

#[test]
fn roots_survive_a_round_trip() {
    let bytes = package(&info()).unwrap();
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    let opened = Package::open(&bytes, &Limits::default()).unwrap();
    assert_eq!(opened.roots().unwrap(), Some(info()));
    // Bytes that a reader in another language depends on: eight times three f32, then a list of f32.
    let asides = info().asides.map(|aside| [aside.mean[0], aside.mean[1], aside.along].map(f32::to_le_bytes).concat());
    let count = info().uv_per_tile.len();
    let expected =
        [asides.concat(), (count as u64).to_le_bytes().to_vec(), 0.25f32.to_le_bytes().repeat(count)].concat();
    assert_eq!(section_bytes(&opened, Tag::ROOTS), expected);
}

#[test]
fn roots_contents_are_checked() {
    let cases: [Refusal<RootsInfo>; 4] = [
        (|r| r.asides[3].along = f32::NAN, "asides[3] has NaN, expected finite numbers"),
        (|r| r.asides[7].mean[1] = f32::INFINITY, "asides[7] has inf"),
        (|r| r.uv_per_tile[0] = -1.0, "uv_per_tile[0] is -1, expected a finite number of at least 0"),
        (|r| r.uv_per_tile.clear(), "uv_per_tile has 0 entries, expected one for each of"),
    ];
    assert_refused(Tag::ROOTS, info, &cases, package);
}
