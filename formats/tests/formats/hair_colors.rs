//! The `HCOL` section: round trip and rejected contents.

use crate::common::{Refusal, assert_refused, sample_manifest, sample_with, section_bytes};
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
    let first = [vec![1], [1.3f32, 0.0, 0.25].map(f32::to_le_bytes).concat()].concat();
    let count = colors().len();
    let expected = [(count as u64).to_le_bytes().to_vec(), first, vec![0; count - 1]].concat();
    assert_eq!(section_bytes(&opened, Tag::HAIR_COLORS), expected);
}

#[test]
fn hair_colors_are_checked() {
    let cases: [Refusal<Vec<_>>; 3] = [
        (|c| c[0] = Some([0.5, f32::NAN, 0.5]), "colour 0 has NaN, expected finite numbers"),
        (|c| c[0] = Some([-1.0, 0.5, 0.5]), "colour 0 has -1, expected finite numbers of at least 0"),
        (|c| c.push(None), "colours, expected one for each of"),
    ];
    assert_refused(Tag::HAIR_COLORS, colors, &cases, |colors| sample_with(|writer| writer.hair_colors(colors)));
}
