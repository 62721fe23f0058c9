//! Assembly of packages: from a bake, from a package sliced again, or from a folder written by `pelage unpack`.

use super::slice::ShellTextures;
use pelage_formats::meaning::openness::Openness;
use pelage_formats::{
    Animation, ContourMesh, FibreInfo, FinData, FormatError, Gloss, HairGroup, HairMotion, InkData, Manifest, MeshData,
    Morphs, Package, PackageWriter, RootsInfo, SimplifiedLevel, StoredStrands, StrandsData, StrokePool, Tag,
    TextureEntry, VisibilityInfo,
};
use std::borrow::Cow;
use std::sync::Arc;

/// Section of a package: either new data, or bytes copied from another package.
#[derive(Clone, Debug)]
pub enum Content<'a> {
    /// Mesh.
    Mesh(Arc<MeshData>),
    /// Skeleton and clips.
    Animation(Arc<Animation>),
    /// Morph targets.
    Morphs(Arc<Morphs>),
    /// Fins.
    Fins(FinData),
    /// Ink style.
    Ink(InkData),
    /// Strokes of a painted model.
    Strokes(Arc<StrokePool>),
    /// Contour mesh of the ink style.
    Contours(Arc<ContourMesh>),
    /// Simplified index lists.
    Simplified(Arc<[SimplifiedLevel]>),
    /// Strands of the tile.
    Strands(StrandsData),
    /// Strands of the tile, quantized as they are stored in the section.
    StoredStrands(StoredStrands),
    /// Guided hair.
    Hair(Vec<HairGroup>),
    /// Motion of guided hair.
    HairMotion(Arc<HairMotion>),
    /// Scattering of light by the fibres.
    Fibres(FibreInfo),
    /// Indices of the visibility textures.
    Visibility(VisibilityInfo),
    /// Openness at each vertex: share of the environment that the body does not occlude.
    Openness(Arc<[Openness]>),
    /// Stored normals of bare surface at each vertex.
    BareNormals(Arc<[[i16; 2]]>),
    /// Gloss of the bare surface of each material.
    Gloss(Vec<Option<Gloss>>),
    /// Lateral displacement of hair from its root.
    Roots(RootsInfo),
    /// Colour of the hair on each material, if it differs from that of the skin.
    HairColors(Vec<Option<[f32; 3]>>),
    /// Complete .ktx2 file. The k-th texture section belongs to the k-th texture of the manifest.
    Texture(Cow<'a, [u8]>),
    /// Section with this tag, copied unchanged from another package or a file.
    Bytes(Tag, Cow<'a, [u8]>),
}

impl Content<'_> {
    /// Returns the same content with borrowed bytes.
    pub fn borrowed(&self) -> Content<'_> {
        match self {
            Content::Texture(file) => Content::Texture(Cow::Borrowed(file)),
            Content::Bytes(tag, bytes) => Content::Bytes(*tag, Cow::Borrowed(bytes)),
            made => made.clone(),
        }
    }
}

/// Writes a package in version `version` of the format: the manifest, then the sections in order.
///
/// Fails with the error of opening or validating the written package.
pub fn assemble<'a>(
    version: u32,
    manifest: Manifest,
    sections: impl IntoIterator<Item = Content<'a>>,
) -> Result<Vec<u8>, FormatError> {
    let writer = PackageWriter::new(manifest).version(version);
    let add = |writer: PackageWriter<'a>, content| match content {
        Content::Mesh(mesh) => writer.mesh(&mesh),
        Content::Animation(animation) => writer.animation(&animation),
        Content::Morphs(morphs) => writer.morphs(&morphs),
        Content::Fins(fins) => writer.fins(&fins),
        Content::Ink(ink) => writer.ink(&ink),
        Content::Strokes(pool) => writer.stroke_pool(&pool),
        Content::Contours(contours) => writer.contours(&contours),
        Content::Simplified(levels) => writer.simplified(&levels),
        Content::Strands(strands) => writer.strands(&strands),
        Content::StoredStrands(strands) => writer.stored_strands(&strands),
        Content::Hair(groups) => writer.hair_groups(&groups),
        Content::HairMotion(motion) => writer.hair_motion(&motion),
        Content::Fibres(info) => writer.fibres(&info),
        Content::Visibility(info) => writer.visibility(&info),
        Content::Openness(vertices) => writer.openness(&vertices),
        Content::BareNormals(vertices) => writer.bare_normals(&vertices),
        Content::Gloss(materials) => writer.gloss(&materials),
        Content::Roots(info) => writer.roots(&info),
        Content::HairColors(colors) => writer.hair_colors(&colors),
        Content::Texture(file) => writer.texture(file),
        Content::Bytes(tag, bytes) => writer.section(tag, bytes),
    };
    sections.into_iter().fold(writer, add).finish()
}

/// Copies the sections of a package whose tags `take` accepts, except the manifest. They are unchanged and keep their
/// order.
///
/// Fails with the error of a damaged section.
pub fn copied_sections<'a>(package: &Package<'a>, take: impl Fn(Tag) -> bool) -> Result<Vec<Content<'a>>, FormatError> {
    let taken = package.sections().iter().enumerate().filter(|(_, s)| s.tag != Tag::MANIFEST && take(s.tag));
    taken.map(|(index, s)| Ok(Content::Bytes(s.tag, package.section_bytes(index)?.into()))).collect()
}

/// Texture of a package: name and .ktx2 file.
pub type NamedTexture<'a> = (Cow<'a, str>, Cow<'a, [u8]>);

/// Returns the same texture, borrowed.
pub fn borrowed_texture<'a>((name, file): &'a NamedTexture<'_>) -> NamedTexture<'a> {
    (Cow::Borrowed(name), Cow::Borrowed(file))
}

/// Returns a texture of an opened package, unchanged.
///
/// Fails with the error of a damaged or missing texture.
pub fn copied_texture<'a>(package: &Package<'a>, index: u32) -> Result<NamedTexture<'a>, FormatError> {
    let name = package.manifest().textures.get(index as usize).map_or("", |entry| &entry.name);
    Ok((name.to_owned().into(), package.texture(index)?.ktx2.into()))
}

/// Textures of a package under assembly, in order.
#[derive(Debug, Default)]
pub struct Textures<'a> {
    names: Vec<TextureEntry>,
    files: Vec<Cow<'a, [u8]>>,
}

impl<'a> Textures<'a> {
    /// Adds a texture and returns its index. A texture with the same name and contents is added only once.
    pub fn add(&mut self, (name, file): NamedTexture<'a>) -> u32 {
        let same = self.names.iter().zip(&self.files).position(|(entry, there)| entry.name == name && *there == file);
        let index = same.unwrap_or_else(|| {
            self.names.push(TextureEntry { name: name.into_owned() });
            self.files.push(file);
            self.files.len() - 1
        });
        index as u32
    }

    /// Adds the two textures of a shell volume, with a prefix to their names.
    pub fn add_shells(&mut self, prefix: &str, shells: &'a ShellTextures) -> pelage_formats::ShellTextures {
        let mut add = |what, file: &'a Vec<u8>| self.add((format!("{prefix}_{what}").into(), file.into()));
        pelage_formats::ShellTextures {
            color_texture: add("color", &shells.color),
            direction_texture: add("direction", &shells.direction),
        }
    }

    /// Returns the texture entries for the manifest, and the files.
    pub fn finish(self) -> (Vec<TextureEntry>, impl Iterator<Item = Content<'a>>) {
        (self.names, self.files.into_iter().map(Content::Texture))
    }
}
