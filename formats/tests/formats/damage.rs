//! Tests with damaged packages: whatever the damage, the reader reports what is wrong and where, and never panics.

use crate::bodies::reseal;
use crate::common::{self, ktx2_file, sample_fins, sample_manifest, sample_mesh, sample_package, sample_package_v1};
use pelage_formats::*;

const LIMITS: fn() -> Limits = Limits::default;

fn section(bytes: &[u8], tag: Tag) -> Section {
    *Package::open(bytes, &LIMITS()).unwrap().sections().iter().find(|s| s.tag == tag).unwrap()
}

fn put(bytes: &mut [u8], at: u64, value: &[u8]) {
    bytes[at as usize..at as usize + value.len()].copy_from_slice(value);
}

#[test]
fn every_prefix_is_an_error() {
    let bytes = sample_package();
    for length in 0..bytes.len() {
        let faults = Package::validate(&bytes[..length], &LIMITS());
        assert_eq!(faults.len(), 1, "prefix of {length} bytes: {faults:?}");
        match (&faults[0], length) {
            (FormatError::Magic { .. }, 0) => {}
            (FormatError::Truncated { offset, needed, available, .. }, 1..) => {
                assert!(offset + available <= length as u64 && needed > available, "{length}: {}", faults[0]);
            }
            (fault, _) => panic!("prefix of {length} bytes: {fault}"),
        }
    }
}

#[test]
fn every_flipped_bit_is_found_in_its_section() {
    let good = sample_package();
    let sections = Package::open(&good, &LIMITS()).unwrap().sections().to_vec();
    let mut bytes = good.clone();
    for at in 0..bytes.len() {
        let within = |s: &&Section| (s.offset..s.offset + s.length).contains(&(at as u64));
        let expected = sections.iter().find(within).map_or(Tag::HEAD, |s| s.tag);
        for flip in [1u8, 0x80, 0xff] {
            bytes[at] ^= flip;
            let faults = Package::validate(&bytes, &LIMITS());
            // A damaged animation also hides the mesh's joints, and vice versa; only one fault must be reported.
            assert_eq!(faults.len(), 1, "byte {at} ^ {flip:#x}: {faults:?}");
            assert_eq!(faults[0].section(), Some(expected), "byte {at} ^ {flip:#x}: {}", faults[0]);
            bytes[at] ^= flip;
        }
    }
    assert_eq!(bytes, good);
}

/// If the checksums are correct, the contents themselves must be checked. Not every change is a fault, because a
/// position may be a different number. But changes to bytes with one legal value must be detected.
#[test]
fn reserved_bytes_and_padding_of_the_mesh_are_checked() {
    let reserved = [
        (12, "reserved byte"),
        (48, "reserved byte"),
        (63, "reserved byte"),
        (304 + 22, "a groom of 0 after its first 2"),
        (304 + 120, "padding byte"),
        (432 + 120, "padding byte"),
        (11, "flags are"),
        (16, "stream offset"),
    ];
    assert_flips_are_found(&sample_package(), &reserved);
}

/// Flips a bit of each byte of the mesh and corrects the checksums. Each must give exactly one fault with the given
/// text.
fn assert_flips_are_found(good: &[u8], cases: &[(u64, &str)]) {
    let mesh = section(good, Tag::MESH).offset;
    for (at, expected) in cases {
        let mut bytes = good.to_vec();
        bytes[(mesh + at) as usize] ^= 0x80;
        reseal(&mut bytes);
        let faults = Package::validate(&bytes, &LIMITS());
        assert_eq!(faults.len(), 1, "byte {at}: {faults:?}");
        assert!(faults[0].to_string().contains(expected), "byte {at}: {}", faults[0]);
    }
}

/// Replaces bytes in a section of the sample package and corrects the checksums. Each case must give exactly one fault,
/// which contains the given text and is at that position or at the start of the section.
fn assert_one_fault_each(tag: Tag, cases: &[(u64, &[u8], &str)]) {
    let good = sample_package();
    let start = section(&good, tag).offset;
    for (at, value, expected) in cases {
        let mut bytes = good.clone();
        put(&mut bytes, start + at, value);
        reseal(&mut bytes);
        let faults = Package::validate(&bytes, &LIMITS());
        assert_eq!(faults.len(), 1, "{expected}: {faults:?}");
        assert!(faults[0].to_string().contains(expected), "{expected}: {}", faults[0]);
        assert_eq!(faults[0].section(), Some(tag));
        assert!(faults[0].offset().is_some_and(|o| o == start || o.abs_diff(start + at) < 48), "{:?}", faults[0]);
    }
}

#[test]
fn mesh_contents_are_checked() {
    let nan = f32::NAN.to_le_bytes();
    let cases: [(u64, &[u8], &str); 9] = [
        (64, &nan, "vertex 0"),
        (64 + 28, &1.5f32.to_le_bytes(), "lean 0..=1"),
        (64 + 28, &nan, "lean 0..=1"),
        (64 + 48 + 12, &(-1.0f32).to_le_bytes(), "fur_height >= 0"),
        (304 + 24, &f32::INFINITY.to_le_bytes(), "vertex 1"),
        (432 + 8, &0.5f32.to_le_bytes(), "summing to 1"),
        (432 + 8, &nan, "weights of vertex 0"),
        (432, &9u16.to_le_bytes(), "joint 9, expected less than the 2"),
        (560 + 4, &5u32.to_le_bytes(), "index 1 is 5, expected less than the 5"),
    ];
    assert_one_fault_each(Tag::MESH, &cases);
}

/// Fields that have a meaning only since version 2 must be 0 in a package of version 1.
#[test]
fn version_1_checks_its_reserved_bytes() {
    let good = sample_package_v1();
    assert_eq!(Package::validate(&good, &LIMITS()), []);
    let reserved = [(64 + 28, "lean 0 in version 1"), (64 + 31, "lean 0 in"), (304 + 20, "after its first 0")];
    assert_flips_are_found(&good, &reserved);
    // A manifest of version 1 cannot store later fields, and the writer fails instead of dropping them.
    let old = |change: fn(&mut Manifest)| {
        let mut manifest = common::sample_manifest_v1();
        change(&mut manifest);
        PackageWriter::new(manifest).version(1).finish().unwrap_err().to_string()
    };
    let fins = old(|m| m.fur.fins = Some(FinInfo::default()));
    assert!(fins.contains("fur.fins is given, expected none in version 1"), "{fins}");
    assert!(old(|m| m.fur.wet = Some(ShellTextures::default())).contains("fur.wet is given"));
    assert!(old(|m| m.materials[1].groom_texture = Some(0)).contains("materials[1].groom_texture is given"));
    assert!(old(|m| m.coat = Some(FarLayerInfo::default())).contains("coat is given, expected none in version 1"));
    let before_3 = |change: fn(&mut Manifest)| {
        let mut manifest = common::sample_manifest_v2();
        change(&mut manifest);
        PackageWriter::new(manifest).version(2).finish().unwrap_err().to_string()
    };
    let coat = before_3(|m| m.coat = Some(FarLayerInfo::default()));
    assert!(coat.contains("coat is given, expected none in version 2"), "{coat}");
    assert!(before_3(|m| m.detail = sample_manifest().detail).contains("detail is given"));
    assert!(before_3(|m| m.choice = sample_manifest().choice).contains("choice is given"));
    // In version 2, bytes after the warnings are not read as a far layer.
    let plain = PackageWriter::new(Manifest::default()).version(2).finish().unwrap();
    let at = section(&plain, Tag::MANIFEST);
    let mut coat = plain[at.offset as usize..(at.offset + at.length) as usize].to_vec();
    coat.extend([1].into_iter().chain([0; 15]));
    let mut longer = plain[..at.offset as usize].to_vec();
    longer.extend(&coat);
    longer.resize(longer.len().next_multiple_of(16), 0);
    let length = longer.len() as u64;
    put(&mut longer, 16, &length.to_le_bytes());
    put(&mut longer, 32 + 16, &(coat.len() as u64).to_le_bytes());
    reseal(&mut longer);
    let error = Package::open(&longer, &LIMITS()).unwrap_err().to_string();
    assert!(error.contains("bytes of coat follow the manifest of version 2"), "{error}");
    // In version 1 the tag of the fins is unknown.
    let any =
        PackageWriter::new(Manifest::default()).version(1).section(Tag::FINS, &b"x"[..]).section(Tag::FINS, &b""[..]);
    let bytes = any.finish().unwrap();
    assert!(Package::open(&bytes, &LIMITS()).unwrap().fins().unwrap().is_none());
    for version in [0, 4] {
        let error = PackageWriter::new(Manifest::default()).version(version).finish().unwrap_err().to_string();
        assert!(error.contains(&format!("version {version}")) || error.contains("is 0, expected 1..=3"), "{error}");
    }
}

#[test]
fn fin_contents_are_checked() {
    let good = sample_package();
    let first = 32;
    let nan = f32::NAN.to_le_bytes();
    let cases: [(u64, &[u8], &str); 13] = [
        (0, &2u32.to_le_bytes(), "expected 80 for these counts"),
        (0, &u32::MAX.to_le_bytes(), "fin count"),
        (4, &1u32.to_le_bytes(), "padding byte is 1"),
        (4, &u32::MAX.to_le_bytes(), "fin offset is 32, expected 17179869200"),
        (8, &16u64.to_le_bytes(), "fin offset is 16, expected 32"),
        (16, &9u32.to_le_bytes(), "the parts have 10 fins, expected 3"),
        (31, &[1], "padding byte is 1"),
        (first, &5u32.to_le_bytes(), "fin 0 is"),
        (first + 4, &0u32.to_le_bytes(), "expected two different vertices"),
        (first + 24 + 8, &1.5f32.to_le_bytes(), "fin 1 is"),
        (first + 24 + 12, &nan, "a finite length"),
        (first + 20, &1.5f32.to_le_bytes(), "start and opacity 0..=1"),
        (first + 48 + 16, &2u32.to_le_bytes(), "vertices less than 5 and a slab less than 2"),
    ];
    assert_one_fault_each(Tag::FINS, &cases);
    let finish = |manifest: Manifest, fins: &[FinData]| {
        let writer = PackageWriter::new(manifest).mesh(&sample_mesh(false));
        fins.iter().fold(writer, PackageWriter::fins).finish().unwrap_err().to_string()
    };
    let bare =
        || Manifest { parts: vec![Part { material: 0, first_index: 0, index_count: 12 }], ..Manifest::default() };
    let bare = || Manifest { materials: vec![sample_manifest().materials.remove(1)], ..bare() };
    assert!(finish(bare(), &[sample_fins()]).contains("expected none because the manifest has no fur.fins"));
    assert!(finish(bare(), &[sample_fins(), sample_fins()]).contains("a second section of this tag"));
    let uneven = FinData { part_counts: vec![1], ..sample_fins() };
    assert!(finish(bare(), &[uneven]).contains("the parts have 1 fins, expected 3"));
    // Textures without fins, and fins whose parts are not the manifest's.
    let textures = |writer: PackageWriter<'_>| {
        let package = Package::open(&good, &LIMITS()).unwrap();
        let files = (0..8).map(|k| package.texture(k).unwrap().ktx2.to_vec());
        files.fold(writer, PackageWriter::texture).finish().unwrap_err().to_string()
    };
    let writer = || PackageWriter::new(sample_manifest()).mesh(&sample_mesh(false));
    assert!(textures(writer()).contains("section FINS number 0 is missing"));
    let one = FinData { part_counts: vec![3], ..sample_fins() };
    assert!(textures(writer().fins(&one)).contains("fins of 1 parts, expected 2"));
}

#[test]
fn trailing_bytes_are_an_error() {
    let good = sample_package();
    for extra in [1, 15, 16, 1000] {
        let mut bytes = good.clone();
        bytes.resize(good.len() + extra, 0);
        let expected = FormatError::TrailingBytes { offset: good.len() as u64, count: extra as u64 };
        assert_eq!(Package::open(&bytes, &LIMITS()).unwrap_err(), expected);
    }
}

#[test]
fn a_newer_version_is_named_whatever_follows() {
    let mut bytes = sample_package();
    put(&mut bytes, 8, &4u32.to_le_bytes());
    let newer = |found| FormatError::Version { found, supported: 3 };
    assert_eq!(Package::open(&bytes, &LIMITS()).unwrap_err(), newer(4));
    // A package of a later version may contain anything after its version number, or may even end there.
    let mut garbage = b"\x89PELAGE\n\xff\xff\xff\xff".to_vec();
    assert_eq!(Package::open(&garbage, &LIMITS()).unwrap_err(), newer(u32::MAX));
    garbage.extend_from_slice(&[0xee; 999]);
    assert_eq!(Package::open(&garbage, &LIMITS()).unwrap_err(), newer(u32::MAX));
    assert!(newer(4).to_string().contains("newer than this reader"));
    // Version 0 never existed.
    put(&mut bytes, 8, &0u32.to_le_bytes());
    assert_eq!(Package::open(&bytes, &LIMITS()).unwrap_err().to_string(), "version at byte 8 is 0, expected 1..=3");
}

#[test]
fn other_files_are_not_packages() {
    for bytes in [&b""[..], b"glTF", b"PELAGE\n\n", b"\x89PELAGE\r\n", &[0; 4096], &[0xff; 7]] {
        let error = Package::open(bytes, &LIMITS()).unwrap_err();
        assert!(matches!(error, FormatError::Magic { .. }), "{bytes:02x?}: {error}");
        assert!(error.to_string().contains("not a pelage package"), "{error}");
    }
}

/// Every length, count and offset of header and table is set to values at and around the powers of two where arithmetic
/// wraps.
#[test]
fn enormous_fields_are_errors() {
    let good = sample_package();
    let count = Package::open(&good, &LIMITS()).unwrap().sections().len();
    let values = [u32::MAX.into(), 1 << 32, (1 << 32) - 16, 1 << 62, i64::MAX as u64, 1 << 63, u64::MAX - 15, u64::MAX];
    for at in (0..count).flat_map(|k| [32 + 32 * k + 8, 32 + 32 * k + 16]).chain([16]) {
        for value in values {
            let mut bytes = good.clone();
            put(&mut bytes, at as u64, &u64::to_le_bytes(value));
            reseal(&mut bytes);
            let error = Package::open(&bytes, &LIMITS()).unwrap_err();
            let named = error.to_string().contains(&value.to_string());
            assert!(named, "field at {at} = {value}: {error}");
        }
    }
    for count in [u32::MAX, 4097, 1 << 27] {
        let mut bytes = good.clone();
        put(&mut bytes, 12, &count.to_le_bytes());
        let error = Package::open(&bytes, &LIMITS()).unwrap_err();
        assert!(matches!(error, FormatError::Limit { offset: 12, .. }), "{error}");
    }
}

/// The counts in MESH are made enormous, with correct checksums.
#[test]
fn enormous_mesh_counts_are_errors() {
    let good = sample_package();
    let mesh = section(&good, Tag::MESH).offset;
    let unlimited = Limits { vertices: u32::MAX, indices: u32::MAX, ..LIMITS() };
    for at in [0, 4] {
        for value in [u32::MAX, u32::MAX - 1, 1 << 31, 1 << 24] {
            let mut bytes = good.clone();
            put(&mut bytes, mesh + at, &value.to_le_bytes());
            reseal(&mut bytes);
            for limits in [LIMITS(), unlimited.clone()] {
                let faults = Package::validate(&bytes, &limits);
                assert_eq!(faults.len(), 1, "{faults:?}");
                assert_eq!(faults[0].section(), Some(Tag::MESH));
            }
        }
    }
}

/// An empty section after truncated padding begins past the end of the file.
#[test]
fn truncated_padding_before_an_empty_section_is_an_error() {
    let bytes = PackageWriter::new(Manifest { generator: "x".into(), ..Manifest::default() })
        .section(Tag(*b"NONE"), Vec::new())
        .finish()
        .unwrap();
    let manifest = section(&bytes, Tag::MANIFEST);
    let end = (manifest.offset + manifest.length) as usize;
    assert!(!end.is_multiple_of(16), "the test needs padding, the manifest ends at {end}");
    for length in end..bytes.len() {
        let error = Package::open(&bytes[..length], &LIMITS()).unwrap_err();
        assert!(matches!(error, FormatError::Truncated { what: "padding", .. }), "{length}: {error}");
    }
}

/// Opening reads only header, table and manifest. A damaged texture is detected when it is used, and others still work.
#[test]
fn damaged_sections_are_reported_at_first_use() {
    let mut bytes = sample_package();
    let sections = Package::open(&bytes, &LIMITS()).unwrap().sections().to_vec();
    for s in sections.iter().skip(1) {
        bytes[s.offset as usize] ^= 1;
    }
    let package = Package::open(&bytes, &LIMITS()).unwrap();
    assert_eq!(package.manifest(), &sample_manifest());
    let damaged = |error: FormatError, tag, k: usize| {
        assert!(matches!(error, FormatError::Checksum { .. }), "{error}");
        assert_eq!((error.section(), error.offset()), (Some(tag), Some(sections[k].offset)));
    };
    damaged(package.mesh().unwrap_err(), Tag::MESH, 1);
    damaged(package.animation().unwrap_err(), Tag::ANIMATION, 2);
    damaged(package.texture(1).unwrap_err(), Tag::TEXTURE, 4);
    damaged(package.section_bytes(5).unwrap_err(), Tag(*b"XTRA"), 5);
    // The faults are in mesh, animation, fins, the section of a later version, and eight textures.
    assert_eq!(Package::validate(&bytes, &LIMITS()).len(), 12);
    bytes[sections[4].offset as usize] ^= 1;
    let package = Package::open(&bytes, &LIMITS()).unwrap();
    package.texture(1).unwrap();
    damaged(package.texture(0).unwrap_err(), Tag::TEXTURE, 3);
}

#[test]
fn limits_are_enforced() {
    let bytes = sample_package();
    let lengths = |tag| section(&bytes, tag).length;
    let cases = [
        ("section count", Tag::HEAD, Limits { sections: 12, ..LIMITS() }),
        ("manifest length", Tag::MANIFEST, Limits { manifest_bytes: lengths(Tag::MANIFEST) - 1, ..LIMITS() }),
        ("animation length", Tag::ANIMATION, Limits { animation_bytes: lengths(Tag::ANIMATION) - 1, ..LIMITS() }),
        ("vertex count", Tag::MESH, Limits { vertices: 4, ..LIMITS() }),
        ("index count", Tag::MESH, Limits { indices: 11, ..LIMITS() }),
        ("fin count", Tag::FINS, Limits { fins: 2, ..LIMITS() }),
        ("texture width", Tag::TEXTURE, Limits { texture_size: 7, ..LIMITS() }),
        ("texture layers", Tag::TEXTURE, Limits { texture_layers: 2, ..LIMITS() }),
    ];
    for (name, tag, limits) in cases {
        let faults = Package::validate(&bytes, &limits);
        let of_this_limit =
            |f: &FormatError| matches!(f, FormatError::Limit { what, .. } if *what == name) && f.section() == Some(tag);
        assert!(!faults.is_empty() && faults.iter().all(of_this_limit), "{name}: {faults:?}");
    }
    let tight = Limits {
        sections: 13,
        manifest_bytes: lengths(Tag::MANIFEST),
        animation_bytes: lengths(Tag::ANIMATION),
        vertices: 5,
        indices: 12,
        fins: 3,
        strands: 0,
        texture_size: 8,
        texture_layers: 3,
    };
    assert_eq!(Package::validate(&bytes, &tight), [], "exactly at the limits");
}

fn refused(manifest: Manifest, expected: &str) {
    let error = PackageWriter::new(manifest.clone()).finish().expect_err(expected);
    assert!(error.to_string().contains(expected), "expected {expected:?} in: {error}");
}

#[test]
fn manifest_contents_are_checked() {
    let with = |change: fn(&mut Manifest)| {
        let mut manifest = sample_manifest();
        change(&mut manifest);
        manifest
    };
    refused(with(|m| m.bounds.min[1] = f32::NAN), "bounds.min is NaN");
    refused(with(|m| m.bounds.min[1] = 7.0), "bounds.min[1] is 7");
    refused(with(|m| m.bounds.radius = -1.0), "bounds.radius is -1");
    refused(with(|m| m.shading.specular_exponent = 10_001.0), "shading.specular_exponent is 10001");
    refused(with(|m| m.shading.back_light_range = 0.0), "shading.back_light_range is 0");
    refused(with(|m| m.shading.diffuse[2] = f32::INFINITY), "shading.diffuse is inf");
    refused(with(|m| m.fur.color_texture = 8), "fur.color_texture is 8, expected less than 8, the number");
    refused(with(|m| m.fur.tile_size_m = 0.0), "fur has tile_size_m 0");
    refused(with(|m| m.fur.tile_texels = 0), "fur.tile_texels is 0");
    refused(with(|m| m.materials[0].base_color_texture = Some(9)), "materials[0].base_color_texture is 9");
    refused(with(|m| m.materials[1].groom_texture = Some(8)), "materials[1].groom_texture is 8");
    refused(with(|m| m.fur.wet.as_mut().unwrap().direction_texture = 8), "fur.wet.direction_texture is 8");
    refused(with(|m| m.fur.fins.as_mut().unwrap().color_texture = 8), "fur.fins.color_texture is 8");
    refused(with(|m| m.fur.fins.as_mut().unwrap().slabs = 0), "fur.fins is 8x4 texels in 0 slabs");
    refused(with(|m| m.fur.layers = 0), "fur.layers is 0 but fur.wet, fur.fins or coat (far layer) is present");
    refused(with(|m| m.coat.as_mut().unwrap().height = f32::NAN), "coat.height is NaN, expected 0..=1");
    refused(with(|m| m.coat.as_mut().unwrap().light_slanted = 0.75), "coat.light_slanted is 0.75, expected 0..=0.5");
    refused(with(|m| m.coat = None), "detail[2].step is 0, expected above 0 in a package without far layer");
    refused(with(|m| m.detail[0].step = 2), "detail[0].step is 2, expected 1");
    refused(with(|m| m.detail[1].step = 4), "detail[1].step is 4, expected 2");
    refused(with(|m| m.detail[1].step = 0), "detail[1].step is 0, expected 2");
    refused(with(|m| m.detail.truncate(2)), "detail[1].full_px is 12, expected 0 for full_px and gone_px in the last");
    refused(with(|m| m.detail[1].full_px = 20.0), "detail[1].full_px is 20, expected more than 0 and at most 18");
    refused(with(|m| m.detail[0].full_px = f32::INFINITY), "detail[0].full_px is inf");
    refused(with(|m| m.detail[0].gone_px = 25.0), "detail[0].gone_px is 25, expected 0 to full_px, 24");
    refused(with(|m| m.detail[0].density = 2.0), "detail[0].density is 2, expected 1");
    refused(with(|m| m.detail[1].density = 0.0), "detail[1].density is 0, expected a finite number above 0");
    refused(with(|m| m.detail[1].fins = 1.5), "detail[1].fins is 1.5");
    refused(
        Manifest { detail: sample_manifest().detail, ..Manifest::default() },
        "detail has 3 levels, expected none without fur",
    );
    let choice = |change: fn(&mut Choice)| {
        let mut manifest = sample_manifest();
        change(manifest.choice.as_mut().unwrap());
        manifest
    };
    refused(choice(|c| c.limits = ChoiceLimits::default()), "choice.limits sets no limit, expected at least one");
    refused(choice(|c| c.limits.max_frame_ms = Some(-1.0)), "choice.limits.max_frame_ms is -1");
    refused(
        choice(|c| c.binding = "max_frame_ms".into()),
        "choice.binding is \"max_frame_ms\", expected an empty string or one of [\"max_error\"",
    );
    refused(choice(|c| c.height = 0), "choice has a picture of 640x0 pixels");
    refused(choice(|c| c.trials[1].error = Some(f64::NAN)), "choice.trials[1].error is NaN");
    refused(choice(|c| c.chosen = 2), "choice.chosen is 2, expected less than the 2 trials");
    refused(choice(|c| c.next_better = Some(9)), "choice.next_better is 9");
    refused(with(|m| m.materials[1].alpha_cutoff = Some(f32::NAN)), "materials[1].alpha_cutoff is NaN");
    refused(with(|m| m.parts[0].material = 2), "parts[0].material is 2");
    refused(with(|m| m.parts[1].first_index = 6), "parts[1] has index_count 3 and first_index 6");
    refused(with(|m| m.parts[1].index_count = 4), "parts[1] has index_count 4 and first_index 9");
    refused(with(|m| m.textures[0].name = "../x".into()), "textures[0].name is \"../x\"");
    refused(with(|m| m.textures[2].name = "Shell_Color".into()), "is taken");
    refused(with(|m| m.quality[0].value = f64::NAN), "\"angle_distortion\" is NaN");
    refused(with(|_| ()), "names 8 textures, the package holds 0");
    let bald = Manifest { textures: Vec::new(), fur: FurInfo::default(), ..common::sample_manifest_v2() };
    refused(Manifest { materials: Vec::new(), ..bald }, "parts[0]");
}

#[test]
fn parts_need_a_mesh_and_skin_needs_a_skeleton() {
    let manifest = || Manifest {
        materials: sample_manifest().materials.split_off(1),
        parts: vec![Part { material: 0, first_index: 0, index_count: 12 }],
        ..Manifest::default()
    };
    let finish = |writer: PackageWriter<'_>| writer.finish().unwrap_err().to_string();
    assert!(finish(PackageWriter::new(manifest())).contains("section MESH number 0 is missing"));
    let skinned = PackageWriter::new(manifest()).mesh(&sample_mesh(true));
    assert!(finish(skinned).contains("joint 1, expected less than the 0"));
    let rigid = PackageWriter::new(manifest()).mesh(&sample_mesh(false)).animation(&common::sample_animation());
    assert!(finish(rigid).contains("expected joints and weights"));
    PackageWriter::new(manifest()).mesh(&sample_mesh(false)).finish().unwrap();
    let two = PackageWriter::new(manifest()).mesh(&sample_mesh(false)).mesh(&sample_mesh(false));
    assert!(finish(two).contains("a second section of this tag"));
    let stand_in = PackageWriter::new(Manifest::default()).section(Tag::HEAD, Vec::new());
    assert!(finish(stand_in).contains("section tag"));
    let mut uneven = sample_mesh(false);
    uneven.attributes.pop();
    assert!(finish(PackageWriter::new(manifest()).mesh(&uneven)).contains("one of each per vertex"));
}

/// No GPU could use these shell and base-colour textures in the way that the manifest states.
#[test]
fn textures_must_fit_their_use() {
    use TextureFormat::*;
    let good = |k: usize| match k {
        0 | 3 => ktx2_file(Bc7Srgb, 4, 4, 3, 1, 0),
        1 | 4 => ktx2_file(Rg8Unorm, 4, 4, 3, 1, 0),
        5 => ktx2_file(Bc7Srgb, 8, 4, 2, 1, 0),
        6 => ktx2_file(Bc5Unorm, 8, 4, 2, 1, 0),
        7 => ktx2_file(Rg8Unorm, 5, 3, 0, 3, 0),
        _ => ktx2_file(Rgba8Srgb, 5, 3, 0, 3, 0),
    };
    let finish = |k: usize, texture: Vec<u8>| {
        let textures = (0..8).map(|i| if i == k { texture.clone() } else { good(i) });
        let manifest = Manifest { parts: Vec::new(), ..sample_manifest() };
        let writer = PackageWriter::new(manifest).fins(&FinData::default());
        textures.fold(writer, PackageWriter::texture).finish()
    };
    finish(0, good(0)).unwrap();
    for format in [Rgba8Unorm, Bc7Unorm, Rg8Unorm, Bc5Unorm] {
        finish(1, ktx2_file(format, 4, 4, 3, 1, 0)).unwrap();
    }
    for (k, texture, expected) in [
        (0, ktx2_file(Bc7Srgb, 4, 4, 2, 1, 0), "\"shell_color\" has 4x4 texels and layer count 2, expected 4x4 and 3"),
        (0, ktx2_file(Bc7Srgb, 8, 4, 3, 1, 0), "\"shell_color\" has 8x4 texels"),
        (1, ktx2_file(Rg8Unorm, 2, 2, 3, 1, 0), "\"shell_direction\" has 2x2 texels"),
        (0, ktx2_file(Rg8Unorm, 4, 4, 3, 1, 0), "\"shell_color\" is rg8unorm, expected four components"),
        (
            1,
            ktx2_file(Rgba8Srgb, 4, 4, 3, 1, 0),
            "\"shell_direction\" is rgba8unorm-srgb, expected a format that is not",
        ),
        (3, ktx2_file(Bc7Srgb, 4, 4, 2, 1, 0), "\"wet_color\" has 4x4 texels and layer count 2, expected 4x4 and 3"),
        (4, ktx2_file(Rgba8Srgb, 4, 4, 3, 1, 0), "\"wet_direction\" is rgba8unorm-srgb"),
        (5, ktx2_file(Bc7Srgb, 8, 4, 1, 1, 0), "\"fin_color\" has 8x4 texels and layer count 1, expected 8x4 and 2"),
        (5, ktx2_file(Bc5Unorm, 8, 4, 2, 1, 0), "\"fin_color\" is bc5-rg-unorm, expected four components"),
        (6, ktx2_file(Rgba8Srgb, 8, 4, 2, 1, 0), "\"fin_direction\" is rgba8unorm-srgb"),
        (7, ktx2_file(Rgba8Srgb, 4, 4, 0, 1, 0), "\"groom\" has format rgba8unorm-srgb and layer count 1"),
        (7, ktx2_file(Rg8Unorm, 4, 4, 2, 1, 0), "\"groom\" has format rg8unorm and layer count 2"),
        (2, ktx2_file(Rg8Unorm, 4, 4, 0, 1, 0), "\"base-color\" has format rg8unorm and layer count 1"),
        (2, ktx2_file(Rgba8Srgb, 4, 4, 2, 1, 0), "\"base-color\" has format rgba8unorm-srgb and layer count 2"),
    ] {
        let error = finish(k, texture).unwrap_err();
        assert_eq!(error.section(), Some(Tag::TEXTURE));
        assert!(error.to_string().contains(expected), "expected {expected:?} in: {error}");
    }
}
