//! Decoding of primitives compressed with KHR_draco_mesh_compression.

use super::elements::{Component, Elements, width_of};
use super::json::JsonNode;
use super::source::{MAX_UNPACKED, Source};
use crate::BakeError;
use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder};
use pelage_formats::Limits;

/// Decodes the Draco data of the primitive at `primitive`; the extension is at `at`. Stores the elements of its
/// accessors in [`Source::supplied`] and returns the corners of its triangles.
pub(super) fn unpack_primitive<'a>(
    source: &mut Source<'a, '_>,
    primitive: &JsonNode<'a>,
    at: &JsonNode<'a>,
) -> Result<Vec<u32>, BakeError> {
    let packed = source.view(&at.require("bufferView")?)?.bytes;
    let limits = Limits::default();
    let ceilings = DecodeLimits::default()
        .with_max_points(limits.vertices.into())
        .with_max_faces(u64::from(limits.indices) / 3)
        .with_max_decoded_bytes(MAX_UNPACKED);
    let mut mesh = Mesh::new();
    MeshDecoder::new().decode(&mut DecoderBuffer::new(packed).with_limits(ceilings), &mut mesh).map_err(|error| {
        at.fault(format!("is compressed with KHR_draco_mesh_compression and cannot be decoded: {error}"))
    })?;
    let points = mesh.num_points();
    let attributes = primitive.require("attributes")?;
    let packed_attributes = at.require("attributes")?;
    for name in packed_attributes.keys() {
        let (Some(id_at), Some(reference)) = (packed_attributes.get(name), attributes.get(name)) else { continue };
        let id = id_at.unsigned()?;
        let attribute = u32::try_from(id).ok().and_then(|id| mesh.attribute_by_unique_id(id));
        let attribute =
            attribute.ok_or_else(|| id_at.fault(format!("is {id}, which the compressed data does not have")))?;
        let (index, accessor) = source.root.follow("accessors", &reference)?;
        let component = Component::read(&accessor.require("componentType")?)?;
        let width = width_of(&accessor.require("type")?)?;
        let (count, found) = (accessor.require("count")?.unsigned()?, usize::from(attribute.num_components()));
        if count != points as u64 || width != found {
            return Err(accessor.fault(format!(
                "has {count} elements of {width} numbers, expected {points} elements of {found} numbers, as in the \
                 compressed data"
            )));
        }
        source.count_unpacked(at, (points * width * 4) as u64)?;
        // An f32 represents all integers that glTF uses here exactly: joint indices, and normalized fractions of 16
        // bits.
        let values = attribute.read_f32s(points, width);
        source.supplied.insert(index, Elements::from_reals(&values, width, component, accessor.flag("normalized")?));
    }
    Ok(mesh.faces().iter().flatten().map(|point| point.0).collect())
}
