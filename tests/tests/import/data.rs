//! Imports every glTF file of the shared test data, and checks the expected result or error.
#![allow(clippy::unwrap_used, reason = "tests")]

use crate::import::support::*;
use glam::Vec3;
use pelage_bake::io::{Reach, read_model};
use pelage_import::BakeError;
use pelage_import::ImportOptions;
use pelage_import::mesh::{Model, RestPose};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn walk(folder: &Path, out: &mut Vec<PathBuf>) {
    let mut entries: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            walk(&path, out);
        } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
            out.push(path);
        }
    }
}

fn read(data: &Path, name: &str) -> Result<Model, BakeError> {
    read_model(&data.join("meshes").join(name), &ImportOptions::default(), Reach::OwnFolder)
}

fn extent(model: &Model) -> Vec3 {
    let positions = RestPose::of(&model.mesh, model.animation.as_ref()).positions;
    let low = positions.iter().fold(Vec3::INFINITY, |a, b| a.min(*b));
    positions.iter().fold(Vec3::NEG_INFINITY, |a, b| a.max(*b)) - low
}

/// Columns: file, triangles, posed extent, images, joints, clips. Triangles and extents are those of the data's README
/// (four digits), except where a comment says otherwise. The triangles of every instance are counted.
type Row = (&'static str, usize, [f32; 3], usize, usize, usize);
const READABLE: &[Row] = &[
    ("static/Duck.glb", 4212, [1.655, 1.54, 1.153], 1, 0, 0),
    ("skinned/CesiumMan.glb", 4672, [0.312, 1.507, 1.138], 1, 19, 1),
    ("skinned/Fox.glb", 576, [25.19, 79.03, 154.7], 1, 24, 3),
    ("skinned/SimpleSkin.gltf", 8, [1.0, 2.0, 0.0], 0, 2, 1),
    ("skinned/quaternius_Alpaca.glb", 2060, [1.265, 5.427, 4.276], 0, 46, 13),
    ("skinned/quaternius_Cow.glb", 2450, [2.312, 4.587, 8.067], 0, 42, 12),
    ("skinned/quaternius_Horse.glb", 2182, [1.411, 4.834, 5.691], 0, 50, 13),
    ("skinned/quaternius_ShibaInu.glb", 1950, [1.071, 3.089, 4.165], 0, 46, 12),
    ("skinned/quaternius_Velociraptor.glb", 1248, [2.636, 6.075, 12.74], 0, 29, 6),
    ("skinned/quaternius_Wolf.glb", 1962, [1.057, 2.701, 5.272], 0, 51, 12),
    // The file has two skins of 43 joints and twelve rigid parts; the README's posed extent covers only the skinned
    // parts.
    ("compressed/RobotExpressive_quantized.glb", 3237, [3.1, 4.461, 2.685], 0, 98, 11),
    ("compressed/BoxMeshopt.glb", 12, [1.0, 1.0, 1.0], 0, 0, 0),
    ("compressed/BoxDraco/BoxDraco.gltf", 12, [1.0, 1.0, 1.0], 0, 0, 0),
    // The scene has several instances of some meshes.
    ("compressed/2CylinderEngine_draco/2CylinderEngine.gltf", 110_336, [743.4, 273.0, 268.0], 0, 0, 0),
    // The file has a glTF skin of 43 joints and a rigid weapon. The posed character's arms are down.
    ("compressed/quaternius_RedPandaAstronaut_draco.glb", 8032, [3.4, 3.147, 1.244], 1, 44, 18),
    ("morph/AnimatedMorphCube/AnimatedMorphCube.gltf", 12, [2.0, 2.0, 2.0], 0, 1, 1),
    ("morph/MorphStressTest.gltf", 2412, [4.0, 0.6, 1.0], 2, 1, 3),
    ("gltf-asset-generator/Mesh_PrimitiveMode_04.gltf", 2, [1.0, 1.0, 0.0], 0, 0, 0),
    ("gltf-asset-generator/Mesh_PrimitiveMode_06.gltf", 2, [1.0, 1.0, 0.0], 0, 0, 0),
    ("gltf-asset-generator/Mesh_PrimitiveMode_12.gltf", 2, [1.0, 1.0, 0.0], 0, 0, 0),
    ("gltf-asset-generator/Mesh_PrimitiveMode_14.gltf", 2, [1.0, 1.0, 0.0], 0, 0, 0),
    // The scene has two instances of one mesh.
    ("hard-gltf/ShapeCollection.glb", 3542, [14.5, 2.0, 2.5], 0, 0, 0),
    ("hard-gltf/assimp_BoxBadNormals-glTF-Binary/BoxBadNormals.glb", 12, [1.0, 1.0, 1.0], 0, 0, 0),
    // The README's extent includes the lines.
    ("hard-gltf/assimp_IncorrectVertexArrays/Cube.gltf", 46, [7.0, 2.0, 4.5], 0, 0, 0),
    ("hard-gltf/assimp_issue_3269/texcoord_crash.gltf", 10, [2.4, 2.4, 0.05259], 1, 0, 0),
    // The errors are in the scale of a normal texture and in the name of a scene, which the importer does not need.
    ("hard-gltf/assimp_wrongTypes/badNumber.gltf", 12, [1.0, 1.0, 1.0], 1, 0, 0),
    ("hard-gltf/assimp_wrongTypes/badString.gltf", 12, [1.0, 1.0, 1.0], 1, 0, 0),
    // The primitive names a material that does not exist; its accessor has no data.
    ("gltf-validator/mesh/unresolved_material.gltf", 1, [0.0, 0.0, 0.0], 0, 0, 0),
    ("hard-gltf/barycentric.gltf", 2, [2.0, 2.0, 0.0], 0, 0, 0),
    ("hard-gltf/bevy_faces.glb", 2077, [4.0, 4.0, 4.0], 0, 0, 0),
    ("hard-gltf/draco_SimpleSparseAccessor/SimpleSparseAccessor.gltf", 12, [6.0, 4.0, 0.0], 0, 0, 0),
    ("hard-gltf/draco_TwoSidedPlane/TwoSidedPlane.gltf", 2, [2.0, 0.0, 2.0], 1, 0, 0),
    ("hard-gltf/draco_one_face_123_mirror/one_face_123_mirror.gltf", 1, [2.0, 0.09998, 0.0], 0, 0, 0),
    ("hard-gltf/draco_sphere_texture_all/sphere_texture_all.gltf", 224, [2.0, 2.0, 2.0], 1, 0, 0),
    ("hard-gltf/trimesh_boolean.glb", 3936, [5.707, 2.5, 3.375], 0, 0, 0),
    ("hard-gltf/trimesh_mode5.gltf", 2786, [57.15, 64.54, 76.12], 0, 0, 0),
    ("hard-gltf/trimesh_monkey.glb", 968, [2.734, 1.969, 1.703], 0, 0, 0),
    ("hard-gltf/trimesh_nested.glb", 36, [1.436, 3.337, 0.5388], 0, 0, 0),
    ("hard-gltf/trimesh_no_indices_3storybuilding.glb", 72, [56.08, 9.0, 63.36], 0, 0, 0),
];

/// Rejected files: path, location of the error, and part of its reason.
const REFUSED: &[(&str, &str, &str)] = &[
    (
        "hard-gltf/assimp_IndexOutOfRange/IndexOutOfRange.gltf",
        "/meshes/0/primitives/0/indices",
        "element 0 is 255, expected less than the 24 vertices",
    ),
    (
        "hard-gltf/assimp_MissingBin/BoxTextured.gltf",
        "/buffers/0/uri",
        "names the buffer file \"BoxTextured0.bin\": it does not exist",
    ),
    (
        "hard-gltf/assimp_TestNoRootNode/NoScene.gltf",
        "/",
        "no triangles, expected at least one; the file holds nothing",
    ),
    ("hard-gltf/assimp_wrongTypes/badArray.gltf", "/meshes/0/primitives", "is an object, expected an array"),
    ("hard-gltf/trimesh_empty_nodes.glb", "/", "no triangles, expected at least one; the file has nodes: 3"),
    ("gltf-asset-generator/Mesh_PrimitiveMode_00.gltf", "/", "1 primitives contain only points"),
    ("gltf-asset-generator/Mesh_PrimitiveMode_02.gltf", "/", "no triangle"),
    ("gltf-asset-generator/Mesh_PrimitiveMode_08.gltf", "/", "no triangle"),
    ("gltf-asset-generator/Mesh_PrimitiveMode_10.gltf", "/", "no triangle"),
    ("gltf-validator/asset/1_0_version.gltf", "/asset/version", "is \"1.0\", expected 2.x"),
    ("gltf-validator/asset/min_version_valid.gltf", "/asset/minVersion", "is \"2.1\", expected 2.0"),
    ("gltf-validator/glb/chunk_too_big.glb", "byte 8", "the header says 13 bytes"),
    ("gltf-validator/glb/empty_json_chunk.glb", "byte 20", "is not valid JSON"),
    ("gltf-validator/glb/invalid_magic.glb", "byte 0", "neither GLB nor JSON nor OBJ"),
    ("gltf-validator/glb/json_and_two_buffers.glb", "byte 92", "a second BIN"),
    ("gltf-validator/glb/only_bin_chunk.glb", "byte 16", "the first chunk is BIN"),
    ("gltf-validator/glb/truncated_chunk_data.glb", "byte 8", "it is cut off"),
    ("gltf-validator/glb/two_valid_json_chunks.glb", "byte 52", "a second JSON chunk"),
    ("gltf-validator/glb/zero_length.glb", "byte 8", "the header says 0 bytes"),
    ("gltf-validator/json/empty_file.gltf", "byte 0", "the file is empty"),
    ("gltf-validator/json/invalid_object.gltf", "byte 0", "neither GLB nor JSON nor OBJ"),
    (
        "gltf-validator/mesh/indices_invalid_format.gltf",
        "/meshes/0/primitives/0/indices",
        "accessor 1 has elements of 1 x f32",
    ),
    (
        "gltf-validator/mesh/unresolved_positions.gltf",
        "/meshes/0/primitives/0/attributes/POSITION",
        "the number of accessors",
    ),
    ("gltf-validator/node/node_loop.gltf", "/nodes/0", "is its own ancestor"),
    (
        "gltf-validator/node/node_parent_override.gltf",
        "/",
        "no triangles, expected at least one; the file has nodes: 3",
    ),
    ("gltf-validator/node/unresolved_child_node.gltf", "/nodes/0/children/0", "the number of nodes"),
    (
        "gltf-validator/root/undefined_used_extensions.gltf",
        "/extensionsRequired/0",
        "KHR_extension: export the model without it",
    ),
    ("gltf-validator/scene/non_root_node.gltf", "/", "no triangles, expected at least one; the file has nodes: 2"),
    ("gltf-validator/scene/unresolved_default_scene.gltf", "/", "no triangles, expected at least one"),
    ("magnum-gltf/mesh-buffers.gltf", "/meshes/16/primitives/0", "has no `attributes`"),
    ("magnum-gltf/mesh-invalid-buffer-notfound.gltf", "/buffers/0/uri", "it is an absolute path"),
    (
        "magnum-gltf/mesh-invalid-sparse-indices.gltf",
        "/accessors/0/sparse/indices",
        "element 6 is 130, expected less than 130",
    ),
    ("magnum-gltf/scene-invalid-children-property.gltf", "/nodes/1/children", "is an object, expected an array"),
    ("magnum-gltf/scene-invalid-cycle.gltf", "/nodes/0", "is its own ancestor"),
    ("magnum-gltf/scene-invalid-node-oob.gltf", "/", "no triangles, expected at least one; the file has nodes: 7"),
    ("magnum-gltf/version-unsupported.gltf", "/asset/version", "is \"3.0\", expected 2.x"),
];

#[test]
fn readable_files_have_the_known_figures() {
    let Some(data) = data("readable_files_have_the_known_figures") else { return };
    for (name, triangles, size, images, joints, clips) in READABLE {
        let model = read(&data, name).unwrap_or_else(|e| panic!("{e}"));
        assert_sound(&model);
        assert_eq!(model.mesh.triangles.len(), *triangles, "{name}");
        let found = extent(&model);
        let near = |a: f32, b: f32| (a - b).abs() <= 6e-4 * b.max(1e-3);
        assert!(found.to_array().into_iter().zip(*size).all(|(a, b)| near(a, b)), "{name}: {found}, expected {size:?}");
        let animation = model.animation.as_ref();
        let moving = animation.map_or((0, 0), |a| (a.joints.len(), a.clips.len()));
        assert_eq!((model.images.len(), moving), (*images, (*joints, *clips)), "{name}");
    }
}

#[test]
fn broken_files_fail_where_they_are_broken() {
    let Some(data) = data("broken_files_fail_where_they_are_broken") else { return };
    for (name, place, reason) in REFUSED {
        let (found, text) = fault(read(&data, name));
        assert_eq!(found, *place, "{name}: {text}");
        assert!(text.contains(reason), "{name}: {text}");
    }
}

#[test]
fn every_gltf_test_file_is_read_or_refused_with_a_position() {
    let Some(data) = data("every_gltf_test_file_is_read_or_refused_with_a_position") else { return };
    let mut files = Vec::new();
    for folder in [
        "static",
        "skinned",
        "morph",
        "compressed",
        "hard-gltf",
        "gltf-validator",
        "gltf-asset-generator",
        "magnum-gltf",
    ] {
        let before = files.len();
        walk(&data.join("meshes").join(folder), &mut files);
        assert!(files.len() > before, "no file in {folder}");
    }
    let (mut read, mut refused) = (0, BTreeSet::new());
    for path in &files {
        match read_model(path, &ImportOptions::default(), Reach::OwnFolder) {
            Ok(model) => {
                assert_sound(&model);
                read += 1;
            }
            Err(BakeError::Input { place, reason, .. }) => {
                assert!(place.starts_with("byte ") || place.starts_with('/'), "{}: {place}", path.display());
                refused.insert((place, reason));
            }
            Err(other) => panic!("{}: expected an input error, found {other}", path.display()),
        }
    }
    println!("{} files: {read} read, {} different complaints", files.len(), refused.len());
    assert!(files.len() > 180 && read > 50 && refused.len() > 50);
}

/// Checks that the importer reads all files that the Khronos validator accepts, with the validator's triangle count.
#[test]
fn files_that_the_validator_accepts_are_read() {
    let Some(data) = data("files_that_the_validator_accepts_are_read") else { return };
    let mut files = Vec::new();
    walk(&data.join("meshes/gltf-validator"), &mut files);
    let mut compared = 0;
    for path in files {
        let report = std::fs::read(format!("{}.report.json", path.display())).unwrap();
        let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
        let triangles = report["info"]["totalTriangleCount"].as_u64().unwrap_or(0);
        if report["issues"]["numErrors"] == 0 && triangles > 0 {
            let model =
                read_model(&path, &ImportOptions::default(), Reach::OwnFolder).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(model.mesh.triangles.len() as u64, triangles, "{}", path.display());
            compared += 1;
        }
    }
    assert!(compared > 5, "{compared} files compared");
}

#[test]
fn clips_have_the_known_names_and_lengths() {
    let Some(data) = data("clips_have_the_known_names_and_lengths") else { return };
    let fox = read(&data, "skinned/Fox.glb").unwrap().animation.unwrap();
    let clips: Vec<_> = fox.clips.iter().map(|c| (c.name.as_str(), (c.duration_s * 1000.0).round())).collect();
    assert_eq!(clips, [("Survey", 3417.0), ("Walk", 708.0), ("Run", 1158.0)]);
    let man = read(&data, "skinned/CesiumMan.glb").unwrap().animation.unwrap();
    assert_eq!((man.clips[0].name.as_str(), man.clips[0].duration_s), ("clip_0", 2.0));
}

/// Checks that the triangles of the posed animals face outward. The stored meshes are a hundred times smaller than the
/// posed animals, and have different axes.
#[test]
fn closed_animals_enclose_a_positive_volume_once_posed() {
    let Some(data) = data("closed_animals_enclose_a_positive_volume_once_posed") else { return };
    for name in
        ["Fox", "CesiumMan", "quaternius_Horse", "quaternius_Alpaca", "quaternius_Velociraptor", "quaternius_Wolf"]
    {
        let model = read(&data, &format!("skinned/{name}.glb")).unwrap();
        let rest = RestPose::of(&model.mesh, model.animation.as_ref());
        let corner = |v: u32| rest.positions[v as usize].as_dvec3();
        let volume: f64 =
            model.mesh.triangles.iter().map(|[a, b, c]| corner(*a).dot(corner(*b).cross(corner(*c))) / 6.0).sum();
        let size = f64::from(extent(&model).element_product());
        assert!(volume > 0.05 * size && volume < 0.7 * size, "{name}: volume {volume} of a box of {size}");
        assert!(!model.warnings.iter().any(|w| w.contains("against")), "{:?}", model.warnings);
    }
}
