//! Packages derived from others: with fins, with fibres, or with a changed manifest.

use crate::support::ktx2;
use pelage_bake::recipe::FibreParams;
use pelage_bake::stages::scatter;
use pelage_runtime::formats::{
    Fin, FinData, FinInfo, Gloss, Limits, Manifest, Package, PackageWriter, StrandPoint, StrandsData, Tag,
    TextureEntry, TextureFormat,
};

/// Starts a package with a new manifest and the other sections of `package`. More sections can be added.
fn writer_with_sections<'a>(package: &Package<'a>, manifest: Manifest) -> PackageWriter<'a> {
    let sections = package.sections().iter().enumerate().skip(1);
    sections.fold(PackageWriter::new(manifest), |writer, (i, section)| {
        writer.section(section.tag, package.section_bytes(i).expect("a valid section"))
    })
}

fn open_package(bytes: &[u8]) -> Package<'_> {
    Package::open(bytes, &Limits::default()).expect("a valid package")
}

/// Returns the same package with a changed manifest.
pub fn with_manifest(bytes: &[u8], change: impl FnOnce(&mut Manifest)) -> Vec<u8> {
    let package = open_package(bytes);
    let mut manifest = package.manifest().clone();
    change(&mut manifest);
    writer_with_sections(&package, manifest).finish().expect("a valid package")
}

/// Returns the package without the sections of the given tags.
pub fn without_sections(bytes: &[u8], tags: &[Tag]) -> Vec<u8> {
    let package = open_package(bytes);
    let sections = package.sections().iter().enumerate().skip(1).filter(|(_, section)| !tags.contains(&section.tag));
    let writer = sections.fold(PackageWriter::new(package.manifest().clone()), |writer, (i, section)| {
        writer.section(section.tag, package.section_bytes(i).expect("a valid section"))
    });
    writer.finish().expect("a valid package")
}

/// Returns the package with gloss for each of its materials.
pub fn with_gloss(bytes: &[u8], gloss: &[Option<Gloss>]) -> Vec<u8> {
    let package = open_package(bytes);
    writer_with_sections(&package, package.manifest().clone()).gloss(gloss).finish().expect("a valid package")
}

/// Returns the package with the given tile strands.
pub fn with_strands(bytes: &[u8], strands: &StrandsData) -> Vec<u8> {
    let package = open_package(bytes);
    writer_with_sections(&package, package.manifest().clone()).strands(strands).finish().expect("a valid package")
}

/// Returns a package that has no guided hair, extended by such hair with the given fibres.
pub fn with_fibres(bytes: &[u8], fibre: &FibreParams) -> Vec<u8> {
    let package = open_package(bytes);
    let mut manifest = package.manifest().clone();
    let materials = manifest.materials.iter().map(|material| material.name.as_str());
    let made = scatter::tables(fibre, materials, std::iter::empty()).expect("there are few fibres");
    let texture = manifest.textures.len() as u32;
    manifest.textures.push(TextureEntry { name: "fibres".into() });
    let info = made.info(texture);
    writer_with_sections(&package, manifest).texture(made.file).fibres(&info).finish().expect("a valid package")
}

/// Returns white, fully lit strands, each with five points on a straight line.
///
/// * `roots`: positions in the tile
/// * `from`: height at which all strands begin, relative to the fur height
/// * `tips`: tip of each strand: sideways offset in tile widths, and height relative to the fur height; tips of wet
///   strands, if any, follow those of dry ones
/// * `radius`: radius in tile widths
pub fn straight_strands(roots: &[[f32; 2]], from: f32, tips: &[[f32; 3]], radius: f32) -> StrandsData {
    const POINTS: u32 = 5;
    let along = |tip: &[f32; 3]| {
        let [u, v, height] = *tip;
        (0..POINTS).map(move |i| {
            let share = i as f32 / (POINTS - 1) as f32;
            StrandPoint {
                aside: [u * share, v * share],
                height: from + (height - from) * share,
                radius,
                color: [255; 3],
                visibility: [255, 128, 128, 128],
            }
        })
    };
    StrandsData { points_per_strand: POINTS, roots: roots.to_vec(), points: tips.iter().flat_map(along).collect() }
}

/// Opacity of every texel in the fin textures, 0..=255.
pub const ALPHA: u8 = 128;

/// Returns the package with fins of uniform opacity, and without ink data. `edges` are pairs of vertices of its first
/// part.
pub fn with_fins(bytes: &[u8], edges: &[(u32, u32)]) -> Vec<u8> {
    let package = open_package(bytes);
    let mut manifest = package.manifest().clone();
    let first = manifest.textures.len() as u32;
    manifest.fur.fins =
        Some(FinInfo { width: 4, height: 4, slabs: 1, color_texture: first, direction_texture: first + 1 });
    manifest.textures.extend(["fin_color", "fin_direction"].map(|name| TextureEntry { name: name.into() }));
    let mut part_counts = vec![0; manifest.parts.len()];
    part_counts[0] = edges.len() as u32;
    let fin = |(a, b): &(u32, u32)| Fin { a: *a, b: *b, start: 0.0, length: 1.0, slab: 0, opacity: 1.0 };
    let fins = FinData { part_counts, fins: edges.iter().map(fin).collect() };
    let mesh = package.mesh().expect("a valid mesh").expect("a mesh").to_data();
    let mut writer = PackageWriter::new(manifest).mesh(&mesh).fins(&fins);
    if let Some(animation) = package.animation().expect("a valid animation") {
        writer = writer.animation(&animation);
    }
    for index in 0..first {
        writer = writer.texture(package.texture(index).expect("a valid texture").ktx2);
    }
    let texels = |texel: [u8; 4]| ktx2::write(TextureFormat::Rgba8Unorm, 4, 4, 1, &[texel.repeat(16)]);
    let writer = writer.texture(texels([60, 60, 60, ALPHA])).texture(texels([128, 128, 255, 255]));
    writer.finish().expect("a valid package")
}
