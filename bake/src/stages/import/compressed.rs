//! Buffer views packed with EXT_meshopt_compression, and primitives packed with KHR_draco_mesh_compression.

use super::accessor::{Component, Elements, width_of};
use super::json::At;
use super::meshopt;
use super::source::Source;
use crate::BakeError;
use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder};
use pelage_formats::Limits;

/// Everything that is unpacked of a model, bytes: many views can name the same packed bytes.
const MAX_UNPACKED: u64 = 1 << 30;

/// The bytes of a buffer view, unpacked as its extension (at `at`) says; `length` is what the view says they are.
pub(super) fn unpack_view<'a>(source: &mut Source<'a, '_>, at: &At<'a>, length: u64) -> Result<Vec<u8>, BakeError> {
    let count_at = at.require("count")?;
    let (count, stride) = (count_at.unsigned()?, at.require("byteStride")?.unsigned()?);
    let mode_at = at.require("mode")?;
    let mode = mode_at.string()?;
    let fits = match mode {
        "ATTRIBUTES" => (4..=256).contains(&stride) && stride % 4 == 0,
        "TRIANGLES" | "INDICES" => matches!(stride, 2 | 4),
        _ => return Err(mode_at.expected("ATTRIBUTES, TRIANGLES or INDICES")),
    };
    if !fits {
        return Err(at.fault(format!("has elements of {stride} bytes, which {mode} does not allow")));
    }
    if count.checked_mul(stride) != Some(length) {
        let reason = format!("has {count} elements of {stride} bytes, expected the {length} bytes of the buffer view");
        return Err(at.fault(reason));
    }
    if mode == "TRIANGLES" && count % 3 != 0 {
        return Err(count_at.expected("a multiple of 3"));
    }
    source.unpacked_bytes = source.unpacked_bytes.saturating_add(length);
    if source.unpacked_bytes > MAX_UNPACKED {
        return Err(at.fault(format!("takes what is unpacked of the model past {MAX_UNPACKED} bytes")));
    }
    let filter_at = at.get("filter");
    let filter = filter_at.as_ref().map_or(Ok("NONE"), At::string)?;
    let packed = source.range(at)?;
    let (count, stride) = (count as usize, stride as usize);
    let decoded = match mode {
        "ATTRIBUTES" => meshopt::decode_vertices(packed, count, stride)
            .and_then(|mut bytes| meshopt::unfilter(filter, stride, &mut bytes).map(|()| bytes)),
        "TRIANGLES" => meshopt::decode_triangles(packed, count).and_then(|indices| index_bytes(&indices, stride)),
        _ => meshopt::decode_indices(packed, count).and_then(|indices| index_bytes(&indices, stride)),
    };
    decoded.map_err(|reason| at.fault(format!("is packed with EXT_meshopt_compression {reason}")))
}

fn index_bytes(indices: &[u32], stride: usize) -> Result<Vec<u8>, meshopt::Fault> {
    if stride == 4 {
        return Ok(indices.iter().flat_map(|i| i.to_le_bytes()).collect());
    }
    let short = |i: &u32| u16::try_from(*i).map_err(|_| format!("and has index {i}, which 2 bytes do not hold"));
    Ok(indices.iter().map(short).collect::<Result<Vec<_>, _>>()?.into_iter().flat_map(u16::to_le_bytes).collect())
}

/// Unpacks the primitive at `primitive`, whose extension stands at `at`: puts the elements of its accessors into
/// [`Source::supplied`] and gives the corners of its triangles.
pub(super) fn unpack_primitive<'a>(
    source: &mut Source<'a, '_>,
    primitive: &At<'a>,
    at: &At<'a>,
) -> Result<Vec<u32>, BakeError> {
    let packed = source.view(&at.require("bufferView")?)?.bytes;
    let limits = Limits::default();
    let ceilings = DecodeLimits::default()
        .with_max_points(limits.vertices.into())
        .with_max_faces(u64::from(limits.indices) / 3)
        .with_max_decoded_bytes(MAX_UNPACKED);
    let mut mesh = Mesh::new();
    MeshDecoder::new().decode(&mut DecoderBuffer::new(packed).with_limits(ceilings), &mut mesh).map_err(|error| {
        at.fault(format!("is packed with KHR_draco_mesh_compression and cannot be unpacked: {error}"))
    })?;
    let points = mesh.num_points();
    let attributes = primitive.require("attributes")?;
    let packed_attributes = at.require("attributes")?;
    for name in packed_attributes.keys() {
        let (Some(id_at), Some(reference)) = (packed_attributes.get(name), attributes.get(name)) else { continue };
        let id = id_at.unsigned()?;
        let attribute = u32::try_from(id).ok().and_then(|id| mesh.attribute_by_unique_id(id));
        let attribute =
            attribute.ok_or_else(|| id_at.fault(format!("is {id}, which the packed data does not have")))?;
        let (index, accessor) = source.root.referred("accessors", &reference)?;
        let component = Component::read(&accessor.require("componentType")?)?;
        let width = width_of(&accessor.require("type")?)?;
        let (count, found) = (accessor.require("count")?.unsigned()?, usize::from(attribute.num_components()));
        if count != points as u64 || width != found {
            return Err(accessor.fault(format!(
                "has {count} elements of {width} numbers, expected the {points} of {found} in the packed data"
            )));
        }
        source.unpacked_bytes = source.unpacked_bytes.saturating_add((points * width * 4) as u64);
        if source.unpacked_bytes > MAX_UNPACKED {
            return Err(at.fault(format!("takes what is unpacked of the model past {MAX_UNPACKED} bytes")));
        }
        // Floats hold all integers that glTF uses here: joints, and normalized fractions of 16 bits.
        let values = attribute.read_f32s(points, width);
        source.supplied.insert(index, Elements::from_reals(&values, width, component, accessor.flag("normalized")?));
    }
    Ok(mesh.faces().iter().flatten().map(|point| point.0).collect())
}
