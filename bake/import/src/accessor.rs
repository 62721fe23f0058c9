//! Accessors (glTF 2.0, section 3.6.2); every range is checked against the available bytes.

use super::elements::{Component, Elements, WHOLE, width_of};
use super::json::JsonNode;
use super::source::Source;
use crate::BakeError;

/// Maximum size of an accessor without data, bytes: 12 bytes for each vertex that a package may have.
const MAX_ZEROS: u64 = 12 << 24;

impl<'a> Source<'a, '_> {
    /// Returns the number of elements of the accessor that `reference` names, without reading them.
    pub fn accessor_count(&self, reference: &JsonNode<'a>) -> Result<u64, BakeError> {
        let (_, at) = self.root.follow("accessors", reference)?;
        at.require("count")?.unsigned()
    }

    /// Reads the accessor that `reference` names.
    ///
    /// Errors give the position of the accessor. Only the error about a type that `widths` or `components` does not
    /// allow gives the position of the reference.
    pub fn accessor(
        &mut self,
        reference: &JsonNode<'a>,
        widths: &[usize],
        components: &[Component],
    ) -> Result<Elements, BakeError> {
        let (index, at) = self.root.follow("accessors", reference)?;
        let component = Component::read(&at.require("componentType")?)?;
        let width = width_of(&at.require("type")?)?;
        if !widths.contains(&width) || !components.contains(&component) {
            let list = |names: Vec<String>| names.join(" or ");
            let expected = list(widths.iter().map(ToString::to_string).collect());
            let types = list(components.iter().map(|c| c.name().to_owned()).collect());
            let found = component.name();
            return Err(reference
                .fault(format!("accessor {index} has elements of {width} x {found}, expected {expected} x {types}")));
        }
        if let Some(elements) = self.supplied.remove(&index) {
            return Ok(elements);
        }
        let count_at = at.require("count")?;
        let count = count_at.unsigned()?;
        let size = width * component.size();
        let bytes = match at.get("bufferView") {
            Some(view) => {
                let offset = at.unsigned_or("byteOffset", 0)?;
                let stride_fault = |stride: usize| {
                    at.fault(format!(
                        "its bufferView has byteStride {stride}, expected at least {size}, the size of an element"
                    ))
                };
                let view = self.view(&view)?;
                let stride = view.stride.unwrap_or(size);
                if stride < size {
                    return Err(stride_fault(stride));
                }
                packed(view.bytes, offset, stride, size, count).map_err(|reason| at.fault(reason))?
            }
            // Without a buffer view all elements are zero. The file's size then does not limit their number, so
            // `MAX_ZEROS` does.
            None => {
                let bytes = count.checked_mul(size as u64).filter(|bytes| *bytes <= MAX_ZEROS);
                let limit = MAX_ZEROS / size as u64;
                let fault =
                    || count_at.fault(format!("is {count}, expected at most {limit} for an accessor without data"));
                vec![0; bytes.ok_or_else(fault)? as usize]
            }
        };
        let mut elements =
            Elements { count: count as usize, width, component, normalized: at.flag("normalized")?, bytes };
        if let Some(sparse) = at.get("sparse") {
            self.replace_sparse(&sparse, &mut elements)?;
        }
        Ok(elements)
    }

    /// Applies sparse storage: replaces single elements of `elements`.
    fn replace_sparse(&mut self, sparse: &JsonNode<'a>, elements: &mut Elements) -> Result<(), BakeError> {
        let count = sparse.require("count")?.unsigned()?;
        let size = elements.width * elements.component.size();
        let at = sparse.require("indices")?;
        let component_at = at.require("componentType")?;
        let component = Component::read(&component_at)?;
        if !WHOLE.contains(&component) {
            return Err(component_at.unexpected("5121 (u8), 5123 (u16) or 5125 (u32)"));
        }
        let mut part = |at: &JsonNode<'a>, size: usize| -> Result<Vec<u8>, BakeError> {
            let offset = at.unsigned_or("byteOffset", 0)?;
            let view = self.view(&at.require("bufferView")?)?;
            packed(view.bytes, offset, size, size, count).map_err(|reason| at.fault(reason))
        };
        let indices = part(&at, component.size())?;
        let values = part(&sparse.require("values")?, size)?;
        let indices =
            Elements { count: count as usize, width: 1, component, normalized: false, bytes: indices }.to_u32s();
        for (i, (index, value)) in indices.iter().zip(values.chunks_exact(size)).enumerate() {
            let start = *index as usize * size;
            let slot = elements.bytes.get_mut(start..start.saturating_add(size)).ok_or_else(|| {
                at.fault(format!("element {i} is {index}, expected less than {}, the accessor's count", elements.count))
            })?;
            slot.copy_from_slice(value);
        }
        Ok(())
    }
}

/// Copies `count` elements of `size` bytes, `stride` bytes apart, out of `bytes`.
fn packed(bytes: &[u8], offset: u64, stride: usize, size: usize, count: u64) -> Result<Vec<u8>, String> {
    let have = bytes.len() as u64;
    let need = match count {
        0 => Some(0),
        _ => (count - 1).checked_mul(stride as u64).and_then(|n| n.checked_add(size as u64)?.checked_add(offset)),
    };
    let Some(need) = need.filter(|need| *need <= have) else {
        let need = need.map_or("more than 2^64".to_owned(), |n| n.to_string());
        return Err(format!(
            "{count} elements of {size} bytes, {stride} bytes apart from byte {offset} on, need {need} bytes of the \
             bufferView, which has {have}"
        ));
    };
    if need == 0 {
        return Ok(Vec::new());
    }
    let used = bytes.get(offset as usize..need as usize).unwrap_or_default();
    if stride == size {
        return Ok(used.to_vec());
    }
    let mut out = Vec::with_capacity(count as usize * size);
    for element in used.chunks(stride) {
        out.extend_from_slice(&element[..size.min(element.len())]);
    }
    Ok(out)
}
