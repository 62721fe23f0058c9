//! The `GLOS` section: gloss of bare surface. Layout in `FORMAT.md`, "GLOS".

use super::kind::Kind;
use crate::encoding::{decode_section, encode_section};
use crate::error::FormatError;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
use core::ops::RangeInclusive;
use serde::{Deserialize, Serialize};

impl Tag {
    /// Gloss of bare surface, since version 3. At most one.
    pub const GLOSS: Self = Self(*b"GLOS");
}

pub(crate) const KIND: Kind =
    Kind::optional(Tag::GLOSS, 3, "[gloss of bare surface](#glos-gloss-of-bare-surface)", |package, _| {
        package.gloss().map(drop)
    });

/// Gloss of a material where its surface is bare.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gloss {
    /// Roughness as in glTF, [`Gloss::ROUGHNESS`]: square root of the width α of the GGX distribution.
    pub roughness: f32,
    /// Reflectance of a dielectric at normal incidence, 0..=1; unused by metals.
    pub reflectance: f32,
    /// Metalness, 0..=1: a metal reflects its base colour at normal incidence, and scatters no light.
    pub metalness: f32,
    /// Whether a film of liquid covers the surface, so that its highlights stay sharp however small they are on
    /// screen.
    pub wet: bool,
}

impl Gloss {
    /// Range of roughness.
    pub const ROUGHNESS: RangeInclusive<f32> = 0.04..=1.0;
    /// Squared width α² by which lights without size widen highlights: they count as discs with a radius of 8°.
    pub const OF_LIGHTS: f32 = 0.005;

    /// Returns an error message if a number is out of its range.
    fn fault(&self) -> Option<String> {
        let ranges = [
            ("roughness", self.roughness, Self::ROUGHNESS),
            ("reflectance", self.reflectance, 0.0..=1.0),
            ("metalness", self.metalness, 0.0..=1.0),
        ];
        let outside = ranges.into_iter().find(|(_, found, range)| !range.contains(found));
        outside.map(|(name, found, range)| format!("{name} is {found}, expected {} to {}", range.start(), range.end()))
    }
}

impl Package<'_> {
    /// Returns for each material the gloss of its bare surface; `None` for a matt one. The list is empty if the package
    /// does not have the section.
    ///
    /// Fails if the section is damaged, or is inconsistent with the manifest.
    pub fn gloss(&self) -> Result<Vec<Option<Gloss>>, FormatError> {
        let Some((index, section)) = self.find(Tag::GLOSS, 0) else { return Ok(Vec::new()) };
        self.cached(index, || {
            let fail = |reason| FormatError::Content { tag: Tag::GLOSS, offset: section.offset, reason };
            let (bytes, expected) = (self.section_bytes(index)?, self.manifest().materials.len());
            // An entry takes at most 14 bytes in the file, but more in memory even where it is absent.
            if bytes.len() > 8 + 14 * expected {
                return Err(fail(format!("{} bytes, too many for {expected} materials", bytes.len())));
            }
            let gloss: Vec<Option<Gloss>> = decode_section(Tag::GLOSS, section.offset, bytes)?;
            let found = gloss.len();
            if found != expected {
                return Err(fail(format!("{found} entries, expected one for each of {expected} materials")));
            }
            let fault = gloss.iter().enumerate().find_map(|(i, of)| Some((i, of.as_ref()?.fault()?)));
            fault.map_or(Ok(gloss), |(i, reason)| Err(fail(format!("entry {i}: {reason}"))))
        })
    }
}

impl PackageWriter<'_> {
    /// Adds the gloss of bare surface, one entry for each material.
    pub fn gloss(self, materials: &[Option<Gloss>]) -> Self {
        self.encoded(Tag::GLOSS, encode_section(Tag::GLOSS, &materials))
    }
}
