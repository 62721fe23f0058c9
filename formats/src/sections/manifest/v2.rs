//! Manifest of version 2: the current one without its last fields, which are far layer, levels of detail and the record
//! of a choice. Kept permanently, so that packages of version 2 stay readable.

use super::data::Manifest;
use crate::encoding::{decode_section, encode_section};
use crate::error::FormatError;
use crate::tag::Tag;

/// Encoding of the three fields that version 3 appended, all empty: an option, a list and an option.
const SINCE_VERSION_3: [u8; 10] = [0; 10];

/// Returns the path of the first field that is set and was added in version 3.
pub(super) fn first_newer_field(manifest: &Manifest) -> Option<&'static str> {
    let fields = [
        ("coat", manifest.coat.is_some()),
        ("detail", !manifest.detail.is_empty()),
        ("choice", manifest.choice.is_some()),
    ];
    fields.iter().find(|(_, given)| *given).map(|(what, _)| *what)
}

/// Reads the section at `offset` of a package.
pub(super) fn decode(offset: u64, bytes: &[u8]) -> Result<Manifest, FormatError> {
    let manifest: Manifest = decode_section(Tag::MANIFEST, offset, &[bytes, &SINCE_VERSION_3].concat())?;
    match first_newer_field(&manifest) {
        // The section continues with bytes as in version 3.
        Some(what) => {
            let reason = format!("bytes of {what} follow the manifest of version 2, expected none");
            Err(FormatError::Content { tag: Tag::MANIFEST, offset, reason })
        }
        None => Ok(manifest),
    }
}

/// Writes the section. Fails if the manifest has fields that version 2 cannot store.
pub(super) fn encode(manifest: &Manifest) -> Result<Vec<u8>, FormatError> {
    if let Some(what) = first_newer_field(manifest) {
        let reason = format!("{what} is given, expected none in version 2 of the format");
        return Err(FormatError::Content { tag: Tag::MANIFEST, offset: 0, reason });
    }
    let mut bytes = encode_section(Tag::MANIFEST, manifest)?;
    bytes.truncate(bytes.len().saturating_sub(SINCE_VERSION_3.len()));
    Ok(bytes)
}
