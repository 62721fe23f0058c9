//! Strands as binary glTF 2.0: lines with a colour and a radius per point.
//!
//! All strands are one primitive of separate lines with indices. Line strips would be one primitive per strand, because core glTF cannot begin
//! a strip anew within one: files of tens of thousands of primitives, which viewers take minutes to open.

use super::write_floats;
use crate::strands::Curves;
use glam::Vec3;
use pelage_glb::{Component, Layout, ViewTarget, write_head};
use serde_json::json;
use std::io::{self, Write};

/// glTF's number for separate lines.
const LINES: u64 = 1;

/// Writes strands with `COLOR_0` (linear RGB) and `_RADIUS` (metres).
///
/// # Errors
/// Those of `out`; [`io::ErrorKind::InvalidInput`] where the file would pass the 4 GiB that the container can count.
pub fn write_glb(curves: &Curves, out: &mut dyn Write) -> io::Result<()> {
    let (points, lines) = (curves.points.len(), curves.segments());
    let mut layout = Layout::default();
    let mut add = |bytes: usize, target, component, kind, count, more| {
        let view = layout.view(bytes, Some(target));
        layout.accessor(view, None, component, kind, count, more);
    };
    let start = curves.points.first().map_or(Vec3::ZERO, |p| p.position_ws);
    let places = || curves.points.iter().map(|p| p.position_ws);
    let (low, high) = (places().fold(start, Vec3::min), places().fold(start, Vec3::max));
    let bounds = json!({ "min": low.to_array(), "max": high.to_array() });
    add(12 * points, ViewTarget::Vertices, Component::Float, "VEC3", points, bounds);
    add(12 * points, ViewTarget::Vertices, Component::Float, "VEC3", points, json!({}));
    add(4 * points, ViewTarget::Vertices, Component::Float, "SCALAR", points, json!({}));
    add(8 * lines, ViewTarget::Indices, Component::UnsignedInt, "SCALAR", 2 * lines, json!({}));
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
            "accessors": layout.accessors,
            "bufferViews": layout.views,
            "buffers": [{ "byteLength": layout.length }],
        })
    };
    write_head(&document, if lines == 0 { 0 } else { layout.length }, out)?;
    if lines == 0 {
        return Ok(());
    }
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
