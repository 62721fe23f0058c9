//! Header and section table of the file. Byte positions are those of `FORMAT.md`.

use crate::checksum::crc32;
use crate::error::FormatError;
use crate::limits::Limits;
use crate::tag::Tag;

/// First eight bytes of every package. The high bit and the line feed at the end make damage by text-mode transfer
/// visible.
pub const MAGIC: [u8; 8] = *b"\x89PELAGE\n";
/// Version of the format that this crate writes, and the newest that it reads. All older versions can be read and, on
/// request, written.
pub const FORMAT_VERSION: u32 = 3;

/// Size of the fixed header, bytes.
pub(crate) const HEADER_BYTES: usize = 32;
/// Offset of the first byte after magic and version. This part of the header is the same in every version.
const VERSION_END: usize = 12;
/// Size of a table entry, bytes.
pub(crate) const ENTRY_BYTES: usize = 32;
/// Alignment of sections, bytes, so that vertex data can be mapped and uploaded in place.
pub(crate) const ALIGNMENT: u64 = 16;

/// Entry of the section table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Section {
    /// Kind of section.
    pub tag: Tag,
    /// Start of the section, bytes from the start of the package; a multiple of 16.
    pub offset: u64,
    /// Length in bytes, without the padding that follows.
    pub length: u64,
    /// CRC-32 (ISO-HDLC, as in zlib and PNG) of the section's bytes.
    pub checksum: u32,
}

impl Section {
    /// Fails if the section has more than `limit` bytes. `what` names the length in the error.
    pub(crate) fn check_length(&self, what: &'static str, limit: u64) -> Result<(), FormatError> {
        if self.length > limit {
            let (tag, offset, found) = (self.tag, self.offset, self.length);
            return Err(FormatError::Limit { tag, what, offset, found, limit });
        }
        Ok(())
    }
}

fn u32_at(bytes: &[u8], offset: usize) -> u32 {
    let mut field = [0; 4];
    field.copy_from_slice(&bytes[offset..offset + 4]);
    u32::from_le_bytes(field)
}

fn u64_at(bytes: &[u8], offset: usize) -> u64 {
    let mut field = [0; 8];
    field.copy_from_slice(&bytes[offset..offset + 8]);
    u64::from_le_bytes(field)
}

fn align_up(offset: u64) -> Option<u64> {
    offset.checked_next_multiple_of(ALIGNMENT)
}

/// Fails unless `bytes` holds `needed` bytes at `offset`.
fn require(bytes: &[u8], tag: Tag, what: &'static str, offset: u64, needed: u64) -> Result<(), FormatError> {
    let available = (bytes.len() as u64).saturating_sub(offset);
    if needed > available {
        return Err(FormatError::Truncated { tag, what, offset, needed, available });
    }
    Ok(())
}

fn expect_field(what: &'static str, offset: usize, found: u64, expected: u64) -> Result<(), FormatError> {
    if found != expected {
        let (offset, expected) = (offset as u64, expected.to_string());
        return Err(FormatError::Field { what, offset, found, expected });
    }
    Ok(())
}

/// Reads and checks header and table, and returns version and sections.
///
/// Checks magic, version, length, checksum and reserved fields. Sections must be consecutive and aligned, with zero
/// padding between them and nothing after the last.
///
/// The layout is canonical: each list of sections has exactly one encoding. Hence unpacking and repacking give
/// identical bytes, and no byte of the file is unchecked.
pub(crate) fn read_table(bytes: &[u8], limits: &Limits) -> Result<(u32, Vec<Section>), FormatError> {
    if !bytes.starts_with(&MAGIC) {
        // A prefix of the magic is a truncated package; anything else is a different kind of file.
        if !bytes.is_empty() && MAGIC.starts_with(bytes) {
            require(bytes, Tag::HEAD, "header", 0, HEADER_BYTES as u64)?;
        }
        let found = bytes[..bytes.len().min(8)].to_vec();
        return Err(FormatError::Magic { found, expected: MAGIC });
    }
    // Magic and version are the only fields whose position is fixed for all versions, so the version is checked first:
    // a newer package must never be reported as damaged.
    if let Some(version) = bytes.get(8..VERSION_END).map(|field| u32_at(field, 0)).filter(|v| *v > FORMAT_VERSION) {
        return Err(FormatError::Version { found: version, supported: FORMAT_VERSION });
    }
    require(bytes, Tag::HEAD, "header", 0, HEADER_BYTES as u64)?;
    let version = u32_at(bytes, 8);
    if version == 0 {
        let expected = format!("1..={FORMAT_VERSION}");
        return Err(FormatError::Field { what: "version", offset: 8, found: 0, expected });
    }
    let count = u32_at(bytes, 12);
    if count > limits.sections {
        let (found, limit) = (count.into(), limits.sections.into());
        return Err(FormatError::Limit { tag: Tag::HEAD, what: "section count", offset: 12, found, limit });
    }
    let table_bytes = u64::from(count) * ENTRY_BYTES as u64;
    require(bytes, Tag::HEAD, "section table", HEADER_BYTES as u64, table_bytes)?;
    let head_bytes = HEADER_BYTES + table_bytes as usize;
    let expected = u32_at(bytes, 24);
    let found = head_checksum(&bytes[..head_bytes]);
    if found != expected {
        return Err(FormatError::Checksum { tag: Tag::HEAD, offset: 0, found, expected });
    }
    expect_field("header reserved bytes", 28, u32_at(bytes, 28).into(), 0)?;

    let mut sections = Vec::new();
    let mut end = head_bytes as u64;
    for index in 0..count as usize {
        let at = HEADER_BYTES + index * ENTRY_BYTES;
        expect_field("table reserved bytes", at + 4, u32_at(bytes, at + 4).into(), 0)?;
        expect_field("table reserved bytes", at + 28, u32_at(bytes, at + 28).into(), 0)?;
        let mut tag = [0; 4];
        tag.copy_from_slice(&bytes[at..at + 4]);
        if Tag(tag) == Tag::HEAD {
            let (what, found) = ("section tag \"head\"", u32::from_le_bytes(tag).into());
            let expected = "a tag other than the one reserved for the header".into();
            return Err(FormatError::Field { what, offset: at as u64, found, expected });
        }
        let section = Section {
            tag: Tag(tag),
            offset: u64_at(bytes, at + 8),
            length: u64_at(bytes, at + 16),
            checksum: u32_at(bytes, at + 24),
        };
        let expected_offset = align_up(end).unwrap_or(u64::MAX);
        expect_field("section offset", at + 8, section.offset, expected_offset)?;
        expect_zero_padding(bytes, end, section.offset)?;
        require(bytes, section.tag, "section", section.offset, section.length)?;
        end = section.offset + section.length;
        sections.push(section);
    }
    let last = end;
    let end = align_up(last).unwrap_or(u64::MAX);
    expect_field("package length", 16, u64_at(bytes, 16), end)?;
    expect_zero_padding(bytes, last, end)?;
    match bytes.len() as u64 - end {
        0 => Ok((version, sections)),
        count => Err(FormatError::TrailingBytes { offset: end, count }),
    }
}

/// Fails unless the bytes in `from`..`to` exist and are zero. Existence must be checked here: in a file truncated
/// inside the padding, an empty section that follows begins past the end.
fn expect_zero_padding(bytes: &[u8], from: u64, to: u64) -> Result<(), FormatError> {
    require(bytes, Tag::HEAD, "padding", from, to - from)?;
    match (from..).zip(&bytes[from as usize..to as usize]).find(|(_, byte)| **byte != 0) {
        Some((offset, byte)) => expect_field("padding", offset as usize, (*byte).into(), 0),
        None => Ok(()),
    }
}

/// CRC-32 of header and table without the checksum field.
fn head_checksum(head: &[u8]) -> u32 {
    crc32(&[&head[..24], &head[28..]])
}

/// Writes header, table and sections. Inverse of [`read_table`].
pub(crate) fn write(version: u32, sections: &[(Tag, impl AsRef<[u8]>)]) -> Vec<u8> {
    let head_bytes = (HEADER_BYTES + sections.len() * ENTRY_BYTES) as u64;
    let mut out = Vec::new();
    out.extend_from_slice(&MAGIC);
    out.extend_from_slice(&version.to_le_bytes());
    out.extend_from_slice(&(sections.len() as u32).to_le_bytes());
    out.extend_from_slice(&[0; 16]); // length, checksum and reserved: filled in below
    let mut offset = head_bytes;
    for (tag, data) in sections {
        let data = data.as_ref();
        offset = offset.next_multiple_of(ALIGNMENT);
        out.extend_from_slice(&tag.0);
        out.extend_from_slice(&[0; 4]);
        out.extend_from_slice(&offset.to_le_bytes());
        out.extend_from_slice(&(data.len() as u64).to_le_bytes());
        out.extend_from_slice(&crc32(&[data]).to_le_bytes());
        out.extend_from_slice(&[0; 4]);
        offset += data.len() as u64;
    }
    let length = offset.next_multiple_of(ALIGNMENT);
    out.reserve_exact(length as usize - out.len());
    out[16..24].copy_from_slice(&length.to_le_bytes());
    let checksum = head_checksum(&out);
    out[24..28].copy_from_slice(&checksum.to_le_bytes());
    for (_, data) in sections {
        out.resize(out.len().next_multiple_of(ALIGNMENT as usize), 0);
        out.extend_from_slice(data.as_ref());
    }
    out.resize(length as usize, 0);
    out
}
