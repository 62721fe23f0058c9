//! The `ROOT` section: lateral offset of hair from its root, so that hair can have the surface colour at its root.
//! Layout in `FORMAT.md`, "ROOT".

use super::kind::Kind;
use crate::encoding::{decode_section, encode_section};
use crate::error::FormatError;
use crate::meaning::RootOffset;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
use serde::{Deserialize, Serialize};

impl Tag {
    /// Roots of hair, since version 3. At most one.
    pub const ROOTS: Self = Self(*b"ROOT");
}

pub(crate) const KIND: Kind =
    Kind::optional(Tag::ROOTS, 3, "[where hair roots](#root-where-hair-roots)", |package, _| package.roots().map(drop));

/// Number of heights at which [`RootsInfo`] gives offsets: evenly from the surface to the outermost layer.
pub const ROOT_HEIGHTS: usize = 8;

/// Lateral offsets of hair from its root, and the resulting offsets of base-colour coordinates.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RootsInfo {
    /// Offset at each height, for dry hair.
    pub asides: [RootOffset; ROOT_HEIGHTS],
    /// For each material, the change of the texture coordinates over one tile width. It applies to u along the tile's u
    /// axis and, equally, to v along its v axis. 0 if hair has the base colour of the surface below it.
    pub uv_per_tile: Vec<f32>,
}

impl Package<'_> {
    /// Returns the lateral offsets of hair from its root; `None` if the package's hair has the colour of the surface
    /// below it.
    ///
    /// Fails if the section is damaged, or is inconsistent with the manifest.
    pub fn roots(&self) -> Result<Option<RootsInfo>, FormatError> {
        let Some((index, section)) = self.find(Tag::ROOTS, 0) else { return Ok(None) };
        let info = self.cached(index, || {
            let info: RootsInfo = decode_section(Tag::ROOTS, section.offset, self.section_bytes(index)?)?;
            let fail = |reason: String| FormatError::Content { tag: Tag::ROOTS, offset: section.offset, reason };
            let manifest = self.manifest();
            if manifest.fur.layers == 0 {
                return Err(fail("roots of a package without fur, expected none".into()));
            }
            if info.uv_per_tile.len() != manifest.materials.len() {
                let (found, expected) = (info.uv_per_tile.len(), manifest.materials.len());
                return Err(fail(format!(
                    "uv_per_tile has {found} entries, expected one for each of {expected} materials"
                )));
            }
            for (i, aside) in info.asides.iter().enumerate() {
                let RootOffset { mean: [u, v], along } = *aside;
                if let Some(found) = [u, v, along].iter().find(|x| !x.is_finite()) {
                    return Err(fail(format!("asides[{i}] has {found}, expected finite numbers")));
                }
            }
            if let Some((i, found)) = info.uv_per_tile.iter().enumerate().find(|(_, x)| !(x.is_finite() && **x >= 0.0))
            {
                return Err(fail(format!("uv_per_tile[{i}] is {found}, expected a finite number of at least 0")));
            }
            Ok(info)
        })?;
        Ok(Some(info))
    }
}

impl PackageWriter<'_> {
    /// Adds the lateral offsets of hair from its root.
    pub fn roots(self, info: &RootsInfo) -> Self {
        self.encoded(Tag::ROOTS, encode_section(Tag::ROOTS, info))
    }
}
