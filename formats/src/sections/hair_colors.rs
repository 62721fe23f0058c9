//! The `HCOL` section: colours of hair that differ from those of the skin below it. Layout in `FORMAT.md`, "HCOL".

use super::kind::Kind;
use crate::encoding::{decode_section, encode_section};
use crate::error::FormatError;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;

impl Tag {
    /// Colours of hair, since version 3. At most one.
    pub const HAIR_COLORS: Self = Self(*b"HCOL");
}

pub(crate) const KIND: Kind =
    Kind::optional(Tag::HAIR_COLORS, 3, "[colours of hair](#hcol-colours-of-hair)", |package, _| {
        package.hair_colors().map(drop)
    });

impl Package<'_> {
    /// Returns for each material the linear RGB by which its hair is multiplied in place of the base colour; `None` for
    /// hair with the base colour. The list is empty if the package does not have the section.
    ///
    /// Fails if the section is damaged, or is inconsistent with the manifest.
    pub fn hair_colors(&self) -> Result<Vec<Option<[f32; 3]>>, FormatError> {
        let Some((index, section)) = self.find(Tag::HAIR_COLORS, 0) else { return Ok(Vec::new()) };
        self.cached(index, || {
            let fail = |reason| FormatError::Content { tag: Tag::HAIR_COLORS, offset: section.offset, reason };
            let (bytes, expected) = (self.section_bytes(index)?, self.manifest().materials.len());
            // A colour takes at most 13 bytes in the file, but 16 in memory even where it is absent.
            if bytes.len() > 16 + 13 * expected {
                return Err(fail(format!("{} bytes, too many for {expected} materials", bytes.len())));
            }
            let colors: Vec<Option<[f32; 3]>> = decode_section(Tag::HAIR_COLORS, section.offset, bytes)?;
            let found = colors.len();
            if found != expected {
                return Err(fail(format!("{found} colours, expected one for each of {expected} materials")));
            }
            for (i, color) in colors.iter().enumerate() {
                let wrong = color.iter().flatten().find(|c| !(c.is_finite() && **c >= 0.0));
                if let Some(wrong) = wrong {
                    return Err(fail(format!("colour {i} has {wrong}, expected finite numbers of at least 0")));
                }
            }
            Ok(colors)
        })
    }
}

impl PackageWriter<'_> {
    /// Adds the colours of hair, one for each material.
    pub fn hair_colors(self, colors: &[Option<[f32; 3]>]) -> Self {
        self.encoded(Tag::HAIR_COLORS, encode_section(Tag::HAIR_COLORS, &colors))
    }
}
