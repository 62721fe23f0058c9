//! Golden packages: a file of each version, which must stay readable, byte for byte, permanently.

use crate::common;
use pelage_formats::*;
use std::path::Path;

/// Returns the golden file of a version, and the same package as written by the current code.
fn golden(version: u32) -> (Vec<u8>, Vec<u8>) {
    let written = match version {
        1 => common::sample_package_v1(),
        2 => common::sample_package_v2(),
        _ => common::sample_package(),
    };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/golden/v{version}.pelage"));
    if std::env::var("PELAGE_WRITE_GOLDEN").is_ok_and(|v| v == "1") {
        std::fs::write(&path, &written).unwrap();
    }
    let golden = std::fs::read(&path).unwrap_or_else(|e| {
        panic!("{}: {e}; PELAGE_WRITE_GOLDEN=1 writes it, which makes a new format", path.display())
    });
    (golden, written)
}

#[test]
fn writer_reproduces_the_golden_packages() {
    for version in 1..=FORMAT_VERSION {
        let (golden, written) = golden(version);
        assert!(golden.len() <= 16 << 10, "the golden package has {} bytes", golden.len());
        let first = golden.iter().zip(&written).position(|(a, b)| a != b);
        assert!(
            golden == written,
            "{} bytes in the golden package of version {version}, {} written; first difference at {first:?}",
            golden.len(),
            written.len()
        );
    }
}

#[test]
fn golden_packages_read_as_expected() {
    for version in 1..=FORMAT_VERSION {
        let (bytes, _) = golden(version);
        assert_eq!(Package::validate(&bytes, &Limits::default()), []);
        let package = Package::open(&bytes, &Limits::default()).unwrap();
        assert_eq!(package.version(), version);
        assert_eq!(*package.animation().unwrap().unwrap(), common::sample_animation());
        let tags: Vec<_> = package.sections().iter().map(|s| s.tag.to_string()).collect();
        assert_eq!(tags[..7], ["MANI", "MESH", "ANIM", "KTX2", "KTX2", "XTRA", "KTX2"]);
        assert_eq!(package.section_bytes(5).unwrap(), b"a section of a later version");

        let fur = package.fur_textures().unwrap().unwrap();
        let color = fur.color;
        assert_eq!((color.format, color.width, color.height), (TextureFormat::Rgba8Srgb, 4, 4));
        // The shell textures have two array layers for shells. Since version 3, a third one holds the far layer.
        let layers = if version < 3 { 2 } else { 3 };
        assert_eq!((color.layers, color.levels), (layers, 3));
        assert_eq!(color.gpu_bytes(), u64::from(layers) * (64 + 16 + 4));
        assert_eq!(color.level(1), (1..=16 * layers as u8).collect::<Vec<u8>>());
        assert!(color.level(3).is_empty());
        assert_eq!(
            (fur.direction.format, fur.direction.level(0).len()),
            (TextureFormat::Bc5Unorm, 16 * layers as usize)
        );
        let base = package.base_color_texture(0).unwrap().unwrap();
        assert_eq!((base.format, base.layers, base.levels), (TextureFormat::Bc7Srgb, 1, 2));
        assert!(package.base_color_texture(1).unwrap().is_none());
    }
}

/// Fields missing from version 1 have these values: no extra lean, no groom, no wet hair, no fins.
#[test]
fn version_1_package_reads_with_defaults() {
    let (bytes, _) = golden(1);
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    assert_eq!(package.manifest(), &common::sample_manifest_v1());
    assert_eq!(package.mesh().unwrap().unwrap().to_data(), common::sample_mesh_v1(true));
    assert_eq!(package.sections().len(), 7);
    assert!(package.fins().unwrap().is_none() && package.fin_textures().unwrap().is_none());
    assert!(package.wet_textures().unwrap().is_none() && package.groom_texture(0).unwrap().is_none());
    let geometry: Vec<_> = package.mesh().unwrap().unwrap().geometry().collect();
    assert!(geometry.iter().all(|v| v.lean == 0.0));
    assert!(package.mesh().unwrap().unwrap().attributes().all(|v| v.groom == [0; 4]));
}

#[test]
fn version_2_has_lean_groom_wet_hair_and_fins() {
    let (bytes, _) = golden(2);
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    assert_eq!(package.manifest(), &common::sample_manifest_v2());
    assert_eq!(package.mesh().unwrap().unwrap().to_data(), common::sample_mesh(true));
    let fins = package.fins().unwrap().unwrap();
    assert_eq!((fins.count, fins.fins.len(), fins.to_data()), (3, 72, common::sample_fins()));
    let textures = package.fin_textures().unwrap().unwrap();
    assert_eq!((textures.color.width, textures.color.height, textures.color.layers), (8, 4, 2));
    assert_eq!(package.wet_textures().unwrap().unwrap().direction.format, TextureFormat::Rg8Unorm);
    assert_eq!(package.groom_texture(0).unwrap().unwrap().width, 3);
    assert!(package.groom_texture(1).unwrap().is_none());
}

#[test]
fn version_3_has_levels_of_detail_far_layer_and_choice() {
    let (bytes, _) = golden(3);
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    let manifest = package.manifest();
    assert_eq!(manifest, &common::sample_manifest());
    assert_eq!(manifest.detail.iter().map(|l| l.step).collect::<Vec<_>>(), [1, 2, 0]);
    let choice = manifest.choice.as_ref().unwrap();
    assert_eq!((choice.trials.len(), choice.chosen, choice.next_better), (2, 1, None));
    assert_eq!((manifest.fur.layers, manifest.shell_texture_layers()), (2, 3));
    let wet = package.wet_textures().unwrap().unwrap();
    assert_eq!((wet.color.layers, wet.direction.layers), (3, 3), "the coat has its wet form");
    assert_eq!(package.fins().unwrap().unwrap().to_data(), common::sample_fins());
}

/// All bytes that a reader in another language depends on. If this test fails, `FORMAT.md` is wrong too.
#[test]
fn header_and_table_have_their_specified_offsets() {
    let (bytes, _) = golden(3);
    let u32_at = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let u64_at = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    assert_eq!(bytes[..8], *b"\x89PELAGE\n");
    assert_eq!((u32_at(8), u32_at(12), u64_at(16), u32_at(28)), (3, 13, bytes.len() as u64, 0));
    let mut head = bytes[..24].to_vec();
    head.extend_from_slice(&bytes[28..32 + 13 * 32]);
    assert_eq!(u32_at(24), crc32fast::hash(&head));
    let mesh = 32 + 32;
    assert_eq!(bytes[mesh..mesh + 4], *b"MESH");
    let (offset, length) = (u64_at(mesh + 8) as usize, u64_at(mesh + 16) as usize);
    assert!(offset.is_multiple_of(16));
    assert_eq!(u32_at(mesh + 24), crc32fast::hash(&bytes[offset..offset + length]));
    assert_eq!((u32_at(offset), u32_at(offset + 4), u32_at(offset + 8)), (5, 12, 1));
    assert_eq!([16, 24, 32, 40].map(|at| u64_at(offset + at)), [64, 304, 432, 560]);
    let fins = 32 + 7 * 32;
    assert_eq!(bytes[fins..fins + 4], *b"FINS");
    let offset = u64_at(fins + 8) as usize;
    assert_eq!((u32_at(offset), u32_at(offset + 4), u64_at(offset + 8)), (3, 2, 32));
    assert_eq!([16, 20].map(|at| u32_at(offset + at)), [2, 1], "fins of the two parts");
    let second = offset + 32 + 24;
    assert_eq!([0, 4, 16].map(|at| u32_at(second + at)), [2, 1, 1], "from, to and slab of the second fin");
    assert_eq!([8, 12, 20].map(|at| f32::from_bits(u32_at(second + at))), [0.25, -1.5, 0.625]);
}
