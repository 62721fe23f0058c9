//! Four-byte identifier of a section's kind.

use std::fmt;

/// Four-byte identifier of a section's kind. Each tag of the format is a constant beside the section's code.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Tag(pub [u8; 4]);

impl Tag {
    /// Tag of header, table and padding in errors; never in a file's table.
    pub const HEAD: Self = Self(*b"head");
}

impl fmt::Display for Tag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.escape_ascii().fmt(f)
    }
}

impl fmt::Debug for Tag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Tag({self})")
    }
}
