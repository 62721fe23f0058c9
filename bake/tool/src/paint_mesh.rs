//! Mesh of a groom map, for painting in other programs.

use super::exit::Failure;
use glam::{Vec2, Vec3};
use pelage_bake::groom_map::GroomMap;
use pelage_glb::{Buffer, Component, ViewTarget, bounds, container};
use pelage_import::BakeError;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::Path;

/// File format of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront OBJ without material colours.
    Obj,
    /// Binary glTF, with the map as its texture.
    Glb,
}

impl MeshFormat {
    /// Returns the format for the extension of a file name.
    ///
    /// Fails with [`Failure::Usage`] for any other extension.
    pub fn of(path: &Path) -> Result<Self, Failure> {
        match path.extension() {
            Some(extension) if extension.eq_ignore_ascii_case("obj") => Ok(Self::Obj),
            Some(extension) if extension.eq_ignore_ascii_case("glb") => Ok(Self::Glb),
            _ => Err(Failure::Usage(format!("--mesh {}: expected a name that ends in .obj or .glb", path.display()))),
        }
    }
}

/// Returns the contents of the mesh file: the mesh at rest, in metres, with the map's texture coordinates.
///
/// * `materials`: names of the model's materials
/// * `png`: the map
///
/// Fails with [`BakeError::Internal`] for a mesh larger than the format allows.
pub fn write(format: MeshFormat, map: &GroomMap, materials: &[String], png: &[u8]) -> Result<Vec<u8>, Failure> {
    match format {
        MeshFormat::Obj => Ok(obj(map, materials).into_bytes()),
        MeshFormat::Glb => glb(map, materials, png),
    }
}

/// Returns a unique material name without spaces.
fn plain_name(materials: &[String], material: usize) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    let name: String = materials.get(material).map_or("", String::as_str).chars().map(plain).collect();
    format!("{material}_{name}")
}

fn obj(map: &GroomMap, materials: &[String]) -> String {
    let GroomMap { mesh, rest, .. } = map;
    let mut text = String::new();
    // Writing into a string cannot fail.
    let _ = writeln!(text, "# {} vertices, {} triangles, metres, y up", mesh.positions.len(), mesh.triangles.len());
    for p in &rest.positions {
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    for uv in &mesh.uvs {
        // OBJ texture coordinates begin at the bottom row of the image.
        let _ = writeln!(text, "vt {} {}", uv.x, 1.0 - uv.y);
    }
    for n in &rest.normals {
        let _ = writeln!(text, "vn {} {} {}", n.x, n.y, n.z);
    }
    for part in &mesh.parts {
        let _ = writeln!(text, "usemtl {}", plain_name(materials, part.material));
        for triangle in &mesh.triangles[part.first_triangle..part.first_triangle + part.triangle_count] {
            let [a, b, c] = triangle.map(|v| v + 1);
            let _ = writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}");
        }
    }
    text
}

fn glb(map: &GroomMap, materials: &[String], png: &[u8]) -> Result<Vec<u8>, Failure> {
    use Component::{Float, UnsignedInt};
    let GroomMap { mesh, rest, .. } = map;
    let mut bin = Buffer::default();
    let count = mesh.positions.len();
    let mut streams = |values: &[f32], kind: &str, more: Value| {
        bin.push(bytemuck::cast_slice(values), Some(ViewTarget::Vertices), Float, kind, count, more)
    };
    let flat = |vectors: &[Vec3]| vectors.iter().flat_map(Vec3::to_array).collect::<Vec<f32>>();
    let positions = flat(&rest.positions);
    let uvs: Vec<f32> = mesh.uvs.iter().flat_map(Vec2::to_array).collect();
    let attributes = json!({
        "POSITION": streams(&positions, "VEC3", bounds(&positions, 3)),
        "NORMAL": streams(&flat(&rest.normals), "VEC3", json!({})),
        "TEXCOORD_0": streams(&uvs, "VEC2", json!({})),
    });
    let indices: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
    let index_view = bin.view(bytemuck::cast_slice(&indices), Some(ViewTarget::Indices));
    let mut primitives = Vec::new();
    for part in mesh.parts.iter().filter(|part| part.triangle_count > 0) {
        let offset = 12 * part.first_triangle as u64;
        let accessor =
            bin.layout.accessor(index_view, Some(offset), UnsignedInt, "SCALAR", 3 * part.triangle_count, json!({}));
        primitives.push(json!({ "attributes": attributes, "indices": accessor, "material": part.material }));
    }
    let image = bin.view(png, None);
    let wears_map = |name: &String| {
        let look = json!({ "baseColorTexture": { "index": 0 }, "metallicFactor": 0.0, "roughnessFactor": 1.0 });
        json!({ "name": name, "pbrMetallicRoughness": look })
    };
    let document = json!({
        "asset": { "version": "2.0", "generator": "pelage" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": primitives }],
        "materials": materials.iter().map(wears_map).collect::<Vec<_>>(),
        "textures": [{ "source": 0 }],
        "images": [{ "bufferView": image, "mimeType": "image/png" }],
        "accessors": bin.layout.accessors,
        "bufferViews": bin.layout.views,
        "buffers": [{ "byteLength": bin.bytes.len() }],
    });
    let failed = |error| BakeError::Internal(format!("writing the mesh as glTF: {error}")).into();
    container(&document, &bin.bytes).map_err(failed)
}
