//! The `FIBR` section: round trip and rejected contents.

use crate::common::{
    Refusal, assert_refused, furless_manifest, ktx2_file, sample_animation, sample_mesh, sample_with, section_bytes,
};
use pelage_formats::meaning::scattering::means::FibreMeans;
use pelage_formats::meaning::scattering::optics::Medulla;
use pelage_formats::meaning::scattering::tables::ScatteringTables;
use pelage_formats::*;

const HAIR: FibreOptics = FibreOptics { eta: 1.55, along: 0.13, tilt: 0.05, around: 0.12, medulla: Medulla::NONE };

fn sample() -> FibreInfo {
    let fibres = vec![HAIR, FibreOptics { tilt: -0.05, ..HAIR }];
    let means = FibreMeans { aside: 0.45, on: [[0.25; 4], [0.0; 4], [0.0; 4]], back: [[0.0; 4]; 3] };
    FibreInfo { texture: 0, fibres, means: vec![means; 2], of_groups: Vec::new(), of_materials: vec![1, 0] }
}

/// Returns a file of half floats whose bytes are all 1, so that every number is finite.
fn tables(size: u32, layers: u32) -> Vec<u8> {
    let mut file = ktx2_file(TextureFormat::Rgba16Float, size, size, layers, 1, 0);
    let texels = (8 * size * size * layers.max(1)) as usize;
    let at = file.len() - texels;
    file[at..].fill(1);
    file
}

fn packed(info: &FibreInfo, texture: Vec<u8>) -> Result<Vec<u8>, FormatError> {
    let textures = vec![TextureEntry { name: "fibres".into() }];
    let writer = PackageWriter::new(Manifest { textures, ..furless_manifest() });
    writer.mesh(&sample_mesh(true)).animation(&sample_animation()).texture(texture).fibres(info).finish()
}

#[test]
fn fibres_survive_a_round_trip() {
    let bytes = packed(&sample(), tables(8, 4)).unwrap();
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    assert_eq!(*package.fibres().unwrap().unwrap(), sample());
    let view = package.fibre_tables().unwrap().unwrap();
    assert_eq!((view.width, view.layers, view.format), (8, 4, TextureFormat::Rgba16Float));
    let layers = [2, 3].map(|layer| view.floats(layer).unwrap());
    let info = sample();
    let read = ScatteringTables::of_layers(info.fibres[1].eta.into(), info.means[1], layers).unwrap();
    assert_eq!((read.size, view.floats(4)), (8, None));
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
}

/// Medullae have a section of their own, which packages without medullae do not contain.
#[test]
fn medullae_survive_a_round_trip_and_are_checked() {
    let with = |medulla: Medulla| {
        let mut info = sample();
        info.fibres[1].medulla = medulla;
        info
    };
    let (info, none) = (with(Medulla { ratio: 0.75, scattering: 2.0 }), packed(&sample(), tables(8, 4)).unwrap());
    let bytes = packed(&info, tables(8, 4)).unwrap();
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    assert_eq!(*package.fibres().unwrap().unwrap(), info);
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    let expected = [2u64.to_le_bytes().to_vec(), [0.0f32, 0.0, 0.75, 2.0].map(f32::to_le_bytes).concat()].concat();
    assert_eq!(section_bytes(&package, Tag::MEDULLAE), expected);
    let count = |bytes| Package::open(bytes, &Limits::default()).unwrap().sections().len();
    assert_eq!(count(&bytes), count(&none) + 1);
    for (medulla, expected) in [
        (Medulla { ratio: 1.0, scattering: 1.0 }, "entry 1: ratio is 1, expected 0 to 0.95"),
        (Medulla { ratio: 0.5, scattering: 11.0 }, "entry 1: scattering is 11, expected 0 to 10"),
    ] {
        let error = packed(&with(medulla), tables(8, 4)).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let alone = sample_with(|writer| writer.section(Tag::MEDULLAE, expected.clone())).unwrap_err().to_string();
    assert!(alone.contains("2 entries, expected one for each of 0 fibres"), "{alone}");
}

#[test]
fn invalid_fibres_are_refused_with_the_reason() {
    let cases: [Refusal<FibreInfo>; 12] = [
        (|f| f.fibres.clear(), "0 fibres, expected 1 to 64"),
        (|f| f.fibres = vec![HAIR; 65], "65 fibres, expected 1 to 64"),
        (|f| f.fibres[1].eta = 1.0, "fibres[1]: eta is 1, expected 1.01 to 3"),
        (|f| f.fibres[0].along = f32::NAN, "fibres[0]: along is NaN"),
        (|f| f.fibres[0].tilt = 0.6, "fibres[0]: tilt is 0.6, expected -0.5 to 0.5"),
        (|f| f.fibres[0].around = 0.0, "fibres[0]: around is 0, expected 0.01 to 5"),
        (|f| f.means.truncate(1), "means has 1 entries, expected one for each of 2 fibres"),
        (|f| f.means[1].aside = -1.0, "means[1]: aside is -1, expected 0 to 1"),
        (|f| f.means[0].back[2][3] = f32::INFINITY, "means[0]: back holds inf, expected -10 to 10"),
        (|f| f.of_groups = vec![1], "of_groups has 1 entries, expected one for each of 0 groups"),
        (|f| f.of_materials.clear(), "of_materials has 0 entries, expected one for each of 2 materials"),
        (|f| f.of_materials[0] = 2, "of_materials[0] is 2, expected less than the 2 fibres"),
    ];
    assert_refused(Tag::FIBRES, sample, &cases, |info| packed(info, tables(8, 4)));
    let infinite = {
        let mut file = tables(8, 4);
        let last = file.len() - 1;
        file[last] = 0x7c;
        file
    };
    for (texture, expected) in [
        (tables(8, 8), "\"fibres\" is 8x8 texels of rgba16float in 8 layers, expected a square of rgba16float in 4"),
        (ktx2_file(TextureFormat::Rgba8Unorm, 8, 8, 4, 1, 0), "texels of rgba8unorm in 4 layers"),
        (ktx2_file(TextureFormat::Rgba16Float, 8, 4, 4, 1, 0), "is 8x4 texels of rgba16float"),
        (infinite, "has a number that is not finite"),
    ] {
        let told = packed(&sample(), texture).unwrap_err().to_string();
        assert!(told.contains(expected), "{told}\nexpected {expected}");
    }
}

/// Groups of hair must name existing fibres.
#[test]
fn groups_name_their_fibres() {
    let mut group = HairGroup { points: 3, lock_hairs: 1, root_radius_m: 1e-4, ..HairGroup::default() };
    let root = TrianglePoint { triangle: 0, weights: [0.5, 0.25, 0.25] };
    group.set_guides(&[(root, vec![glam::Vec3::Z * 0.1, glam::Vec3::Z * 0.2])]);
    let pack = |of_groups: Vec<u8>| {
        let textures = vec![TextureEntry { name: "fibres".into() }];
        let writer = PackageWriter::new(Manifest { textures, ..furless_manifest() });
        let writer = writer.mesh(&sample_mesh(true)).animation(&sample_animation()).texture(tables(8, 4));
        writer.hair_groups(std::slice::from_ref(&group)).fibres(&FibreInfo { of_groups, ..sample() }).finish()
    };
    pack(vec![1]).unwrap();
    let told = pack(vec![2]).unwrap_err().to_string();
    assert!(told.contains("of_groups[0] is 2, expected less than the 2 fibres"), "{told}");
}

/// Texels of a lookup table cannot be used as an image.
#[test]
fn half_float_textures_are_accepted_only_as_fibre_tables() {
    let mut manifest = furless_manifest();
    manifest.textures = vec![TextureEntry { name: "fibres".into() }];
    manifest.materials[0].base_color_texture = Some(0);
    let writer = PackageWriter::new(manifest).mesh(&sample_mesh(true)).animation(&sample_animation());
    let told = writer.texture(tables(4, 0)).finish().unwrap_err().to_string();
    assert!(told.contains("is rgba16float, a format for tables of fibres"), "{told}");
}
