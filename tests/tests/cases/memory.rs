//! Memory of models whose accessors, primitives and nodes share data, or have none.
#![allow(clippy::unwrap_used, reason = "tests")]

use crate::import::support::*;
use pelage_tests::binary::Sandbox;
use serde_json::{Value, json};

/// Returns a document with an accessor of `count` positions, of which three are not zero, and one of three indices.
/// They are its first two accessors.
fn sparse(count: usize) -> Doc {
    let mut doc = Doc::new();
    let (indices, values) =
        (doc.view(&[0_u32, 1, 2][..].bytes()), doc.view(&[0_f32, 0., 0., 1., 0., 0., 0., 1., 0.].bytes()));
    let replaced = json!({"count": 3, "indices": {"bufferView": indices, "componentType": U32},
        "values": {"bufferView": values}});
    doc.push("accessors", json!({"componentType": F32, "count": count, "type": "VEC3", "sparse": replaced}));
    doc.push("accessors", json!({"bufferView": indices, "componentType": U32, "count": 3, "type": "SCALAR"}));
    doc
}

/// Adds a mesh whose primitives are `count` triangles with the first two accessors and `more` attributes.
fn triangles(doc: &mut Doc, count: usize, more: &Value) {
    let mut attributes = json!({"POSITION": 0});
    attributes.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    let primitive = json!({"attributes": attributes, "indices": 1});
    doc.push("meshes", json!({"primitives": vec![primitive; count]}));
}

/// Asserts that a document is refused before it takes memory, because it needs too much. `found`: part of the message.
fn assert_needs_too_much(name: &str, doc: &Doc, found: &str) {
    let said = refused(name, doc);
    assert!(said.contains(found) && said.contains("MiB of memory, expected at most 768 MiB"), "{said}");
}

/// Bakes a document with the binary, which must refuse it before it takes memory. Returns what is printed.
fn refused(name: &str, doc: &Doc) -> String {
    let sandbox = Sandbox::new();
    sandbox.write("m.gltf", doc.gltf());
    let run = sandbox.run(&["bake", "m.gltf", "-o", "m.pelage", "--record", "record.json"]);
    assert_eq!(run.code, Some(3), "{name}: {run:?}");
    let record: Value = serde_json::from_slice(&sandbox.read("record.json")).unwrap();
    let peak = record["peak_bytes"].as_u64().unwrap_or(0) >> 20;
    assert!(peak < 200, "{name}: peak memory {peak} MiB");
    run.stderr
}

#[test]
fn shared_and_absent_data_is_refused_before_it_takes_memory() {
    let mut one = sparse(1 << 24);
    triangles(&mut one, 1, &json!({}));
    one.push("nodes", json!({"mesh": 0}));
    let found = "m.gltf: /meshes/0/primitives/0: takes the model to 16777216 vertices and 3 indices that need";
    assert_needs_too_much("one sparse accessor", &one, found);

    let mut shared = sparse(1 << 20);
    triangles(&mut shared, 16, &json!({}));
    shared.push("nodes", json!({"mesh": 0}));
    assert_needs_too_much("primitives", &shared, "/meshes/0/primitives/5: takes the model to 6291456 vertices");

    // A mesh is read once, however many nodes show it.
    let mut nodes = sparse(1 << 16);
    triangles(&mut nodes, 1, &json!({}));
    for _ in 0..256 {
        nodes.push("nodes", json!({"mesh": 0}));
    }
    assert_needs_too_much("nodes", &nodes, "/meshes/0/primitives/0: takes the model to 6946816 vertices");

    let mut lines = sparse(1 << 24);
    triangles(&mut lines, 1, &json!({}));
    lines.json["accessors"][0]["count"] = json!(3);
    let many = lines.push("accessors", json!({"componentType": F32, "count": 1 << 23, "type": "VEC3"}));
    lines.push("meshes", json!({"name": "comb", "primitives": [{"mode": 3, "attributes": {"POSITION": many}}]}));
    for mesh in 0..2 {
        lines.push("nodes", json!({"mesh": mesh}));
    }
    assert_needs_too_much("comb lines", &lines, "/meshes/1/primitives/0: takes the model to 8388611 vertices");

    // Eight sets of weights take more than the vertex.
    let mut weights = sparse(3 << 20);
    let joints = weights.push("accessors", json!({"componentType": U8, "count": 3 << 20, "type": "VEC4"}));
    let reals = weights.push("accessors", json!({"componentType": F32, "count": 3 << 20, "type": "VEC4"}));
    let sets = (0..8).flat_map(|n| [(format!("JOINTS_{n}"), json!(joints)), (format!("WEIGHTS_{n}"), json!(reals))]);
    triangles(&mut weights, 1, &Value::Object(sets.collect()));
    weights.push("skins", json!({"joints": [1]}));
    weights.push("nodes", json!({"mesh": 0, "skin": 0}));
    weights.push("nodes", json!({}));
    assert_needs_too_much("weights", &weights, "/meshes/0/primitives/0: takes the model to 3145728 vertices");
}

#[test]
fn morph_targets_of_all_nodes_are_bounded() {
    let mut doc = Doc::new();
    let position = doc.floats(&[1.0; 3 * 2000], "VEC3");
    let target = json!({"POSITION": position});
    doc.push("meshes", json!({"primitives": [{"attributes": target, "targets": vec![target.clone(); 64]}]}));
    for _ in 0..64 {
        doc.push("nodes", json!({"mesh": 0}));
    }
    let said = refused("morph targets", &doc);
    let expected = "/meshes/0/primitives/0: makes the morph targets move more than 6710886 vertices in total";
    assert!(said.contains(expected), "{said}");
}
