//! Collection of a package's sections for writing. Each section's file adds the methods for its contents;
//! [`crate::open_validate`] writes the whole package.

use crate::container::FORMAT_VERSION;
use crate::error::FormatError;
use crate::sections::manifest::data::Manifest;
use crate::tag::Tag;
use std::borrow::Cow;

/// Collects sections and writes a package.
///
/// The manifest comes first; the other sections follow in the order in which they were added.
#[derive(Debug)]
pub struct PackageWriter<'a> {
    pub(crate) version: u32,
    pub(crate) manifest: Manifest,
    pub(crate) sections: Vec<(Tag, Cow<'a, [u8]>)>,
    /// First error in the added sections; [`PackageWriter::finish`] returns it.
    pub(crate) error: Option<FormatError>,
}

impl<'a> PackageWriter<'a> {
    /// Creates a writer for a package with the manifest `manifest`.
    pub fn new(manifest: Manifest) -> Self {
        Self { version: FORMAT_VERSION, manifest, sections: Vec::new(), error: None }
    }

    /// Selects an older version of the format (default [`FORMAT_VERSION`]), so that a tool that rewrites a package can
    /// keep its version. `finish` fails for a version that does not exist, and for contents that the version cannot
    /// store.
    pub fn version(mut self, version: u32) -> Self {
        self.version = version;
        self
    }

    /// Adds a section unchanged. Used to carry over sections that this version does not know.
    pub fn section(mut self, tag: Tag, bytes: impl Into<Cow<'a, [u8]>>) -> Self {
        self.sections.push((tag, bytes.into()));
        self
    }

    /// Adds an encoded section, or records why encoding failed.
    pub(crate) fn encoded(mut self, tag: Tag, bytes: Result<Vec<u8>, FormatError>) -> Self {
        match bytes {
            Ok(bytes) => self.section(tag, bytes),
            Err(error) => {
                self.error = self.error.or(Some(error));
                self
            }
        }
    }
}
