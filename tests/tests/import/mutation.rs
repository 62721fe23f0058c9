//! Tests of damaged models: truncated, with flipped bits, with replaced fields. The importer must return a valid model
//! or an error with a location, and never panic. The seed is fixed, so failures are reproducible.
#![allow(clippy::unwrap_used, reason = "tests")]

use crate::import::support::*;
use pelage_bake::stages::import::{ImportOptions, import};
use pelage_import::BakeError;
use serde_json::{Value, json};
use std::panic::catch_unwind;
use std::path::Path;

/// Random number generator xorshift64* (Marsaglia 2003, Vigna 2016).
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % n
    }
}

/// Returns a small document with all features: joints of two glTF skins, a clip of each kind, a sparse and a quantised
/// accessor, and an image.
fn full_doc() -> Doc {
    let mut doc = Doc::new();
    let position = doc.floats(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.], "VEC3");
    let (sparse_at, sparse) = (doc.view(&[1_u8]), doc.view(&[1.0_f32, 0., 0.5][..].bytes()));
    doc.json["accessors"][position]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": sparse_at, "componentType": U8}, "values": {"bufferView": sparse}});
    let uv = doc.accessor(&[0_u16, 0, 65_535, 0, 65_535, 65_535, 0, 65_535][..].bytes(), U16, "VEC2", 4);
    doc.json["accessors"][uv]["normalized"] = json!(true);
    let color = doc.accessor(&[255_u8; 16], U8, "VEC4", 4);
    let joints = doc.accessor(&[0_u8, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1], U8, "VEC4", 4);
    let weights = doc.floats(&[0.5, 0.5, 0., 0., 1., 0., 0., 0., 0., 0., 0., 0., 0.25, 0.25, 0.25, 0.25], "VEC4");
    let indices = doc.accessor(&[0_u16, 1, 2, 0, 2, 3][..].bytes(), U16, "SCALAR", 6);
    let delta = doc.floats(&[0., 0., 0.1, 0., 0., 0.1, 0., 0., 0.1, 0., 0., 0.1], "VEC3");
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(4, 4).write_to(&mut png, image::ImageFormat::Png).unwrap();
    let image = doc.view(&png.into_inner());
    doc.push("images", json!({"bufferView": image}));
    doc.push("textures", json!({"source": 0}));
    let transform =
        json!({"KHR_texture_transform": {"offset": [0.5, 0], "rotation": 1, "scale": [2, 2], "texCoord": 0}});
    doc.push(
        "materials",
        json!({"alphaMode": "MASK", "pbrMetallicRoughness":
        {"baseColorFactor": [1, 0.5, 0.25, 1], "baseColorTexture": {"index": 0, "extensions": transform}}}),
    );
    let body = json!({"attributes": {"POSITION": position, "TEXCOORD_0": uv, "COLOR_0": color, "JOINTS_0": joints,
        "WEIGHTS_0": weights}, "indices": indices, "material": 0, "mode": 4, "targets": [{"POSITION": delta}]});
    let tail = json!({"attributes": {"POSITION": position}, "mode": 5});
    doc.push("meshes", json!({"primitives": [body, tail], "weights": [0.5]}));
    doc.push("meshes", json!({"primitives": [{"attributes": {"POSITION": position}, "mode": 6}]}));
    doc.push("nodes", json!({"children": [1, 3], "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}));
    doc.push("nodes", json!({"translation": [0, 1, 0], "rotation": [0, 0, 0, 1], "scale": [1, -1, 1]}));
    doc.push("nodes", json!({"mesh": 0, "skin": 0}));
    doc.push("nodes", json!({"mesh": 1}));
    let bind: Vec<f32> = [glam::Mat4::IDENTITY.to_cols_array(); 2].concat();
    let bind = doc.floats(&bind, "MAT4");
    doc.push("skins", json!({"joints": [0, 1], "inverseBindMatrices": bind}));
    doc.json["scenes"] = json!([{"nodes": [0, 2]}]);
    doc.json["scene"] = json!(0);
    let times = doc.floats(&[0., 1.], "SCALAR");
    let moves = doc.floats(&[0., 0., 0., 1., 1., 1.], "VEC3");
    let turns = doc.floats(&[[0., 0., 0., 0., 0., 0., 0., 1., 0., 0., 0., 0.]; 2].concat(), "VEC4");
    doc.push(
        "animations",
        json!({"name": "walk", "samplers": [{"input": times, "output": moves},
        {"input": times, "output": turns, "interpolation": "CUBICSPLINE"}],
        "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}},
        {"sampler": 1, "target": {"node": 0, "path": "rotation"}}]}),
    );
    doc
}

/// Imports damaged bytes, and returns whether they were accepted. Panics only if the importer panics or returns an
/// invalid model.
fn imports_without_panic(what: &str, bytes: &[u8], folder: &Path) -> bool {
    let folder = folder.to_owned();
    let outcome = catch_unwind(|| {
        let mut resolve = |uri: &str, _: u64| -> Result<Vec<u8>, BakeError> {
            let path = folder.join(uri.replace(['/', '\\', '\0'], "_"));
            std::fs::read(&path).map_err(|source| BakeError::Io { path, action: "read", source })
        };
        match import("damaged", bytes, &mut resolve, &ImportOptions::default()) {
            Ok(model) => {
                assert_sound(&model);
                true
            }
            Err(BakeError::Input { place, reason, .. }) => {
                let known = ["byte ", "/", "line ", "whole file"];
                assert!(known.iter().any(|p| place.starts_with(p)), "place `{place}`");
                assert!(!reason.is_empty() && reason.len() < 2000, "reason `{reason}`");
                false
            }
            Err(other) => panic!("expected an input error, found {other:?}"),
        }
    });
    outcome.unwrap_or_else(|_| panic!("{what}: panicked, or gave an invalid model"))
}

/// Checks that the check for valid models can fail.
#[test]
fn invalid_models_are_detected() {
    let good = full_doc().model();
    let spoil: [fn(&mut pelage_import::mesh::Model); 6] = [
        |m| m.mesh.triangles[0][0] = 99,
        |m| m.mesh.positions[0].x = f32::NAN,
        |m| m.mesh.normals[0] *= 2.0,
        |m| m.mesh.skin[0].weights[0] = 0.1,
        |m| m.mesh.parts[0].material = 9,
        |m| m.animation.as_mut().unwrap().clips[0].channels[0].times[0] = 7.0,
    ];
    for (i, spoil) in spoil.into_iter().enumerate() {
        let mut model = good.clone();
        spoil(&mut model);
        assert!(catch_unwind(|| assert_sound(&model)).is_err(), "fault {i} was not detected");
    }
}

/// Collects the JSON pointers of all values in a tree.
fn pointers(value: &Value, here: String, out: &mut Vec<String>) {
    match value {
        Value::Array(list) => list.iter().enumerate().for_each(|(i, v)| pointers(v, format!("{here}/{i}"), out)),
        Value::Object(map) => map.iter().for_each(|(k, v)| pointers(v, format!("{here}/{k}"), out)),
        _ => {}
    }
    out.push(here);
}

fn odd_values() -> Vec<Value> {
    let list = concat!(
        r#"[null, true, -1, 0, 1, 2, 3, 4, 5, 7, 255, 1e39, -1e39, 1e-45, 0.5, 65536, "#,
        r#"16777216, 4294967295, 4294967296,
        9007199254740993, 18446744073709551615, 1e300, "", "x", "CUBICSPLINE", "STEP", "weights", "#,
        r#""VEC4", "MAT4", "SCALAR",
        "data:,", "data:;base64,AAAA", "../x", [], [0], [0, 0, 0], [1e38, 1e38, 1e38], [0, 0, 0, 0], {}, {"a": 1}, "#,
        r#"5120, 5121,
        5123, 5125, 5126]"#
    );
    serde_json::from_str::<Vec<Value>>(list).unwrap()
}

#[test]
fn arbitrary_field_values_never_panic() {
    let doc = full_doc();
    assert_sound(&doc.import().unwrap());
    let mut all = Vec::new();
    pointers(&doc.json, String::new(), &mut all);
    let here = Path::new(".");
    let (mut tried, mut refused) = (0, 0);
    for pointer in &all {
        for value in odd_values() {
            let mut broken = doc.clone();
            *broken.json.pointer_mut(pointer).unwrap() = value.clone();
            if broken.json.is_object() {
                tried += 1;
                refused += usize::from(!imports_without_panic(&format!("{pointer} = {value}"), &broken.glb(), here));
            }
        }
        if let Some((parent, key)) = pointer.rsplit_once('/') {
            let mut broken = doc.clone();
            match broken.json.pointer_mut(parent).unwrap() {
                Value::Object(map) => drop(map.remove(key)),
                Value::Array(list) => drop(list.remove(key.parse().unwrap())),
                _ => {}
            }
            tried += 1;
            refused += usize::from(!imports_without_panic(&format!("without {pointer}"), &broken.glb(), here));
        }
    }
    println!("{tried} changed fields, {refused} refused");
    // Accepted and rejected models must both be frequent, or else the test covers only one of these outcomes.
    assert!(tried > 5000 && refused > 1000 && tried - refused > 1000, "{tried} tried, {refused} refused");
}

#[test]
fn arbitrary_pairs_of_field_values_never_panic() {
    let doc = full_doc();
    let mut all = Vec::new();
    pointers(&doc.json, String::new(), &mut all);
    let values = odd_values();
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for round in 0..3000 {
        let mut broken = doc.clone();
        for _ in 0..2 + random.below(4) {
            if let Some(slot) = broken.json.pointer_mut(&all[random.below(all.len() - 1)]) {
                *slot = values[random.below(values.len())].clone();
            }
        }
        imports_without_panic(&format!("round {round}"), &broken.glb(), Path::new("."));
    }
}

fn flip_and_cut(name: &str, good: &[u8], folder: &Path, rounds: usize) {
    let mut random = Random(0x0123_4567_89ab_cdef);
    for round in 0..rounds {
        let mut broken = good.to_vec();
        for _ in 0..=random.below(3) {
            let at = random.below(broken.len());
            broken[at] ^= 1 << random.below(8);
        }
        imports_without_panic(&format!("{name}, flips of round {round}"), &broken, folder);
        let length = random.below(good.len());
        assert!(
            !imports_without_panic(&format!("{name}, cut to {length}"), &good[..length], folder),
            "{name} cut to {length} was read"
        );
    }
}

#[test]
fn flipped_bits_and_truncations_of_built_models_never_panic() {
    flip_and_cut("rich.glb", &full_doc().glb(), Path::new("."), 3000);
    flip_and_cut("rich.gltf", &full_doc().gltf(), Path::new("."), 1500);
}

#[test]
fn flipped_bits_and_truncations_of_files_never_panic() {
    let Some(data) = data("flipped_bits_and_truncations_of_files_never_panic") else { return };
    for name in [
        "skinned/SimpleSkin.gltf",
        "hard-gltf/assimp_BoxBadNormals-glTF-Binary/BoxBadNormals.glb",
        "hard-gltf/draco_SimpleSparseAccessor/SimpleSparseAccessor.gltf",
        "hard-gltf/trimesh_nested.glb",
        "hard-gltf/assimp_wrongTypes/badNumber.gltf",
        "morph/AnimatedMorphCube/AnimatedMorphCube.gltf",
    ] {
        let path = data.join("meshes").join(name);
        // White space after the last brace may be removed, so it is not counted.
        let bytes = std::fs::read(&path).unwrap();
        let good = if name.ends_with("gltf") { bytes.trim_ascii_end() } else { &bytes };
        flip_and_cut(name, good, path.parent().unwrap(), 300);
    }
}

/// Returns an OBJ file with every statement and every notation of a face corner, a concave polygon, and materials with
/// an image.
fn rich_obj() -> String {
    "# rich\nmtllib a.mtl\no box\nv 0 0 0\nv 1 0 0 1 0.5 0\nv 1 1 0\nv 0 1 0 1\nv 0.5 0.5 1\nvt 0 0\nvt 1 0\nvt 1 1\n\
     vn 0 0 1\nvn 0 0.6 0.8\ng side lid\nusemtl a\ns 1\nf 1/1/1 2/2/2 3/3/1\nusemtl b\nf -5//-1 -3//1 -2//1\n\
     f 1 5 3 \\\n 4\ns off\nf 1/1 2/2 5/3\np 1\nl 1 2\n"
        .to_owned()
}

#[test]
fn damaged_obj_files_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(4, 4).write_to(&mut png, image::ImageFormat::Png).unwrap();
    std::fs::write(folder.path().join("a.png"), png.into_inner()).unwrap();
    std::fs::write(folder.path().join("a.mtl"), "newmtl a\nKd 1 0.5 0\nmap_Kd a.png\nnewmtl b\n").unwrap();
    let good = rich_obj();
    assert!(imports_without_panic("rich.obj", good.as_bytes(), folder.path()));
    let (mut read, mut refused) = (0, 0);
    let mut count = |what: &str, bytes: &[u8]| {
        let fine = imports_without_panic(what, bytes, folder.path());
        *if fine { &mut read } else { &mut refused } += 1;
    };
    // A truncated text is often still valid. Every prefix must be read or rejected without a panic.
    for length in 0..good.len() {
        count(&format!("cut to {length}"), &good.as_bytes()[..length]);
        for bit in 0..8 {
            let mut broken = good.clone().into_bytes();
            broken[length] ^= 1 << bit;
            count(&format!("bit {bit} of byte {length}"), &broken);
        }
    }
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let words = [
        "",
        "-1",
        "0",
        "1",
        "5",
        "6",
        "99999999999",
        "-99999999999999999999",
        "1/",
        "1//",
        "//",
        "1/1/1/1",
        "nan",
        "inf",
        "-inf",
        "1e39",
        "1e38",
        "-0",
        "1e-45",
        "v",
        "f",
        "g",
        "usemtl",
        "mtllib",
        "a.png",
        "\\",
        "\n",
        "#",
        "\u{feff}",
        "ä",
    ];
    for round in 0..4000 {
        let mut pieces: Vec<&str> = good.split_inclusive([' ', '\n']).collect();
        for _ in 0..=random.below(3) {
            let at = random.below(pieces.len());
            match random.below(3) {
                0 => drop(pieces.remove(at)),
                1 => pieces.insert(at, pieces[random.below(pieces.len())]),
                _ => pieces.splice(at..=at, [words[random.below(words.len())], " "]).for_each(drop),
            }
        }
        count(&format!("words of round {round}"), pieces.concat().as_bytes());
    }
    println!("{read} read, {refused} refused");
    assert!(read > 1000 && refused > 1000, "{read} read, {refused} refused");
}

/// Checks that a damaged material file never causes a panic or the rejection of a model, whose shape does not depend on
/// it.
#[test]
fn damaged_material_files_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let mtl = b"# skins\nnewmtl a\nKd 1 0.5 0\nmap_Kd -s 1 1 -clamp on ./a.png\nnewmtl b\nKd 0.5\n";
    let model = rich_obj();
    for at in 0..mtl.len() {
        let mut flipped = mtl.to_vec();
        flipped[at] ^= 1 << (at % 8);
        for bytes in [&mtl[..at], &flipped] {
            std::fs::write(folder.path().join("a.mtl"), bytes).unwrap();
            assert!(imports_without_panic(&format!("material file, byte {at}"), model.as_bytes(), folder.path()));
        }
    }
}
