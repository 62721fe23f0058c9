//! Converts a package's mesh to a binary glTF file for other tools, and back without loss.
//!
//! Each part of the manifest is a primitive; all primitives share one set of vertex accessors. Data without a glTF
//! equivalent are application-specific attributes, which begin with an underscore (glTF 2.0, section 3.7.2.1):
//! `_FUR_HEIGHT`, `_LEAN`, `_TILE_UV` and `_GROOM`.

use bytemuck::{Pod, Zeroable};
use pelage_formats::{AttributeVertex, GeometryVertex, Manifest, MeshData, SkinVertex};
use pelage_glb::{Buffer, Component, ViewTarget, bounds, container};
use pelage_import::BakeError;
use serde_json::{Value, json};

/// Adds a vertex attribute; returns the index of its accessor.
fn attribute<T: Pod>(buffer: &mut Buffer, values: &[T], component: Component, kind: &str, more: Value) -> usize {
    buffer.push(bytemuck::cast_slice(values), Some(ViewTarget::Vertices), component, kind, values.len(), more)
}

/// Writes `mesh` as .glb. Returns `None` for a mesh that glTF cannot hold: one without vertices or triangles, or larger
/// than 4 GiB.
pub fn write(mesh: &MeshData, manifest: &Manifest) -> Option<Vec<u8>> {
    if mesh.geometry.is_empty() || mesh.indices.is_empty() {
        return None;
    }
    use Component::{Float, UnsignedByte, UnsignedInt, UnsignedShort};
    let mut bin = Buffer::default();
    let mut attributes = json!({});
    let mut add = |name: &str, accessor: usize| attributes[name] = accessor.into();
    let plain = || json!({});
    let normalized = || json!({ "normalized": true });
    let g = |f: fn(&GeometryVertex) -> [f32; 3]| mesh.geometry.iter().map(f).collect::<Vec<_>>();
    let positions = g(|v| v.position);
    add("POSITION", attribute(&mut bin, &positions, Float, "VEC3", bounds(bytemuck::cast_slice(&positions), 3)));
    add("NORMAL", attribute(&mut bin, &g(|v| v.normal), Float, "VEC3", plain()));
    let tangents: Vec<_> = mesh.geometry.iter().map(|v| v.tangent).collect();
    add("TANGENT", attribute(&mut bin, &tangents, Float, "VEC4", plain()));
    let base_uvs: Vec<_> = mesh.attributes.iter().map(|v| v.base_uv).collect();
    add("TEXCOORD_0", attribute(&mut bin, &base_uvs, Float, "VEC2", plain()));
    let colors: Vec<_> = mesh.attributes.iter().map(|v| v.color).collect();
    add("COLOR_0", attribute(&mut bin, &colors, UnsignedByte, "VEC4", normalized()));
    if !mesh.skin.is_empty() {
        let joints: Vec<_> = mesh.skin.iter().map(|v| v.joints).collect();
        add("JOINTS_0", attribute(&mut bin, &joints, UnsignedShort, "VEC4", plain()));
        let weights: Vec<_> = mesh.skin.iter().map(|v| v.weights).collect();
        add("WEIGHTS_0", attribute(&mut bin, &weights, Float, "VEC4", plain()));
    }
    let heights: Vec<_> = mesh.geometry.iter().map(|v| v.fur_height).collect();
    add("_FUR_HEIGHT", attribute(&mut bin, &heights, Float, "SCALAR", plain()));
    let tile_uvs: Vec<_> = mesh.attributes.iter().map(|v| v.tile_uv).collect();
    add("_TILE_UV", attribute(&mut bin, &tile_uvs, Float, "VEC2", plain()));
    let leans: Vec<_> = mesh.geometry.iter().map(|v| v.lean).collect();
    add("_LEAN", attribute(&mut bin, &leans, Float, "SCALAR", plain()));
    let grooms: Vec<_> = mesh.attributes.iter().map(|v| v.groom).collect();
    add("_GROOM", attribute(&mut bin, &grooms, UnsignedByte, "VEC4", normalized()));

    let index_view = bin.view(bytemuck::cast_slice(&mesh.indices), Some(ViewTarget::Indices));
    let mut primitives = Vec::new();
    for part in manifest.parts.iter().filter(|p| p.index_count > 0) {
        let (offset, count) = (u64::from(part.first_index) * 4, part.index_count as usize);
        let indices = bin.layout.accessor(index_view, Some(offset), UnsignedInt, "SCALAR", count, plain());
        primitives.push(json!({ "attributes": attributes, "indices": indices, "material": part.material }));
    }
    let materials: Vec<_> = manifest
        .materials
        .iter()
        .map(|m| {
            json!({
                "name": m.name,
                "doubleSided": m.double_sided,
                "pbrMetallicRoughness": {
                    "baseColorFactor": m.base_color.map(|c| c.clamp(0.0, 1.0)),
                    "metallicFactor": 0.0,
                },
            })
        })
        .collect();
    let mut document = json!({
        "asset": { "version": "2.0", "generator": manifest.generator },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": manifest.model }],
        "meshes": [{ "primitives": primitives }],
        "accessors": bin.layout.accessors,
        "bufferViews": bin.layout.views,
        "buffers": [{ "byteLength": bin.bytes.len() }],
    });
    // glTF forbids empty arrays.
    if !materials.is_empty() {
        document["materials"] = materials.into();
    }
    container(&document, &bin.bytes).ok()
}

/// Reads the output of [`fn@write`], which may have been edited. Uses the primitives of the first mesh, in order.
/// Primitives that do not share accessors get their own vertices.
pub fn read(file: &str, bytes: &[u8]) -> Result<MeshData, BakeError> {
    let (document, bin) = parse_container(file, bytes)?;
    let glb = Glb { file, document: &document, bin };
    let primitives = document.pointer("/meshes/0/primitives").and_then(Value::as_array).filter(|p| !p.is_empty());
    let primitives =
        primitives.ok_or_else(|| glb.fail("/meshes/0/primitives", "nothing found, expected a list of primitives"))?;
    let mut mesh = MeshData::default();
    let mut previous: Option<(&Value, usize)> = None;
    for (i, primitive) in primitives.iter().enumerate() {
        let at = format!("/meshes/0/primitives/{i}");
        if primitive.get("mode").is_some_and(|m| *m != 4) {
            return Err(glb.fail(&format!("{at}/mode"), format!("found {}, expected 4 (triangles)", primitive["mode"])));
        }
        let attributes = &primitive["attributes"];
        let base = match previous {
            Some((same, base)) if same == attributes => base,
            _ => {
                let base = mesh.geometry.len();
                glb.append_vertices(&format!("{at}/attributes"), &mut mesh)?;
                base
            }
        };
        previous = Some((attributes, base));
        for index in glb.accessor::<u32>(&format!("{at}/indices"), Component::UnsignedInt, "SCALAR")? {
            let index = u32::try_from(base).ok().and_then(|base| index.checked_add(base));
            mesh.indices.push(index.ok_or_else(|| glb.fail(&format!("{at}/indices"), "an index exceeds 32 bits"))?);
        }
    }
    Ok(mesh)
}

fn parse_container<'a>(file: &str, bytes: &'a [u8]) -> Result<(Value, &'a [u8]), BakeError> {
    let fail = |at: usize, reason: String| BakeError::Input { file: file.into(), place: format!("byte {at}"), reason };
    let u32_at = |at: usize| {
        let field = bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
        field.ok_or_else(|| fail(at, format!("the file ends after {} bytes, expected a number here", bytes.len())))
    };
    if !bytes.starts_with(b"glTF") {
        return Err(fail(0, "not a binary glTF file: expected it to begin with \"glTF\"".into()));
    }
    let (version, length) = (u32_at(4)?, u32_at(8)?);
    if version != 2 {
        return Err(fail(4, format!("glTF version {version}, expected 2")));
    }
    if length as usize != bytes.len() {
        return Err(fail(8, format!("length is {length}, expected the file's {} bytes", bytes.len())));
    }
    let chunk = |at: usize, kind: &[u8; 4]| -> Result<&'a [u8], BakeError> {
        let length = u32_at(at)? as usize;
        if bytes.get(at + 4..at + 8) != Some(kind) {
            return Err(fail(at + 4, format!("expected a chunk of type {:?}", kind.escape_ascii().to_string())));
        }
        let end = (at + 8).saturating_add(length);
        bytes.get(at + 8..end).ok_or_else(|| fail(at, format!("a chunk of {length} bytes reaches past the file's end")))
    };
    let json = chunk(12, b"JSON")?;
    let document = serde_json::from_slice(json)
        .map_err(|e| fail(20, format!("its JSON is broken at line {}, column {}: {e}", e.line(), e.column())))?;
    Ok((document, chunk(20 + json.len(), b"BIN\0")?))
}

/// Parsed file.
struct Glb<'a> {
    file: &'a str,
    document: &'a Value,
    bin: &'a [u8],
}

impl Glb<'_> {
    fn fail(&self, place: &str, reason: impl Into<String>) -> BakeError {
        BakeError::Input { file: self.file.to_owned(), place: place.to_owned(), reason: reason.into() }
    }

    fn number(&self, pointer: &str) -> Result<usize, BakeError> {
        let found = self.document.pointer(pointer).and_then(Value::as_u64).and_then(|n| usize::try_from(n).ok());
        found.ok_or_else(|| self.fail(pointer, "missing, expected a whole number"))
    }

    fn number_or(&self, pointer: &str, default: usize) -> Result<usize, BakeError> {
        if self.document.pointer(pointer).is_some() { self.number(pointer) } else { Ok(default) }
    }

    /// Returns the elements of an accessor; the JSON pointer `pointer` locates its index.
    fn accessor<T: Pod + Zeroable>(
        &self,
        pointer: &str,
        component: Component,
        kind: &str,
    ) -> Result<Vec<T>, BakeError> {
        let at = format!("/accessors/{}", self.number(pointer)?);
        let (found, found_kind) =
            (self.number(&format!("{at}/componentType"))? as u64, self.document.pointer(&format!("{at}/type")));
        if found != component as u64 || found_kind.and_then(Value::as_str) != Some(kind) {
            let found_kind = found_kind.cloned().unwrap_or_default();
            let reason = format!(
                "found component type {found} and type {found_kind}, expected {} and \"{kind}\"",
                component as u64
            );
            return Err(self.fail(&at, reason));
        }
        if self.document.pointer(&format!("{at}/sparse")).is_some() {
            return Err(self.fail(&format!("{at}/sparse"), "found a sparse accessor, expected one that is not sparse"));
        }
        let view = format!("/bufferViews/{}", self.number(&format!("{at}/bufferView"))?);
        let start = self.number_or(&format!("{view}/byteOffset"), 0)?;
        let length = self.number(&format!("{view}/byteLength"))?;
        let data = start.checked_add(length).and_then(|end| self.bin.get(start..end)).ok_or_else(|| {
            self.fail(
                &view,
                format!(
                    "found {length} bytes from offset {start}, expected them within the binary chunk of {} bytes",
                    self.bin.len()
                ),
            )
        })?;
        let stride = self.number_or(&format!("{view}/byteStride"), size_of::<T>())?;
        let offset = self.number_or(&format!("{at}/byteOffset"), 0)?;
        let count = self.number(&format!("{at}/count"))?;
        let element = |i: usize| {
            let from = i.checked_mul(stride)?.checked_add(offset)?;
            data.get(from..from.checked_add(size_of::<T>())?).map(bytemuck::pod_read_unaligned)
        };
        // The element size is checked because a stride of zero would allow any count.
        if stride < size_of::<T>() || (count > 0 && element(count - 1).is_none_or(|_: T| false)) {
            return Err(self.fail(&at, format!("{count} elements reach past the {length} bytes of {view}")));
        }
        Ok((0..count).map_while(element).collect())
    }

    fn append_vertices(&self, at: &str, mesh: &mut MeshData) -> Result<(), BakeError> {
        let name = |attribute: &str| format!("{at}/{attribute}");
        let positions: Vec<[f32; 3]> = self.accessor(&name("POSITION"), Component::Float, "VEC3")?;
        let n = positions.len();
        let normals: Vec<[f32; 3]> = self.sized(&name("NORMAL"), Component::Float, "VEC3", n)?;
        let tangents: Vec<[f32; 4]> = self.sized(&name("TANGENT"), Component::Float, "VEC4", n)?;
        let heights: Vec<f32> = self.sized(&name("_FUR_HEIGHT"), Component::Float, "SCALAR", n)?;
        let leans: Vec<f32> = self.sized(&name("_LEAN"), Component::Float, "SCALAR", n)?;
        let grooms: Vec<[u8; 4]> = self.sized(&name("_GROOM"), Component::UnsignedByte, "VEC4", n)?;
        let tile_uvs: Vec<[f32; 2]> = self.sized(&name("_TILE_UV"), Component::Float, "VEC2", n)?;
        let base_uvs: Vec<[f32; 2]> = self.sized(&name("TEXCOORD_0"), Component::Float, "VEC2", n)?;
        let colors: Vec<[u8; 4]> = self.sized(&name("COLOR_0"), Component::UnsignedByte, "VEC4", n)?;
        let skinned = self.document.pointer(&name("JOINTS_0")).is_some();
        if !mesh.geometry.is_empty() && skinned == mesh.skin.is_empty() {
            return Err(self.fail(at, "expected JOINTS_0 in all primitives or in none"));
        }
        if skinned {
            let joints: Vec<[u16; 4]> = self.sized(&name("JOINTS_0"), Component::UnsignedShort, "VEC4", n)?;
            let weights: Vec<[f32; 4]> = self.sized(&name("WEIGHTS_0"), Component::Float, "VEC4", n)?;
            mesh.skin.extend(joints.into_iter().zip(weights).map(|(joints, weights)| SkinVertex { joints, weights }));
        }
        for i in 0..n {
            mesh.geometry.push(GeometryVertex {
                position: positions[i],
                fur_height: heights[i],
                normal: normals[i],
                lean: leans[i],
                tangent: tangents[i],
            });
            let (tile_uv, base_uv, color, groom) = (tile_uvs[i], base_uvs[i], colors[i], grooms[i]);
            mesh.attributes.push(AttributeVertex { tile_uv, base_uv, color, groom });
        }
        Ok(())
    }

    /// Returns [`Self::accessor`], and requires exactly `count` elements.
    fn sized<T: Pod>(
        &self,
        pointer: &str,
        component: Component,
        kind: &str,
        count: usize,
    ) -> Result<Vec<T>, BakeError> {
        let values = self.accessor(pointer, component, kind)?;
        if values.len() != count {
            return Err(self.fail(pointer, format!("{} elements, expected the {count} of POSITION", values.len())));
        }
        Ok(values)
    }
}
