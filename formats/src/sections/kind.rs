//! Properties of each kind of section.

use crate::error::FormatError;
use crate::package::Package;
use crate::sections::manifest::data::Manifest;
use crate::tag::Tag;

/// Kind of section. Each kind has a file or folder beside this one, with its layout, its checks, and its methods of
/// [`Package`] and [`crate::PackageWriter`]. That file also holds a constant of this type, which the list in `mod.rs`
/// names.
#[derive(Debug)]
pub(crate) struct Kind {
    /// Tag in the section table.
    pub(crate) tag: Tag,
    /// First version of the format that defines the tag. In packages of older versions the tag is unknown: such
    /// sections are carried over unread.
    pub(crate) since: u32,
    /// Allowed number of sections in a package.
    pub(crate) count: Count,
    /// Reads the section with the given index among those with this tag, and checks it against everything that it must
    /// be consistent with. With [`Count::AtMostOne`], it is also called without such a section, because a package may
    /// need one.
    pub(crate) check: fn(&Package<'_>, u32) -> Result<(), FormatError>,
    /// Returns every fault in the use of the textures that the section names.
    pub(crate) check_use: fn(&Package<'_>) -> Vec<FormatError>,
    /// Row in `FORMAT.md`.
    #[cfg_attr(not(test), expect(dead_code, reason = "a test compares the specification with it"))]
    pub(crate) row: Row,
}

impl Kind {
    /// Returns a kind of which a package has at most one section, anywhere, and which names no texture.
    pub(crate) const fn optional(
        tag: Tag,
        since: u32,
        what: &'static str,
        check: fn(&Package<'_>, u32) -> Result<(), FormatError>,
    ) -> Self {
        let row = Row { what, how_many: "at most one", place: "any" };
        Self { tag, since, count: Count::AtMostOne, check, check_use: USES_NOTHING, row }
    }
}

/// Allowed number of sections of a kind in a package.
#[derive(Debug)]
pub(crate) enum Count {
    /// Single section; may be absent if the section's own check allows it.
    AtMostOne,
    /// Number of sections given by the manifest.
    AsNamed {
        /// Number of sections that the manifest names.
        named: fn(&Manifest) -> usize,
        /// Name of the items, for messages.
        what: &'static str,
    },
}

/// Row of the table of tags in `FORMAT.md`, in Markdown.
#[cfg_attr(not(test), expect(dead_code, reason = "a test compares the specification with it"))]
#[derive(Debug)]
pub(crate) struct Row {
    /// Contents.
    pub(crate) what: &'static str,
    /// Number of sections.
    pub(crate) how_many: &'static str,
    /// Position among the sections.
    pub(crate) place: &'static str,
}

/// Value of `check_use` for kinds that name no texture.
pub(crate) const USES_NOTHING: fn(&Package<'_>) -> Vec<FormatError> = |_| Vec::new();

/// Returns the faults among several results.
pub(crate) fn faults<const N: usize>(results: [Option<FormatError>; N]) -> Vec<FormatError> {
    results.into_iter().flatten().collect()
}
