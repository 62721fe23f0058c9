//! The `HCOL` section: round trip and rejected contents.

use crate::common::{sample_manifest, sample_package, sample_with};
use pelage_formats::*;

/// Returns a colour for the first material only.
fn colors() -> Vec<Option<[f32; 3]>> {
    let mut colors = vec![None; sample_manifest().materials.len()];
    colors[0] = Some([1.3, 0.0, 0.25]);
    colors
}

#[test]
fn hair_colors_survive_a_round_trip() {
    let bytes = sample_with(|writer| writer.hair_colors(&colors())).unwrap();
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    let opened = Package::open(&bytes, &Limits::default()).unwrap();
    assert_eq!(opened.hair_colors().unwrap(), colors());
    // Bytes that a reader in another language depends on: a list of options of three f32.
    let index = opened.sections().iter().position(|s| s.tag == Tag::HAIR_COLORS).unwrap();
    let first = [vec![1], [1.3f32, 0.0, 0.25].map(f32::to_le_bytes).concat()].concat();
    let count = colors().len();
    let expected = [(count as u64).to_le_bytes().to_vec(), first, vec![0; count - 1]].concat();
    assert_eq!(opened.section_bytes(index).unwrap(), expected);
    let without = sample_package();
    assert!(Package::open(&without, &Limits::default()).unwrap().hair_colors().unwrap().is_empty());
}

#[test]
fn hair_colors_are_checked() {
    for (change, expected) in [
        ((|c| c[0] = Some([0.5, f32::NAN, 0.5])) as fn(&mut Vec<_>), "colour 0 has NaN, expected finite numbers"),
        (|c| c[0] = Some([-1.0, 0.5, 0.5]), "colour 0 has -1, expected finite numbers of at least 0"),
        (|c| c.push(None), "colours, expected one for each of"),
    ] {
        let mut colors = colors();
        change(&mut colors);
        let error = sample_with(|writer| writer.hair_colors(&colors)).unwrap_err().to_string();
        assert!(error.contains(expected), "expected {expected:?} in: {error}");
    }
}
