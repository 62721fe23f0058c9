//! Lines of a glTF scene as strands.

use super::elements::REAL;
use super::json::JsonNode;
use super::memory::MeshMemory;
use super::per_vertex::{check_count, read_per_vertex};
use super::primitive::{are_lines, color_reals, indices_of, vectors};
use super::scene::Tree;
use super::source::Source;
use crate::BakeError;
use crate::guides::Guides;
use crate::guides::lines::join_lines;
use glam::{DMat4, Mat4, Vec3};

/// Value of `mode` for separate lines (glTF 2.0, section 3.7.2.1). The other modes for lines follow.
const LINES: u64 = 1;
const LINE_LOOP: u64 = 2;
const LINE_STRIP: u64 = 3;

/// Strands and counts gathered from a scene.
#[derive(Default)]
struct LineStrands {
    guides: Guides,
    memory: MeshMemory,
    /// Number of primitives that are not lines.
    others: usize,
}

/// Reads the lines of the scene, in world space.
pub(super) fn strands<'a>(source: &mut Source<'a, '_>) -> Result<Guides, BakeError> {
    let tree = Tree::read(source)?;
    let root = Mat4::from_quat(source.forward_turn());
    let world = tree.world(root);
    let mut found = LineStrands::default();
    if tree.nodes.is_empty() {
        // In a document without nodes every mesh is shown without a transform, as in models.
        if let Some(meshes) = source.root.get("meshes") {
            for at in meshes.entries()? {
                read_mesh(source, &mut found, &at, root)?;
            }
        }
    }
    for node in tree.shown() {
        let at = &tree.nodes[node].at;
        let Some(reference) = at.get("mesh") else { continue };
        let followed = source.root.follow("meshes", &reference);
        let Some((_, mesh)) = source.or_warn(followed, "left out") else { continue };
        // A skin determines the positions of its vertices, whatever the node's transform (glTF 2.0, section 3.7.3.3).
        // At rest, a skin mostly leaves the vertices in place, so its joints are ignored.
        let placed = if at.get("skin").is_some() { root } else { world[node] };
        read_mesh(source, &mut found, &mesh, placed)?;
    }
    let LineStrands { guides, others, .. } = found;
    if guides.is_empty() && guides.left_out.total() == 0 {
        let reason = format!(
            "the scene has no lines, expected primitives of mode {LINES} (LINES), {LINE_LOOP} (LINE_LOOP) or \
             {LINE_STRIP} (LINE_STRIP); {others} have other modes"
        );
        return Err(source.root.fault(reason));
    }
    Ok(guides)
}

fn read_mesh<'a>(
    source: &mut Source<'a, '_>,
    found: &mut LineStrands,
    mesh: &JsonNode<'a>,
    world: Mat4,
) -> Result<(), BakeError> {
    for at in mesh.require("primitives")?.entries()? {
        let mode = at.unsigned_or("mode", 4)?;
        if are_lines(mode) {
            read_primitive(source, found, &at, mode, world)?;
        } else {
            found.others += 1;
        }
    }
    Ok(())
}

fn read_primitive<'a>(
    source: &mut Source<'a, '_>,
    found: &mut LineStrands,
    at: &JsonNode<'a>,
    mode: u64,
    world: Mat4,
) -> Result<(), BakeError> {
    let attributes = at.require("attributes")?;
    let position = attributes.require("POSITION")?;
    found.memory.count_primitive(source, at, false)?;
    let own = vectors(&source.accessor(&position, &[3], REAL)?.to_f32s(false));
    let points: Vec<Vec3> = own.iter().map(|p| world.transform_point3(*p)).collect();
    let size = DMat4::from_cols_array(&world.to_cols_array().map(f64::from)).determinant().abs();
    let radii = match attributes.get("_RADIUS") {
        Some(reference) => {
            let scale = libm::cbrt(size) as f32;
            let radii = read_per_vertex(source, &reference, &[1], own.len(), false)?;
            radii.iter().map(|r| scale * r).collect()
        }
        None => Vec::new(),
    };
    let colors = match attributes.get("COLOR_0") {
        Some(reference) => {
            check_count(source, &reference, own.len())?;
            let (width, flat) = color_reals(source, &reference)?;
            flat.chunks_exact(width).map(|c| Vec3::new(c[0], c[1], c[2])).collect()
        }
        None => Vec::new(),
    };
    let indices = indices_of(source, at, own.len())?;
    for strand in strands_of(at, mode, &indices, &own)? {
        let of = |v: &u32| *v as usize;
        let places: Vec<Vec3> = strand.iter().map(|v| points[of(v)]).collect();
        let radii: Vec<f32> = strand.iter().filter_map(|v| radii.get(of(v)).copied()).collect();
        let colors: Vec<Vec3> = strand.iter().filter_map(|v| colors.get(of(v)).copied()).collect();
        found.guides.push(&places, &radii, &colors);
    }
    Ok(())
}

/// Returns the vertex indices of each strand of a primitive.
pub(super) fn strands_of(
    at: &JsonNode<'_>,
    mode: u64,
    indices: &[u32],
    points: &[Vec3],
) -> Result<Vec<Vec<u32>>, BakeError> {
    if mode != LINES {
        let ring = indices.first().filter(|_| mode == LINE_LOOP);
        return Ok(vec![indices.iter().chain(ring).copied().collect()]);
    }
    let (pairs, odd) = indices.as_chunks::<2>();
    if !odd.is_empty() {
        return Err(at.fault(format!("has {} line ends, expected an even number", indices.len())));
    }
    let mut lines = pairs.to_vec();
    if at.get("indices").is_none() {
        // Without an index list, no two segments share a vertex. Then a segment that begins exactly where the previous
        // one ends continues it.
        for k in 1..lines.len() {
            if points[lines[k - 1][1] as usize] == points[lines[k][0] as usize] {
                lines[k][0] = lines[k - 1][1];
            }
        }
    }
    Ok(join_lines(&lines, points.len()))
}
