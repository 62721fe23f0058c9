//! Tests of glTF skins and clips: models built in code, compared with numbers computed by hand.
#![allow(clippy::unwrap_used, reason = "tests")]

use crate::import::support::*;
use glam::{Mat4, Vec3};
use pelage_bake::stages::import::{ImportOptions, import};
use pelage_formats::{Interpolation, Pose, Property, SkinVertex};
use pelage_import::mesh::{Model, RestPose};
use serde_json::json;

/// Returns a triangle bound to two joints, the nodes 0 and 1. Node 1 is a child of node 0 at (0, 1, 0); node 2 has the
/// mesh.
fn skinned(joints: &[u8], weights: &[f32]) -> Doc {
    let mut doc = Doc::new();
    let position = doc.triangle();
    let joints = doc.accessor(joints, U8, "VEC4", joints.len() / 4);
    let weights = doc.floats(weights, "VEC4");
    doc.push("nodes", json!({"name": "hip", "children": [1]}));
    doc.push("nodes", json!({"name": "head", "translation": [0, 1, 0]}));
    let node = doc.show(json!({"attributes": {"POSITION": position, "JOINTS_0": joints, "WEIGHTS_0": weights}}));
    doc.json["nodes"][node]["skin"] = json!(0);
    // The node transform must be ignored, because the mesh is skinned.
    doc.json["nodes"][node]["translation"] = json!([500, 0, 0]);
    doc.push("skins", json!({"joints": [0, 1]}));
    doc
}

const ALTERNATE: [u8; 12] = [0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0];

fn rest(model: &Model) -> Vec<Vec3> {
    RestPose::of(&model.mesh, model.animation.as_ref()).positions
}

#[test]
fn skins_bind_to_joints_and_ignore_the_mesh_node() {
    let doc = skinned(&ALTERNATE, &[1., 0., 0., 0., 1., 0., 0., 0., 0.25, 0.75, 0., 0.]);
    let model = doc.model();
    let animation = model.animation.as_ref().unwrap();
    let names: Vec<&str> = animation.nodes.iter().map(|n| n.name.as_str()).collect();
    assert_eq!(names, ["hip", "head"], "the mesh's own node moves nothing and must be dropped");
    assert_eq!(animation.nodes[1].parent, Some(0));
    assert!(animation.clips.is_empty());
    // Missing inverse bind matrices are identities. The second joint therefore raises vertices by 1, and the last
    // vertex by three quarters of that.
    assert_eq!(rest(&model), [Vec3::ZERO, Vec3::new(1., 1., 0.), Vec3::new(0., 1.75, 0.)]);
    assert_eq!(model.mesh.positions[1], Vec3::X, "positions must stay in mesh space");
    assert_eq!(model.mesh.skin[1], SkinVertex { joints: [1, 0, 0, 0], weights: [1., 0., 0., 0.] });
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
}

#[test]
fn inverse_bind_matrices_undo_the_bind_pose() {
    let mut doc = skinned(&ALTERNATE, &[1., 0., 0., 0., 1., 0., 0., 0., 0.25, 0.75, 0., 0.]);
    let bind = [Mat4::IDENTITY, Mat4::from_translation(Vec3::new(0., -1., 0.))].map(|m| m.to_cols_array()).concat();
    let bind = doc.floats(&bind, "MAT4");
    doc.json["skins"][0]["inverseBindMatrices"] = json!(bind);
    assert_eq!(rest(&doc.model()), [Vec3::ZERO, Vec3::X, Vec3::Y]);
    let short = doc.floats(&Mat4::IDENTITY.to_cols_array(), "MAT4");
    doc.json["skins"][0]["inverseBindMatrices"] = json!(short);
    let lost = "/skins/0/inverseBindMatrices has 1 usable matrices, expected 2, one per joint; a missing one is the";
    let model = doc.model();
    assert_warns(&model, lost);
    assert_warns(&model, "mesh 0 \"body\", primitive 0: 2 vertices follow joints without an inverse bind matrix");
    // The identity raises what follows the second joint by 1.
    assert_eq!(rest(&model), [Vec3::ZERO, Vec3::new(1., 1., 0.), Vec3::new(0., 1.75, 0.)]);
    let (mut last, undo) = (Mat4::IDENTITY.to_cols_array(), Mat4::from_translation(Vec3::Y).to_cols_array());
    last[5] = f32::NAN;
    let partly = doc.floats(&[undo, last].concat(), "MAT4");
    doc.json["skins"][0]["inverseBindMatrices"] = json!(partly);
    assert_warns(&doc.model(), lost);
    assert_eq!(rest(&doc.model())[0], Vec3::Y, "the matrices that there are hold");
    // An accessor that cannot be read at all.
    for broken in [json!(99), json!(0), json!("x")] {
        doc.json["skins"][0]["inverseBindMatrices"] = broken;
        assert_warns(&doc.model(), "no matrix is read");
        assert_warns(&doc.model(), "has 0 usable matrices, expected 2");
    }
}

/// Checks that a missing matrix is reported for the file, and for vertices only if any follows the joint.
#[test]
fn missing_matrices_of_idle_joints_displace_nothing() {
    let mut doc = skinned(&[0; 12], &[1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0.]);
    let single = doc.floats(&Mat4::IDENTITY.to_cols_array(), "MAT4");
    doc.json["skins"][0]["inverseBindMatrices"] = json!(single);
    let model = doc.model();
    assert_warns(&model, "has 1 usable matrices, expected 2");
    assert_eq!(model.warnings.len(), 1, "{:?}", model.warnings);
}

#[test]
fn model_unit_scales_animated_models_through_an_extra_root() {
    let doc = skinned(&ALTERNATE, &[1., 0., 0., 0., 1., 0., 0., 0., 0.25, 0.75, 0., 0.]);
    let model = import("m", &doc.glb(), &mut |_, _| unreachable!(), &ImportOptions { unit_m: 0.5 }).unwrap();
    assert_sound(&model);
    assert_near(rest(&model)[2], [0.0, 0.875, 0.0]);
    assert_eq!(model.animation.as_ref().unwrap().nodes.len(), 3);
    assert_eq!(model.mesh.positions[2], Vec3::Y);
}

#[test]
fn invalid_joint_weights_are_repaired() {
    let doc = skinned(&ALTERNATE, &[2., 0., 0., 0., 0., 0., 0., 0., -1., 0.5, f32::NAN, 0.]);
    let model = doc.model();
    let skin = &model.mesh.skin;
    assert_eq!(skin[0], SkinVertex { joints: [0; 4], weights: [1., 0., 0., 0.] });
    assert_eq!(
        skin[1],
        SkinVertex { joints: [1, 0, 0, 0], weights: [1., 0., 0., 0.] },
        "the vertex must follow the first joint that it names"
    );
    assert_eq!(skin[2], SkinVertex { joints: [1, 0, 0, 0], weights: [1., 0., 0., 0.] });
    assert_warns(&model, "2 weights are negative or not finite");
    assert_warns(&model, "1 vertices have no weight");
    assert_warns(&model, "2 vertices have weights that do not sum to 1");
}

#[test]
fn four_largest_of_eight_influences_are_kept() {
    let mut doc = skinned(&[0; 12], &[0.3, 0.05, 0.1, 0.05, 0., 0., 0., 1., 1., 0., 0., 0.]);
    let extra: Vec<u8> = [[1_u8; 4]; 3].concat();
    let joints = doc.accessor(&extra, U8, "VEC4", 3);
    let weights = doc.floats(&[0.2, 0.25, 0.03, 0.02, 0., 0., 0., 0., 0., 0., 0., 0.], "VEC4");
    let attributes = &mut doc.json["meshes"][0]["primitives"][0]["attributes"];
    (attributes["JOINTS_1"], attributes["WEIGHTS_1"]) = (json!(joints), json!(weights));
    let model = doc.model();
    // The weights are 0.3, 0.25, 0.2 and 0.1, divided by their sum of 0.85.
    assert_eq!(model.mesh.skin[0].joints, [0, 1, 1, 0]);
    for (found, expected) in model.mesh.skin[0].weights.iter().zip([0.3, 0.25, 0.2, 0.1]) {
        assert!((found - expected / 0.85).abs() < 1e-6);
    }
    assert_warns(&model, "1 vertices follow more than four joints");
}

#[test]
fn out_of_range_joints_with_weight_are_refused() {
    let mut joints = ALTERNATE;
    joints[6] = 9;
    let weights = [1., 0., 0., 0., 1., 0., 0., 0., 0.25, 0.75, 0., 0.];
    skinned(&joints, &weights).model();
    joints[4] = 9;
    let (place, reason) = skinned(&joints, &weights).fault();
    assert_eq!(place, "/meshes/0/primitives/0");
    assert_eq!(reason, "vertex 1 follows joint 9, expected less than 2, the joint count of its skin");
}

#[test]
fn mirroring_skeleton_flips_the_triangles() {
    let mut doc = skinned(&[0; 12], &[1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0.]);
    doc.json["nodes"][0]["scale"] = json!([-1, 1, 1]);
    let model = doc.model();
    assert_near(face_normal(&model, 0), [0., 0., 1.]);
    assert_eq!(model.mesh.triangles, [[0, 2, 1]]);
    let normals = RestPose::of(&model.mesh, model.animation.as_ref()).normals;
    assert!(normals.iter().all(|n| n.abs_diff_eq(Vec3::Z, 1e-6)));
}

/// Adds an animation with one channel. `values` contains the values of all keys, one after another.
fn clip(doc: &mut Doc, node: usize, path: &str, interpolation: &str, times: &[f32], values: &[f32]) {
    let kind = if path == "rotation" { "VEC4" } else { "VEC3" };
    let (input, output) = (doc.floats(times, "SCALAR"), doc.floats(values, kind));
    doc.push(
        "animations",
        json!({
            "samplers": [{"input": input, "output": output, "interpolation": interpolation}],
            "channels": [{"sampler": 0, "target": {"node": node, "path": path}}],
        }),
    );
}

/// Returns two rigid triangles, on node 0 (a child of 1) and on node 2, without a glTF skin.
fn rigid() -> Doc {
    let mut doc = Doc::new();
    let position = doc.triangle();
    let child = doc.show(json!({"attributes": {"POSITION": position}}));
    doc.push("nodes", json!({"name": "turntable", "children": [child], "translation": [0, 0, 2]}));
    doc.push("nodes", json!({"name": "other", "mesh": 0, "translation": [0, 0, 9]}));
    doc
}

#[test]
fn rigid_meshes_are_bound_only_to_moving_ancestors() {
    let mut doc = rigid();
    let camera = doc.push("nodes", json!({"name": "camera"}));
    clip(&mut doc, camera, "translation", "LINEAR", &[0., 1.], &[0.; 6]);
    assert!(doc.model().animation.is_none(), "a moving camera moves no fur");
    clip(&mut doc, 1, "translation", "LINEAR", &[0., 1.], &[0., 0., 2., 0., 0., 4.]);
    let model = doc.model();
    let animation = model.animation.as_ref().unwrap();
    let names: Vec<&str> = animation.nodes.iter().map(|n| n.name.as_str()).collect();
    assert_eq!(names, ["turntable", "", "other"], "parents must come first, and the camera must be dropped");
    assert_eq!(model.mesh.skin.iter().map(|s| s.joints[0]).collect::<Vec<_>>(), [0, 0, 0, 1, 1, 1]);
    let clips = &animation.clips;
    assert_eq!((clips.len(), clips[0].name.as_str(), clips[0].duration_s), (1, "clip_1", 1.0));
    assert_near(rest(&model)[0], [0., 0., 2.]);
    let mut pose = Pose::default();
    pose.sample(animation, Some(0), 0.5);
    let posed = RestPose::posed(&model.mesh, &pose).positions;
    assert_near(posed[0], [0., 0., 3.]);
    assert_near(posed[3], [0., 0., 9.]);
}

#[test]
fn mirrored_moving_rigid_parts_are_flipped() {
    let mut doc = rigid();
    doc.json["nodes"][1]["scale"] = json!([1, -1, 1]);
    clip(&mut doc, 1, "translation", "STEP", &[0.], &[0., 0., 2.]);
    let model = doc.model();
    assert_eq!(model.mesh.triangles, [[0, 2, 1], [3, 4, 5]]);
    assert_near(face_normal(&model, 0), [0., 0., 1.]);
    assert_near(face_normal(&model, 1), [0., 0., 1.]);
}

#[test]
fn keys_of_every_interpolation_are_kept() {
    let mut doc = rigid();
    clip(&mut doc, 1, "scale", "STEP", &[0.5, 1.], &[1., 1., 1., 2., 2., 2.]);
    // The clip is one second of a cubic spline from 0 to 1 in x with zero tangents. At half the time, x is 0.5.
    let cubic = [[0.; 3], [0., 0., 0.], [0.; 3], [0.; 3], [1., 0., 0.], [0.; 3]].concat();
    clip(&mut doc, 1, "translation", "CUBICSPLINE", &[0., 1.], &cubic);
    let model = doc.model();
    let animation = model.animation.as_ref().unwrap();
    let scale = &animation.clips[0].channels[0];
    assert_eq!((scale.property, scale.interpolation), (Property::Scale, Interpolation::Step));
    assert_eq!((scale.times.as_slice(), scale.values.len()), (&[0.5, 1.][..], 6));
    assert_eq!(animation.clips[1].channels[0].interpolation, Interpolation::Cubic);
    let mut pose = Pose::default();
    pose.sample(animation, Some(0), 0.99);
    assert_near(RestPose::posed(&model.mesh, &pose).positions[1], [1., 0., 2.]);
    pose.sample(animation, Some(1), 0.5);
    assert_near(RestPose::posed(&model.mesh, &pose).positions[0], [0.5, 0., 0.]);
}

#[test]
fn quantised_rotations_are_normalised() {
    let mut doc = rigid();
    let input = doc.floats(&[0.], "SCALAR");
    let output = doc.accessor(&[0_i16, 0, 32_767, 0][..].bytes(), I16, "VEC4", 1);
    doc.json["accessors"][output]["normalized"] = json!(true);
    let sampler = json!({"input": input, "output": output});
    doc.push(
        "animations",
        json!({"name": "turn", "samplers": [sampler],
        "channels": [{"sampler": 0, "target": {"node": 1, "path": "rotation"}}]}),
    );
    let model = doc.model();
    assert_eq!(model.animation.as_ref().unwrap().clips[0].channels[0].values, [0., 0., 1., 0.]);
    let mut pose = Pose::default();
    pose.sample(model.animation.as_ref().unwrap(), Some(0), 0.0);
    assert_near(RestPose::posed(&model.mesh, &pose).positions[1], [-1., 0., 2.]);
}

#[test]
fn invalid_channels_are_left_out_or_repaired() {
    let mut doc = rigid();
    let (input, output) = (
        doc.floats(&[0., 0., 2., 1.], "SCALAR"),
        doc.floats(&[0., 0., 1., 9., 9., 9., 0., 0., 3., 9., 9., 9.], "VEC3"),
    );
    let single = doc.floats(&[0.], "SCALAR");
    let weights = doc.floats(&[0.], "SCALAR");
    doc.push(
        "animations",
        json!({
            "name": "odd",
            "samplers": [{"input": input, "output": output}, {"input": single, "output": weights}],
            "channels": [
                {"sampler": 0, "target": {"path": "translation"}},
                {"sampler": 1, "target": {"node": 0, "path": "weights"}},
                {"sampler": 0, "target": {"node": 0, "path": "pointer"}},
                {"sampler": 0, "target": {"node": 1, "path": "scale"}},
                {"sampler": 0, "target": {"node": 1, "path": "scale"}},
            ],
        }),
    );
    let model = doc.model();
    let channels = &model.animation.as_ref().unwrap().clips[0].channels;
    assert_eq!(channels.len(), 1);
    assert_eq!(channels[0].times, [0., 2.]);
    assert_eq!(channels[0].values, [0., 0., 1., 0., 0., 3.]);
    for text in ["\"pointer\"", "replaces", "2 keys are not later than"] {
        assert_warns(&model, text);
    }
}

#[test]
fn broken_channels_are_named_and_left_out() {
    let broken = |times: &[f32], values: &[f32], interpolation: &str, text: &str| {
        let mut doc = rigid();
        clip(&mut doc, 1, "translation", interpolation, times, values);
        // A sound channel beside the broken one is kept.
        let (input, output) = (doc.floats(&[0., 1.], "SCALAR"), doc.floats(&[1., 1., 1., 2., 2., 2.], "VEC3"));
        let animation = &mut doc.json["animations"][0];
        animation["name"] = json!("walk\u{7}");
        animation["samplers"].as_array_mut().unwrap().push(json!({"input": input, "output": output}));
        let sound = json!({"sampler": 1, "target": {"node": 1, "path": "scale"}});
        animation["channels"].as_array_mut().unwrap().push(sound);
        let model = doc.model();
        assert_warns(&model, &format!("{text}; left out of clip \"walk\u{fffd}\""));
        let channels = &model.animation.as_ref().unwrap().clips[0].channels;
        assert_eq!(channels.iter().map(|c| c.property).collect::<Vec<_>>(), [Property::Scale]);
    };
    let output = "/animations/0/samplers/0/output";
    broken(&[0., 1.], &[0.; 3], "LINEAR", &format!("{output}: has 1 elements, expected 2 for 2 keys"));
    broken(&[0.], &[0.; 3], "CUBICSPLINE", "has 1 elements, expected 3 for 1 keys");
    broken(
        &[f32::NAN],
        &[0.; 3],
        "LINEAR",
        "/animations/0/samplers/0/input: element 0 is NaN, expected a time in seconds",
    );
    broken(&[0.], &[f32::INFINITY; 3], "LINEAR", "element 0 is not finite, expected finite numbers");
    broken(&[0.], &[0.; 3], "SPLINE", "is \"SPLINE\", expected LINEAR, STEP or CUBICSPLINE");
    broken(&[], &[], "LINEAR", "has no keys, expected at least one");
}

#[test]
fn broken_clips_do_not_lose_the_model() {
    let mut doc = rigid();
    clip(&mut doc, 1, "translation", "LINEAR", &[0., 1.], &[0., 0., 2., 0., 0., 4.]);
    for (pointer, value, text) in [
        ("/animations/0/channels/0/target/node", json!(99), "is 99, expected less than 3, the number of nodes"),
        ("/animations/0/channels/0/target/path", json!(7), "is 7, expected a string"),
        ("/animations/0/channels/0/target", json!(null), "has no `target`"),
        ("/animations/0/channels/0/sampler", json!(9), "is 9, expected less than 1, the number of samplers"),
        ("/animations/0/channels/0", json!("x"), "is \"x\", expected an object"),
        ("/animations/0/channels", json!(null), "has no `channels`"),
        ("/animations/0/samplers", json!({}), "is an object, expected an array"),
        ("/animations/0/samplers/0/interpolation", json!(0), "is 0, expected a string"),
        ("/animations/0/samplers/0/input", json!(77), "is 77, expected less than 3, the number of accessors"),
        ("/animations/0", json!(null), "is null, expected an object"),
        ("/animations", json!("x"), "is \"x\", expected an array; all clips are left out"),
    ] {
        let mut broken = doc.clone();
        *broken.json.pointer_mut(pointer).unwrap() = value;
        let model = broken.model();
        assert_warns(&model, text);
        assert!(model.animation.is_none(), "{pointer}");
    }
}

#[test]
fn one_mesh_on_two_nodes_appears_twice() {
    let mut doc = rigid();
    let model = doc.model();
    assert_eq!((model.mesh.positions.len(), model.mesh.parts.len()), (6, 2));
    assert_eq!(model.mesh.parts[0].source, model.mesh.parts[1].source);
    assert_near(model.mesh.positions[3], [0., 0., 9.]);
    clip(&mut doc, 2, "rotation", "LINEAR", &[0.], &[0., 0., 0., 1.]);
    assert_eq!(doc.model().animation.unwrap().joints.len(), 2);
}

#[test]
fn shear_of_animated_nodes_is_dropped_with_a_warning() {
    let mut doc = rigid();
    doc.json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    clip(&mut doc, 1, "translation", "LINEAR", &[-1., 1.], &[0., 0., 1., 0., 0., 3.]);
    let model = doc.model();
    assert_warns(&model, "contains shear");
    assert_warns(&model, "begins before 0 s");
    // The shear cannot be represented, so the second term of x' = x + y/2 is lost.
    assert_near(rest(&model)[2], [0., 1., 2.]);
}

#[test]
fn clips_animate_nodes_placed_by_a_matrix() {
    let mut doc = rigid();
    doc.json["nodes"][1] = json!({"name": "turntable", "children": [0],
        "matrix": [0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, 5, 0, 0, 1]});
    clip(&mut doc, 1, "translation", "LINEAR", &[0.], &[0., 0., 0.]);
    let model = doc.model();
    let turntable = &model.animation.as_ref().unwrap().nodes[0];
    assert_eq!((turntable.translation, turntable.scale), ([5., 0., 0.], [2.; 3]));
    assert_near(rest(&model)[1], [5., 2., 0.]);
    let mut pose = Pose::default();
    pose.sample(model.animation.as_ref().unwrap(), Some(0), 0.0);
    assert_near(RestPose::posed(&model.mesh, &pose).positions[1], [0., 2., 0.]);
}

#[test]
fn parts_without_joints_under_a_skin_follow_their_node() {
    let mut doc = skinned(&ALTERNATE, &[1., 0., 0., 0., 1., 0., 0., 0., 0.25, 0.75, 0., 0.]);
    let eye = json!({"attributes": {"POSITION": 0}});
    doc.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(eye);
    let model = doc.model();
    assert_warns(&model, "has no joints, but its node has a skin; it follows the node");
    assert_near(rest(&model)[3], [500., 0., 0.]);
    assert_eq!(model.animation.unwrap().joints.len(), 3);
}
