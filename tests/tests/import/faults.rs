//! Tests of broken models: each fault gives an error with its location, the value found and the value expected.
#![allow(clippy::unwrap_used, reason = "tests")]

use crate::import::support::*;
use pelage_import::BakeError;
use pelage_import::mesh::{Material, Model};
use serde_json::{Value, json};

/// Returns an indexed triangle with normals and texture coordinates.
fn valid_doc() -> Doc {
    let mut doc = Doc::new();
    let position = doc.triangle();
    let normal = doc.floats(&[0., 0., 1., 0., 0., 1., 0., 0., 1.], "VEC3");
    let uv = doc.floats(&[0.; 6], "VEC2");
    let indices = doc.accessor(&[0_u16, 1, 2][..].bytes(), U16, "SCALAR", 3);
    let attributes = json!({"POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv});
    doc.show(json!({"attributes": attributes, "indices": indices}));
    doc.model();
    doc
}

fn replace(doc: &mut Doc, pointer: &str, value: Value) {
    match doc.json.pointer_mut(pointer) {
        Some(slot) => *slot = value,
        None => {
            let (parent, key) = pointer.rsplit_once('/').unwrap();
            doc.json.pointer_mut(parent).unwrap()[key] = value;
        }
    }
}

/// Replaces the value at `pointer` in a valid document, and asserts the location and reason of the error.
#[track_caller]
fn expect(pointer: &str, value: Value, place: &str, reason: &str) {
    let mut doc = valid_doc();
    replace(&mut doc, pointer, value);
    assert_eq!(doc.fault(), (place.to_owned(), reason.to_owned()));
}

/// Replaces the value at `pointer` in a valid document, and asserts that the model is read with a warning.
#[track_caller]
fn expect_warning(pointer: &str, value: Value, text: &str) -> Model {
    let mut doc = valid_doc();
    replace(&mut doc, pointer, value);
    let model = doc.model();
    assert_warns(&model, text);
    model
}

#[test]
fn invalid_references_and_types_are_reported_at_their_field() {
    expect("/nodes/0/mesh", json!(7), "/nodes/0/mesh", "is 7, expected less than 1, the number of meshes");
    expect("/nodes/0/mesh", json!(-2), "/nodes/0/mesh", "is -2, expected a whole number >= 0");
    let empty = "the scene has no triangles, expected at least one; the file has nodes: 1, meshes: 1";
    expect("/nodes/0/mesh", json!(-1), "/", empty);
    expect(
        "/nodes/0/mesh",
        json!(4294967296_u64),
        "/nodes/0/mesh",
        "is 4294967296, expected less than 1, the number of meshes",
    );
    expect("/nodes/0/mesh", json!("a"), "/nodes/0/mesh", "is \"a\", expected a whole number >= 0");
    expect("/nodes", json!({}), "/nodes", "is an object, expected an array");
    expect("/nodes/0/children", json!([0]), "/nodes/0", "is its own ancestor; expected a tree");
    let primitive = "/meshes/0/primitives/0";
    expect(
        &format!("{primitive}/mode"),
        json!(7),
        "/meshes/0/primitives/0/mode",
        "is 7, expected 0..=6 (4 is triangles)",
    );
    let at = format!("{primitive}/attributes/POSITION");
    expect(&at, json!(2), &at, "accessor 2 has elements of 2 x f32, expected 3 x f32 or i8 or u8 or i16 or u16");
    let at = format!("{primitive}/indices");
    expect(&at, json!(0), &at, "accessor 0 has elements of 3 x f32, expected 1 x u8 or u16 or u32");
    expect("/meshes/0/primitives", json!(null), "/meshes/0", "has no `primitives`, which glTF 2.0 requires here");
    expect(
        "/accessors/0/componentType",
        json!(5124),
        "/accessors/0/componentType",
        "is 5124, expected 5120 (i8), 5121 (u8), 5122 (i16), 5123 (u16), 5125 (u32) or 5126 (f32)",
    );
    expect(
        "/accessors/0/type",
        json!("VEC5"),
        "/accessors/0/type",
        "is \"VEC5\", expected SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4",
    );
}

/// Checks that faults in a part that is not needed leave the part out.
#[test]
fn faulty_parts_that_a_picture_can_do_without_are_left_out() {
    expect_warning("/scene", json!(0), "/scene: is 0, expected less than 0, the number of scenes; the first scene");
    let unscaled = |model: Model| assert_near(model.mesh.positions[1], [1.0, 0.0, 0.0]);
    let scale = |value, text| unscaled(expect_warning("/nodes/0/scale", value, text));
    scale(json!([1, 1]), "/nodes/0/scale: has 2 numbers, expected 3; left out");
    scale(json!([1, 1, "x"]), "/nodes/0/scale/2: is \"x\", expected a number; left out");
    scale(json!([1, 1e39, 1]), "/nodes/0/scale/1: is 1e+39, expected a number within the range of 32-bit floats");
    expect_warning("/nodes/0/rotation", json!({}), "/nodes/0/rotation: is an object, expected an array; left out");
    let matrix = json!([2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 1]);
    let text = "/nodes/0/matrix has the last row [0, 0, 1, 1], expected [0, 0, 0, 1]";
    assert_near(expect_warning("/nodes/0/matrix", matrix, text).mesh.positions[1], [2.0, 0.0, 0.0]);
    unscaled(expect_warning("/nodes/0/matrix", json!([2]), "/nodes/0/matrix: has 1 numbers, expected 16"));

    let primitive = "/meshes/0/primitives/0";
    for (value, text) in [
        (json!(0), "material: is 0, expected less than 0, the number of materials; the default material is used"),
        (json!(-1), "1 indices are -1, such as /meshes/0/primitives/0/material; treated as absent"),
        (json!("a"), "material: is \"a\", expected a whole number >= 0; the default material is used"),
    ] {
        let model = expect_warning(&format!("{primitive}/material"), value, text);
        assert_eq!(model.materials, [Material::default()]);
    }
    // Attributes other than the position: normals are computed, texture coordinates and colours left out.
    let model = expect_warning("/accessors/1/count", json!(2), "NORMAL: has 2 elements, expected 3, one per POSITION");
    assert_eq!(model.mesh.normals, [glam::Vec3::Z; 3]);
    let huge = "TEXCOORD_0: has 4294967295 elements, expected 3, one per POSITION";
    assert!(!expect_warning("/accessors/2/count", json!(4294967295_u64), huge).mesh.parts[0].has_uvs);
    let color = format!("{primitive}/attributes/COLOR_0");
    let model = expect_warning(&color, json!(9), "is 9, expected less than 4, the number of accessors");
    assert_eq!(model.mesh.colors, [[255; 4]; 3]);
    let targets = format!("{primitive}/targets");
    expect_warning(&targets, json!([{"POSITION": 9}]), "the number of accessors; left out of the morph target");
    expect_warning("/meshes/0/weights", json!("a"), "is \"a\", expected an array; all weights are 0");
}

/// Checks that faults in parts that are never read do not matter.
#[test]
fn cameras_lights_extras_and_unused_parts_are_never_read() {
    for broken in [json!(null), json!(-1), json!("x"), json!({}), json!([{"type": 7}, 7])] {
        let mut doc = valid_doc();
        let root = doc.json.as_object_mut().unwrap();
        for list in ["cameras", "samplers", "materials", "textures", "images", "skins", "animations", "extras"] {
            root.insert(list.into(), broken.clone());
        }
        root.insert("extensions".into(), json!({"KHR_lights_punctual": broken, "KHR_xmp": broken}));
        for of in ["/nodes/0", "/meshes/0", "/meshes/0/primitives/0"] {
            let object = doc.json.pointer_mut(of).unwrap();
            (object["extras"], object["extensions"]) = (broken.clone(), json!({"KHR_lights_punctual": broken}));
        }
        (doc.json["nodes"][0]["camera"], doc.json["meshes"][0]["extras"]) =
            (broken.clone(), json!({"targetNames": broken}));
        assert!(doc.model().animation.is_none());
    }
}

#[test]
fn accessor_ranges_are_checked_against_the_buffer() {
    let cut = "4 elements of 12 bytes, 12 bytes apart from byte 0 on, need 48 bytes of the bufferView, which has 36";
    expect("/accessors/0/count", json!(4), "/accessors/0", cut);

    expect(
        "/accessors/0/count",
        json!(4294967295_u64),
        "/meshes/0/primitives/0",
        "takes the model to 4294967295 vertices and 3 indices, expected at most 16777216 and 100663296",
    );
    let offset = "3 elements of 12 bytes, 12 bytes apart from byte 4 on, need 40 bytes of the bufferView, which has 36";
    expect("/accessors/0/byteOffset", json!(4), "/accessors/0", offset);
    expect(
        "/bufferViews/0/byteStride",
        json!(8),
        "/accessors/0",
        "its bufferView has byteStride 8, expected at least 12, the size of an element",
    );
    expect(
        "/bufferViews/0/byteOffset",
        json!(10_000),
        "/bufferViews/0",
        "begins at byte 10000 of buffer 0, which has 104 bytes",
    );
    expect(
        "/bufferViews/0/buffer",
        json!(1),
        "/bufferViews/0/buffer",
        "is 1, expected less than 1, the number of buffers",
    );
    // The number of a clip's keys is not compared with the count of an earlier accessor. Another check must detect a
    // huge number of keys.
    let mut doc = valid_doc();
    let keys = doc.floats(&[0.], "SCALAR");
    let sampler = json!({"input": keys, "output": 0});
    let channel = json!({"sampler": 0, "target": {"node": 0, "path": "translation"}});
    doc.push("animations", json!({"samplers": [sampler], "channels": [channel]}));
    let place = format!("/accessors/{keys}");
    doc.json["accessors"][keys]["count"] = json!(u64::MAX);
    let over = "18446744073709551615 elements of 4 bytes, 4 bytes apart from byte 0 on, \
                need more than 2^64 bytes of the bufferView, which has 4";
    assert_warns(&doc.model(), &format!("{place}: {over}; left out of clip \"clip_0\""));
    doc.json["accessors"][keys]["count"] = json!(1_u64 << 40);
    doc.json["accessors"][keys].as_object_mut().unwrap().remove("bufferView");
    let zeros = "is 1099511627776, expected at most 50331648 for an accessor without data";
    assert_warns(&doc.model(), &format!("{place}/count: {zeros}; left out of clip \"clip_0\""));
}

/// Checks that small files are rejected if their expanded data would exceed the limits of a package. No memory must be
/// allocated for the data.
#[test]
fn shared_accessors_cannot_expand_without_bound() {
    let million = json!({"componentType": F32, "type": "VEC3", "count": 1_000_000});
    let mut doc = Doc::new();
    let position = doc.push("accessors", million);
    let primitives: Vec<Value> = vec![json!({"attributes": {"POSITION": position}}); 17];
    doc.push("meshes", json!({"primitives": primitives}));
    doc.push("nodes", json!({"mesh": 0}));
    let (place, reason) = doc.fault();
    assert_eq!(place, "/meshes/0/primitives/5");
    let expected =
        "takes the model to 6000000 vertices and 0 indices that need 916 MiB of memory, expected at most 768 MiB;";
    assert!(reason.starts_with(expected), "{reason}");

    let mut doc = Doc::new();
    let position = doc.push("accessors", json!({"componentType": F32, "type": "VEC3", "count": 900_000}));
    doc.show(json!({"attributes": {"POSITION": position}}));
    for _ in 0..19 {
        doc.push("nodes", json!({"mesh": 0}));
    }
    assert!(doc.fault().1.starts_with("takes the model to 7200000 vertices and 7200000 indices that need"));

    let mut doc = valid_doc();
    let times: Vec<f32> = (0..400_000).map(|i| i as f32).collect();
    let input = doc.floats(&times, "SCALAR");
    let output = doc.push("accessors", json!({"componentType": F32, "type": "VEC3", "count": 400_000}));
    let sampler = json!({"input": input, "output": output});
    for _ in 0..50 {
        let channel = json!({"sampler": 0, "target": {"node": 0, "path": "scale"}});
        doc.push("animations", json!({"samplers": [sampler.clone()], "channels": [channel]}));
    }
    let (place, reason) = doc.fault();
    assert_eq!(
        (place.as_str(), reason.as_str()),
        ("/animations/41/channels/0", "makes the animation larger than 256 MiB")
    );
}

#[test]
fn unused_view_past_its_buffer_is_only_a_warning() {
    let mut doc = valid_doc();
    let last = doc.json["bufferViews"].as_array().unwrap().len() - 1;
    doc.json["bufferViews"][last]["byteLength"] = json!(1_000_000);
    assert_warns(&doc.model(), "extends to byte");
}

#[test]
fn invalid_indices_and_positions_name_the_element() {
    let mut doc = valid_doc();
    let at = doc.json["bufferViews"][3]["byteOffset"].as_u64().unwrap() as usize;
    doc.bin[at + 2] = 3;
    let (place, reason) = doc.fault();
    assert_eq!(place, "/meshes/0/primitives/0/indices");
    assert_eq!(reason, "element 1 is 3, expected less than the 3 vertices");
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut doc = valid_doc();
        doc.bin[16..20].copy_from_slice(&bad.to_le_bytes());
        let (place, reason) = doc.fault();
        assert_eq!(place, "/meshes/0/primitives/0/attributes/POSITION");
        assert!(reason.starts_with("element 1 is [") && reason.ends_with("expected finite numbers"), "{reason}");
    }
    let mut doc = valid_doc();
    doc.json["nodes"][0]["scale"] = json!([1e38, 1e38, 1e38]);
    doc.push("nodes", json!({"children": [0], "scale": [1e38, 1, 1]}));
    assert!(doc.fault().1.contains("once its nodes are applied"));
}

#[test]
fn sparse_accessors_are_checked() {
    let sparse = |edit: &dyn Fn(&mut Value)| {
        let mut doc = valid_doc();
        let (indices, values) = (doc.view(&[0_u8, 3]), doc.view(&[0.0_f32; 6][..].bytes()));
        let mut sparse = json!({
            "count": 2,
            "indices": {"bufferView": indices, "componentType": U8},
            "values": {"bufferView": values},
        });
        edit(&mut sparse);
        doc.json["accessors"][0]["sparse"] = sparse;
        doc.fault()
    };
    let (place, reason) = sparse(&|_| {});
    assert_eq!(place, "/accessors/0/sparse/indices");
    assert_eq!(reason, "element 1 is 3, expected less than 3, the accessor's count");
    let (place, _) = sparse(&|s| s["count"] = json!(1_u64 << 60));
    assert_eq!(place, "/accessors/0/sparse/indices");
    let (place, _) = sparse(&|s| s["indices"]["componentType"] = json!(F32));
    assert_eq!(place, "/accessors/0/sparse/indices/componentType");
    let (place, _) = sparse(&|s| s["values"] = json!({"bufferView": 99}));
    assert_eq!(place, "/accessors/0/sparse/values/bufferView");
}

#[test]
fn unsupported_extensions_are_named_with_a_workaround() {
    let mut doc = valid_doc();
    doc.json["extensionsRequired"] = json!([
        "KHR_mesh_quantization",
        "KHR_draco_mesh_compression",
        "KHR_materials_sheen",
        "EXT_meshopt_compression",
        "KHR_meshopt_compression",
        "KHR_texture_basisu",
        "EXT_texture_webp",
        "KHR_node_visibility",
        "ACME_fur"
    ]);
    let (place, reason) = doc.fault();
    assert_eq!(place, "/extensionsRequired/4");
    for text in [
        "KHR_meshopt_compression: decode it with `gltf-transform cp in.glb out.glb`, or run gltfpack without -c",
        "ACME_fur: export the model without it",
    ] {
        assert!(reason.contains(text), "no `{text}` in: {reason}");
    }
    for readable in ["sheen", "quantization", "draco", "EXT_meshopt", "texture", "node"] {
        assert!(!reason.contains(readable), "{reason}");
    }
}

#[test]
fn syntax_errors_give_the_byte_offset() {
    let at = |bytes: &[u8]| fault(import_bytes(bytes)).0;
    assert_eq!(at(b""), "byte 0");
    assert_eq!(at(b" \n "), "byte 0");
    assert_eq!(at(b"{\"asset\": x}"), "byte 10");
    assert_eq!(at(b"{\n\"asset\":\n tru }"), "byte 15", "in the third line");
    assert_eq!(at(b"{\"asset\": 1"), "byte 11", "the end");
    assert_eq!(at(&glb(b"{ \"a\": ?}  ", b"")), "byte 27", "counted from the start of the file");
    assert_eq!(at(&[b'{', b'"', 0xff, b'"', b'}']), "byte 2");
    let deep = "[".repeat(100_000);
    assert!(at(format!("{{\"asset\": {deep}").as_bytes()).starts_with("byte "));
    assert_eq!(fault(import_bytes(b"{}")), ("/".into(), "has no `asset`, which glTF 2.0 requires here".into()));
    let version = fault(import_bytes(br#"{"asset": {"version": "1.0"}}"#));
    assert!(version.0 == "/asset/version" && version.1.contains("gltf-pipeline"), "{version:?}");
    let guess = fault(import_bytes(b"Kaydara FBX Binary  \0")).1;
    assert!(guess.contains("FBX") && guess.contains("Blender"), "{guess}");
    let other = fault(import_bytes(b"solid cube\n")).1;
    assert!(other.contains("neither") && other.contains("OBJ"), "{other}");
}

#[test]
fn glb_chunks_are_checked() {
    let good = valid_doc().glb();
    let with = |at: usize, bytes: &[u8]| {
        let mut broken = good.clone();
        broken[at..at + bytes.len()].copy_from_slice(bytes);
        fault(import_bytes(&broken))
    };
    assert_eq!(with(4, &[3]), ("byte 4".into(), "GLB version is 3, expected 2".into()));
    assert_eq!(with(8, &[0xff; 4]).0, "byte 8");
    assert_eq!(with(8, &[0; 4]).0, "byte 8");
    assert_eq!(with(12, &[0xff; 4]).0, "byte 12", "a length field of 4 GiB");
    assert_eq!(with(16, b"JUNK"), ("byte 16".into(), "the first chunk is JUNK, expected JSON".into()));
    let extra = [good.clone(), vec![7; 5]].concat();
    assert_warns(&import_bytes(&extra).unwrap(), "5 bytes after the end");
    for length in 0..good.len() {
        let (place, _) = fault(import_bytes(&good[..length]));
        assert!(place.starts_with("byte "), "cut to {length}: {place}");
    }
}

#[test]
fn buffers_that_are_missing_or_short_are_named() {
    let mut doc = valid_doc();
    let text = |doc: &Doc, buffer: Value| {
        let mut root = doc.json.clone();
        root["buffers"] = json!([buffer]);
        fault(import_bytes(&serde_json::to_vec(&root).unwrap()))
    };
    let (place, reason) = text(&doc, json!({"byteLength": 104, "uri": "lost.bin"}));
    assert_eq!(place, "/buffers/0/uri");
    assert_eq!(reason, "names the buffer file \"lost.bin\": no such file in this test");
    let (place, reason) = text(&doc, json!({"byteLength": 104}));
    assert!(place == "/buffers/0" && reason.contains("has no `uri`, and the file has no BIN chunk"), "{reason}");
    let (place, reason) = text(&doc, json!({"byteLength": 104, "uri": "data:;base64,AAAA"}));
    assert_eq!(place, "/buffers/0/uri");
    assert_eq!(reason, "buffer 0 holds 3 bytes, but byteLength says 104: it is cut off");
    assert!(text(&doc, json!({"byteLength": 104, "uri": "data:;base64,A!"})).1.contains("invalid base64"));
    assert!(text(&doc, json!({"byteLength": 104, "uri": "data:AAAA"})).1.contains("without a comma"));
    // The data of the triangle is percent-encoded.
    doc.bin.clear();
    let encoded: String = valid_doc().bin.iter().map(|b| format!("%{b:02X}")).collect();
    let mut root = doc.json.clone();
    root["buffers"] =
        json!([{"byteLength": valid_doc().bin.len(), "uri": format!("data:application/octet-stream,{encoded}")}]);
    assert_sound(&import_bytes(&serde_json::to_vec(&root).unwrap()).unwrap());
}

#[test]
fn unreadable_images_are_named_and_left_out() {
    let with = |image: &[u8]| {
        let mut doc = valid_doc();
        let view = doc.view(image);
        let factor = [0.5, 0.25, 0.125, 1.0];
        doc.push("images", json!({"name": "coat", "bufferView": view}));
        doc.push("textures", json!({"source": 0}));
        doc.push(
            "materials",
            json!({"pbrMetallicRoughness":
            {"baseColorTexture": {"index": 0}, "baseColorFactor": factor}}),
        );
        doc.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        doc
    };
    let lost = |doc: &Doc, text: &str| {
        let model = doc.model();
        assert_warns(&model, &format!("{text}; the colour factor alone is used"));
        assert_eq!((model.materials[0].base_color, model.images.len()), ([0.5, 0.25, 0.125, 1.0], 0));
        assert!(model.mesh.parts[0].has_uvs, "texture coordinates do not depend on the image");
    };
    let encode = |width: u32, height: u32| {
        let mut out = std::io::Cursor::new(Vec::new());
        image::GrayImage::new(width, height).write_to(&mut out, image::ImageFormat::Png).unwrap();
        out.into_inner()
    };
    assert_eq!(with(&encode(3, 2)).model().images.len(), 1);
    let ktx = with(b"\xabKTX 20\xbb\r\n\x1a\n");
    lost(&ktx, "/images/0/bufferView: image 0 \"coat\" is KTX, expected PNG, JPEG or WebP");
    let wide = "/images/0/bufferView: image 0 \"coat\" is 16385 x 1 texels, expected 1..=16384 per side";
    lost(&with(&encode(16_385, 1)), wide);
    let mut cut = encode(64, 64);
    cut.truncate(60);
    assert_warns(&with(&cut).model(), "/images/0/bufferView: image 0 \"coat\" cannot be decoded");
    let with_texture = |texture: Value| {
        let mut doc = with(&encode(1, 1));
        doc.json["textures"][0] = texture;
        doc
    };
    let no_source = "has no `source`, expected the index of an image";
    for (texture, text) in [
        (json!({}), format!("/textures/0: {no_source}")),
        (json!(null), format!("/textures/0: {no_source}")),
        (json!({"source": 7}), "/textures/0/source: is 7, expected less than 1, the number of images".to_owned()),
        (
            json!({"extensions": {"KHR_texture_basisu": {"source": 0}}}),
            "/textures/0: has an image only through KHR_texture_basisu, which cannot be read; supply the textures as \
             PNG or JPEG: `gltf-transform ktxdecompress in.glb out.glb`"
                .to_owned(),
        ),
        (
            json!({"extensions": {"ACME_texture_\u{1b}": {"source": 0}}}),
            "only through ACME_texture_\u{fffd}, which cannot be read; export the model without it".to_owned(),
        ),
    ] {
        lost(&with_texture(texture), &text);
    }
    let mut doc = with(&encode(1, 1));
    doc.json["images"][0] = json!({"mimeType": "image/png"});
    lost(&doc, "/images/0: has neither `bufferView` nor `uri`");
    doc.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = json!(5);
    lost(&doc, "baseColorTexture/index: is 5, expected less than 1, the number of textures");
    // An unknown extension beside a readable image is not mentioned.
    let model = with_texture(json!({"source": 0, "extensions": {"ACME_texture": {"source": 9}}})).model();
    assert!(model.images.len() == 1 && model.warnings.is_empty(), "{:?}", model.warnings);
}

/// Checks that images that cannot be decoded count towards the limit on texels: a file must not be able to make pelage
/// decode one large damaged image again and again.
#[test]
fn damaged_images_count_towards_the_limit() {
    let mut doc = valid_doc();
    let mut png = std::io::Cursor::new(Vec::new());
    image::GrayImage::new(1, 1).write_to(&mut png, image::ImageFormat::Png).unwrap();
    // The header claims 16384 x 16384 texels, the whole limit; the data end after the first.
    let mut png = png.into_inner();
    png[16..24].copy_from_slice(&[0, 0, 64, 0, 0, 0, 64, 0]);
    let mut crc = crc32(&png[12..29]).to_be_bytes().to_vec();
    png.splice(29..33, crc.drain(..));
    let view = doc.view(&png);
    for i in 0..3 {
        doc.push("images", json!({"name": format!("copy {i}"), "bufferView": view}));
        doc.push("textures", json!({"source": i}));
        doc.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}}));
        let body = json!({"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "material": i});
        doc.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(body);
    }
    let model = doc.model();
    assert_warns(&model, "image 0 \"copy 0\" cannot be decoded");
    for i in 1..3 {
        assert_warns(&model, &format!("/images/{i}: image {i} \"copy {i}\" is not opened"));
    }
}

/// CRC of a PNG chunk.
fn crc32(bytes: &[u8]) -> u32 {
    let bit = |crc: u32, _| if crc & 1 == 1 { 0xedb8_8320 ^ (crc >> 1) } else { crc >> 1 };
    !bytes.iter().fold(u32::MAX, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), bit))
}

#[test]
fn long_names_are_shortened_and_escaped_in_messages() {
    let mut doc = valid_doc();
    let long = "x".repeat(10_000);
    doc.json["extensionsRequired"] = json!([format!("{long}\u{1b}[31m")]);
    let text = doc.import().unwrap_err().to_string();
    assert!(text.len() < 400 && !text.contains('\u{1b}'), "{} bytes", text.len());
    assert!(matches!(doc.import(), Err(BakeError::Input { .. })));
}
