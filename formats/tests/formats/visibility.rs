//! The `VISI` section: round trip and rejected contents.

use crate::common::{ktx2_file, sample_manifest, sample_mesh, section_bytes};
use pelage_formats::*;

const TEXELS: TextureFormat = TextureFormat::Rgba8Unorm;

/// Returns a package with dry and wet hair, whose visibility is in textures 2 and 5.
fn package(info: &VisibilityInfo, change: &dyn Fn(&mut Manifest), seen: &[u8]) -> Result<Vec<u8>, FormatError> {
    let mut manifest = Manifest {
        textures: (0..6).map(|i| TextureEntry { name: format!("t{i}") }).collect(),
        materials: sample_manifest().materials.split_off(1),
        parts: vec![Part { material: 0, first_index: 0, index_count: 12 }],
        ..sample_manifest()
    };
    (manifest.coat, manifest.choice, manifest.fur.fins) = (None, None, None);
    manifest.detail.clear();
    manifest.fur.wet = Some(ShellTextures { color_texture: 3, direction_texture: 4 });
    change(&mut manifest);
    let hair = |format| ktx2_file(format, 4, 4, 2, 3, 1);
    let writer = PackageWriter::new(manifest).mesh(&sample_mesh(false)).visibility(info);
    let writer = writer.texture(hair(TextureFormat::Rgba8Srgb)).texture(hair(TextureFormat::Rg8Unorm));
    let writer = writer.texture(seen.to_vec()).texture(hair(TextureFormat::Rgba8Srgb));
    writer.texture(hair(TextureFormat::Rg8Unorm)).texture(hair(TEXELS)).finish()
}

const INFO: VisibilityInfo = VisibilityInfo { texture: 2, wet_texture: Some(5), horizon: 8.0 };

fn sound() -> Vec<u8> {
    package(&INFO, &|_| (), &ktx2_file(TEXELS, 4, 4, 2, 3, 7)).unwrap()
}

#[test]
fn visibility_survives_a_round_trip() {
    let bytes = sound();
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    assert_eq!(package.visibility().unwrap(), Some(INFO));
    let textures = package.visibility_textures().unwrap().unwrap();
    assert_eq!((textures.dry.layers, textures.wet.unwrap().width), (2, 4));
    // Bytes that a reader in another language depends on: u32, option of u32, f32.
    let expected = [&2u32.to_le_bytes()[..], &[1], &5u32.to_le_bytes(), &8f32.to_le_bytes()].concat();
    assert_eq!(section_bytes(&package, Tag::VISIBILITY), expected);
}

#[test]
fn visibility_contents_are_checked() {
    let good = || ktx2_file(TEXELS, 4, 4, 2, 3, 7);
    for (info, change, seen, expected) in [
        (VisibilityInfo { horizon: 0.0, ..INFO }, None, good(), "horizon is 0, expected a finite number above 0"),
        (VisibilityInfo { horizon: f32::INFINITY, ..INFO }, None, good(), "horizon is inf"),
        (VisibilityInfo { wet_texture: None, ..INFO }, None, good(), "wet_texture and the manifest's fur.wet"),
        (VisibilityInfo { texture: 9, ..INFO }, None, good(), "section KTX2 number 9 is missing"),
        (INFO, None, ktx2_file(TEXELS, 4, 4, 3, 3, 7), "in 3 layers, expected 4x4 texels with four components"),
        (INFO, None, ktx2_file(TextureFormat::Rgba8Srgb, 4, 4, 2, 3, 7), "not sRGB, in 2 layers for the visibility"),
        (INFO, None, ktx2_file(TextureFormat::Rg8Unorm, 4, 4, 2, 3, 7), "with four components"),
        (
            VisibilityInfo { wet_texture: None, ..INFO },
            Some((|m: &mut Manifest| (m.fur.layers, m.fur.wet) = (0, None)) as fn(&mut Manifest)),
            good(),
            "visibility of a package without fur",
        ),
    ] {
        let error = package(&info, &|m| change.iter().for_each(|change| change(m)), &seen).unwrap_err().to_string();
        assert!(error.contains(expected), "expected {expected:?} in: {error}");
    }
}
