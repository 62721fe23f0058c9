//! The `INKW` section: golden package, round trip and rejected contents.

use crate::common::{self, ktx2_file, sample_mesh};
use pelage_formats::*;
use std::path::Path;

/// Returns the manifest of a bare [`sample_mesh`] with the ink style, which uses the manifest's first four textures.
fn manifest() -> Manifest {
    let name = |name: &str| TextureEntry { name: name.into() };
    Manifest {
        materials: common::sample_manifest().materials.split_off(1),
        parts: vec![Part { material: 0, first_index: 0, index_count: 12 }],
        textures: ["ink_stroke", "ink_wash", "ink_paper", "ink_fur"].map(name).to_vec(),
        ..Manifest::default()
    }
}

fn ink() -> InkData {
    let vertices = sample_mesh(false).geometry.len() as i16;
    let vertex = |i: i16| InkVertex {
        wash: [i * 8000 - 16000, 32767 - i],
        amount: 255 - i as u8,
        solid: 3 * i as u8,
        line: 128,
        reserved: 0,
    };
    let shading =
        InkShading { wash_speed: -0.5, wash_range: 0.25, normalised: true, line: 4.0, ..InkShading::default() };
    InkData {
        info: InkInfo {
            stroke_texture: 0,
            wash_texture: 1,
            paper_texture: 2,
            fur_texture: Some(3),
            grain_size_m: 0.5,
            shading,
        },
        vertices: (0..vertices).map(vertex).collect(),
    }
}

fn texture(k: usize) -> Vec<u8> {
    match k {
        1 => ktx2_file(TextureFormat::Bc7Unorm, 8, 8, 0, 2, 2),
        3 => ktx2_file(TextureFormat::Rgba8Unorm, 4, 4, 2, 3, 4),
        _ => ktx2_file(TextureFormat::Rgba8Unorm, 4, 4, 0, 3, 1 + k as u8),
    }
}

fn package(ink: &InkData, texture: impl Fn(usize) -> Vec<u8>) -> Result<Vec<u8>, FormatError> {
    let writer = PackageWriter::new(manifest()).mesh(&sample_mesh(false)).ink(ink);
    (0..4).map(texture).fold(writer, PackageWriter::texture).finish()
}

#[test]
fn golden_ink_package_reads_as_expected() {
    let written = package(&ink(), texture).unwrap();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/v3-ink.pelage");
    if std::env::var("PELAGE_WRITE_GOLDEN").is_ok_and(|v| v == "1") {
        std::fs::write(&path, &written).unwrap();
    }
    let golden = std::fs::read(&path).unwrap();
    assert!(golden == written, "{} bytes in the golden package, {} written", golden.len(), written.len());
    assert_eq!(Package::validate(&golden, &Limits::default()), []);
    let package = Package::open(&golden, &Limits::default()).unwrap();
    let view = package.ink().unwrap().unwrap();
    assert_eq!(view.to_data(), ink());
    let textures = package.ink_textures().unwrap().unwrap();
    assert_eq!((textures.wash.width, textures.fur.unwrap().layers), (8, 2));
    // Bytes that a reader in another language depends on.
    let section = package.sections().iter().find(|s| s.tag == Tag::INK).unwrap();
    let bytes = &golden[section.offset as usize..][..section.length as usize];
    let u32_at = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    // 12 bytes of texture indices, 1 + 4 of the optional index, 4 of the grain size, 4 + 4 + 1 + 4 * 4 of the
    // constants.
    assert_eq!([0, 4, 8, 12].map(u32_at), [5, 46, 64, 0]);
    assert_eq!([16, 20, 24, 29].map(u32_at), [0, 1, 2, 3]);
    assert_eq!((bytes[28], f32::from_bits(u32_at(33)), f32::from_bits(u32_at(37))), (1, 0.5, -0.5));
    assert_eq!(bytes[64..72], [&(-16000i16).to_le_bytes()[..], &32767i16.to_le_bytes(), &[255, 0, 128, 0]].concat());
}

#[test]
fn old_packages_have_no_ink() {
    // In older versions the tag is unknown, and the section is kept unread.
    let old = PackageWriter::new(Manifest::default()).version(2).section(Tag::INK, &b"anything"[..]).finish().unwrap();
    assert!(Package::open(&old, &Limits::default()).unwrap().ink().unwrap().is_none());
}

#[test]
fn ink_contents_are_checked() {
    let with = |change: &dyn Fn(&mut InkData)| {
        let mut data = ink();
        change(&mut data);
        data
    };
    for (data, expected) in [
        (with(&|d| d.vertices.truncate(4)), "4 vertices, expected the 5 of the mesh"),
        (with(&|d| d.vertices[2].reserved = 1), "vertex 2 is"),
        (with(&|d| d.vertices[3].wash[1] = i16::MIN), "vertex 3 is"),
        (with(&|d| d.info.grain_size_m = 0.0), "grain_size_m is 0"),
        (with(&|d| d.info.shading.wash_speed = f32::NAN), "shading.wash_speed is NaN"),
        (with(&|d| d.info.shading.grain = 1.5), "shading.grain is 1.5, expected 0..=1"),
        (with(&|d| d.info.shading.line = -1.0), "shading.line is -1, expected 0..=4"),
        (with(&|d| d.info.paper_texture = 4), "section KTX2 number 4 is missing"),
        (
            with(&|d| d.info.stroke_texture = 3),
            "layer count 2, expected four components, not sRGB, and layer count 1 for stroke",
        ),
    ] {
        let error = package(&data, texture).unwrap_err().to_string();
        assert!(error.contains(expected), "expected {expected:?} in: {error}");
    }
    let srgb = |k| if k == 2 { ktx2_file(TextureFormat::Rgba8Srgb, 4, 4, 0, 1, 0) } else { texture(k) };
    let error = package(&ink(), srgb).unwrap_err().to_string();
    assert!(error.contains("\"ink_paper\" has format rgba8unorm-srgb"), "{error}");
    let two = PackageWriter::new(Manifest::default()).ink(&InkData::default()).ink(&InkData::default()).finish();
    assert!(two.is_err());
}

#[test]
fn every_truncation_and_changed_byte_of_ink_is_detected() {
    let bytes = package(&ink(), texture).unwrap();
    let opened = Package::open(&bytes, &Limits::default()).unwrap();
    let index = opened.sections().iter().position(|s| s.tag == Tag::INK).unwrap();
    let good = opened.section_bytes(index).unwrap();
    let rewrite = |section: &[u8]| {
        let writer = PackageWriter::new(manifest()).mesh(&sample_mesh(false)).section(Tag::INK, section.to_vec());
        (0..4).map(texture).fold(writer, PackageWriter::texture).finish()
    };
    assert_eq!(rewrite(good).unwrap(), bytes);
    for length in 0..good.len() {
        assert_eq!(rewrite(&good[..length]).unwrap_err().section(), Some(Tag::INK), "cut to {length} bytes");
    }
    // Header and padding have one legal value each.
    for at in (0..16).chain(62..64) {
        let mut damaged = good.to_vec();
        damaged[at] ^= 0x81;
        assert_eq!(rewrite(&damaged).unwrap_err().section(), Some(Tag::INK), "byte {at}");
    }
    let few = Limits { vertices: 4, ..Limits::default() };
    let opened = Package::open(&bytes, &few).unwrap();
    assert!(opened.ink().unwrap_err().to_string().contains("vertex count"));
}
