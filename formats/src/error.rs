use crate::tag::Tag;

/// What is wrong with a package, where in the file, what was found and what was expected.
///
/// Offsets are bytes from the start of the package.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// The first eight bytes are not the package's magic.
    #[error("not a pelage package: byte 0 begins {found:02x?}, expected {expected:02x?} (\"\\x89PELAGE\\n\")")]
    Magic {
        /// The first bytes of the input, at most eight.
        found: Vec<u8>,
        /// [`crate::MAGIC`].
        expected: [u8; 8],
    },
    /// The package was written in a newer version of the format than this reader knows.
    #[error(
        "package version {found} at byte 8 is newer than this reader: expected version {supported}; update pelage, or bake the package again"
    )]
    Version {
        /// Version in the file.
        found: u32,
        /// The newest version this reader knows.
        supported: u32,
    },
    /// The input ends before the named thing is complete.
    #[error("package is cut short: {what} ({tag}) at byte {offset} needs {needed} bytes, {available} are left")]
    Truncated {
        /// The section that is cut; `head` for header, table and padding.
        tag: Tag,
        /// What was being read.
        what: &'static str,
        /// Where it begins.
        offset: u64,
        /// Its size in bytes.
        needed: u64,
        /// Bytes between `offset` and the end of the input.
        available: u64,
    },
    /// The input goes on after the end that its header states.
    #[error("{count} trailing bytes at byte {offset}: expected the package to end there")]
    TrailingBytes {
        /// Where the package should end.
        offset: u64,
        /// How many bytes follow.
        count: u64,
    },
    /// A field that must hold one fixed or derived value holds another.
    #[error("{what} at byte {offset} is {found}, expected {expected}")]
    Field {
        /// Name of the field as in `FORMAT.md`.
        what: &'static str,
        /// Where it stands.
        offset: u64,
        /// Its value.
        found: u64,
        /// What it must be.
        expected: String,
    },
    /// A number in the file is above the reader's [`crate::Limits`].
    #[error("section {tag}: {what} at byte {offset} is {found}, above the reader's limit of {limit}")]
    Limit {
        /// Which section; `head` for header and table.
        tag: Tag,
        /// Name of the field.
        what: &'static str,
        /// Where it stands.
        offset: u64,
        /// Its value.
        found: u64,
        /// The limit.
        limit: u64,
    },
    /// The bytes of a section do not match the checksum in the table.
    #[error("section {tag} at byte {offset} is damaged: CRC-32 {found:#010x}, the table says {expected:#010x}")]
    Checksum {
        /// Which section; `head` for header and table.
        tag: Tag,
        /// Where the section begins.
        offset: u64,
        /// CRC-32 of the bytes.
        found: u32,
        /// CRC-32 in the table.
        expected: u32,
    },
    /// A section that the format requires, or that the manifest names, is not there.
    #[error("section {tag} number {index} is missing: {reason}")]
    MissingSection {
        /// Which section.
        tag: Tag,
        /// The how-manieth of its tag, from 0.
        index: u32,
        /// Who needs it.
        reason: String,
    },
    /// The contents of a section are well-formed bytes but not a valid value.
    #[error("section {tag} at byte {offset}: {reason}")]
    Content {
        /// Which section.
        tag: Tag,
        /// Where the section, or the faulty part of it, begins.
        offset: u64,
        /// What was found and what was expected.
        reason: String,
    },
}

impl FormatError {
    /// The byte offset the error points at, where it has one.
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

    /// The section the error is about; [`Tag::HEAD`] for header, table, padding and the length of the whole.
    ///
    /// Every error of this version names one; the `Option` leaves room for those that cannot.
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
