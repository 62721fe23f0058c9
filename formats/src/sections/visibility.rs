//! The `VISI` section: textures with the share of light that reaches the hair past other strands. Layout in
//! `FORMAT.md`, "VISI".

use super::kind::{Kind, faults};
use super::textures::TextureView;
use crate::encoding::{decode_section, encode_section};
use crate::error::FormatError;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
use serde::{Deserialize, Serialize};

impl Tag {
    /// Visibility of the hair, since version 3. At most one.
    pub const VISIBILITY: Self = Self(*b"VISI");
}

pub(crate) const KIND: Kind = Kind {
    check_use: |package| faults([package.visibility_textures().err()]),
    ..Kind::optional(Tag::VISIBILITY, 3, "[visibility of the hair](#visi-visibility-of-the-hair)", |package, _| {
        package.visibility().map(drop)
    })
};

/// Visibility textures: the light that reaches the hair, as read by [`crate::meaning::visibility_towards`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct VisibilityInfo {
    /// Index into the manifest's `textures`: four components, not sRGB, with the size and array layers of the shell
    /// textures.
    pub texture: u32,
    /// Index into `textures` for wet hair; present if and only if the manifest's `fur.wet` is.
    pub wet_texture: Option<u32>,
    /// k of [`crate::meaning::above_horizon`], finite and above 0. It determines the height above the horizon below
    /// which a light fades.
    pub horizon: f32,
}

/// Textures of [`VisibilityInfo`], see [`Package::visibility_textures`].
#[derive(Clone, Copy, Debug)]
pub struct VisibilityTextures<'a> {
    /// Visibility of dry hair.
    pub dry: TextureView<'a>,
    /// Visibility of wet hair, if dry and wet hair blend.
    pub wet: Option<TextureView<'a>>,
}

impl<'a> Package<'a> {
    /// Returns the references to the visibility textures; `None` if the package has no such section.
    ///
    /// Fails if the section is damaged, or is inconsistent with the manifest's fur.
    pub fn visibility(&self) -> Result<Option<VisibilityInfo>, FormatError> {
        let Some((index, section)) = self.find(Tag::VISIBILITY, 0) else { return Ok(None) };
        let info = self.cached(index, || {
            let info: VisibilityInfo = decode_section(Tag::VISIBILITY, section.offset, self.section_bytes(index)?)?;
            let fail = |reason: &str| FormatError::Content {
                tag: Tag::VISIBILITY,
                offset: section.offset,
                reason: reason.into(),
            };
            let fur = &self.manifest().fur;
            if fur.layers == 0 {
                return Err(fail("visibility of a package without fur, expected none"));
            }
            if info.wet_texture.is_some() != fur.wet.is_some() {
                return Err(fail(
                    "only one of wet_texture and the manifest's fur.wet is present, expected both or neither",
                ));
            }
            if !(info.horizon > 0.0 && info.horizon.is_finite()) {
                return Err(fail(&format!("horizon is {}, expected a finite number above 0", info.horizon)));
            }
            Ok(info)
        })?;
        Ok(Some(info))
    }

    /// Returns the visibility textures; `None` if the package has none.
    ///
    /// Fails if a texture is damaged or inconsistent with [`VisibilityInfo`].
    pub fn visibility_textures(&self) -> Result<Option<VisibilityTextures<'a>>, FormatError> {
        let Some(info) = self.visibility()? else { return Ok(None) };
        let texels = self.manifest().fur.tile_texels;
        let expected = (texels, texels, self.manifest().shell_texture_layers());
        let read = |index: u32| {
            let view = self.image_texture(index)?;
            let found = (view.width, view.height, view.layers);
            if found != expected || view.format.components() != 4 || view.format.is_srgb() {
                let reason = format!(
                    "is {}x{} texels of {} in {} layers, expected {}x{} texels with four components, not sRGB, in {} \
                     layers for the visibility of the hair",
                    found.0,
                    found.1,
                    view.format.name(),
                    found.2,
                    expected.0,
                    expected.1,
                    expected.2
                );
                return Err(self.texture_fault(index, &reason));
            }
            Ok(view)
        };
        Ok(Some(VisibilityTextures { dry: read(info.texture)?, wet: info.wet_texture.map(read).transpose()? }))
    }
}

impl PackageWriter<'_> {
    /// Adds the references to the visibility textures.
    pub fn visibility(self, info: &VisibilityInfo) -> Self {
        self.encoded(Tag::VISIBILITY, encode_section(Tag::VISIBILITY, info))
    }
}
