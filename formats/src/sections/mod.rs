//! Sections of a package, one file each, and the list of them.
//!
//! To add a section, add its file and its line in [`SECTIONS`]. Opening, validating and writing packages follow the
//! list. A test compares the table of tags in `FORMAT.md` with it. `probe.rs` is a section that exists only in tests.

pub(crate) mod animation;
pub(crate) mod bare_normals;
pub(crate) mod contours;
pub(crate) mod fibres;
pub(crate) mod fins;
pub(crate) mod gloss;
pub(crate) mod hair;
pub(crate) mod hair_colors;
pub(crate) mod hair_motion;
pub(crate) mod ink;
pub(crate) mod kind;
pub(crate) mod manifest;
pub(crate) mod medullae;
pub(crate) mod mesh;
pub(crate) mod morphs;
pub(crate) mod openness;
mod per_vertex;
#[cfg(test)]
mod probe;
pub(crate) mod roots;
pub(crate) mod simplified;
pub(crate) mod strands;
pub(crate) mod strokes;
pub(crate) mod textures;
pub(crate) mod visibility;

use crate::tag::Tag;
use kind::Kind;

/// List of all sections, in the order of the table in `FORMAT.md`. Faults across sections are reported in this order.
pub(crate) const SECTIONS: &[&Kind] = &[
    &manifest::KIND,
    &mesh::KIND,
    &animation::KIND,
    &morphs::KIND,
    &fins::KIND,
    &ink::KIND,
    &strokes::KIND,
    &contours::KIND,
    &visibility::KIND,
    &roots::KIND,
    &hair_colors::KIND,
    &openness::KIND,
    &bare_normals::KIND,
    &gloss::KIND,
    &simplified::KIND,
    &strands::KIND,
    &hair::KIND,
    &hair_motion::KIND,
    &fibres::KIND,
    &medullae::KIND,
    &textures::KIND,
    #[cfg(test)]
    &probe::KIND,
];

/// Returns the sections that packages of format version `version` may have.
pub(crate) fn of_version(version: u32) -> impl Iterator<Item = &'static Kind> {
    SECTIONS.iter().copied().filter(move |kind| kind.since <= version)
}

/// Returns the kind of section that a tag has in packages of the given version; `None` if the version does not define
/// the tag.
pub(crate) fn kind(tag: Tag, version: u32) -> Option<&'static Kind> {
    of_version(version).find(|kind| kind.tag == tag)
}

#[cfg(test)]
mod tests;
