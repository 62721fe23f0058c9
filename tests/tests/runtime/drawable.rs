//! Checks that `pelage validate` agrees with the runtime: a package loads if and only if it has no fault that prevents
//! drawing.
#![allow(clippy::unwrap_used, reason = "tests")]

use pelage_runtime::formats::{
    Limits, Manifest, MeshData, Package, PackageWriter, ShellTextures, Tag, TextureEntry, TextureFormat,
};
use pelage_runtime::{Renderer, RendererOptions};
use pelage_tests::binary::{Sandbox, workspace};
use pelage_tests::gpu::gpu;
use pelage_tests::mutate::assemble::{assemble, sections};
use pelage_tests::support::ktx2;
use pelage_tests::support::sphere::{SphereParams, package};
use serde_json::Value;

fn golden(name: &str) -> Vec<u8> {
    std::fs::read(workspace().join("formats/tests/golden").join(name)).unwrap()
}

fn sphere() -> Vec<u8> {
    package(&SphereParams {
        quads: 2,
        texels: 8,
        layers: 4,
        strands: 4,
        skeleton: true,
        ink: true,
        stripes: true,
        ..SphereParams::default()
    })
}

/// Returns the sphere with a damaged section: the last byte of the `nth` section with the tag is changed. The checksum
/// is updated if `sealed` is true.
fn damaged(tag: Tag, nth: usize, sealed: bool) -> Vec<u8> {
    let good = sphere();
    let (version, mut list) = sections(&good);
    let at = (0..list.len()).filter(|i| list[*i].0 == tag.0).nth(nth).unwrap();
    *list[at].1.last_mut().unwrap() ^= 0x80;
    if sealed {
        return assemble(version, &list);
    }
    let section = Package::open(&good, &Limits::default()).unwrap().sections()[at];
    let mut bad = good.clone();
    bad[(section.offset + section.length) as usize - 1] ^= 0x80;
    bad
}

/// Returns the sphere with wet hair, whose directions are in the given format.
fn with_wet_format(format: TextureFormat) -> Vec<u8> {
    let good = sphere();
    let package = Package::open(&good, &Limits::default()).unwrap();
    let mut manifest = package.manifest().clone();
    let first = manifest.textures.len() as u32;
    manifest.fur.wet = Some(ShellTextures { color_texture: manifest.fur.color_texture, direction_texture: first });
    manifest.textures.push(TextureEntry { name: "wet_direction".into() });
    let layers = package.manifest().shell_texture_layers();
    let bytes = format.layer_bytes(8, 8) * u64::from(layers);
    let texture = ktx2::write(format, 8, 8, layers, &[vec![128; bytes as usize]]);
    let sections = package.sections().iter().enumerate().skip(1);
    let writer =
        sections.fold(PackageWriter::new(manifest), |w, (i, s)| w.section(s.tag, package.section_bytes(i).unwrap()));
    writer.texture(texture).finish().unwrap()
}

/// Returns the sphere with an additional unused texture, whose bytes are zeros instead of a KTX2 file.
fn unused_texture() -> Vec<u8> {
    let good = sphere();
    let package = Package::open(&good, &Limits::default()).unwrap();
    let mut manifest = package.manifest().clone();
    manifest.textures.push(TextureEntry { name: "unused".into() });
    let texture = ktx2::write(TextureFormat::Rgba8Unorm, 4, 4, 1, &[vec![0; 64]]);
    let sections = package.sections().iter().enumerate().skip(1);
    let writer =
        sections.fold(PackageWriter::new(manifest), |w, (i, s)| w.section(s.tag, package.section_bytes(i).unwrap()));
    let (version, mut list) = self::sections(&writer.texture(texture).finish().unwrap());
    list.last_mut().unwrap().1.fill(0);
    assemble(version, &list)
}

#[test]
fn validated_packages_load_in_the_runtime() {
    let Some(gpu) = gpu("validated_packages_load_in_the_runtime") else { return };
    let renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let nothing = PackageWriter::new(Manifest::default());
    let without_triangles = PackageWriter::new(Manifest::default()).mesh(&MeshData::default());
    // Columns: name, package, exit code of `validate`, and whether the package is drawn.
    let table: Vec<(&str, Vec<u8>, i32, bool)> = vec![
        ("version 1", golden("v1.pelage"), 7, true),
        ("version 2", golden("v2.pelage"), 7, true),
        ("version 3", golden("v3.pelage"), 7, true),
        ("ink", golden("v3-ink.pelage"), 0, true),
        ("a sphere", sphere(), 0, true),
        ("wet as dry", with_wet_format(TextureFormat::Rg8Unorm), 0, true),
        ("unused texture with invalid data", unused_texture(), 7, true),
        ("one texel too many", damaged(Tag::TEXTURE, 0, true), 0, true),
        ("no mesh", nothing.finish().unwrap(), 7, false),
        ("no triangles", without_triangles.finish().unwrap(), 7, false),
        ("wet unlike dry", with_wet_format(TextureFormat::Rgba8Unorm), 7, false),
        ("a damaged shell", damaged(Tag::TEXTURE, 0, false), 7, false),
        ("a damaged base colour", damaged(Tag::TEXTURE, 2, false), 7, false),
        ("a damaged mesh", damaged(Tag::MESH, 0, false), 7, false),
        ("an index out of range", damaged(Tag::MESH, 0, true), 7, false),
        ("a damaged animation", damaged(Tag::ANIMATION, 0, false), 7, false),
        ("damaged ink", damaged(Tag::INK, 0, false), 7, false),
        ("ink with a reserved byte set", damaged(Tag::INK, 0, true), 7, false),
    ];
    let sandbox = Sandbox::new();
    for (name, bytes, code, drawn) in table {
        sandbox.write("a.pelage", &bytes);
        let run = sandbox.run(&["validate", "a.pelage", "--json"]);
        let answer: Value = serde_json::from_str(&run.stdout).unwrap();
        let stops = answer["faults"].as_array().unwrap().iter().any(|fault| fault["stops_drawing"] == true);
        let loaded = renderer.load_bytes(&bytes).map(drop);
        println!("{name}: {:?} {stops} {loaded:?}", run.code);
        assert_eq!((run.code, stops), (Some(code), !drawn), "{name}: {answer}");
        assert_eq!(loaded.is_ok(), drawn, "{name}: {loaded:?}");
    }
}
