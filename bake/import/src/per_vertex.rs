//! Checks that attributes have one element per vertex.

use super::elements::REAL;
use super::json::JsonNode;
use super::source::Source;
use crate::BakeError;

/// Reads an attribute that must have one element per vertex.
pub(super) fn read_per_vertex<'a>(
    source: &mut Source<'a, '_>,
    reference: &JsonNode<'a>,
    widths: &[usize],
    vertices: usize,
    normalized: bool,
) -> Result<Vec<f32>, BakeError> {
    check_count(source, reference, vertices)?;
    Ok(source.accessor(reference, widths, REAL)?.to_f32s(normalized))
}

/// Checks the number of elements of an attribute before they are read.
pub(super) fn check_count<'a>(
    source: &Source<'a, '_>,
    reference: &JsonNode<'a>,
    vertices: usize,
) -> Result<(), BakeError> {
    let found = source.accessor_count(reference)?;
    if found == vertices as u64 {
        return Ok(());
    }
    Err(reference.fault(format!("has {found} elements, expected {vertices}, one per POSITION")))
}
