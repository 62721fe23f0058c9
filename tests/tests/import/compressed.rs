//! Tests of compressed glTF: our decoder must restore the data of meshopt's own encoder bit for bit, and damaged data
//! must give an error.
#![allow(clippy::unwrap_used, reason = "tests")]

use crate::import::support::*;
use glam::Vec3;
use pelage_bake::stages::import::{ImportOptions, import};
use pelage_import::BakeError;
use pelage_import::mesh::Model;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::path::Path;

/// Returns a wavy sheet of `side` x `side` vertices: positions, normals for octahedral encoding, triangles.
fn sheet(side: usize) -> (Vec<[f32; 3]>, Vec<[f32; 4]>, Vec<u32>) {
    let (mut positions, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for y in 0..side {
        for x in 0..side {
            let (fx, fy) = (x as f32 / side as f32, y as f32 / side as f32);
            positions.push([fx, fy, 0.25 * (6.0 * fx).sin() * (5.0 * fy).cos()]);
            let n =
                Vec3::new(-1.5 * (6.0 * fx).cos() * (5.0 * fy).cos(), 1.25 * (6.0 * fx).sin() * (5.0 * fy).sin(), 1.0);
            let n = n.normalize();
            normals.push([n.x, n.y, n.z, 0.0]);
            if x + 1 < side && y + 1 < side {
                let at = (y * side + x) as u32;
                let below = at + side as u32;
                triangles.extend([at, at + 1, below, below, at + 1, below + 1]);
            }
        }
    }
    (positions, normals, triangles)
}

/// Document with one mesh and compressed views. Buffer 0 contains only compressed bytes; buffer 1 has no data.
struct CompressedDoc {
    doc: Doc,
    plain: usize,
}

impl CompressedDoc {
    fn new() -> Self {
        let mut doc = Doc::new();
        doc.json["extensionsRequired"] = json!(["EXT_meshopt_compression", "KHR_mesh_quantization"]);
        Self { doc, plain: 0 }
    }

    /// Adds a view of `count` elements of `stride` bytes; `bytes` is its compressed form.
    fn view(&mut self, bytes: &[u8], mode: &str, filter: &str, count: usize, stride: usize) -> usize {
        let view = self.doc.view(bytes);
        let offset = self.doc.json["bufferViews"][view]["byteOffset"].clone();
        let mut packed = json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len(), "byteStride": stride,
            "mode": mode, "count": count});
        if filter != "NONE" {
            packed["filter"] = json!(filter);
        }
        let mut whole = json!({"buffer": 1, "byteOffset": self.plain, "byteLength": count * stride,
            "extensions": {"EXT_meshopt_compression": packed}});
        if mode == "ATTRIBUTES" {
            whole["byteStride"] = json!(stride);
        }
        self.plain += count * stride;
        self.doc.json["bufferViews"][view] = whole;
        view
    }

    fn accessor(&mut self, view: usize, component: u32, kind: &str, count: usize, normalized: bool) -> usize {
        self.doc.push(
            "accessors",
            json!({"bufferView": view, "componentType": component, "type": kind, "count": count,
                "normalized": normalized}),
        )
    }

    fn glb(&self) -> Vec<u8> {
        let mut root = self.doc.json.clone();
        root["buffers"] = json!([{"byteLength": self.doc.bin.len()},
            {"byteLength": self.plain, "extensions": {"EXT_meshopt_compression": {"fallback": true}}}]);
        glb(serde_json::to_string(&root).unwrap().as_bytes(), &self.doc.bin)
    }
}

fn packed_vertices<T>(elements: &[T]) -> Vec<u8> {
    meshopt::encode_vertex_buffer_level(elements, 2, Some(0)).unwrap()
}

/// Returns the sheet with quantized positions, filtered normals and two-byte indices, all compressed.
fn packed_sheet(side: usize) -> (CompressedDoc, Vec<[u16; 4]>, Vec<u32>) {
    let (positions, normals, triangles) = sheet(side);
    let n = positions.len();
    let quantized: Vec<[u16; 4]> = positions
        .iter()
        .map(|p| {
            let [x, y, z] = p.map(|x| ((x + 1.0) / 2.0 * 65_535.0).round() as u16);
            [x, y, z, 0]
        })
        .collect();
    let filtered = meshopt::encode_filter_oct::<i8>(&normals, 8);
    let mut packed = CompressedDoc::new();
    let view = packed.view(&packed_vertices(&quantized), "ATTRIBUTES", "NONE", n, 8);
    let position = packed.accessor(view, U16, "VEC3", n, true);
    let view = packed.view(&packed_vertices(&filtered), "ATTRIBUTES", "OCTAHEDRAL", n, 4);
    let normal = packed.accessor(view, I8, "VEC3", n, true);
    let bytes = meshopt::encode_index_buffer(&triangles, n).unwrap();
    let view = packed.view(&bytes, "TRIANGLES", "NONE", triangles.len(), 2);
    let indices = packed.accessor(view, U16, "SCALAR", triangles.len(), false);
    packed.doc.show(json!({"attributes": {"POSITION": position, "NORMAL": normal}, "indices": indices}));
    (packed, quantized, triangles)
}

#[test]
fn quantized_meshopt_model_decodes_to_its_input() {
    let (packed, quantized, triangles) = packed_sheet(40);
    let model = import_bytes(&packed.glb()).unwrap();
    assert_sound(&model);
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    for (found, expected) in model.mesh.positions.iter().zip(&quantized) {
        assert_eq!(*found, Vec3::new(expected[0].into(), expected[1].into(), expected[2].into()) / 65_535.0);
    }
    // The encoder may rotate the corners of a triangle but must not flip it.
    let corners = |t: [u32; 3]| {
        let mut t = t;
        let least = (0..3).min_by_key(|k| t[*k]).unwrap();
        t.rotate_left(least);
        t
    };
    let found: Vec<_> = model.mesh.triangles.iter().map(|t| corners(*t)).collect();
    let expected: Vec<_> = triangles.as_chunks::<3>().0.iter().map(|t| corners(*t)).collect();
    assert_eq!(found, expected);
    for (found, expected) in model.mesh.normals.iter().zip(sheet(40).1) {
        // Octahedral encoding with eight bits has an error of up to 0.025 rad, about 1.5°.
        assert!(found.angle_between(Vec3::from_slice(&expected)) < 0.025, "{found} for {expected:?}");
    }
}

/// Reads a compressed view as the vertex positions of a mesh.
fn decode_positions(
    bytes: &[u8],
    filter: &str,
    count: usize,
    stride: usize,
    component: u32,
) -> Result<Model, BakeError> {
    let mut packed = CompressedDoc::new();
    let view = packed.view(bytes, "ATTRIBUTES", filter, count, stride);
    let position = packed.accessor(view, component, "VEC3", count, component != F32);
    packed.doc.show(json!({"attributes": {"POSITION": position}}));
    import_bytes(&packed.glb())
}

#[test]
fn meshopt_vertices_of_all_counts_and_spreads_decode() {
    // The counts include the sizes of meshopt's groups and blocks, and their neighbours. The spreads require deltas of
    // zero, two, four and eight bits.
    for count in [3, 15, 16, 17, 240, 255, 256, 257, 700] {
        for spread in [0_u32, 1, 5, 100, 1 << 20] {
            let mut state = 1_u32;
            let elements: Vec<[f32; 5]> = (0..count)
                .map(|_| {
                    std::array::from_fn(|_| {
                        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                        f32::from_bits(0x3f00_0000 + ((state >> 8) % (spread + 1)))
                    })
                })
                .collect();
            let model = decode_positions(&packed_vertices(&elements), "NONE", count, 20, F32).unwrap();
            let expected: Vec<Vec3> = elements.iter().map(|e| Vec3::from_slice(e)).collect();
            assert_eq!(model.mesh.positions, expected, "{count} elements, spread {spread}");
        }
    }
}

#[test]
fn meshopt_filters_decode_as_in_the_library() {
    let (positions, normals, _) = sheet(20);
    let n = positions.len();
    let exponential: Vec<[u32; 3]> = meshopt::encode_filter_exp(&positions, 15, meshopt::EncodeExpMode::Separate);
    let model = decode_positions(&packed_vertices(&exponential), "EXPONENTIAL", n, 12, F32).unwrap();
    let mut expected = exponential.clone();
    meshopt::decode_filter_exp(&mut expected);
    let expected: Vec<Vec3> = expected.iter().map(|v| Vec3::from(v.map(f32::from_bits))).collect();
    assert_eq!(model.mesh.positions, expected);

    let short = meshopt::encode_filter_oct::<i16>(&normals, 12);
    let model = decode_positions(&packed_vertices(&short), "OCTAHEDRAL", n, 8, I16).unwrap();
    for (found, expected) in model.mesh.positions.iter().zip(&normals) {
        // The tolerance is for octahedral encoding with twelve bits.
        assert!((*found - Vec3::from_slice(expected)).length() < 2e-3, "{found} for {expected:?}");
    }

    let turns: Vec<[f32; 4]> = (0..n)
        .map(|i| {
            glam::Quat::from_euler(glam::EulerRot::XYZ, i as f32 * 0.1, i as f32 * 0.37, i as f32 * 0.9).to_array()
        })
        .collect();
    let quaternions = meshopt::encode_filter_quat(&turns, 16);
    let mut expected = quaternions.clone();
    meshopt::decode_filter_quat(&mut expected);
    let model = decode_positions(&packed_vertices(&quaternions), "QUATERNION", n, 8, I16).unwrap();
    for (found, expected) in model.mesh.positions.iter().zip(&expected) {
        let expected = Vec3::new(expected[0].into(), expected[1].into(), expected[2].into()) / 32_767.0;
        // The tolerance allows for the reference decoder, which uses a 12-bit reciprocal square root if the processor
        // has one.
        assert!((*found - expected).length() < 1e-3, "{found} for {expected}");
    }
}

#[test]
fn meshopt_index_lists_decode_in_any_order() {
    let (positions, _, triangles) = sheet(30);
    let backwards: Vec<u32> = triangles.chunks(3).rev().flatten().copied().collect();
    for (mode, stride) in [("INDICES", 4), ("INDICES", 2), ("TRIANGLES", 4)] {
        for list in [&triangles, &backwards] {
            let mut packed = CompressedDoc::new();
            let n = positions.len();
            let view = packed.view(&packed_vertices(&positions), "ATTRIBUTES", "NONE", n, 12);
            let position = packed.accessor(view, F32, "VEC3", n, false);
            let bytes = match mode {
                "INDICES" => meshopt::encode_index_sequence(list, n),
                _ => meshopt::encode_index_buffer(list, n),
            };
            let view = packed.view(&bytes.unwrap(), mode, "NONE", list.len(), stride);
            let indices = packed.accessor(view, if stride == 2 { U16 } else { U32 }, "SCALAR", list.len(), false);
            packed.doc.show(json!({"attributes": {"POSITION": position}, "indices": indices}));
            let model = import_bytes(&packed.glb()).unwrap();
            // The importer splits vertices for flat normals, so corners are compared by their positions.
            let key = |p: [f32; 3]| p.map(|x| (x + 0.0).to_bits());
            let numbers: HashMap<_, u32> = positions.iter().map(|p| key(*p)).zip(0..).collect();
            let place = |v: &u32| model.mesh.positions[*v as usize].to_array();
            let mut found: Vec<u32> = model.mesh.triangles.iter().flatten().map(|v| numbers[&key(place(v))]).collect();
            if mode == "TRIANGLES" {
                // Triangles are compared as sets of corners; another test checks orientation.
                let sort = |v: &mut Vec<u32>| v.as_chunks_mut::<3>().0.iter_mut().for_each(|t| t.sort_unstable());
                let mut expected = list.clone();
                sort(&mut expected);
                sort(&mut found);
                assert_eq!(found, expected);
            } else {
                assert_eq!(&found, list, "{mode}, {stride} bytes");
            }
        }
    }
}

#[test]
fn meshopt_errors_name_the_buffer_view() {
    let (good, ..) = packed_sheet(8);
    let with = |change: fn(&mut Value)| {
        let mut packed = CompressedDoc { doc: good.doc.clone(), plain: good.plain };
        change(&mut packed.doc.json);
        fault(import_bytes(&packed.glb()))
    };
    const AT: &str = "/bufferViews/0/extensions/EXT_meshopt_compression";
    type Change = fn(&mut Value);
    let cases: [(Change, &str, &str); 9] = [
        (|j| ext(j)["mode"] = json!("POINTS"), "/mode", "expected ATTRIBUTES"),
        (|j| ext(j)["byteStride"] = json!(6), "", "elements of 6 bytes"),
        (|j| ext(j)["count"] = json!(65), "", "expected the 512 bytes"),
        (|j| ext(j)["filter"] = json!("BLUR"), "", "the filter BLUR on elements of 8 bytes"),
        (|j| ext(j)["byteLength"] = json!(40), "", "cut off"),
        (|j| ext(j)["byteOffset"] = json!(1), "", "begins with"),
        (|j| ext(j)["byteOffset"] = json!(1_u64 << 40), "", "begins at byte 1099511627776"),
        (|j| ext(j)["byteLength"] = json!(0), "", "and empty"),
        (
            |j| {
                let list = j["bufferViews"][2]["extensions"]["EXT_meshopt_compression"].clone();
                ext(j)["byteOffset"] = list["byteOffset"].clone();
            },
            "",
            "begins with 0xe1, expected 0xa0",
        ),
    ];
    for (change, place, words) in cases {
        let (found, reason) = with(change);
        assert_eq!(found, format!("{AT}{place}"), "{reason}");
        assert!(reason.contains(words), "{reason}");
    }
}

fn ext(json: &mut Value) -> &mut Value {
    &mut json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]
}

#[test]
fn small_compressed_file_cannot_expand_without_bound() {
    // The first view is decompressed. The second is rejected before decompression, because both views together would
    // exceed a gibibyte.
    let elements = vec![[0.5_f32; 64]; 64];
    let mut packed = CompressedDoc::new();
    let bytes = packed_vertices(&elements);
    for count in [64, 1 << 22] {
        let view = packed.view(&bytes, "ATTRIBUTES", "NONE", count, 256);
        let position = packed.accessor(view, F32, "VEC3", 3, false);
        packed.doc.show(json!({"attributes": {"POSITION": position}}));
    }
    let (place, reason) = fault(import_bytes(&packed.glb()));
    assert!(
        place.starts_with("/bufferViews/1/") && reason.contains("larger than 1073741824 bytes"),
        "{place}: {reason}"
    );
}

fn imports_without_panic(bytes: &[u8], folder: &Path) -> bool {
    let mut resolve = |uri: &str, _: u64| -> Result<Vec<u8>, BakeError> {
        let path = folder.join(uri);
        std::fs::read(&path).map_err(|source| BakeError::Io { path, action: "read", source })
    };
    match import("damaged", bytes, &mut resolve, &ImportOptions::default()) {
        Ok(model) => {
            assert_sound(&model);
            true
        }
        Err(BakeError::Input { .. }) => false,
        Err(other) => panic!("{other}"),
    }
}

/// Flips single bits of `glb`, from the byte `start` on. Returns the numbers of rejected and of readable files.
fn flip_bits(glb: &[u8], start: usize, step: usize, folder: &Path) -> [usize; 2] {
    let mut counts = [0; 2];
    for at in (start..glb.len()).step_by(step) {
        let mut broken = glb.to_vec();
        broken[at] ^= 1 << (at % 8);
        counts[usize::from(imports_without_panic(&broken, folder))] += 1;
    }
    counts
}

#[test]
fn damaged_meshopt_data_never_panics() {
    let (packed, ..) = packed_sheet(20);
    let glb = packed.glb();
    let start = glb.len() - packed.doc.bin.len();
    let [refused, read] = flip_bits(&glb, start, 1, Path::new("."));
    println!("{read} read, {refused} refused");
    assert!(read > 100 && refused > 100, "{read} read, {refused} refused");
    for length in 0..packed.doc.bin.len() {
        let mut cut = CompressedDoc { doc: packed.doc.clone(), plain: packed.plain };
        cut.doc.bin.truncate(length);
        assert!(!imports_without_panic(&cut.glb(), Path::new(".")), "cut to {length}");
    }
}

#[test]
fn damaged_draco_data_never_panics() {
    let Some(data) = data("damaged_draco_data_never_panics") else { return };
    let folder = data.join("meshes/compressed");
    let glb = std::fs::read(folder.join("quaternius_RedPandaAstronaut_draco.glb")).unwrap();
    let [refused, read] = flip_bits(&glb, 12, 2003, &folder);
    println!("{read} read, {refused} refused");
    assert!(read > 10 && refused > 10, "{read} read, {refused} refused");
    let folder = folder.join("BoxDraco");
    let text = std::fs::read_to_string(folder.join("BoxDraco.gltf")).unwrap();
    let bin = std::fs::read(folder.join("0.bin")).unwrap();
    let sandbox = tempfile::tempdir().unwrap();
    for at in 0..bin.len() {
        let mut broken = bin.clone();
        broken[at] ^= 0x41;
        std::fs::write(sandbox.path().join("0.bin"), &broken).unwrap();
        imports_without_panic(text.as_bytes(), sandbox.path());
        std::fs::write(sandbox.path().join("0.bin"), &bin[..at]).unwrap();
        assert!(!imports_without_panic(text.as_bytes(), sandbox.path()), "cut to {at}");
    }
}

#[test]
fn draco_and_uncompressed_models_agree() {
    let Some(data) = data("draco_and_uncompressed_models_agree") else { return };
    let folder = data.join("meshes/compressed/BoxDraco");
    let model = pelage_bake::io::read_model(
        &folder.join("BoxDraco.gltf"),
        &ImportOptions::default(),
        pelage_bake::io::Reach::OwnFolder,
    )
    .unwrap();
    assert_sound(&model);
    // The model is a box of edge 1 around the origin, with normals along the axes.
    assert_eq!((model.mesh.positions.len(), model.mesh.triangles.len()), (24, 12));
    for (position, normal) in model.mesh.positions.iter().zip(&model.mesh.normals) {
        assert!((position.abs() - Vec3::splat(0.5)).abs().max_element() < 1e-3, "{position}");
        assert!((position.dot(*normal) - 0.5).abs() < 1e-2, "{position}: {normal}");
    }
}
