//! Where packages are put together: by a bake, by slicing one anew, and from the folder that `pelage unpack` wrote.

use super::textures::ShellTextures;
use pelage_formats::meaning::openness::Openness;
use pelage_formats::{
    Animation, FibreInfo, FinData, FormatError, HairGroup, HairMotion, InkData, Manifest, MeshData, Morphs, Package,
    PackageWriter, RootsInfo, SimplifiedLevel, StoredStrands, StrandsData, Tag, TextureEntry, VisibilityInfo,
};
use std::borrow::Cow;
use std::sync::Arc;

/// A section as it goes into a package: made, or the bytes of one that is carried over.
#[derive(Clone, Debug)]
pub enum Content<'a> {
    /// The mesh.
    Mesh(Arc<MeshData>),
    /// Skeleton and clips.
    Animation(Arc<Animation>),
    /// Morph targets.
    Morphs(Arc<Morphs>),
    /// The fins.
    Fins(FinData),
    /// The ink style.
    Ink(InkData),
    /// Index lists of fewer triangles.
    Simplified(Arc<[SimplifiedLevel]>),
    /// The strands of the tile.
    Strands(StrandsData),
    /// The same in the whole numbers of a section.
    StoredStrands(StoredStrands),
    /// Hair on guides.
    Hair(Vec<HairGroup>),
    /// How that moves.
    HairMotion(Arc<HairMotion>),
    /// How its fibres scatter light.
    Fibres(FibreInfo),
    /// Which textures say how much light reaches the hair.
    Visibility(VisibilityInfo),
    /// What the body leaves open to the hair at each vertex.
    Openness(Arc<[Openness]>),
    /// How far hair lies aside of its root.
    Roots(RootsInfo),
    /// A complete .ktx2 file; the k-th belongs to the manifest's k-th texture.
    Texture(Cow<'a, [u8]>),
    /// A section of that tag as it lies in another package, or in a file.
    Bytes(Tag, Cow<'a, [u8]>),
}

impl Content<'_> {
    /// The same, with the bytes borrowed.
    pub fn lent(&self) -> Content<'_> {
        match self {
            Content::Texture(file) => Content::Texture(Cow::Borrowed(file)),
            Content::Bytes(tag, bytes) => Content::Bytes(*tag, Cow::Borrowed(bytes)),
            made => made.clone(),
        }
    }
}

/// Writes a package of that version of the format: the manifest, then the sections in their order.
///
/// # Errors
/// What keeps the package from being opened and validated.
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
        Content::Simplified(levels) => writer.simplified(&levels),
        Content::Strands(strands) => writer.strands(&strands),
        Content::StoredStrands(strands) => writer.stored_strands(&strands),
        Content::Hair(groups) => writer.hair_groups(&groups),
        Content::HairMotion(motion) => writer.hair_motion(&motion),
        Content::Fibres(info) => writer.fibres(&info),
        Content::Visibility(info) => writer.visibility(&info),
        Content::Openness(vertices) => writer.openness(&vertices),
        Content::Roots(info) => writer.roots(&info),
        Content::Texture(file) => writer.texture(file),
        Content::Bytes(tag, bytes) => writer.section(tag, bytes),
    };
    sections.into_iter().fold(writer, add).finish()
}

/// The sections of a package whose tags `take` accepts, as they lie in it, in their order; never its manifest.
///
/// # Errors
/// A section that is damaged.
pub fn carried<'a>(package: &Package<'a>, take: impl Fn(Tag) -> bool) -> Result<Vec<Content<'a>>, FormatError> {
    let taken = package.sections().iter().enumerate().filter(|(_, s)| s.tag != Tag::MANIFEST && take(s.tag));
    taken.map(|(index, s)| Ok(Content::Bytes(s.tag, package.section_bytes(index)?.into()))).collect()
}

/// A texture of a package: its name, and its .ktx2 file.
pub type NamedTexture<'a> = (Cow<'a, str>, Cow<'a, [u8]>);

/// The same texture, borrowed.
pub fn lent<'a>((name, file): &'a NamedTexture<'_>) -> NamedTexture<'a> {
    (Cow::Borrowed(name), Cow::Borrowed(file))
}

/// A texture of an opened package, as it lies there.
///
/// # Errors
/// One that is damaged, or not there.
pub fn kept_texture<'a>(package: &Package<'a>, index: u32) -> Result<NamedTexture<'a>, FormatError> {
    let name = package.manifest().textures.get(index as usize).map_or("", |entry| &entry.name);
    Ok((name.to_owned().into(), package.texture(index)?.ktx2.into()))
}

/// The textures of a package that is being put together, in their order.
#[derive(Debug, Default)]
pub struct Textures<'a> {
    names: Vec<TextureEntry>,
    files: Vec<Cow<'a, [u8]>>,
}

impl<'a> Textures<'a> {
    /// The index of a texture, which is added unless it is there already: one of that name with the same file.
    pub fn add(&mut self, (name, file): NamedTexture<'a>) -> u32 {
        let same = self.names.iter().zip(&self.files).position(|(entry, there)| entry.name == name && *there == file);
        let index = same.unwrap_or_else(|| {
            self.names.push(TextureEntry { name: name.into_owned() });
            self.files.push(file);
            self.files.len() - 1
        });
        index as u32
    }

    /// Adds the two textures of a shell volume, their names prefixed.
    pub fn add_shells(&mut self, prefix: &str, shells: &'a ShellTextures) -> pelage_formats::ShellTextures {
        let mut add = |what, file: &'a Vec<u8>| self.add((format!("{prefix}_{what}").into(), file.into()));
        pelage_formats::ShellTextures {
            color_texture: add("color", &shells.color),
            direction_texture: add("direction", &shells.direction),
        }
    }

    /// Their names for the manifest, and their files.
    pub fn finish(self) -> (Vec<TextureEntry>, impl Iterator<Item = Content<'a>>) {
        (self.names, self.files.into_iter().map(Content::Texture))
    }
}
