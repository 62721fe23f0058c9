//! Tests of lines and empty nodes of a model that define the comb direction.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use crate::import::support::{Bytes as _, Doc, U8, U16, assert_near, assert_warns};
use glam::Vec3;
use serde_json::{Value, json};

/// Returns a document with a triangle.
fn with_triangle() -> Doc {
    let mut doc = Doc::new();
    let position = doc.triangle();
    doc.show(json!({"attributes": {"POSITION": position}}));
    doc
}

/// Adds a line from the origin along x, then along y. `node` contains additional keys of its node.
fn line(doc: &mut Doc, mode: u64, mesh_name: &str, mut node: Value) {
    let position = doc.floats(&[0., 0., 0., 1., 0., 0., 1., 2., 0.], "VEC3");
    let indices: &[u16] = if mode == 1 { &[0, 1, 1, 2] } else { &[0, 1, 2] };
    let indices = doc.accessor(&indices.bytes(), U16, "SCALAR", indices.len());
    let primitive = json!({"attributes": {"POSITION": position}, "mode": mode, "indices": indices});
    node["mesh"] = doc.push("meshes", json!({"name": mesh_name, "primitives": [primitive]})).into();
    doc.push("nodes", node);
}

#[test]
fn comb_lines_are_read_in_world_space() {
    let mut doc = with_triangle();
    let moved = json!({"name": "Comb_neck", "translation": [0, 0, 5], "scale": [2, 2, 2],
        "rotation": [0, 0, std::f32::consts::FRAC_1_SQRT_2, std::f32::consts::FRAC_1_SQRT_2]});
    line(&mut doc, 1, "Curve.001", moved);
    line(&mut doc, 3, "COMB_back", json!({"name": "Curve"}));
    line(&mut doc, 2, "", json!({"name": "comb"}));
    line(&mut doc, 3, "whisker", json!({"name": "honeycomb"}));
    let model = doc.model();
    let found: Vec<(&str, usize)> = model.combs.iter().map(|c| (c.name.as_str(), c.places.len())).collect();
    assert_eq!(found, [("Comb_neck", 3), ("COMB_back", 3), ("comb", 4)]);
    // The node rotates by a quarter turn about z (x becomes y), scales by two, and translates.
    let turned = &model.combs[0].places;
    assert_near(turned[1].0, [0.0, 2.0, 5.0]);
    assert_near(turned[2].0, [-4.0, 2.0, 5.0]);
    assert_near(turned[0].1, [0.0, 1.0, 0.0]);
    assert_near(turned[2].1, [-1.0, 0.0, 0.0]);
    assert_warns(&model, "holds a line strip");
    assert_eq!(model.warnings.len(), 1, "comb lines must not be reported as left out: {:?}", model.warnings);
    assert_eq!(model.mesh.parts.len(), 1);
}

#[test]
fn comb_markers_point_along_their_y_axis() {
    let mut doc = with_triangle();
    let parent = doc
        .push("nodes", json!({"name": "parent", "translation": [0, 3, 0], "scale": [2, 2, 2], "children": [2, 3, 4]}));
    assert_eq!(parent, 1);
    let quarter = [std::f32::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2];
    doc.push("nodes", json!({"name": "comb_tail", "translation": [1, 0, 0], "rotation": quarter}));
    doc.push("nodes", json!({"name": "comb_flat", "scale": [1, 0, 1]}));
    doc.push("nodes", json!({"name": "combed"}));
    let model = doc.model();
    assert_eq!(model.combs.len(), 1, "{:?}", model.combs);
    assert_eq!(model.combs[0].name, "comb_tail");
    assert_near(model.combs[0].places[0].0, [2.0, 3.0, 0.0]);
    assert_near(model.combs[0].places[0].1, [0.0, 0.0, 1.0]);
    assert_warns(&model, "\"comb_flat\" has no direction");
}

/// Returns a triangle and a line, both bound to a joint that is one metre above its bind pose. The joint has a child
/// node with the name of a comb.
fn skinned_line(joint_of_line: u8) -> Doc {
    let mut doc = Doc::new();
    let (position, points) = (doc.triangle(), doc.floats(&[0., 0., 0., 1., 0., 0.], "VEC3"));
    let joints = |doc: &mut Doc, n: usize, joint: u8| {
        doc.accessor(&vec![[joint, 0, 0, 0]; n].concat()[..].bytes(), U8, "VEC4", n)
    };
    let (of_triangle, of_line) = (joints(&mut doc, 3, 0), joints(&mut doc, 2, joint_of_line));
    let weights = doc.floats(&[1., 0., 0., 0.].repeat(3), "VEC4");
    let two = doc.floats(&[1., 0., 0., 0.].repeat(2), "VEC4");
    let attributes = |position: usize, joints: usize, weights: usize| {
        json!({
            "POSITION": position,
            "JOINTS_0": joints,
            "WEIGHTS_0": weights,
        })
    };
    let body = json!({"attributes": attributes(position, of_triangle, weights)});
    let comb = json!({"attributes": attributes(points, of_line, two), "mode": 1});
    doc.push("meshes", json!({"primitives": [body]}));
    doc.push("meshes", json!({"name": "comb_arm", "primitives": [comb]}));
    doc.push("skins", json!({"joints": [2]}));
    doc.push("nodes", json!({"mesh": 0, "skin": 0}));
    // The node's own transform must be ignored, because its mesh is skinned.
    doc.push("nodes", json!({"mesh": 1, "skin": 0, "translation": [9, 9, 9]}));
    doc.push("nodes", json!({"name": "comb_joint", "translation": [0, 1, 0], "children": [3]}));
    doc.push("nodes", json!({"name": "comb_tip", "translation": [0, 1, 0]}));
    doc
}

#[test]
fn skinned_comb_lines_are_moved_to_the_rest_pose() {
    let model = skinned_line(0).model();
    let names: Vec<&str> = model.combs.iter().map(|comb| comb.name.as_str()).collect();
    assert_eq!(names, ["comb_arm", "comb_tip"], "a joint is not a comb marker, but its child node is");
    assert_near(model.combs[0].places[1].0, [1.0, 1.0, 0.0]);
    assert_near(model.combs[1].places[0].0, [0.0, 2.0, 0.0]);
    assert_near(model.combs[0].places[0].1, [1.0, 0.0, 0.0]);
}

#[test]
fn comb_line_errors_are_reported() {
    let (place, reason) = skinned_line(7).fault();
    assert!(place == "/meshes/1/primitives/0" && reason.contains("joint 7"), "{place}: {reason}");
    let mut odd = with_triangle();
    line(&mut odd, 1, "comb", json!({}));
    let accessor = odd.json["meshes"][1]["primitives"][0]["indices"].as_u64().unwrap() as usize;
    odd.json["accessors"][accessor]["count"] = 3.into();
    let (place, reason) = odd.fault();
    assert!(place == "/meshes/1/primitives/0" && reason.contains("even"), "{place}: {reason}");
    let mut far = with_triangle();
    line(&mut far, 3, "comb", json!({"scale": [3e38, 1, 1]}));
    far.json["nodes"][1]["translation"] = json!([3e38, 0, 0]);
    let (_, reason) = far.fault();
    assert!(reason.contains("finite"), "{reason}");
    let mut point = with_triangle();
    line(&mut point, 3, "comb", json!({"scale": [0, 0, 0]}));
    let model = point.model();
    assert!(model.combs.is_empty());
    assert_warns(&model, "has no length");
}

#[test]
fn comb_lines_without_nodes_are_read_untransformed() {
    let mut doc = Doc::new();
    let (position, points) = (doc.triangle(), doc.floats(&[0., 0., 0., 1., 0., 0.], "VEC3"));
    doc.push("meshes", json!({"name": "body", "primitives": [{"attributes": {"POSITION": position}}]}));
    doc.push("meshes", json!({"name": "comb_a", "primitives": [{"attributes": {"POSITION": points}, "mode": 3}]}));
    let model = doc.model();
    assert_eq!(model.combs.len(), 1);
    assert_eq!(model.combs[0].places, [(Vec3::ZERO, Vec3::X), (Vec3::X, Vec3::X)]);
}
