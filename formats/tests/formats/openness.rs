//! The `OPEN` section: round trip and rejected contents.

use crate::common::{sample_package, sample_with};
use pelage_formats::meaning::openness::Openness;
use pelage_formats::*;

/// Returns a value for each vertex of the sample package.
fn vertices() -> Vec<Openness> {
    let bytes = sample_package();
    let count = Package::open(&bytes, &Limits::default()).unwrap().mesh().unwrap().unwrap().vertex_count;
    (0..count).map(|i| Openness { share: i as f32 / count as f32, tangential: [0.5, -0.25] }).collect()
}

#[test]
fn openness_survives_a_round_trip() {
    let bytes = sample_with(|writer| writer.openness(&vertices())).unwrap();
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    let opened = Package::open(&bytes, &Limits::default()).unwrap();
    let expected: Vec<u8> = vertices().iter().flat_map(|v| [(v.share * 255.0).round() as u8, 63, 225, 0]).collect();
    assert_eq!(opened.openness().unwrap().unwrap(), expected);
}

#[test]
fn openness_contents_are_checked() {
    let count = vertices().len();
    let reason = |bytes: Vec<u8>| sample_with(|writer| writer.section(Tag::OPENNESS, bytes)).unwrap_err().to_string();
    let missing = reason(vec![0; 4 * count - 4]);
    assert!(missing.contains(&format!("expected {}, 4 for each of {count} vertices", 4 * count)), "{missing}");
    for (at, byte, what) in [(7, 1, "vertex 1 has bytes [0, 0, 0, 1]"), (1, 0x80, "vertex 0 has bytes [0, 128, 0, 0]")]
    {
        let mut bytes = vec![0; 4 * count];
        bytes[at] = byte;
        let found = reason(bytes);
        assert!(found.contains(what) && found.contains("expected a vector of length at most 127"), "{found}");
    }
}
