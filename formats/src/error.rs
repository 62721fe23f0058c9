use crate::tag::Tag;

/// Error in a package: its location in the file, what was found and what was expected.
///
/// Offsets are bytes from the start of the package.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// The first eight bytes are not the package's magic.
    #[error(
        "not a pelage package: byte 0 starts with {found:02x?}, expected {expected:02x?} (\"\\x89PELAGE\\n\"){}",
        if found.starts_with(b"glTF") { "; this is a glTF model, which `pelage bake` turns into a package" } else { "" }
    )]
    Magic {
        /// The first bytes of the input, at most eight.
        found: Vec<u8>,
        /// [`crate::MAGIC`].
        expected: [u8; 8],
    },
    /// The package has a newer format version than this reader supports.
    #[error(
        "package version {found} at byte 8 is newer than this reader: expected version {supported}; \
         update pelage, or bake the package again"
    )]
    Version {
        /// Version in the file.
        found: u32,
        /// Newest version that this reader supports.
        supported: u32,
    },
    /// The input ends before the named item is complete.
    #[error("package is cut short: {what} ({tag}) at byte {offset} needs {needed} bytes, {available} are left")]
    Truncated {
        /// Truncated section; `head` for header, table and padding.
        tag: Tag,
        /// Name of the item being read.
        what: &'static str,
        /// Start of the item.
        offset: u64,
        /// Size of the item, bytes.
        needed: u64,
        /// Bytes between `offset` and the end of the input.
        available: u64,
    },
    /// The input continues after the end stated in its header.
    #[error("{count} trailing bytes at byte {offset}: expected the package to end there")]
    TrailingBytes {
        /// Expected end of the package.
        offset: u64,
        /// Number of bytes that follow.
        count: u64,
    },
    /// A field that allows only one fixed or derived value holds a different one.
    #[error("{what} at byte {offset} is {found}, expected {expected}")]
    Field {
        /// Name of the field, as in `FORMAT.md`.
        what: &'static str,
        /// Position of the field.
        offset: u64,
        /// Value found.
        found: u64,
        /// Value expected.
        expected: String,
    },
    /// A number in the file exceeds the reader's [`crate::Limits`].
    #[error("section {tag}: {what} at byte {offset} is {found}, above the reader's limit of {limit}")]
    Limit {
        /// Section; `head` for header and table.
        tag: Tag,
        /// Name of the field.
        what: &'static str,
        /// Position of the field.
        offset: u64,
        /// Value found.
        found: u64,
        /// Limit.
        limit: u64,
    },
    /// The bytes of a section do not match the checksum in the table.
    #[error("section {tag} at byte {offset} is damaged: CRC-32 {found:#010x}, the table says {expected:#010x}")]
    Checksum {
        /// Section; `head` for header and table.
        tag: Tag,
        /// Start of the section.
        offset: u64,
        /// CRC-32 of the bytes.
        found: u32,
        /// CRC-32 in the table.
        expected: u32,
    },
    /// A section is missing that the format requires or the manifest names.
    #[error("section {tag} number {index} is missing: {reason}")]
    MissingSection {
        /// Missing section.
        tag: Tag,
        /// Index among the sections with this tag, from 0.
        index: u32,
        /// Reason why the section is needed.
        reason: String,
    },
    /// The contents of a section are well-formed bytes but not a valid value.
    #[error("section {tag} at byte {offset}: {reason}")]
    Content {
        /// Section.
        tag: Tag,
        /// Start of the section or of its faulty part.
        offset: u64,
        /// Description of what was found and what was expected.
        reason: String,
    },
}

impl FormatError {
    /// Returns the byte offset of the error, if it has one.
    pub fn offset(&self) -> Option<u64> {
        match self {
            Self::Magic { .. } => Some(0),
            Self::Version { .. } => Some(8),
            Self::Truncated { offset, .. }
            | Self::TrailingBytes { offset, .. }
            | Self::Field { offset, .. }
            | Self::Limit { offset, .. }
            | Self::Checksum { offset, .. }
            | Self::Content { offset, .. } => Some(*offset),
            Self::MissingSection { .. } => None,
        }
    }

    /// Returns the section of the error; [`Tag::HEAD`] for header, table, padding and the length of the whole file.
    ///
    /// Every error of this version names a section; the `Option` is reserved for errors that cannot.
    pub fn section(&self) -> Option<Tag> {
        Some(match self {
            Self::Magic { .. } | Self::Version { .. } | Self::TrailingBytes { .. } | Self::Field { .. } => Tag::HEAD,
            Self::Truncated { tag, .. }
            | Self::Limit { tag, .. }
            | Self::Checksum { tag, .. }
            | Self::MissingSection { tag, .. }
            | Self::Content { tag, .. } => *tag,
        })
    }
}
