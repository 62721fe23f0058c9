//! The `NORM` section: round trip and rejected contents.

use crate::common::{sample_package, sample_with};
use pelage_formats::*;

/// Returns numbers for each vertex of the sample package.
fn vertices() -> Vec<[i16; 2]> {
    let bytes = sample_package();
    let count = Package::open(&bytes, &Limits::default()).unwrap().mesh().unwrap().unwrap().vertex_count;
    (0..count).map(|i| [100 * i as i16, -20_000]).collect()
}

#[test]
fn bare_normals_survive_a_round_trip() {
    let bytes = sample_with(|writer| writer.bare_normals(&vertices())).unwrap();
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    let opened = Package::open(&bytes, &Limits::default()).unwrap();
    let stored = opened.bare_normals().unwrap().unwrap();
    assert_eq!(stored_bare_normals(stored).collect::<Vec<_>>(), vertices());
}

#[test]
fn bare_normal_contents_are_checked() {
    let count = vertices().len();
    let reason = |bytes: Vec<u8>| sample_with(|w| w.section(Tag::BARE_NORMALS, bytes)).unwrap_err().to_string();
    let missing = reason(vec![0; 4 * count - 4]);
    assert!(missing.contains(&format!("expected {}, 4 for each of {count} vertices", 4 * count)), "{missing}");
    let mut bytes = vec![0; 4 * count];
    bytes[4..8].copy_from_slice(&[0xff, 0x7f, 0xff, 0x7f]);
    let found = reason(bytes);
    assert!(found.contains("vertex 1 has [32767, 32767], expected a vector of length at most 32767"), "{found}");
    let written = sample_with(|writer| writer.bare_normals(&vec![[i16::MIN; 2]; count])).unwrap_err().to_string();
    assert!(written.contains("vertex 0 has [-32768, -32768]"), "{written}");
}
