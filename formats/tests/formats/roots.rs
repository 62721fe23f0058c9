//! The `ROOT` section: round trip and rejected contents.

use crate::common::{sample_manifest, sample_package};
use pelage_formats::*;

fn info() -> RootsInfo {
    let asides = std::array::from_fn(|i| RootOffset { mean: [0.0, 0.02 * i as f32], along: 0.01 * i as f32 });
    RootsInfo { asides, uv_per_tile: vec![0.25; sample_manifest().materials.len()] }
}

/// Returns the sample package with the section appended.
fn package(info: &RootsInfo, change: impl FnOnce(&mut Manifest)) -> Result<Vec<u8>, FormatError> {
    let bytes = sample_package();
    let package = Package::open(&bytes, &Limits::default())?;
    let mut manifest = package.manifest().clone();
    change(&mut manifest);
    let mut writer = PackageWriter::new(manifest);
    for (index, section) in package.sections().iter().enumerate().skip(1) {
        writer = writer.section(section.tag, package.section_bytes(index)?);
    }
    writer.roots(info).finish()
}

#[test]
fn roots_survive_a_round_trip() {
    let bytes = package(&info(), |_| ()).unwrap();
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    let opened = Package::open(&bytes, &Limits::default()).unwrap();
    assert_eq!(opened.roots().unwrap(), Some(info()));
    // Bytes that a reader in another language depends on: eight times three f32, then a list of f32.
    let index = opened.sections().iter().position(|s| s.tag == Tag::ROOTS).unwrap();
    let asides = info().asides.map(|aside| [aside.mean[0], aside.mean[1], aside.along].map(f32::to_le_bytes).concat());
    let count = info().uv_per_tile.len();
    let expected =
        [asides.concat(), (count as u64).to_le_bytes().to_vec(), 0.25f32.to_le_bytes().repeat(count)].concat();
    assert_eq!(opened.section_bytes(index).unwrap(), expected);
}

#[test]
fn packages_without_roots_have_none() {
    let bytes = sample_package();
    assert_eq!(Package::open(&bytes, &Limits::default()).unwrap().roots().unwrap(), None);
}

#[test]
fn roots_contents_are_checked() {
    let changed = |change: fn(&mut RootsInfo)| {
        let mut info = info();
        change(&mut info);
        package(&info, |_| ()).unwrap_err().to_string()
    };
    for (change, expected) in [
        ((|r| r.asides[3].along = f32::NAN) as fn(&mut RootsInfo), "asides[3] has NaN, expected finite numbers"),
        (|r| r.asides[7].mean[1] = f32::INFINITY, "asides[7] has inf"),
        (|r| r.uv_per_tile[0] = -1.0, "uv_per_tile[0] is -1, expected a finite number of at least 0"),
        (|r| r.uv_per_tile.clear(), "uv_per_tile has 0 entries, expected one for each of"),
    ] {
        let error = changed(change);
        assert!(error.contains(expected), "expected {expected:?} in: {error}");
    }
}

#[test]
fn every_changed_byte_of_roots_is_detected() {
    let bytes = package(&info(), |_| ()).unwrap();
    let opened = Package::open(&bytes, &Limits::default()).unwrap();
    let section = opened.sections().iter().find(|s| s.tag == Tag::ROOTS).unwrap();
    for at in section.offset..section.offset + section.length {
        let mut broken = bytes.clone();
        broken[at as usize] ^= 0x10;
        assert!(!Package::validate(&broken, &Limits::default()).is_empty(), "byte {at} changed, and nobody saw it");
    }
}
