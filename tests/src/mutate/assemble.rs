//! Assembles packages from arbitrary sections, with a valid layout and valid checksums.

/// Operations of the fuzz targets on packages: open a package, use everything in it, and update its checksums.
#[path = "../../../formats/fuzz/src/bodies.rs"]
mod bodies;

pub use bodies::{open, reseal, round_trip};

use pelage_formats::{Limits, MAGIC, Package};

/// Tag and contents of a section.
pub type Section = ([u8; 4], Vec<u8>);

/// Size of the header, and of each entry in the section table, bytes.
const ENTRY: usize = 32;

/// Returns the version and the sections of a valid package.
///
/// # Panics
///
/// If the package is invalid.
pub fn sections(package: &[u8]) -> (u32, Vec<Section>) {
    let package =
        Package::open(package, &Limits::default()).unwrap_or_else(|e| panic!("the base package must open: {e}"));
    let bytes = |index: usize| {
        let bytes = package.section_bytes(index).unwrap_or_else(|e| panic!("the base package must be valid: {e}"));
        bytes.to_vec()
    };
    let list = package.sections().iter().enumerate().map(|(index, section)| (section.tag.0, bytes(index)));
    (package.version(), list.collect())
}

/// Assembles a package from the given sections.
pub fn assemble(version: u32, sections: &[Section]) -> Vec<u8> {
    let mut table = Vec::new();
    let mut data = Vec::new();
    let begin = ENTRY * (1 + sections.len());
    for (tag, bytes) in sections {
        table.extend_from_slice(tag);
        table.extend_from_slice(&[0; 4]);
        table.extend_from_slice(&((begin + data.len()) as u64).to_le_bytes());
        table.extend_from_slice(&(bytes.len() as u64).to_le_bytes());
        table.extend_from_slice(&[0; 8]);
        data.extend_from_slice(bytes);
        data.resize(data.len().next_multiple_of(16), 0);
    }
    let mut out = MAGIC.to_vec();
    out.extend_from_slice(&version.to_le_bytes());
    out.extend_from_slice(&(sections.len() as u32).to_le_bytes());
    out.extend_from_slice(&((begin + data.len()) as u64).to_le_bytes());
    out.extend_from_slice(&[0; 8]);
    out.extend(table);
    out.extend(data);
    reseal(&mut out);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn package_sections_survive_a_round_trip() {
        let package: &[u8] = include_bytes!("../../../formats/tests/golden/v3.pelage");
        let (version, list) = sections(package);
        assert!(assemble(version, &list) == package);
    }
}
