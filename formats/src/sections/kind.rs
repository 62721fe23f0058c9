//! What the list of sections says of each.

use crate::error::FormatError;
use crate::package::Package;
use crate::sections::manifest::data::Manifest;
use crate::tag::Tag;

/// A kind of section. Each has a file, or a folder, beside this one: with its layout, its checks, its methods of
/// [`Package`] and [`crate::PackageWriter`], and a constant of this type, which the list in `mod.rs` names.
#[derive(Debug)]
pub(crate) struct Kind {
    /// What the section is called in the table.
    pub(crate) tag: Tag,
    /// The first version of the format that defines the tag. To packages of older versions it is a tag like any other: such
    /// sections are carried over unread.
    pub(crate) since: u32,
    /// How many a package may have.
    pub(crate) count: Count,
    /// Reads the section of that number among those of its tag, and checks it with all that it must agree with. For
    /// [`Count::AtMostOne`] it is also asked where there is none: a package may need one.
    pub(crate) check: fn(&Package<'_>, u32) -> Result<(), FormatError>,
    /// Every fault of the textures that it names, by what it uses them for.
    pub(crate) check_use: fn(&Package<'_>) -> Vec<FormatError>,
    /// Its row in `FORMAT.md`.
    #[cfg_attr(not(test), expect(dead_code, reason = "a test holds the specification against it"))]
    pub(crate) row: Row,
}

/// How many sections of a kind a package may have.
#[derive(Debug)]
pub(crate) enum Count {
    /// One, or none where the section's own check allows it.
    AtMostOne,
    /// As many as the manifest names.
    AsNamed {
        /// How many it names.
        named: fn(&Manifest) -> usize,
        /// What they are, for messages.
        what: &'static str,
    },
}

/// A row of the table of tags in `FORMAT.md`, in Markdown.
#[cfg_attr(not(test), expect(dead_code, reason = "a test holds the specification against it"))]
#[derive(Debug)]
pub(crate) struct Row {
    /// What it holds.
    pub(crate) what: &'static str,
    /// How many there are.
    pub(crate) how_many: &'static str,
    /// Where it stands among the sections.
    pub(crate) place: &'static str,
}

/// For kinds that name no texture.
pub(crate) const USES_NOTHING: fn(&Package<'_>) -> Vec<FormatError> = |_| Vec::new();

/// The faults among several results.
pub(crate) fn faults<const N: usize>(results: [Option<FormatError>; N]) -> Vec<FormatError> {
    results.into_iter().flatten().collect()
}
