//! Buffer views (glTF 2.0, section 3.6.1), plain or compressed with EXT_meshopt_compression.

use super::json::JsonNode;
use super::meshopt;
use super::source::Source;
use crate::BakeError;

pub(super) struct BufferView<'b> {
    pub bytes: &'b [u8],
    pub stride: Option<usize>,
}

impl<'a> Source<'a, '_> {
    /// Loads the buffer of the positions of a primitive. Faults are ignored: reading the positions reports them.
    pub fn load_buffer_of(&mut self, primitive: &JsonNode<'a>) {
        let position = primitive.get("attributes").and_then(|attributes| attributes.get("POSITION"));
        let accessor = position.and_then(|at| self.root.follow("accessors", &at).ok());
        let view = accessor.and_then(|(_, at)| self.root.follow("bufferViews", &at.get("bufferView")?).ok());
        if let Some(buffer) = view.and_then(|(_, at)| at.get("buffer")) {
            self.buffer(&buffer).ok();
        }
    }

    /// Returns the bytes of the buffer view that `reference` names.
    pub fn view(&mut self, reference: &JsonNode<'a>) -> Result<BufferView<'_>, BakeError> {
        let (index, at) = self.root.follow("bufferViews", reference)?;
        let stride = at.get("byteStride").map(|s| s.unsigned()).transpose()?.map(|s| s as usize);
        let Some(packed) = at.extension("EXT_meshopt_compression") else {
            return Ok(BufferView { bytes: self.buffer_range(&at)?, stride });
        };
        if !self.unpacked.contains_key(&index) {
            let bytes = unpack_view(self, &packed, at.require("byteLength")?.unsigned()?)?;
            self.unpacked.insert(index, bytes);
        }
        Ok(BufferView { bytes: self.unpacked.get(&index).map(Vec::as_slice).unwrap_or_default(), stride })
    }
}

/// Decompresses a buffer view whose extension is at `at`. `length` is the size that the view declares.
fn unpack_view<'a>(source: &mut Source<'a, '_>, at: &JsonNode<'a>, length: u64) -> Result<Vec<u8>, BakeError> {
    let count_at = at.require("count")?;
    let (count, stride) = (count_at.unsigned()?, at.require("byteStride")?.unsigned()?);
    let mode_at = at.require("mode")?;
    let mode = mode_at.string()?;
    let fits = match mode {
        "ATTRIBUTES" => (4..=256).contains(&stride) && stride % 4 == 0,
        "TRIANGLES" | "INDICES" => matches!(stride, 2 | 4),
        _ => return Err(mode_at.unexpected("ATTRIBUTES, TRIANGLES or INDICES")),
    };
    if !fits {
        return Err(at.fault(format!("has elements of {stride} bytes, which {mode} does not allow")));
    }
    if count.checked_mul(stride) != Some(length) {
        let reason = format!("has {count} elements of {stride} bytes, expected the {length} bytes of the buffer view");
        return Err(at.fault(reason));
    }
    if mode == "TRIANGLES" && count % 3 != 0 {
        return Err(count_at.unexpected("a multiple of 3"));
    }
    source.count_unpacked(at, length)?;
    let filter_at = at.get("filter");
    let filter = filter_at.as_ref().map_or(Ok("NONE"), JsonNode::string)?;
    let packed = source.buffer_range(at)?;
    let (count, stride) = (count as usize, stride as usize);
    let decoded = match mode {
        "ATTRIBUTES" => meshopt::decode_vertices(packed, count, stride)
            .and_then(|mut bytes| meshopt::unfilter(filter, stride, &mut bytes).map(|()| bytes)),
        "TRIANGLES" => meshopt::decode_triangles(packed, count).and_then(|indices| index_bytes(&indices, stride)),
        _ => meshopt::decode_indices(packed, count).and_then(|indices| index_bytes(&indices, stride)),
    };
    decoded.map_err(|reason| at.fault(format!("is compressed with EXT_meshopt_compression {reason}")))
}

fn index_bytes(indices: &[u32], stride: usize) -> Result<Vec<u8>, meshopt::Fault> {
    if stride == 4 {
        return Ok(indices.iter().flat_map(|i| i.to_le_bytes()).collect());
    }
    let short = |i: &u32| u16::try_from(*i).map_err(|_| format!("and has index {i}, which does not fit in 2 bytes"));
    Ok(indices.iter().map(short).collect::<Result<Vec<_>, _>>()?.into_iter().flat_map(u16::to_le_bytes).collect())
}
