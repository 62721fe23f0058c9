//! Strands as binary glTF 2.0: lines with a colour and a radius per point.
//!
//! All strands are one primitive of separate lines with indices. Line strips would be one primitive per strand, because core glTF cannot begin
//! a strip anew within one: files of tens of thousands of primitives, which viewers take minutes to open.

use super::{too_many, write_floats};
use crate::strands::Curves;
use glam::Vec3;
use serde_json::json;
use std::io::{self, Write};

const FLOAT: u64 = 5126;
const UNSIGNED_INT: u64 = 5125;
const ARRAY_BUFFER: u64 = 34962;
const ELEMENT_ARRAY_BUFFER: u64 = 34963;
const LINES: u64 = 1;

/// Writes strands with `COLOR_0` (linear RGB) and `_RADIUS` (metres).
///
/// # Errors
/// Those of `out`; [`io::ErrorKind::InvalidInput`] where the file would pass the 4 GiB that the container can count.
pub fn write_glb(curves: &Curves, out: &mut dyn Write) -> io::Result<()> {
    let (points, lines) = (curves.points.len(), curves.segments());
    // Positions, colours, radii, pairs of indices; each a multiple of four bytes.
    let lengths = [12 * points, 12 * points, 4 * points, 8 * lines];
    let bin: usize = lengths.iter().sum();
    let mut offset = 0;
    let views: Vec<_> = lengths
        .iter()
        .enumerate()
        .map(|(i, length)| {
            let target = if i == 3 { ELEMENT_ARRAY_BUFFER } else { ARRAY_BUFFER };
            let view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": length, "target": target });
            offset += length;
            view
        })
        .collect();
    let start = curves.points.first().map_or(Vec3::ZERO, |p| p.position_ws);
    let places = || curves.points.iter().map(|p| p.position_ws);
    let (low, high) = (places().fold(start, Vec3::min), places().fold(start, Vec3::max));
    let generator = concat!("pelage ", env!("CARGO_PKG_VERSION"));
    let document = if lines == 0 {
        // glTF has no empty lists.
        json!({ "asset": { "version": "2.0", "generator": generator } })
    } else {
        json!({
            "asset": { "version": "2.0", "generator": generator },
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "mesh": 0, "name": "strands" }],
            "meshes": [{ "primitives": [{
                "attributes": { "POSITION": 0, "COLOR_0": 1, "_RADIUS": 2 },
                "indices": 3,
                "mode": LINES,
            }] }],
            "accessors": [
                {
                    "bufferView": 0, "componentType": FLOAT, "count": points, "type": "VEC3",
                    "min": low.to_array(), "max": high.to_array(),
                },
                { "bufferView": 1, "componentType": FLOAT, "count": points, "type": "VEC3" },
                { "bufferView": 2, "componentType": FLOAT, "count": points, "type": "SCALAR" },
                { "bufferView": 3, "componentType": UNSIGNED_INT, "count": 2 * lines, "type": "SCALAR" },
            ],
            "bufferViews": views,
            "buffers": [{ "byteLength": bin }],
        })
    };
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + text.len() + if lines == 0 { 0 } else { 8 + bin };
    let total = u32::try_from(total).map_err(|_| too_many("bytes", total, u32::MAX.into()))?;
    out.write_all(b"glTF")?;
    for number in [2, total, text.len() as u32] {
        out.write_all(&number.to_le_bytes())?;
    }
    out.write_all(b"JSON")?;
    out.write_all(&text)?;
    if lines == 0 {
        return Ok(());
    }
    out.write_all(&(bin as u32).to_le_bytes())?;
    out.write_all(b"BIN\0")?;
    curves.points.iter().try_for_each(|p| write_floats(&p.position_ws.to_array(), out))?;
    // The format allows 0..=1.
    curves.points.iter().try_for_each(|p| write_floats(&p.color.clamp(Vec3::ZERO, Vec3::ONE).to_array(), out))?;
    curves.points.iter().try_for_each(|p| write_floats(&[p.radius_m], out))?;
    for ends in curves.offsets.windows(2) {
        for i in ends[0]..ends[1] - 1 {
            out.write_all(&i.to_le_bytes())?;
            out.write_all(&(i + 1).to_le_bytes())?;
        }
    }
    Ok(())
}
