//! The `MEDU` section: medullae of the hair's fibres. Layout in `FORMAT.md`, "MEDU".

use super::kind::Kind;
use crate::encoding::{decode_section, encode_section};
use crate::error::FormatError;
use crate::meaning::scattering::optics::Medulla;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;

impl Tag {
    /// Medullae of fibres, since version 3. At most one.
    pub const MEDULLAE: Self = Self(*b"MEDU");
}

pub(crate) const KIND: Kind =
    Kind::optional(Tag::MEDULLAE, 3, "[medullae of fibres](#medu-medullae-of-fibres)", |package, _| {
        package.medullae(package.fibres()?.map_or(0, |info| info.fibres.len())).map(drop)
    });

impl Package<'_> {
    /// Returns the medullae of the package's `expected` fibres; an empty list if the package does not have the section.
    pub(crate) fn medullae(&self, expected: usize) -> Result<Vec<Medulla>, FormatError> {
        let Some((index, section)) = self.find(Tag::MEDULLAE, 0) else { return Ok(Vec::new()) };
        let fail = |reason| FormatError::Content { tag: Tag::MEDULLAE, offset: section.offset, reason };
        let medullae: Vec<Medulla> = decode_section(Tag::MEDULLAE, section.offset, self.section_bytes(index)?)?;
        let found = medullae.len();
        if found != expected {
            return Err(fail(format!("{found} entries, expected one for each of {expected} fibres")));
        }
        let fault = |medulla: &Medulla| {
            let ranges =
                [("ratio", medulla.ratio, Medulla::RATIO), ("scattering", medulla.scattering, Medulla::SCATTERING)];
            let outside = ranges.into_iter().find(|(_, found, range)| !range.contains(found));
            outside
                .map(|(name, found, range)| format!("{name} is {found}, expected {} to {}", range.start(), range.end()))
        };
        let fault = medullae.iter().enumerate().find_map(|(i, medulla)| Some((i, fault(medulla)?)));
        fault.map_or(Ok(medullae), |(i, reason)| Err(fail(format!("entry {i}: {reason}"))))
    }
}

impl PackageWriter<'_> {
    /// Adds the medullae of fibres, one entry for each.
    pub(crate) fn medullae(self, medullae: &[Medulla]) -> Self {
        self.encoded(Tag::MEDULLAE, encode_section(Tag::MEDULLAE, &medullae))
    }
}
