//! Tests of `EXT_mesh_gpu_instancing`: several instances of a mesh in one node.
#![allow(clippy::unwrap_used, reason = "tests")]

use crate::import::support::*;
use pelage_import::mesh::RestPose;
use serde_json::{Value, json};

/// Returns a triangle under a node at (0, 0, 10), with instances of the given attributes.
fn doc(attributes: impl FnOnce(&mut Doc) -> Value) -> Doc {
    let mut doc = Doc::new();
    let position = doc.triangle();
    let node = doc.show(json!({"attributes": {"POSITION": position}}));
    let attributes = attributes(&mut doc);
    doc.json["nodes"][node]["name"] = json!("grove");
    doc.json["nodes"][node]["translation"] = json!([0, 0, 10]);
    doc.json["nodes"][node]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
    doc.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    doc
}

fn two_places(doc: &mut Doc) -> Value {
    json!({"TRANSLATION": doc.floats(&[1., 0., 0., 0., 2., 0.], "VEC3")})
}

#[test]
fn mesh_is_placed_at_its_instances_and_not_at_its_node() {
    let mut doc = doc(|doc| {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        json!({
            "TRANSLATION": doc.floats(&[1., 0., 0., 0., 2., 0.], "VEC3"),
            "ROTATION": doc.floats(&[0., 0., 0., 1., 0., 0., 2. * half, 2. * half], "VEC4"),
            "SCALE": doc.floats(&[1., 1., 1., 3., 1., 1.], "VEC3"),
            "_ID": doc.floats(&[7., 8.], "SCALAR"),
        })
    });
    doc.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let model = doc.model();
    let places = &model.mesh.positions;
    assert_eq!(model.mesh.triangles.len(), 2);
    assert_near(places[0], [1.0, 0.0, 10.0]);
    assert_near(places[1], [2.0, 0.0, 10.0]);
    // The instance is scaled threefold along x, rotated by a quarter turn about z with a quaternion of length 2, and
    // translated.
    assert_near(places[3], [0.0, 2.0, 10.0]);
    assert_near(places[4], [0.0, 5.0, 10.0]);
    assert_near(places[5], [-1.0, 2.0, 10.0]);
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    // All parts have the node's name, and only one node has that name.
    assert!(model.mesh.parts.iter().all(|part| part.names.contains(&"grove".to_owned())));
    assert_eq!(model.nodes.iter().filter(|place| place.name == "grove").count(), 1);
}

#[test]
fn integer_rotations_are_read_and_mirroring_keeps_faces_outward() {
    let model = doc(|doc| {
        // The rotation is a quarter turn about z in normalised bytes; the scale mirrors x.
        let rotation = doc.accessor(&[0_i8, 0, 90, 90][..].bytes(), I8, "VEC4", 1);
        doc.json["accessors"][rotation]["normalized"] = json!(true);
        json!({"ROTATION": rotation, "SCALE": doc.floats(&[-1., 1., 1.], "VEC3")})
    })
    .model();
    assert_near(model.mesh.positions[1], [0.0, -1.0, 10.0]);
    assert!(face_normal(&model, 0).z > 0.0, "the triangle must face the same way");
}

#[test]
fn instances_move_with_their_node() {
    let mut doc = doc(two_places);
    let times = doc.floats(&[0., 1.], "SCALAR");
    let values = doc.floats(&[0., 0., 10., 0., 0., 20.], "VEC3");
    doc.push(
        "animations",
        json!({
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
            "samplers": [{"input": times, "output": values}],
        }),
    );
    let model = doc.model();
    let animation = model.animation.as_ref().unwrap();
    let rest = RestPose::of(&model.mesh, Some(animation));
    assert_near(rest.positions[0], [1.0, 0.0, 10.0]);
    assert_near(rest.positions[3], [0.0, 2.0, 10.0]);
    let mut pose = pelage_formats::Pose::default();
    pose.sample(animation, Some(0), 1.0);
    let joints = [model.mesh.skin[0].joints[0], model.mesh.skin[3].joints[0]].map(usize::from);
    assert_ne!(joints[0], joints[1]);
    assert_near(pose.joints[joints[1]].transform_point3(model.mesh.positions[3]), [0.0, 2.0, 20.0]);
}

#[test]
fn instance_errors_name_the_field() {
    type Attributes = fn(&mut Doc) -> Value;
    let table: [(Attributes, &str, &str); 6] = [
        (|_| json!({}), "attributes", "has none of TRANSLATION, ROTATION and SCALE"),
        (
            |doc| json!({"TRANSLATION": doc.floats(&[0.; 6], "VEC3"), "SCALE": doc.floats(&[1.; 9], "VEC3")}),
            "SCALE",
            "has 3 elements, expected 2, as many as TRANSLATION",
        ),
        (|doc| json!({"TRANSLATION": doc.floats(&[0.; 4], "VEC4")}), "TRANSLATION", "expected 3 x f32"),
        (|doc| json!({"TRANSLATION": doc.floats(&[0., f32::NAN, 0.], "VEC3")}), "TRANSLATION", "element 0"),
        (
            |doc| {
                let accessor = json!({"componentType": F32, "type": "VEC3", "count": 70_000});
                json!({"SCALE": doc.push("accessors", accessor)})
            },
            "SCALE",
            "expected at most 65536 instances in a document",
        ),
        (|_| json!({"TRANSLATION": 99}), "TRANSLATION", "99"),
    ];
    for (attributes, place, reason) in table {
        let found = doc(attributes).fault();
        assert!(found.0.contains(place) && found.1.contains(reason), "{found:?}, expected {place}: {reason}");
    }
    // Checks that the limit of 65 536 instances applies to the sum over all nodes.
    let mut many = doc(
        |doc| json!({"SCALE": doc.push("accessors", json!({"componentType": F32, "type": "VEC3", "count": 40_000}))}),
    );
    let node = many.json["nodes"][0].clone();
    many.push("nodes", node);
    assert!(many.fault().1.contains("at most 65536 instances"), "{:?}", many.fault());
}

#[test]
fn zero_instances_show_nothing_and_skinned_meshes_appear_once() {
    let nothing = doc(
        |doc| json!({"TRANSLATION": doc.push("accessors", json!({"componentType": F32, "type": "VEC3", "count": 0}))}),
    );
    let found = nothing.fault();
    assert!(found.1.contains("has no triangles"), "{found:?}");
    // Checks that a node without a mesh has no instances.
    let mut bare = doc(two_places);
    let node = bare.json["nodes"][0].clone();
    bare.push("nodes", json!({"extensions": node["extensions"]}));
    assert_eq!(bare.model().mesh.triangles.len(), 2);
    let mut skinned = doc(two_places);
    skinned.push("skins", json!({"joints": [0]}));
    skinned.json["nodes"][0]["skin"] = json!(0);
    let model = skinned.model();
    assert_eq!(model.mesh.triangles.len(), 1);
    assert_warns(&model, "it is shown once");
}
