//! Opening and writing whole packages.

use crate::animation::Animation;
use crate::container::{self, Section, Tag};
use crate::encoding::{decode_section, encode_section};
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
    sections: Vec<Section>,
    /// Sections whose checksum was found right. Relaxed is enough: verifying twice is harmless.
    verified: Vec<AtomicBool>,
    manifest: Manifest,
}

impl fmt::Debug for Package<'_> {
    /// Says what is in the package, not its megabytes.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut out = f.debug_struct("Package");
        out.field("bytes", &self.bytes.len()).field("sections", &self.sections).field("manifest", &self.manifest);
        out.finish_non_exhaustive()
    }
}

impl<'a> Package<'a> {
    /// Reads header, section table and manifest. No other byte of the sections is touched: their checksums are verified, and
    /// their contents checked, when they are first used.
    pub fn open(bytes: &'a [u8], limits: &Limits) -> Result<Self, FormatError> {
        let sections = container::read_table(bytes, limits)?;
        let missing = || FormatError::MissingSection {
            tag: Tag::MANIFEST,
            index: 0,
            reason: "every package begins with its manifest".into(),
        };
        let first = *sections.first().filter(|s| s.tag == Tag::MANIFEST).ok_or_else(missing)?;
        for tag in [Tag::MANIFEST, Tag::MESH, Tag::ANIMATION] {
            if let Some(second) = sections.iter().filter(|s| s.tag == tag).nth(1) {
                let reason = "a second section of this tag, expected at most one".into();
                return Err(FormatError::Content { tag, offset: second.offset, reason });
            }
        }
        check_limit("manifest length", &first, limits.manifest_bytes)?;
        let verified = sections.iter().map(|_| AtomicBool::new(false)).collect();
        let mut package = Self { bytes, limits: limits.clone(), sections, verified, manifest: Manifest::default() };
        let textures = package.sections.iter().filter(|s| s.tag == Tag::TEXTURE).count();
        package.manifest = decode_section(Tag::MANIFEST, first.offset, package.section_bytes(0)?)?;
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
        add(package.fur_textures().err());
        // Each texture once, however many materials share it.
        let mut seen = BTreeSet::new();
        for (index, material) in package.manifest.materials.iter().enumerate() {
            if material.base_color_texture.is_some_and(|texture| seen.insert(texture)) {
                add(package.base_color_texture(index).err());
            }
        }
        faults
    }

    /// Version of the format the package was written in.
    pub fn version(&self) -> u32 {
        container::FORMAT_VERSION
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
        let view = MeshView::parse(self.section_bytes(index)?, section.offset, &self.limits)?;
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
    /// Fails where one of them is damaged or not as [`crate::FurInfo`] says: `layers` array layers, `tile_texels` square, colour with
    /// four components, directions in a format that is not sRGB.
    pub fn fur_textures(&self) -> Result<Option<FurTextures<'a>>, FormatError> {
        let fur = &self.manifest.fur;
        if fur.layers == 0 {
            return Ok(None);
        }
        let (color, direction) = (self.texture(fur.color_texture)?, self.texture(fur.direction_texture)?);
        for (index, view) in [(fur.color_texture, &color), (fur.direction_texture, &direction)] {
            let (found, expected) =
                ((view.width, view.height, view.layers), (fur.tile_texels, fur.tile_texels, fur.layers));
            if found != expected {
                let reason = format!(
                    "is {}x{} texels in {} layers, expected {}x{} in {} as the manifest's fur says",
                    found.0, found.1, found.2, expected.0, expected.1, expected.2
                );
                return Err(self.texture_fault(index, &reason));
            }
        }
        if color.format.components() != 4 {
            let reason = format!("is {}, expected four components for colour and opacity", color.format.name());
            return Err(self.texture_fault(fur.color_texture, &reason));
        }
        if direction.format.is_srgb() {
            let reason = format!("is {}, expected a format that is not sRGB for directions", direction.format.name());
            return Err(self.texture_fault(fur.direction_texture, &reason));
        }
        Ok(Some(FurTextures { color, direction }))
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
}

/// The shell textures of a package, see [`Package::fur_textures`].
#[derive(Clone, Copy, Debug)]
pub struct FurTextures<'a> {
    /// Premultiplied colour and opacity, one array layer per shell, skin first.
    pub color: TextureView<'a>,
    /// Hair direction in the tile frame, of the same size (`FORMAT.md`, "Directions").
    pub direction: TextureView<'a>,
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
    manifest: Manifest,
    sections: Vec<(Tag, Cow<'a, [u8]>)>,
    error: Option<FormatError>,
}

impl<'a> PackageWriter<'a> {
    /// Begins a package.
    pub fn new(manifest: Manifest) -> Self {
        Self { manifest, sections: Vec::new(), error: None }
    }

    fn push(mut self, tag: Tag, bytes: Result<Vec<u8>, FormatError>) -> Self {
        match bytes {
            Ok(bytes) => self.sections.push((tag, bytes.into())),
            Err(error) => self.error = self.error.or(Some(error)),
        }
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
        let manifest = encode_section(Tag::MANIFEST, &self.manifest)?;
        let mut sections = vec![(Tag::MANIFEST, Cow::Owned(manifest))];
        sections.extend(self.sections);
        let bytes = container::write(&sections);
        let unlimited = Limits {
            sections: u32::MAX,
            manifest_bytes: u64::MAX,
            animation_bytes: u64::MAX,
            vertices: u32::MAX,
            indices: u32::MAX,
            texture_size: u32::MAX,
            texture_layers: u32::MAX,
        };
        match Package::validate(&bytes, &unlimited).into_iter().next() {
            Some(fault) => Err(fault),
            None => Ok(bytes),
        }
    }
}
