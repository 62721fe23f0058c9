#![allow(clippy::unwrap_used, reason = "tests")]

use super::*;
use glam::Vec3;

/// Returns a `.hair` file with all arrays and two strands: one of three points, one of two.
fn hair() -> Vec<u8> {
    let mut bytes = b"HAIR".to_vec();
    bytes.extend([2u32, 5, 31, 0].into_iter().flat_map(u32::to_le_bytes));
    bytes.extend([0u8; 108]);
    bytes.extend([2u16, 1].into_iter().flat_map(u16::to_le_bytes));
    let floats = |bytes: &mut Vec<u8>, numbers: &[f32]| bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
    floats(&mut bytes, &(0..15).map(|i| i as f32).collect::<Vec<_>>());
    floats(&mut bytes, &[0.5, 0.25, 0.125, 1.0, 2.0]);
    floats(&mut bytes, &[0.0; 5]);
    floats(&mut bytes, &(0..15).map(|i| i as f32 / 16.0).collect::<Vec<_>>());
    bytes
}

/// Returns a `.tfx` file of format version `version` with two strands of three points.
fn tfx(version: f32) -> Vec<u8> {
    let mut bytes = vec![0; 200];
    let offset = if version < 4.0 { 160u32 } else { 176 };
    bytes[0..4].copy_from_slice(&version.to_le_bytes());
    bytes[4..8].copy_from_slice(&2u32.to_le_bytes());
    bytes[8..12].copy_from_slice(&3u32.to_le_bytes());
    let at = if version < 4.0 { 144 } else { 12 };
    bytes[at..at + 4].copy_from_slice(&offset.to_le_bytes());
    bytes.truncate(offset as usize);
    for i in 0..6 {
        let mut row = vec![i as f32, 1.0, -1.0];
        row.extend((version >= 4.0).then_some(9.0));
        bytes.extend(row.iter().flat_map(|x: &f32| x.to_le_bytes()));
    }
    bytes
}

fn refused(format: GuideFormat, bytes: &[u8], expected: &str) {
    let error = format.read("a.file", bytes).expect_err(expected).to_string();
    assert!(error.starts_with("a.file: ") && error.contains(expected), "expected {expected:?} in: {error}");
}

#[test]
fn hair_files_are_read() {
    let guides = GuideFormat::Hair.read("a.hair", &hair()).unwrap();
    assert_eq!((guides.len(), guides.strand(0).len(), guides.strand(1).len()), (2, 3, 2));
    assert_eq!(guides.strand(1), [Vec3::new(9.0, 10.0, 11.0), Vec3::new(12.0, 13.0, 14.0)]);
    assert_eq!(guides.radii, [0.25, 0.125, 0.0625, 0.5, 1.0]);
    assert_eq!(guides.colors[1], Vec3::new(3.0, 4.0, 5.0) / 16.0);
}

#[test]
fn tressfx_files_are_read() {
    for version in [3.0, 4.0] {
        let guides = GuideFormat::Tfx.read("a.tfx", &tfx(version)).unwrap();
        assert_eq!((guides.len(), guides.strand(1)[0]), (2, Vec3::new(3.0, 1.0, -1.0)), "version {version}");
    }
}

#[test]
fn strands_without_length_are_left_out() {
    let guides = GuideFormat::Text.read("a.txt", b"0 0 0\n0 0 0\n\n1 0 0\n\n\n0 0 0\n1 0 0\n1 0 0\n2 0 0\n").unwrap();
    assert_eq!((guides.len(), guides.left_out, guides.strand(0).len()), (1, 2, 3));
    assert_eq!(GuideFormat::Text.read("a.txt", b"").unwrap(), Guides::default());
}

#[test]
fn errors_of_damaged_guide_files_name_the_position() {
    use GuideFormat::{Hair, Text, Tfx};
    let with = |mut bytes: Vec<u8>, at: usize, value: &[u8]| {
        bytes[at..at + value.len()].copy_from_slice(value);
        bytes
    };
    let many = u32::MAX.to_le_bytes();
    refused(Hair, b"HAIR", "byte 0: the header: expected 128 bytes from here, the file ends at byte 4");
    refused(Hair, &with(hair(), 0, b"HARE"), "byte 0: \"HARE\", expected \"HAIR\"");
    refused(
        Hair,
        &with(hair(), 4, &many),
        "byte 128: segment counts of the strands: expected 8589934590 bytes from here",
    );
    refused(Hair, &with(hair(), 8, &many), "byte 8: 4294967295 points, expected 5");
    refused(Hair, &with(hair(), 12, &1u32.to_le_bytes()), "no points");
    refused(Hair, &with(hair(), 132, &f32::NAN.to_le_bytes()), "byte 132: points: row 0 has NaN");
    refused(Hair, &hair()[..180], "byte 132: points: expected 60 bytes from here, the file ends at byte 180");
    refused(Tfx, &with(tfx(3.0), 0, &2.0f32.to_le_bytes()), "byte 0: TressFX version is 2, expected 3 or 4");
    refused(Tfx, &with(tfx(4.0), 4, &many), "bytes from here, the file ends at");
    refused(Tfx, &with(tfx(4.0), 8, &many), "byte 8: 4294967295 points per strand, expected 2..=64");
    refused(Tfx, &with(tfx(3.0), 148, &many), "bytes from here, the file ends at");
    refused(Text, b"0 0 0\n0 1\n", "line 2: 2 numbers, expected 3, as in the lines before");
    refused(Text, b"0 0\n", "line 1: 2 numbers, expected x y z, or x y z radius");
    refused(Text, b"0 zero 0\n", "line 1: \"zero\", expected a number");
    refused(Text, b"0 inf 0\n", "line 1: inf, expected a finite number");
    refused(Text, b"0 0 0\n\xff", "byte 6: not text");
    // Truncated files and flipped bits must not cause a panic; errors are allowed.
    for (format, bytes) in [(Hair, hair()), (Tfx, tfx(3.0)), (Tfx, tfx(4.0))] {
        (0..bytes.len()).for_each(|length| drop(format.read("a", &bytes[..length])));
        for (at, bit) in (0..bytes.len()).flat_map(|at| (0..8).map(move |bit| (at, bit))) {
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << bit;
            drop(format.read("a", &flipped));
        }
    }
}
