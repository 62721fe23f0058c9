//! Opening and writing whole packages.

use crate::animation::Animation;
use crate::container::{self, FORMAT_VERSION, Section, Tag};
use crate::encoding::{decode_section, encode_section};
use crate::fins::{Fin, FinData, FinsView};
use crate::ink::{InkData, InkView};
use crate::manifest_v1::ManifestV1;
use crate::manifest_v2;
use crate::mesh::{MeshData, MeshView};
use crate::texture::TextureView;
use crate::{FormatError, Limits, Manifest};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};

/// An opened package, borrowing from the bytes it was opened from.
pub struct Package<'a> {
    bytes: &'a [u8],
    limits: Limits,
    version: u32,
    sections: Vec<Section>,
    /// Sections whose checksum was found right. Relaxed is enough: verifying twice is harmless.
    verified: Vec<AtomicBool>,
    manifest: Manifest,
}

impl fmt::Debug for Package<'_> {
    /// Says what is in the package, not its megabytes.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut out = f.debug_struct("Package");
        out.field("version", &self.version).field("bytes", &self.bytes.len());
        out.field("sections", &self.sections).field("manifest", &self.manifest);
        out.finish_non_exhaustive()
    }
}

impl<'a> Package<'a> {
    /// Reads header, section table and manifest. No other byte of the sections is touched: their checksums are verified, and
    /// their contents checked, when they are first used.
    pub fn open(bytes: &'a [u8], limits: &Limits) -> Result<Self, FormatError> {
        let (version, sections) = container::read_table(bytes, limits)?;
        let missing = || FormatError::MissingSection {
            tag: Tag::MANIFEST,
            index: 0,
            reason: "every package begins with its manifest".into(),
        };
        let first = *sections.first().filter(|s| s.tag == Tag::MANIFEST).ok_or_else(missing)?;
        for tag in [Tag::MANIFEST, Tag::MESH, Tag::ANIMATION, Tag::FINS, Tag::INK] {
            if !means(tag, version) {
                continue;
            }
            if let Some(second) = sections.iter().filter(|s| s.tag == tag).nth(1) {
                let reason = "a second section of this tag, expected at most one".into();
                return Err(FormatError::Content { tag, offset: second.offset, reason });
            }
        }
        check_limit("manifest length", &first, limits.manifest_bytes)?;
        let verified = sections.iter().map(|_| AtomicBool::new(false)).collect();
        let mut package =
            Self { bytes, limits: limits.clone(), version, sections, verified, manifest: Manifest::default() };
        let textures = package.sections.iter().filter(|s| s.tag == Tag::TEXTURE).count();
        let manifest = package.section_bytes(0)?;
        package.manifest = match version {
            1 => decode_section::<ManifestV1>(Tag::MANIFEST, first.offset, manifest)?.into(),
            2 => manifest_v2::decode(first.offset, manifest)?,
            _ => decode_section(Tag::MANIFEST, first.offset, manifest)?,
        };
        package.manifest.check().map_err(|reason| FormatError::Content {
            tag: Tag::MANIFEST,
            offset: first.offset,
            reason,
        })?;
        if textures != package.manifest.textures.len() {
            return Err(FormatError::MissingSection {
                tag: Tag::TEXTURE,
                index: textures.min(package.manifest.textures.len()) as u32,
                reason: format!(
                    "the manifest names {} textures, the package holds {textures}",
                    package.manifest.textures.len()
                ),
            });
        }
        Ok(package)
    }

    /// Reads everything: every checksum, every vertex, every texture's header, every key, and whether the manifest's textures
    /// are fit for their use. Returns all faults: those of each section in file order, then those between sections. Where
    /// the package does not open, that is the only fault found.
    pub fn validate(bytes: &'a [u8], limits: &Limits) -> Vec<FormatError> {
        let package = match Self::open(bytes, limits) {
            Ok(package) => package,
            Err(error) => return vec![error],
        };
        let mut faults: Vec<FormatError> = Vec::new();
        // A damaged section fails again in each check that uses it: once is enough.
        let mut add = |fault: Option<FormatError>| faults.extend(fault.filter(|fault| !faults.contains(fault)));
        let mut texture = 0;
        for (index, section) in package.sections.iter().enumerate() {
            add(match section.tag {
                Tag::MESH => package.mesh().map(drop),
                Tag::ANIMATION => package.animation().map(drop),
                Tag::FINS if means(Tag::FINS, package.version) => package.fins().map(drop),
                Tag::INK if means(Tag::INK, package.version) => package.ink().map(drop),
                Tag::TEXTURE => {
                    texture += 1;
                    package.texture(texture - 1).map(drop)
                }
                _ => package.section_bytes(index).map(drop),
            }
            .err());
        }
        if package.find(Tag::MESH, 0).is_none() {
            add(package.mesh().err());
        }
        if package.find(Tag::FINS, 0).is_none() {
            add(package.fins().err());
        }
        add(package.fur_textures().err());
        add(package.wet_textures().err());
        add(package.fin_textures().err());
        add(package.ink_textures().err());
        // Each texture once, however many materials share it.
        let (mut colors, mut grooms) = (BTreeSet::new(), BTreeSet::new());
        for (index, material) in package.manifest.materials.iter().enumerate() {
            if material.base_color_texture.is_some_and(|texture| colors.insert(texture)) {
                add(package.base_color_texture(index).err());
            }
            if material.groom_texture.is_some_and(|texture| grooms.insert(texture)) {
                add(package.groom_texture(index).err());
            }
        }
        faults
    }

    /// Version of the format the package was written in.
    pub fn version(&self) -> u32 {
        self.version
    }

    /// The bytes the package was opened from.
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// The manifest.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// The section table, in file order.
    pub fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// Bytes of section number `index` of the table; verifies its checksum the first time.
    pub fn section_bytes(&self, index: usize) -> Result<&'a [u8], FormatError> {
        let section = self.sections.get(index).ok_or_else(|| FormatError::MissingSection {
            tag: Tag::HEAD,
            index: index as u32,
            reason: format!("the table has {} entries", self.sections.len()),
        })?;
        let data = &self.bytes[section.offset as usize..(section.offset + section.length) as usize];
        if !self.verified[index].load(Ordering::Relaxed) {
            let found = crc32fast::hash(data);
            if found != section.checksum {
                let (tag, offset, expected) = (section.tag, section.offset, section.checksum);
                return Err(FormatError::Checksum { tag, offset, found, expected });
            }
            self.verified[index].store(true, Ordering::Relaxed);
        }
        Ok(data)
    }

    fn find(&self, tag: Tag, nth: usize) -> Option<(usize, Section)> {
        self.sections.iter().copied().enumerate().filter(|(_, s)| s.tag == tag).nth(nth)
    }

    /// The mesh; `None` for a package without one. Checks every vertex and index anew at every call.
    ///
    /// Fails where the manifest's parts do not cover the index buffer, a skinned mesh has no skeleton, or a mesh without skin
    /// has one.
    pub fn mesh(&self) -> Result<Option<MeshView<'a>>, FormatError> {
        let Some((index, section)) = self.find(Tag::MESH, 0) else {
            let parts = self.manifest.parts.len();
            if parts == 0 {
                return Ok(None);
            }
            let reason = format!("the manifest has {parts} parts of its indices");
            return Err(FormatError::MissingSection { tag: Tag::MESH, index: 0, reason });
        };
        let view = MeshView::parse(self.section_bytes(index)?, section.offset, self.version, &self.limits)?;
        let fail = |reason| FormatError::Content { tag: Tag::MESH, offset: section.offset, reason };
        let covered: u64 = self.manifest.parts.iter().map(|p| u64::from(p.index_count)).sum();
        if covered != u64::from(view.index_count) {
            let n = view.index_count;
            return Err(fail(format!("{n} indices, expected the {covered} that the manifest's parts cover")));
        }
        let joints = self.animation()?.map_or(0, |a| a.joints.len());
        if view.skin.is_empty() {
            if joints > 0 && view.vertex_count > 0 {
                return Err(fail(format!(
                    "vertices without joints, expected joints and weights beside {joints} joints"
                )));
            }
        } else {
            let top = view.skin().flat_map(|v| v.joints).map(usize::from).max().unwrap_or(0);
            if top >= joints {
                return Err(fail(format!("a vertex follows joint {top}, expected less than the {joints} joints")));
            }
        }
        Ok(Some(view))
    }

    /// Skeleton and clips; `None` for a package without. Decodes anew at every call.
    pub fn animation(&self) -> Result<Option<Animation>, FormatError> {
        let Some((index, section)) = self.find(Tag::ANIMATION, 0) else { return Ok(None) };
        check_limit("animation length", &section, self.limits.animation_bytes)?;
        let animation: Animation = decode_section(Tag::ANIMATION, section.offset, self.section_bytes(index)?)?;
        animation.check().map_err(|reason| FormatError::Content {
            tag: Tag::ANIMATION,
            offset: section.offset,
            reason,
        })?;
        Ok(Some(animation))
    }

    /// Texture number `index` of the manifest.
    pub fn texture(&self, index: u32) -> Result<TextureView<'a>, FormatError> {
        let (at, section) = self.find(Tag::TEXTURE, index as usize).ok_or_else(|| FormatError::MissingSection {
            tag: Tag::TEXTURE,
            index,
            reason: format!("the package holds {} textures", self.manifest.textures.len()),
        })?;
        TextureView::parse(self.section_bytes(at)?, section.offset, &self.limits)
    }

    /// Where texture number `index` of the manifest lies and what it is called, for an error about its use.
    fn texture_fault(&self, index: u32, reason: &str) -> FormatError {
        let offset = self.find(Tag::TEXTURE, index as usize).map_or(0, |(_, section)| section.offset);
        let name = self.manifest.textures.get(index as usize).map_or("", |t| &t.name);
        FormatError::Content { tag: Tag::TEXTURE, offset, reason: format!("texture {name:?} {reason}") }
    }

    /// The two shell textures; `None` for a package without fur.
    ///
    /// Fails where one of them is damaged or not as [`crate::FurInfo`] says: an array layer for each of `layers` and for the
    /// coat, `tile_texels` square, colour with four components, directions in a format that is not sRGB.
    pub fn fur_textures(&self) -> Result<Option<FurTextures<'a>>, FormatError> {
        let fur = &self.manifest.fur;
        if fur.layers == 0 {
            return Ok(None);
        }
        let size = (fur.tile_texels, fur.tile_texels, self.manifest.shell_texture_layers());
        self.hair_textures("fur", size, fur.color_texture, fur.direction_texture).map(Some)
    }

    /// The two textures of wet hair; `None` for a package without. They are as [`Package::fur_textures`], which see for errors.
    pub fn wet_textures(&self) -> Result<Option<FurTextures<'a>>, FormatError> {
        let fur = &self.manifest.fur;
        let Some(wet) = &fur.wet else { return Ok(None) };
        let size = (fur.tile_texels, fur.tile_texels, self.manifest.shell_texture_layers());
        self.hair_textures("fur.wet", size, wet.color_texture, wet.direction_texture).map(Some)
    }

    /// The two fin textures; `None` for a package without fins.
    ///
    /// Fails where one of them is damaged or not as [`crate::FinInfo`] says: `slabs` array layers of `width` by `height` texels,
    /// colour with four components, directions in a format that is not sRGB.
    pub fn fin_textures(&self) -> Result<Option<FurTextures<'a>>, FormatError> {
        let Some(fins) = &self.manifest.fur.fins else { return Ok(None) };
        let size = (fins.width, fins.height, fins.slabs);
        self.hair_textures("fur.fins", size, fins.color_texture, fins.direction_texture).map(Some)
    }

    /// A pair of textures of hair, colour and direction, of `size` texels across, down and array layers.
    fn hair_textures(
        &self,
        whose: &str,
        size: (u32, u32, u32),
        color_texture: u32,
        direction_texture: u32,
    ) -> Result<FurTextures<'a>, FormatError> {
        let (color, direction) = (self.texture(color_texture)?, self.texture(direction_texture)?);
        for (index, view) in [(color_texture, &color), (direction_texture, &direction)] {
            let found = (view.width, view.height, view.layers);
            if found != size {
                let reason = format!(
                    "is {}x{} texels in {} layers, expected {}x{} in {} as the manifest's {whose} says",
                    found.0, found.1, found.2, size.0, size.1, size.2
                );
                return Err(self.texture_fault(index, &reason));
            }
        }
        if color.format.components() != 4 {
            let reason = format!("is {}, expected four components for colour and opacity", color.format.name());
            return Err(self.texture_fault(color_texture, &reason));
        }
        if direction.format.is_srgb() {
            let reason = format!("is {}, expected a format that is not sRGB for directions", direction.format.name());
            return Err(self.texture_fault(direction_texture, &reason));
        }
        Ok(FurTextures { color, direction })
    }

    /// The fins; `None` for a package without. Checks every fin anew at every call.
    ///
    /// Fails where the manifest has no fin textures for them (or textures and no fins), the parts are not the manifest's, or a fin
    /// stands on a vertex or shows a slab that is not there.
    pub fn fins(&self) -> Result<Option<FinsView<'a>>, FormatError> {
        let section = self.find(Tag::FINS, 0).filter(|_| means(Tag::FINS, self.version));
        let (info, (index, section)) = match (&self.manifest.fur.fins, section) {
            (None, None) => return Ok(None),
            (Some(info), Some(found)) => (info, found),
            (Some(_), None) => {
                let reason = "the manifest's fur.fins has textures for them".into();
                return Err(FormatError::MissingSection { tag: Tag::FINS, index: 0, reason });
            }
            (None, Some((_, section))) => {
                let reason = "fins, expected none where the manifest's fur.fins is none".into();
                return Err(FormatError::Content { tag: Tag::FINS, offset: section.offset, reason });
            }
        };
        let view = FinsView::parse(self.section_bytes(index)?, section.offset, &self.limits)?;
        let fail = |at: u64, reason| FormatError::Content { tag: Tag::FINS, offset: section.offset + at, reason };
        let (found, parts) = (view.part_counts().len(), self.manifest.parts.len());
        if found != parts {
            return Err(fail(4, format!("fins of {found} parts, expected the {parts} of the manifest")));
        }
        let vertices = self.mesh()?.map_or(0, |mesh| mesh.vertex_count);
        let stands = |f: &Fin| f.a < vertices && f.b < vertices && f.slab < info.slabs;
        if let Some((i, fin)) = view.fins().enumerate().find(|(_, f)| !stands(f)) {
            let reason =
                format!("fin {i} is {fin:?}, expected less than the {vertices} vertices and {} slabs", info.slabs);
            return Err(fail(view.offset_of(i), reason));
        }
        Ok(Some(view))
    }

    /// The ink style; `None` for a package without. Checks every vertex anew at every call.
    ///
    /// Fails where the section is damaged, or has not a vertex for each of the mesh.
    pub fn ink(&self) -> Result<Option<InkView<'a>>, FormatError> {
        let Some((index, section)) = self.find(Tag::INK, 0).filter(|_| means(Tag::INK, self.version)) else {
            return Ok(None);
        };
        let view = InkView::parse(self.section_bytes(index)?, section.offset, &self.limits)?;
        let (found, expected) = (view.vertices().len(), self.mesh()?.map_or(0, |mesh| mesh.vertex_count));
        if found != expected as usize {
            let reason = format!("{found} vertices, expected the {expected} of the mesh");
            return Err(FormatError::Content { tag: Tag::INK, offset: section.offset, reason });
        }
        Ok(Some(view))
    }

    /// The textures of the ink style; `None` for a package without.
    ///
    /// Fails where one of them is damaged or not as [`crate::InkInfo`] says: in layers, components or colour space.
    pub fn ink_textures(&self) -> Result<Option<InkTextures<'a>>, FormatError> {
        let Some(ink) = self.ink()? else { return Ok(None) };
        let read = |what: &str, index: u32, layers: u32| {
            let view = self.texture(index)?;
            if view.layers != layers || view.format.components() != 4 || view.format.is_srgb() {
                let reason = format!(
                    "is {} in {} layers, expected four components that are not sRGB in {layers} as {what} of the ink style",
                    view.format.name(),
                    view.layers
                );
                return Err(self.texture_fault(index, &reason));
            }
            Ok(view)
        };
        Ok(Some(InkTextures {
            stroke: read("stroke", ink.info.stroke_texture, 1)?,
            wash: read("wash", ink.info.wash_texture, 1)?,
            paper: read("paper", ink.info.paper_texture, 1)?,
            fur: ink.info.fur_texture.map(|index| read("fur", index, 2)).transpose()?,
        }))
    }

    /// The base-colour texture of a material; `None` for a material without one, or a material that does not exist.
    ///
    /// Fails where the texture is damaged, has more than one array layer, or has not four components.
    pub fn base_color_texture(&self, material: usize) -> Result<Option<TextureView<'a>>, FormatError> {
        let Some(index) = self.manifest.materials.get(material).and_then(|m| m.base_color_texture) else {
            return Ok(None);
        };
        let view = self.texture(index)?;
        if view.layers != 1 || view.format.components() != 4 {
            let (layers, format) = (view.layers, view.format.name());
            let reason = format!(
                "is {format} in {layers} layers, expected four components in one layer as base colour of materials[{material}]"
            );
            return Err(self.texture_fault(index, &reason));
        }
        Ok(Some(view))
    }

    /// The groom texture of a material; `None` for a material without one, or a material that does not exist.
    ///
    /// Fails where the texture is damaged, has more than one array layer, or an sRGB format.
    pub fn groom_texture(&self, material: usize) -> Result<Option<TextureView<'a>>, FormatError> {
        let Some(index) = self.manifest.materials.get(material).and_then(|m| m.groom_texture) else {
            return Ok(None);
        };
        let view = self.texture(index)?;
        if view.layers != 1 || view.format.is_srgb() {
            let (layers, format) = (view.layers, view.format.name());
            let reason = format!(
                "is {format} in {layers} layers, expected one layer that is not sRGB as groom of materials[{material}]"
            );
            return Err(self.texture_fault(index, &reason));
        }
        Ok(Some(view))
    }
}

/// A pair of hair textures, see [`Package::fur_textures`], [`Package::wet_textures`] and [`Package::fin_textures`].
#[derive(Clone, Copy, Debug)]
pub struct FurTextures<'a> {
    /// Premultiplied colour and opacity, one array layer per shell, skin first, or per slab.
    pub color: TextureView<'a>,
    /// Hair direction in the tile frame, of the same size (`FORMAT.md`, "Directions").
    pub direction: TextureView<'a>,
}

/// The textures of the ink style, see [`Package::ink_textures`] and [`crate::InkInfo`].
#[derive(Clone, Copy, Debug)]
pub struct InkTextures<'a> {
    /// The stroke of the sphere map.
    pub stroke: TextureView<'a>,
    /// The tile of wash on the surface.
    pub wash: TextureView<'a>,
    /// The tile of paper.
    pub paper: TextureView<'a>,
    /// Strokes of fur in the hair's tile, where the package has fur.
    pub fur: Option<TextureView<'a>>,
}

/// Whether a tag means something to a version: to those before it, it is one of the sections that are kept unread.
fn means(tag: Tag, version: u32) -> bool {
    match tag {
        Tag::FINS => version > 1,
        Tag::INK => version > 2,
        _ => true,
    }
}

fn check_limit(what: &'static str, section: &Section, limit: u64) -> Result<(), FormatError> {
    if section.length > limit {
        let (offset, found) = (section.offset, section.length);
        return Err(FormatError::Limit { tag: section.tag, what, offset, found, limit });
    }
    Ok(())
}

/// Collects sections and writes a package.
///
/// The manifest comes first; the other sections follow in the order in which they were added.
#[derive(Debug)]
pub struct PackageWriter<'a> {
    version: u32,
    manifest: Manifest,
    sections: Vec<(Tag, Cow<'a, [u8]>)>,
    error: Option<FormatError>,
}

impl<'a> PackageWriter<'a> {
    /// Begins a package.
    pub fn new(manifest: Manifest) -> Self {
        Self { version: FORMAT_VERSION, manifest, sections: Vec::new(), error: None }
    }

    fn push(mut self, tag: Tag, bytes: Result<Vec<u8>, FormatError>) -> Self {
        match bytes {
            Ok(bytes) => self.sections.push((tag, bytes.into())),
            Err(error) => self.error = self.error.or(Some(error)),
        }
        self
    }

    /// Writes an older version of the format (default [`FORMAT_VERSION`]): how a tool that rewrites a package leaves its version
    /// alone. `finish` fails for a version that does not exist, and for contents that the version has no place for.
    pub fn version(mut self, version: u32) -> Self {
        self.version = version;
        self
    }

    /// Adds the mesh.
    pub fn mesh(self, mesh: &MeshData) -> Self {
        self.push(Tag::MESH, mesh.encode())
    }

    /// Adds skeleton and clips.
    pub fn animation(self, animation: &Animation) -> Self {
        self.push(Tag::ANIMATION, encode_section(Tag::ANIMATION, animation))
    }

    /// Adds the fins.
    pub fn fins(self, fins: &FinData) -> Self {
        self.push(Tag::FINS, fins.encode())
    }

    /// Adds the ink style.
    pub fn ink(self, ink: &InkData) -> Self {
        self.push(Tag::INK, ink.encode())
    }

    /// Adds a complete .ktx2 file; the k-th belongs to the manifest's k-th texture.
    pub fn texture(mut self, ktx2: impl Into<Cow<'a, [u8]>>) -> Self {
        self.sections.push((Tag::TEXTURE, ktx2.into()));
        self
    }

    /// Adds a section as it is: how sections this version does not know are carried over.
    pub fn section(mut self, tag: Tag, bytes: impl Into<Cow<'a, [u8]>>) -> Self {
        self.sections.push((tag, bytes.into()));
        self
    }

    /// Writes the package, then reads it back in full: what is returned is a package that opens and validates.
    pub fn finish(self) -> Result<Vec<u8>, FormatError> {
        if let Some(error) = self.error {
            return Err(error);
        }
        let no_place = |reason| FormatError::Content { tag: Tag::MANIFEST, offset: 0, reason };
        let manifest = match self.version {
            1 => encode_section(Tag::MANIFEST, &ManifestV1::try_from(&self.manifest).map_err(no_place)?)?,
            2 => manifest_v2::encode(&self.manifest)?,
            _ => encode_section(Tag::MANIFEST, &self.manifest)?,
        };
        let mut sections = vec![(Tag::MANIFEST, Cow::Owned(manifest))];
        sections.extend(self.sections);
        let bytes = container::write(self.version, &sections);
        let unlimited = Limits {
            sections: u32::MAX,
            manifest_bytes: u64::MAX,
            animation_bytes: u64::MAX,
            vertices: u32::MAX,
            indices: u32::MAX,
            fins: u32::MAX,
            texture_size: u32::MAX,
            texture_layers: u32::MAX,
        };
        match Package::validate(&bytes, &unlimited).into_iter().next() {
            Some(fault) => Err(fault),
            None => Ok(bytes),
        }
    }
}
