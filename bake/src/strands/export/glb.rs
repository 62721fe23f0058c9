//! Export of strands as binary glTF 2.0: lines with a colour and a radius per point.
//!
//! Each group is a node and a mesh with the group's name. Its strands are one primitive of separate lines with indices.
//! Line strips would need one primitive per strand, because core glTF cannot restart a strip within a primitive.
//! Viewers take minutes to open files with tens of thousands of primitives.

use super::write_floats;
use crate::strands::{CurveGroup, Curves};
use glam::Vec3;
use pelage_glb::{Component, Layout, ViewTarget, write_head};
use serde_json::{Value, json};
use std::io::{self, Write};

/// Primitive mode of separate lines in glTF.
const LINES: u64 = 1;

/// Writes strands with `COLOR_0` (linear RGB) and `_RADIUS` (metres).
///
/// Fails with errors of `out`; [`io::ErrorKind::InvalidInput`] if the file would exceed the container's limit of 4 GiB.
pub fn write_glb(curves: &Curves, out: &mut dyn Write) -> io::Result<()> {
    let mut layout = Layout::default();
    let (nodes, meshes): (Vec<Value>, Vec<Value>) = curves
        .groups()
        .iter()
        .enumerate()
        .map(|(i, group)| {
            let primitive = lay_out(curves, group, &mut layout);
            (json!({ "mesh": i, "name": group.name }), json!({ "name": group.name, "primitives": [primitive] }))
        })
        .unzip();
    let asset = json!({ "version": "2.0", "generator": concat!("pelage ", env!("CARGO_PKG_VERSION")) });
    let document = if nodes.is_empty() {
        // An empty file has no lists, because glTF does not allow empty ones.
        json!({ "asset": asset })
    } else {
        json!({
            "asset": asset,
            "scene": 0,
            "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
            "nodes": nodes,
            "meshes": meshes,
            "accessors": layout.accessors,
            "bufferViews": layout.views,
            "buffers": [{ "byteLength": layout.length }],
        })
    };
    write_head(&document, layout.length, out)?;
    curves.groups().iter().try_for_each(|group| write_group(curves, group, out))
}

/// Adds the buffer views and accessors of a group, in the order in which [`write_group`] writes the data. Returns the
/// primitive of the group.
fn lay_out(curves: &Curves, group: &CurveGroup, layout: &mut Layout) -> Value {
    let points = curves.points_of(group);
    let lines = points.len() - group.strands.len();
    let mut add = |bytes: usize, target, component, kind, count, more| {
        let view = layout.view(bytes, Some(target));
        layout.accessor(view, None, component, kind, count, more)
    };
    let places = || points.iter().map(|p| p.position_ws);
    let (low, high) = (places().fold(Vec3::INFINITY, Vec3::min), places().fold(Vec3::NEG_INFINITY, Vec3::max));
    let bounds = json!({ "min": low.to_array(), "max": high.to_array() });
    let count = points.len();
    let positions = add(12 * count, ViewTarget::Vertices, Component::Float, "VEC3", count, bounds);
    let colors = add(12 * count, ViewTarget::Vertices, Component::Float, "VEC3", count, json!({}));
    let radii = add(4 * count, ViewTarget::Vertices, Component::Float, "SCALAR", count, json!({}));
    let indices = add(8 * lines, ViewTarget::Indices, Component::UnsignedInt, "SCALAR", 2 * lines, json!({}));
    json!({
        "attributes": { "POSITION": positions, "COLOR_0": colors, "_RADIUS": radii },
        "indices": indices,
        "mode": LINES,
    })
}

fn write_group(curves: &Curves, group: &CurveGroup, out: &mut dyn Write) -> io::Result<()> {
    let points = curves.points_of(group);
    points.iter().try_for_each(|p| write_floats(&p.position_ws.to_array(), out))?;
    // The format only allows colours in 0..=1.
    points.iter().try_for_each(|p| write_floats(&p.color.clamp(Vec3::ZERO, Vec3::ONE).to_array(), out))?;
    points.iter().try_for_each(|p| write_floats(&[p.radius_m], out))?;
    let offsets = &curves.offsets[group.strands.start as usize..=group.strands.end as usize];
    for ends in offsets.windows(2) {
        // Indices are relative to the group.
        for i in ends[0] - offsets[0]..ends[1] - 1 - offsets[0] {
            out.write_all(&i.to_le_bytes())?;
            out.write_all(&(i + 1).to_le_bytes())?;
        }
    }
    Ok(())
}
