//! The `MANI` section: the manifest, in the encoding of the package's version.

pub(crate) mod choice;
pub(crate) mod data;
pub(crate) mod detail;
mod v1;
mod v2;

use super::kind::{Count, Kind, Row, faults};
use crate::encoding::{decode_section, encode_section};
use crate::error::FormatError;
use crate::tag::Tag;
use data::Manifest;

impl Tag {
    /// Manifest: bincode of [`Manifest`]. Exactly one, and the first section.
    pub const MANIFEST: Self = Self(*b"MANI");
}

pub(crate) const KIND: Kind = Kind {
    tag: Tag::MANIFEST,
    since: 1,
    count: Count::AtMostOne,
    // A package without a valid manifest does not open.
    check: |package, _| package.section_bytes(0).map(drop),
    check_use: |package| faults([package.fur_textures().err(), package.wet_textures().err()]),
    row: Row { what: "[manifest](#mani-manifest)", how_many: "exactly one", place: "first" },
};

/// Reads and checks the section at `offset` of a package of format version `version`.
pub(crate) fn decode(version: u32, offset: u64, bytes: &[u8]) -> Result<Manifest, FormatError> {
    let manifest = match version {
        1 => decode_section::<v1::ManifestV1>(Tag::MANIFEST, offset, bytes)?.into(),
        2 => v2::decode(offset, bytes)?,
        _ => decode_section(Tag::MANIFEST, offset, bytes)?,
    };
    manifest.check().map_err(|reason| FormatError::Content { tag: Tag::MANIFEST, offset, reason })?;
    Ok(manifest)
}

/// Writes the section. Fails if the manifest has fields that the version cannot store.
pub(crate) fn encode(version: u32, manifest: &Manifest) -> Result<Vec<u8>, FormatError> {
    let no_place = |reason| FormatError::Content { tag: Tag::MANIFEST, offset: 0, reason };
    match version {
        1 => encode_section(Tag::MANIFEST, &v1::ManifestV1::try_from(manifest).map_err(no_place)?),
        2 => v2::encode(manifest),
        _ => encode_section(Tag::MANIFEST, manifest),
    }
}
