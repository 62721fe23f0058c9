//! `KTX2` sections: complete .ktx2 files, one for each texture of the manifest, and the requirements of their use.

mod decode;
mod format;
mod view;

use super::kind::{Count, Kind, Row};
use crate::error::FormatError;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
pub use format::TextureFormat;
use std::borrow::Cow;
use std::collections::BTreeSet;
pub use view::TextureView;

impl Tag {
    /// Complete .ktx2 file; the k-th one belongs to the k-th texture of the manifest.
    pub const TEXTURE: Self = Self(*b"KTX2");
}

pub(crate) const KIND: Kind = Kind {
    tag: Tag::TEXTURE,
    since: 1,
    count: Count::AsNamed { named: |manifest| manifest.textures.len(), what: "textures" },
    check: |package, nth| package.texture(nth).map(drop),
    check_use: check_materials,
    row: Row {
        what: "[a texture](#ktx2-textures)",
        how_many: "as many as the manifest's `textures`, in that order",
        place: "any",
    },
};

/// Checks that the textures of materials suit their use. Each texture is checked once, however many materials share it.
fn check_materials(package: &Package<'_>) -> Vec<FormatError> {
    let (mut colors, mut grooms) = (BTreeSet::new(), BTreeSet::new());
    let mut faults = Vec::new();
    for (index, material) in package.manifest().materials.iter().enumerate() {
        if material.base_color_texture.is_some_and(|texture| colors.insert(texture)) {
            faults.extend(package.base_color_texture(index).err());
        }
        if material.groom_texture.is_some_and(|texture| grooms.insert(texture)) {
            faults.extend(package.groom_texture(index).err());
        }
    }
    faults
}

/// Pair of hair textures, see [`Package::fur_textures`], [`Package::wet_textures`] and [`Package::fin_textures`].
#[derive(Clone, Copy, Debug)]
pub struct FurTextures<'a> {
    /// Premultiplied colour and opacity. Each shell, the surface first, or each slab has one array layer.
    pub color: TextureView<'a>,
    /// Hair direction in the tile frame, of the same size (`FORMAT.md`, "Directions").
    pub direction: TextureView<'a>,
}

impl<'a> Package<'a> {
    /// Returns texture number `index` of the manifest. Its file is checked once; the result is cached.
    pub fn texture(&self, index: u32) -> Result<TextureView<'a>, FormatError> {
        let (at, section) = self.find(Tag::TEXTURE, index as usize).ok_or_else(|| FormatError::MissingSection {
            tag: Tag::TEXTURE,
            index,
            reason: format!("the package holds {} textures", self.manifest().textures.len()),
        })?;
        let shape = self.cached(at, || {
            let view = TextureView::parse(self.section_bytes(at)?, section.offset, self.limits())?;
            Ok(view.shape())
        })?;
        Ok(TextureView::of(self.section_bytes(at)?, shape))
    }

    /// Returns a texture like [`Self::texture`]; fails for half floats, which only lookup tables use.
    pub(crate) fn image_texture(&self, index: u32) -> Result<TextureView<'a>, FormatError> {
        let view = self.texture(index)?;
        if view.format == TextureFormat::Rgba16Float {
            let reason = format!("is {}, a format for tables of fibres, expected any other format", view.format.name());
            return Err(self.texture_fault(index, &reason));
        }
        Ok(view)
    }

    /// Returns an error about the use of texture number `index` of the manifest, with its position and name.
    pub(crate) fn texture_fault(&self, index: u32, reason: &str) -> FormatError {
        let offset = self.find(Tag::TEXTURE, index as usize).map_or(0, |(_, section)| section.offset);
        let name = self.manifest().textures.get(index as usize).map_or("", |t| &t.name);
        FormatError::Content { tag: Tag::TEXTURE, offset, reason: format!("texture {name:?} {reason}") }
    }

    /// Returns the two shell textures; `None` if the package has no fur.
    ///
    /// Fails if a texture is damaged or inconsistent with [`crate::FurInfo`]. It must have an array layer for each of
    /// `layers` and for the far layer, each `tile_texels` square. Colour needs four components; directions need a
    /// format that is not sRGB.
    pub fn fur_textures(&self) -> Result<Option<FurTextures<'a>>, FormatError> {
        let fur = &self.manifest().fur;
        if fur.layers == 0 {
            return Ok(None);
        }
        let size = (fur.tile_texels, fur.tile_texels, self.manifest().shell_texture_layers());
        self.hair_textures("fur", size, fur.color_texture, fur.direction_texture).map(Some)
    }

    /// Returns the two textures of wet hair; `None` if the package has none. Format and errors are as for
    /// [`Package::fur_textures`].
    pub fn wet_textures(&self) -> Result<Option<FurTextures<'a>>, FormatError> {
        let fur = &self.manifest().fur;
        let Some(wet) = &fur.wet else { return Ok(None) };
        let size = (fur.tile_texels, fur.tile_texels, self.manifest().shell_texture_layers());
        self.hair_textures("fur.wet", size, wet.color_texture, wet.direction_texture).map(Some)
    }

    /// Fails if dry and wet hair cannot be blended, because a shader decodes the directions of both in the same way.
    /// Other faults of the textures are reported elsewhere.
    pub(crate) fn check_wet_matches_dry(&self) -> Result<(), FormatError> {
        let (Ok(Some(dry)), Ok(Some(wet)), Some(info)) =
            (self.fur_textures(), self.wet_textures(), &self.manifest().fur.wet)
        else {
            return Ok(());
        };
        let (dry, wet) = (dry.direction.format, wet.direction.format);
        if (dry.components() == 2) == (wet.components() == 2) {
            return Ok(());
        }
        let reason = format!(
            "is {}, expected as many components as {}, the format of the directions of dry \
                 hair",
            wet.name(),
            dry.name()
        );
        Err(self.texture_fault(info.direction_texture, &reason))
    }

    /// Returns a pair of hair textures, colour and direction. `size` is width, height and number of array layers.
    pub(crate) fn hair_textures(
        &self,
        whose: &str,
        size: (u32, u32, u32),
        color_texture: u32,
        direction_texture: u32,
    ) -> Result<FurTextures<'a>, FormatError> {
        let (color, direction) = (self.image_texture(color_texture)?, self.image_texture(direction_texture)?);
        for (index, view) in [(color_texture, &color), (direction_texture, &direction)] {
            let found = (view.width, view.height, view.layers);
            if found != size {
                let reason = format!(
                    "has {}x{} texels and layer count {}, expected {}x{} and {}, as in the manifest's {whose}",
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

    /// Returns the base-colour texture of a material; `None` for a material without one, or a material that does not
    /// exist.
    ///
    /// Fails if the texture is damaged, has more than one array layer, or does not have four components.
    pub fn base_color_texture(&self, material: usize) -> Result<Option<TextureView<'a>>, FormatError> {
        let Some(index) = self.manifest().materials.get(material).and_then(|m| m.base_color_texture) else {
            return Ok(None);
        };
        let view = self.image_texture(index)?;
        if view.layers != 1 || view.format.components() != 4 {
            let (layers, format) = (view.layers, view.format.name());
            let reason = format!(
                "has format {format} and layer count {layers}, \
                 expected four components and layer count 1 for the base colour of materials[{material}]"
            );
            return Err(self.texture_fault(index, &reason));
        }
        Ok(Some(view))
    }

    /// Returns the groom texture of a material; `None` for a material without one, or a material that does not exist.
    ///
    /// Fails if the texture is damaged, has more than one array layer, or has an sRGB format.
    pub fn groom_texture(&self, material: usize) -> Result<Option<TextureView<'a>>, FormatError> {
        let Some(index) = self.manifest().materials.get(material).and_then(|m| m.groom_texture) else {
            return Ok(None);
        };
        let view = self.image_texture(index)?;
        if view.layers != 1 || view.format.is_srgb() {
            let (layers, format) = (view.layers, view.format.name());
            let reason = format!(
                "has format {format} and layer count {layers}, expected a format that is not sRGB and layer count 1 \
                 for the groom of materials[{material}]"
            );
            return Err(self.texture_fault(index, &reason));
        }
        Ok(Some(view))
    }
}

impl<'a> PackageWriter<'a> {
    /// Adds a complete .ktx2 file; the k-th belongs to the manifest's k-th texture.
    pub fn texture(self, ktx2: impl Into<Cow<'a, [u8]>>) -> Self {
        self.section(Tag::TEXTURE, ktx2)
    }
}
