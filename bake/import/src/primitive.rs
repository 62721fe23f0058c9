//! Primitives: attributes and topology of one mesh (glTF 2.0, section 3.7.2).

use super::elements::{Component, REAL, WHOLE, grouped};
use super::json::{JsonNode, shorten};
use super::material::{Materials, TextureCoords};
use super::memory::MeshMemory;
use super::per_vertex::{check_count, read_per_vertex};
use super::source::Source;
use super::{compressed, morphs, normals, weights};
use crate::BakeError;
use glam::{Vec2, Vec3};

/// A primitive of triangles, in mesh space, with the default morph weights applied.
#[derive(Debug)]
pub(super) struct Primitive<'a> {
    /// Position in the file, for errors.
    pub at: JsonNode<'a>,
    /// Readable description, for warnings.
    pub label: String,
    /// Index into [`Materials::materials`].
    pub material: usize,
    pub positions: Vec<Vec3>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// Whether the normals come from the file; if not, the importer computed them.
    pub has_normals: bool,
    pub uvs: Vec<Vec2>,
    pub has_uvs: bool,
    pub colors: Vec<[u8; 4]>,
    /// Four joints of the skin per vertex, with their weights; `None` for a primitive that follows its node.
    pub influences: Option<Vec<weights::Influence>>,
    pub triangles: Vec<[u32; 3]>,
    /// Morph targets of the primitive; `None` without any.
    pub morph: Option<morphs::Morph>,
}

pub(super) struct MeshUse<'a> {
    pub index: usize,
    pub at: JsonNode<'a>,
    /// Morph weights of the node, which override the mesh's own.
    pub weights: Option<JsonNode<'a>>,
    pub skinned: bool,
    /// Whether lines of the mesh define the comb direction of hair.
    pub combs: bool,
}

/// Running totals and materials of the meshes read.
#[derive(Debug, Default)]
pub(super) struct MeshTotals {
    pub materials: Materials,
    /// Number of primitives that were ignored.
    pub skipped: usize,
    pub memory: MeshMemory,
}

/// Returns whether `mode` is a topology of lines (glTF 2.0, section 3.7.2.1, "Topology").
pub(super) fn are_lines(mode: u64) -> bool {
    (1..=3).contains(&mode)
}

/// Reads all primitives of a mesh that hold triangles. Others are counted and reported.
pub(super) fn read_mesh<'a>(
    source: &mut Source<'a, '_>,
    gathered: &mut MeshTotals,
    mesh: &MeshUse<'a>,
) -> Result<Vec<Primitive<'a>>, BakeError> {
    let targets = morphs::TargetInfo::from_mesh(source, &mesh.at, mesh.weights.as_ref());
    let name = mesh.at.name();
    let name = if name.is_empty() { String::new() } else { format!(" \"{}\"", shorten(name)) };
    for at in mesh.at.require("primitives")?.entries()? {
        gathered.memory.count_primitive(source, &at, mesh.skinned)?;
    }
    let mut primitives = Vec::new();
    for (i, at) in mesh.at.require("primitives")?.entries()?.enumerate() {
        let label = format!("mesh {}{name}, primitive {i}", mesh.index);
        if mesh.combs && are_lines(at.unsigned_or("mode", 4)?) {
            continue;
        }
        match read_primitive(source, gathered, &at, label, &targets, mesh.skinned)? {
            Some(primitive) => primitives.push(primitive),
            None => gathered.skipped += 1,
        }
    }
    let shapes = primitives.iter_mut().map(|p| normals::NormalInput {
        label: &p.label,
        positions: &p.positions,
        triangles: &p.triangles,
        normals: &mut p.normals,
    });
    normals::complete_normals(&mut source.notes, &mut shapes.collect::<Vec<_>>());
    Ok(primitives)
}

fn read_primitive<'a>(
    source: &mut Source<'a, '_>,
    gathered: &mut MeshTotals,
    at: &JsonNode<'a>,
    label: String,
    targets: &morphs::TargetInfo,
    skinned: bool,
) -> Result<Option<Primitive<'a>>, BakeError> {
    let mode = at.unsigned_or("mode", 4)?;
    if mode > 6 {
        return at.get("mode").map_or(Ok(None), |mode| Err(mode.unexpected("0..=6 (4 is triangles)")));
    }
    if mode < 4 {
        let what = ["points", "lines", "a line loop", "a line strip"][mode as usize];
        source.warn(format!("{label} holds {what}, expected triangles; left out"));
        return Ok(None);
    }
    let unpacked = match draco_only(source, at) {
        Some(extension) => Some(compressed::unpack_primitive(source, at, &extension)?),
        None => None,
    };
    let attributes = at.require("attributes")?;
    let Some(position_at) = attributes.get("POSITION") else {
        source.warn(format!("{label} has no POSITION; left out"));
        return Ok(None);
    };
    let mut positions = vectors(&source.accessor(&position_at, &[3], REAL)?.to_f32s(false));
    // Draco data always holds triangles, whatever mode the primitive states.
    let mode = if unpacked.is_some() { 4 } else { mode };
    let indices = match unpacked {
        Some(indices) => in_range(at, indices, positions.len())?,
        None => indices_of(source, at, positions.len())?,
    };
    let triangles = triangulate(mode, &indices);
    if mode == 4 && indices.len() % 3 != 0 {
        let n = indices.len();
        source.warn(format!("{label} has {n} corners, which is not a multiple of 3; the last {} are left out", n % 3));
    }
    if triangles.is_empty() {
        source.warn(format!("{label} has {} vertices but no triangles; left out", positions.len()));
        return Ok(None);
    }
    let mut normals = attributes.get("NORMAL").and_then(|reference| {
        let normals = read_per_vertex(source, &reference, &[3], positions.len(), false);
        source.or_warn(normals, "normals are computed").map(|flat| vectors(&flat))
    });
    let morph =
        morphs::read(source, &mut gathered.memory, at, &label, targets, &mut positions, normals.as_deref_mut())?;
    if let Some(i) = positions.iter().position(|p| !p.is_finite()) {
        return Err(position_at.fault(format!("element {i} is {}, expected finite numbers", positions[i])));
    }
    let (material, coords) = gathered.materials.read(source, at.get("material").as_ref());
    let uvs = read_uvs(source, &attributes, &label, &coords, positions.len());
    let uvs = source.or_warn(uvs, "the texture coordinates are left out").flatten();
    let colors = read_colors(source, &attributes, positions.len());
    let colors = source.or_warn(colors, "the vertex colours are white");
    let influences = if skinned { weights::read(source, &attributes, &label, positions.len())? } else { None };
    Ok(Some(Primitive {
        at: at.clone(),
        label,
        material,
        has_normals: normals.is_some(),
        normals: normals.unwrap_or_default(),
        has_uvs: uvs.is_some(),
        uvs: uvs.unwrap_or_else(|| vec![Vec2::ZERO; positions.len()]),
        colors: colors.unwrap_or_else(|| vec![[255; 4]; positions.len()]),
        influences,
        triangles,
        positions,
        morph,
    }))
}

/// Returns the extension of a primitive that has Draco data and no uncompressed data.
fn draco_only<'a>(source: &Source<'a, '_>, at: &JsonNode<'a>) -> Option<JsonNode<'a>> {
    let extension = at.extension("KHR_draco_mesh_compression")?;
    let position = at.get("attributes").and_then(|a| a.get("POSITION"));
    let accessor = position.and_then(|p| source.root.follow("accessors", &p).ok());
    let plain = accessor.is_some_and(|(_, a)| a.get("bufferView").is_some() || a.get("sparse").is_some());
    (!plain).then_some(extension)
}

/// Returns the vertex indices of a primitive, in the order of its index list.
pub(super) fn indices_of<'a>(
    source: &mut Source<'a, '_>,
    at: &JsonNode<'a>,
    vertices: usize,
) -> Result<Vec<u32>, BakeError> {
    match at.get("indices") {
        Some(reference) => in_range(at, source.accessor(&reference, &[1], WHOLE)?.to_u32s(), vertices),
        None => Ok((0..vertices as u32).collect()),
    }
}

fn in_range(at: &JsonNode<'_>, indices: Vec<u32>, vertices: usize) -> Result<Vec<u32>, BakeError> {
    let Some(i) = indices.iter().position(|v| *v as usize >= vertices) else { return Ok(indices) };
    let at = at.get("indices").unwrap_or_else(|| at.clone());
    Err(at.fault(format!("element {i} is {}, expected less than the {vertices} vertices", indices[i])))
}

pub(super) fn vectors(flat: &[f32]) -> Vec<Vec3> {
    grouped::<3>(flat).map(Vec3::from).collect()
}

/// Returns the corner indices of each triangle (glTF 2.0, section 3.7.2.1, "Topology").
fn triangulate(mode: u64, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        5 => {
            // In a strip the winding alternates: two corners of every second triangle are swapped, so that all face the
            // same side.
            let corner = |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
            indices.windows(3).enumerate().map(corner).collect()
        }
        6 => {
            let (first, rest) = indices.split_first().map_or((0, &[][..]), |(f, r)| (*f, r));
            rest.windows(2).map(|w| [w[0], w[1], first]).collect()
        }
        _ => indices.as_chunks::<3>().0.to_vec(),
    }
}

/// Reads the transformed texture coordinates of the material. For a material without texture reads the first set
/// present.
fn read_uvs<'a>(
    source: &mut Source<'a, '_>,
    attributes: &JsonNode<'a>,
    label: &str,
    coords: &TextureCoords,
    vertices: usize,
) -> Result<Option<Vec<Vec2>>, BakeError> {
    let mut found = coords.set.and_then(|n| attributes.get(&format!("TEXCOORD_{n}")));
    if found.is_none() {
        found = (0..8).find_map(|n| attributes.get(&format!("TEXCOORD_{n}")));
        if let Some(set) = coords.set {
            let instead = found.as_ref().map_or("its texture cannot be applied".to_owned(), |at| {
                format!("{} is used", at.place.rsplit('/').next().unwrap_or_default())
            });
            source.warn(format!("{label} has no TEXCOORD_{set}, which its material's texture uses; {instead}"));
        }
    }
    let Some(reference) = found else { return Ok(None) };
    let flat = read_per_vertex(source, &reference, &[2], vertices, false)?;
    let mut uvs: Vec<Vec2> = grouped::<2>(&flat).map(|uv| coords.transform.transform_point2(uv.into())).collect();
    let mut bad = 0;
    for uv in uvs.iter_mut().filter(|uv| !uv.is_finite()) {
        *uv = Vec2::ZERO;
        bad += 1;
    }
    if bad > 0 {
        source.warn(format!("{}: {bad} texture coordinates are not finite; set to 0", reference.place));
    }
    Ok(Some(uvs))
}

fn read_colors<'a>(
    source: &mut Source<'a, '_>,
    attributes: &JsonNode<'a>,
    vertices: usize,
) -> Result<Vec<[u8; 4]>, BakeError> {
    let Some(reference) = attributes.get("COLOR_0") else { return Ok(vec![[255; 4]; vertices]) };
    check_count(source, &reference, vertices)?;
    let (width, flat) = color_reals(source, &reference)?;
    let byte = |x: f32| (x * 255.0).round().clamp(0.0, 255.0) as u8;
    Ok(match width {
        3 => grouped::<3>(&flat).map(|[r, g, b]| [byte(r), byte(g), byte(b), 255]).collect(),
        _ => grouped::<4>(&flat).map(|rgba| rgba.map(byte)).collect(),
    })
}

/// Reads a colour attribute: returns the number of components and all numbers.
pub(super) fn color_reals<'a>(
    source: &mut Source<'a, '_>,
    reference: &JsonNode<'a>,
) -> Result<(usize, Vec<f32>), BakeError> {
    let elements = source.accessor(reference, &[3, 4], REAL)?;
    // Integer colours are fractions of 1, even if the accessor lacks `normalized`, which the specification requires.
    Ok((elements.width, elements.to_f32s(elements.component != Component::F32)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_have_consistent_winding() {
        assert_eq!(triangulate(5, &[0, 1, 2, 3, 4]), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        assert_eq!(triangulate(6, &[9, 1, 2, 3]), [[1, 2, 9], [2, 3, 9]]);
        assert_eq!(triangulate(4, &[0, 1, 2, 3, 4]), [[0, 1, 2]]);
        for mode in 4..=6 {
            for short in 0..3 {
                assert!(triangulate(mode, &[0, 1, 2][..short]).is_empty());
            }
        }
    }
}
