//! Opening, validating and writing of whole packages. The list in [`crate::sections`] defines the sections, their
//! number and their checks.

use crate::container;
use crate::error::FormatError;
use crate::limits::Limits;
use crate::package::Package;
use crate::sections::kind::Count;
use crate::sections::{kind, manifest, of_version};
use crate::tag::Tag;
use crate::writer::PackageWriter;
use std::borrow::Cow;
use std::collections::BTreeMap;

impl<'a> Package<'a> {
    /// Reads header, section table and manifest. No other byte of the sections is accessed: checksums and contents are
    /// checked on first use.
    pub fn open(bytes: &'a [u8], limits: &Limits) -> Result<Self, FormatError> {
        let (version, sections) = container::read_table(bytes, limits)?;
        let missing = || FormatError::MissingSection {
            tag: Tag::MANIFEST,
            index: 0,
            reason: "every package begins with its manifest".into(),
        };
        let first = *sections.first().filter(|s| s.tag == Tag::MANIFEST).ok_or_else(missing)?;
        let package = Self::new(bytes, limits, version, sections, |tag| kind(tag, version).is_some());
        for kind in of_version(version).filter(|kind| matches!(kind.count, Count::AtMostOne)) {
            if let Some((_, second)) = package.find(kind.tag, 1) {
                let reason = "a second section of this tag, expected at most one".into();
                return Err(FormatError::Content { tag: kind.tag, offset: second.offset, reason });
            }
        }
        first.check_length("manifest length", limits.manifest_bytes)?;
        let manifest = manifest::decode(version, first.offset, package.section_bytes(0)?)?;
        for kind in of_version(version) {
            let Count::AsNamed { named, what } = &kind.count else { continue };
            let found = package.sections().iter().filter(|s| s.tag == kind.tag).count();
            let named = named(&manifest);
            if found != named {
                return Err(FormatError::MissingSection {
                    tag: kind.tag,
                    index: found.min(named) as u32,
                    reason: format!("the manifest names {named} {what}, the package holds {found}"),
                });
            }
        }
        Ok(package.with_manifest(manifest))
    }

    /// Reads everything: all checksums, vertices, texture headers and animation keys, and whether the manifest's
    /// textures suit their use. Returns all faults: first those of each section in file order, then those between
    /// sections. If the package does not open, returns only that fault.
    pub fn validate(bytes: &'a [u8], limits: &Limits) -> Vec<FormatError> {
        let package = match Self::open(bytes, limits) {
            Ok(package) => package,
            Err(error) => return vec![error],
        };
        let mut faults: Vec<FormatError> = Vec::new();
        // A damaged section fails again in each check that uses it; report it once.
        let mut add = |fault: Option<FormatError>| faults.extend(fault.filter(|fault| !faults.contains(fault)));
        let mut found: BTreeMap<Tag, u32> = BTreeMap::new();
        for (index, section) in package.sections().iter().enumerate() {
            add(match kind(section.tag, package.version()) {
                Some(kind) => {
                    let count = found.entry(kind.tag).or_default();
                    *count += 1;
                    (kind.check)(&package, *count - 1)
                }
                None => package.section_bytes(index).map(drop),
            }
            .err());
        }
        for kind in of_version(package.version()) {
            if matches!(kind.count, Count::AtMostOne) && !found.contains_key(&kind.tag) {
                add((kind.check)(&package, 0).err());
            }
        }
        for kind in of_version(package.version()) {
            (kind.check_use)(&package).into_iter().for_each(|fault| add(Some(fault)));
        }
        faults
    }

    /// Returns the faults that prevent drawing, in everything that a renderer reads.
    ///
    /// [`Self::validate`] finds most of them as well, and others in sections or textures that drawing does not need. It
    /// does not report two obstacles that the format allows: a package without anything to draw, and directions of dry
    /// and wet hair in formats with different numbers of components.
    pub fn drawing_faults(&self) -> Vec<FormatError> {
        let mut faults = vec![
            self.triangles().err(),
            self.animation().err(),
            self.fins().err(),
            self.simplified().err(),
            self.strands().err(),
            self.hair_groups().err(),
            self.fibre_tables().err(),
            self.ink().err(),
            self.contours().err(),
            self.fur_textures().err(),
            self.wet_textures().err(),
            self.check_wet_matches_dry().err(),
            self.visibility_textures().err(),
            self.fin_textures().err(),
            self.ink_textures().err(),
        ];
        for material in 0..self.manifest().materials.len() {
            faults.extend([self.base_color_texture(material).err(), self.groom_texture(material).err()]);
        }
        let mut found: Vec<FormatError> = Vec::new();
        for fault in faults.into_iter().flatten() {
            // A damaged texture fails again in each check that uses it; report it once.
            if !found.contains(&fault) {
                found.push(fault);
            }
        }
        found
    }
}

impl PackageWriter<'_> {
    /// Writes the package, then reads it back in full, so that every returned package opens and validates.
    pub fn finish(self) -> Result<Vec<u8>, FormatError> {
        if let Some(error) = self.error {
            return Err(error);
        }
        let manifest = manifest::encode(self.version, &self.manifest)?;
        let mut sections = vec![(Tag::MANIFEST, Cow::Owned(manifest))];
        sections.extend(self.sections);
        let bytes = container::write(self.version, &sections);
        match Package::validate(&bytes, &Limits::NONE).into_iter().next() {
            Some(fault) => Err(fault),
            None => Ok(bytes),
        }
    }
}
