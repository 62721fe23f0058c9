//! An opened package: its bytes, its table, its manifest, and what is kept of its sections. What a section means stands in
//! [`crate::sections`]; how a package is opened and validated, in [`crate::whole`].

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

/// An opened package, borrowing from the bytes it was opened from.
///
/// A section is checked when it is first asked for, once for each opened package; what came of it, the value or the fault, is
/// kept, and later calls return that.
pub struct Package<'a> {
    bytes: &'a [u8],
    limits: Limits,
    version: u32,
    sections: Vec<Section>,
    /// One for each section.
    slots: Vec<Slot>,
    manifest: Manifest,
}

/// What is known of a section besides its entry of the table.
struct Slot {
    /// Whether the package's version defines its tag; else it is one of the sections that are kept unread.
    defined: bool,
    /// Whether its checksum was found right. Relaxed is enough: verifying twice is harmless.
    verified: AtomicBool,
    /// A `Result<T, FormatError>`, where T is what the section's own file keeps of it. The type is erased, so that this file need
    /// not name the sections.
    kept: OnceLock<Box<dyn Any + Send + Sync>>,
}

impl fmt::Debug for Package<'_> {
    /// Says what is in the package, not its megabytes.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut out = f.debug_struct("Package");
        out.field("version", &self.version).field("bytes", &self.bytes.len());
        out.field("sections", &self.sections).field("manifest", &self.manifest);
        out.finish_non_exhaustive()
    }
}

impl<'a> Package<'a> {
    /// A package whose table is read, with a manifest still to come. `defined` says whether its version defines a tag.
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

    /// The same package with its manifest.
    pub(crate) fn with_manifest(self, manifest: Manifest) -> Self {
        Self { manifest, ..self }
    }

    /// Version of the format the package was written in.
    pub fn version(&self) -> u32 {
        self.version
    }

    /// The bytes the package was opened from.
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// The manifest.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// The section table, in file order.
    pub fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// What the reader accepts.
    pub(crate) fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Bytes of section number `index` of the table; verifies its checksum the first time.
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

    /// Number in the table and entry of the `nth` section of a tag, counted from 0; `None` also where the package's version does
    /// not define the tag.
    pub(crate) fn find(&self, tag: Tag, nth: usize) -> Option<(usize, Section)> {
        let of_tag = |(index, section): &(usize, Section)| section.tag == tag && self.slots[*index].defined;
        self.sections.iter().copied().enumerate().filter(of_tag).nth(nth)
    }

    /// What `read` makes of section number `index` of the table: made once, then kept.
    ///
    /// `read` may ask for other sections, but none of them, however far on, may ask for this one.
    pub(crate) fn keep<T>(&self, index: usize, read: impl Fn() -> Result<T, FormatError>) -> Result<T, FormatError>
    where
        T: Clone + Send + Sync + 'static,
    {
        let Some(slot) = self.slots.get(index) else { return read() };
        let kept = slot.kept.get_or_init(|| Box::new(read()));
        // A slot holds one type: a section is read by its own file alone.
        kept.downcast_ref::<Result<T, FormatError>>().cloned().unwrap_or_else(read)
    }
}
