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
    assert_eq!((guides.len(), guides.left_out.no_length, guides.strand(0).len()), (1, 2, 3));
}

#[test]
fn strands_with_numbers_that_are_not_finite_are_left_out() {
    let mut bytes = hair();
    bytes[132..136].copy_from_slice(&f32::NAN.to_le_bytes());
    let guides = GuideFormat::Hair.read("a.hair", &bytes).unwrap();
    assert_eq!((guides.len(), guides.left_out.not_finite, guides.strand(0)[0].x), (1, 1, 9.0));
    assert_eq!(guides.radii, [0.5, 1.0]);
    // Packages are stricter than guides.
    let error = HairFile::read("a.hair", &bytes).unwrap_err().to_string();
    assert!(error.contains("byte 132: points: row 0 has NaN"), "{error}");
    // The shape needs no radii.
    let mut bytes = hair();
    bytes[192..196].copy_from_slice(&f32::INFINITY.to_le_bytes());
    let guides = GuideFormat::Hair.read("a.hair", &bytes).unwrap();
    assert_eq!((guides.len(), guides.radii.len(), guides.colors.len()), (2, 0, 5));
    for word in ["nan", "-inf", "1.#QNAN", "-nan(ind)", "1e99"] {
        let text = format!("0 0 0\n0 {word} 0\n\n0 0 0\n1 0 0\n");
        let guides = GuideFormat::Text.read("a.txt", text.as_bytes()).unwrap();
        assert_eq!((guides.len(), guides.left_out.not_finite), (1, 1), "{word}");
    }
    for version in [3.0, 4.0] {
        let mut bytes = tfx(version);
        let last = bytes.len() - if version < 4.0 { 4 } else { 8 };
        bytes[last..last + 4].copy_from_slice(&f32::NAN.to_le_bytes());
        let guides = GuideFormat::Tfx.read("a.tfx", &bytes).unwrap();
        assert_eq!((guides.len(), guides.left_out.not_finite), (1, 1), "version {version}");
    }
}

#[test]
fn text_is_read_in_the_notations_of_other_programs() {
    let expected = GuideFormat::Text.read("a.txt", b"0 0 0 1\n0 1 0 1\n\n2 0 0 1\n2 1 0.5 1\n").unwrap();
    let utf16 = |text: &str, bytes: fn(u16) -> [u8; 2]| {
        "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(bytes).collect::<Vec<u8>>()
    };
    let plain = "0 0 0 1\n0 1 0 1\n\n2 0 0 1\n2 1 0.5 1\n";
    for text in [
        format!("\u{feff}{plain}").into_bytes(),
        utf16(plain, u16::to_le_bytes),
        utf16(plain, u16::to_be_bytes),
        b"0, 0, 0, 1\n0,1,0,1\n , \n2;0;0;1\n2,\t1, 0.5, 1,\n".to_vec(),
        b"x,y,z,radius\r\n0,0,0,1\r\n0,1,0,1\r\n\r\n2,0,0,1\r\n2,1,0.5,1\r\n".to_vec(),
        b"# a strand\n0 0 0 1\n0 1 0 1\n\n# and another\n2 0 0 1\n2 1 0.5 1".to_vec(),
    ] {
        assert_eq!(GuideFormat::Text.read("a.txt", &text).unwrap(), expected, "{}", String::from_utf8_lossy(&text));
    }
}

/// Returns text with strands of four points each, with roots in a row at x = 1, 2, …, changed by `change`.
fn rows(strands: usize, change: impl Fn(usize, &mut Vec<Vec3>)) -> Guides {
    let strand = |i: usize| {
        let mut points: Vec<Vec3> = (0..4).map(|k| Vec3::new(1.0 + i as f32, 5.0 + 0.1 * k as f32, 0.0)).collect();
        change(i, &mut points);
        points.iter().map(|p| format!("{} {} {}\n", p.x, p.y, p.z)).collect::<String>() + "\n"
    };
    GuideFormat::Text.read("a.txt", (0..strands).map(strand).collect::<String>().as_bytes()).unwrap()
}

#[test]
fn strands_with_a_point_far_away_are_left_out() {
    for (point, place) in (0..4).flat_map(|k| [Vec3::ZERO, Vec3::X * 100.0, Vec3::MAX].map(|p| (k, p))) {
        let guides = rows(9, |i, points| {
            if i % 4 == 2 {
                points[point] = place;
            }
        });
        assert_eq!((guides.len(), guides.left_out.far_point), (7, 2), "point {point} at {place}");
        assert!(guides.warnings.is_empty() && guides.points.iter().all(|p| p.x >= 1.0 && p.y >= 5.0 && p.x < 10.0));
    }
    // Both points of the second half, and the only two points.
    let half = rows(9, |i, points| points[2..].iter_mut().for_each(|p| p.z = if i == 3 { 100.0 } else { 0.0 }));
    assert_eq!((half.len(), half.left_out.far_point), (8, 1));
    let short = rows(9, |i, points| *points = vec![points[0], if i == 8 { Vec3::ZERO } else { points[1] }]);
    assert_eq!((short.len(), short.left_out.far_point), (8, 1));
    assert_eq!(short.left_out.to_string(), "1 with a piece many times longer than the others");
}

#[test]
fn points_at_the_origin_of_most_strands_are_removed() {
    let good = rows(9, |_, _| ());
    let padded = rows(9, |_, points| points.extend([Vec3::ZERO; 3]));
    assert_eq!((&padded.points, &padded.offsets, padded.left_out), (&good.points, &good.offsets, good.left_out));
    let expected = "9 of 9 strands have a last piece many times longer than the others, to the origin; it is left out";
    assert_eq!(padded.warnings, [expected]);
    let inner = rows(9, |_, points| points.insert(2, Vec3::ZERO));
    assert_eq!((inner.points, inner.warnings.len()), (good.points, 1));
}

#[test]
fn long_hair_among_short_hair_is_kept() {
    let mixed = rows(20, |i, points| {
        let times = if i % 3 == 0 { 100.0 } else { 1.0 };
        let root = points[0];
        points.iter_mut().for_each(|p| *p = root + (*p - root) * times);
    });
    assert_eq!((mixed.len(), mixed.warnings.len()), (20, 0));
    // Curves with few points: a short piece at the root, and one piece for the rest.
    let sparse = rows(20, |_, points| points[3].y += 5.0);
    assert_eq!((sparse.len(), sparse.points.len(), sparse.warnings.len()), (20, 80, 0));
    let rooted = GuideFormat::Text.read("a.txt", b"0 0 0\n0 1 0\n0 1.01 0\n\n0 0 0\n1 0 0\n1.01 0 0\n").unwrap();
    assert_eq!((rooted.len(), rooted.points.len()), (2, 6));
}

#[test]
fn strands_that_are_not_separated_are_reported() {
    let text = |strands: usize| {
        let point = |i: usize| format!("{} {} 0\n", 0.4 * (i / 4) as f32, 0.1 * (i % 4) as f32);
        GuideFormat::Text.read("a.txt", (0..4 * strands).map(point).collect::<String>().as_bytes()).unwrap()
    };
    let found = text(24);
    assert_eq!((found.len(), found.points.len()), (1, 96));
    assert!(found.warnings[0].contains("one strand with jumps, 96 points and 23 pieces much longer"), "{found:?}");
    assert_eq!(text(2).warnings.len(), 1);
    assert!(rows(1, |_, _| ()).warnings.is_empty());
    // A spiral, whose pieces grow.
    let spiral: String =
        (0..40).map(|i| (i, 1.1_f32.powi(i))).map(|(i, r)| format!("{r} {} 0\n", r * (i % 3) as f32)).collect();
    let spiral = GuideFormat::Text.read("a.txt", spiral.as_bytes()).unwrap();
    assert_eq!(spiral.len(), 1);
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
    let empty = [&with(with(hair(), 4, &[0; 8]), 12, &[3])[..128]].concat();
    refused(Hair, &empty, "strands: the file has no strands, expected at least one");
    let all_nan = with(with(hair(), 132, &f32::NAN.to_le_bytes()), 168, &f32::NAN.to_le_bytes());
    refused(Hair, &all_nan, "no strand in the file can be used: 2 with a coordinate that is not a finite number");
    refused(Tfx, &with(tfx(3.0), 4, &[0; 4]), "the file has no strands");
    refused(Text, b"\xef\xbb\xbf\n", "the file has no strands");
    refused(Hair, &hair()[..180], "byte 132: points: expected 60 bytes from here, the file ends at byte 180");
    refused(Tfx, &with(tfx(3.0), 0, &2.0f32.to_le_bytes()), "byte 0: TressFX version is 2, expected 3 or 4");
    refused(Tfx, &with(tfx(4.0), 4, &many), "bytes from here, the file ends at");
    refused(Tfx, &with(tfx(4.0), 8, &many), "byte 8: 4294967295 points per strand, expected 2..=64");
    refused(Tfx, &with(tfx(3.0), 148, &many), "bytes from here, the file ends at");
    refused(Text, b"0 0 0\n0 1\n", "line 2: 2 numbers, expected 3, as in the lines before");
    refused(Text, b"0 0\n", "line 1: 2 numbers, expected x y z, or x y z radius");
    refused(Text, b"0 zero 0\n", "line 1: \"zero\", expected a number");
    refused(Text, b"x y z\n0 y 0\n", "line 2: \"y\", expected a number");
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
