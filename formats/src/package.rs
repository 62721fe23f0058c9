//! Opened package: bytes, table, manifest, and cached section contents. [`crate::sections`] defines the sections;
//! [`crate::open_validate`] opens and validates packages.

use crate::checksum::crc32;
use crate::container::Section;
use crate::error::FormatError;
use crate::limits::Limits;
use crate::sections::manifest::data::Manifest;
use crate::tag::Tag;
use std::any::Any;
use std::fmt;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// Opened package, which borrows the bytes it was opened from.
///
/// A section is checked on first access, once for each opened package. The result, value or error, is cached for later
/// calls.
pub struct Package<'a> {
    bytes: &'a [u8],
    limits: Limits,
    version: u32,
    sections: Vec<Section>,
    /// Cache, one slot for each section.
    slots: Vec<Slot>,
    manifest: Manifest,
}

/// State of a section besides its table entry.
struct Slot {
    /// Whether the package's version defines the section's tag. Sections of unknown tags are kept unread.
    defined: bool,
    /// Whether the section's checksum has been verified. Relaxed ordering suffices, because verifying twice is
    /// harmless.
    verified: AtomicBool,
    /// Cached `Result<T, FormatError>`, where T is a type of the section's own module. The type is erased, so that this
    /// module need not name the sections.
    kept: OnceLock<Box<dyn Any + Send + Sync>>,
}

impl fmt::Debug for Package<'_> {
    /// Formats a summary of the contents.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut out = f.debug_struct("Package");
        out.field("version", &self.version).field("bytes", &self.bytes.len());
        out.field("sections", &self.sections).field("manifest", &self.manifest);
        out.finish_non_exhaustive()
    }
}

impl<'a> Package<'a> {
    /// Creates a package from its section table, without a manifest yet. `defined` returns whether the package's
    /// version defines a tag.
    pub(crate) fn new(
        bytes: &'a [u8],
        limits: &Limits,
        version: u32,
        sections: Vec<Section>,
        defined: impl Fn(Tag) -> bool,
    ) -> Self {
        let slot =
            |s: &Section| Slot { defined: defined(s.tag), verified: AtomicBool::new(false), kept: OnceLock::new() };
        let slots = sections.iter().map(slot).collect();
        Self { bytes, limits: limits.clone(), version, sections, slots, manifest: Manifest::default() }
    }

    /// Returns the package with its manifest set.
    pub(crate) fn with_manifest(self, manifest: Manifest) -> Self {
        Self { manifest, ..self }
    }

    /// Returns the format version that the package was written in.
    pub fn version(&self) -> u32 {
        self.version
    }

    /// Returns the bytes that the package was opened from.
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// Returns the manifest.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Returns the section table, in file order.
    pub fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// Returns the reader's limits.
    pub(crate) fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Returns the bytes of section `index` of the table. Verifies its checksum on first access.
    pub fn section_bytes(&self, index: usize) -> Result<&'a [u8], FormatError> {
        let section = self.sections.get(index).ok_or_else(|| FormatError::MissingSection {
            tag: Tag::HEAD,
            index: index as u32,
            reason: format!("the table has {} entries", self.sections.len()),
        })?;
        let data = &self.bytes[section.offset as usize..(section.offset + section.length) as usize];
        let verified = &self.slots[index].verified;
        if !verified.load(Ordering::Relaxed) {
            let found = crc32(&[data]);
            if found != section.checksum {
                let (tag, offset, expected) = (section.tag, section.offset, section.checksum);
                return Err(FormatError::Checksum { tag, offset, found, expected });
            }
            verified.store(true, Ordering::Relaxed);
        }
        Ok(data)
    }

    /// Returns table index and entry of the `nth` section with the given tag, counted from 0. `None` if there is none,
    /// or if the package's version does not define the tag.
    pub(crate) fn find(&self, tag: Tag, nth: usize) -> Option<(usize, Section)> {
        let of_tag = |(index, section): &(usize, Section)| section.tag == tag && self.slots[*index].defined;
        self.sections.iter().copied().enumerate().filter(of_tag).nth(nth)
    }

    /// Returns the result of `read` for section `index` of the table. It is computed once, then cached.
    ///
    /// `read` may access other sections, but none of them may access this one, directly or indirectly.
    pub(crate) fn cached<T>(&self, index: usize, read: impl Fn() -> Result<T, FormatError>) -> Result<T, FormatError>
    where
        T: Clone + Send + Sync + 'static,
    {
        let Some(slot) = self.slots.get(index) else { return read() };
        let kept = slot.kept.get_or_init(|| Box::new(read()));
        // A slot holds a single type, because a section is read only by its own module.
        kept.downcast_ref::<Result<T, FormatError>>().cloned().unwrap_or_else(read)
    }
}
