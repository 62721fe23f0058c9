//! Collecting the sections of a package. Each section's file adds what it can write; [`crate::whole`] lays the whole out.

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
    /// The first fault of what was added; [`PackageWriter::finish`] returns it.
    pub(crate) error: Option<FormatError>,
}

impl<'a> PackageWriter<'a> {
    /// Begins a package.
    pub fn new(manifest: Manifest) -> Self {
        Self { version: FORMAT_VERSION, manifest, sections: Vec::new(), error: None }
    }

    /// Writes an older version of the format (default [`FORMAT_VERSION`]): how a tool that rewrites a package leaves its version
    /// alone. `finish` fails for a version that does not exist, and for contents that the version has no place for.
    pub fn version(mut self, version: u32) -> Self {
        self.version = version;
        self
    }

    /// Adds a section as it is: how sections this version does not know are carried over.
    pub fn section(mut self, tag: Tag, bytes: impl Into<Cow<'a, [u8]>>) -> Self {
        self.sections.push((tag, bytes.into()));
        self
    }

    /// Adds a section that was encoded, or notes why it could not be.
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
