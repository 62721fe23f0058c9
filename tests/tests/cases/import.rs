//! Faults of models that must not lose the model: what is drawn, in which colour, and what the warning says.
#![allow(clippy::unwrap_used, reason = "tests")]

use crate::import::support::*;
use glam::Vec3;
use pelage_bake::io::{Reach, read_model};
use pelage_bake::stages::import::{ImportOptions, import};
use pelage_formats::meaning::{linear_to_srgb, srgb_to_linear};
use pelage_import::BakeError;
use pelage_import::mesh::{Model, RestPose};
use serde_json::{Value, json};
use std::path::Path;

const ORANGE: [u8; 3] = [230, 140, 60];
const WHITE: [u8; 3] = [255; 3];

/// Returns the sRGB-encoded base colour of a material at the first texel of its image.
fn color(model: &Model, material: usize) -> [u8; 3] {
    let material = &model.materials[material];
    let texel = material.base_color_image.map_or([255; 4], |image| *model.images[image].rgba.first_chunk().unwrap());
    [0, 1, 2].map(|i| linear_to_srgb(srgb_to_linear(texel[i]) * material.base_color[i]))
}

fn positions(model: &Model) -> Vec<Vec3> {
    RestPose::of(&model.mesh, model.animation.as_ref()).positions
}

/// Returns the names of the clips, with the number of channels of each.
fn clips(model: &Model) -> Vec<(&str, usize)> {
    let clips = model.animation.iter().flat_map(|animation| &animation.clips);
    clips.map(|clip| (clip.name.as_str(), clip.channels.len())).collect()
}

/// Imports a document with other files, by path.
fn with_files(doc: &Doc, files: &[(&str, &[u8])]) -> Model {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    let path = folder.path().join("model.glb");
    std::fs::write(&path, doc.glb()).unwrap();
    let model = read_model(&path, &ImportOptions::default(), Reach::OwnFolder).unwrap();
    assert_sound(&model);
    model
}

/// Returns a triangle with texture coordinates and a material.
fn textured(material: Value) -> Doc {
    let mut doc = Doc::new();
    let position = doc.triangle();
    let uv = doc.floats(&[0.; 6], "VEC2");
    doc.show(json!({"attributes": {"POSITION": position, "TEXCOORD_0": uv}, "material": 0}));
    doc.push("materials", material);
    doc
}

/// Adds a texture with the image; returns the index of the texture.
fn texture(doc: &mut Doc, image: Value) -> usize {
    let image = doc.push("images", image);
    doc.push("textures", json!({"source": image}))
}

fn encoded(rgb: [u8; 3], format: image::ImageFormat) -> Vec<u8> {
    let mut out = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_pixel(2, 2, image::Rgb(rgb)).write_to(&mut out, format).unwrap();
    out.into_inner()
}

fn png(rgb: [u8; 3]) -> Vec<u8> {
    encoded(rgb, image::ImageFormat::Png)
}

/// Columns: file, colour, triangles, clips with their channels, part of a warning (empty: no warning at all).
type Row = (&'static str, [u8; 3], usize, &'static [(&'static str, usize)], &'static str);
const CASES: &[Row] = &[
    ("scene_names_a_child", WHITE, 8, &[], "lists 1 nodes that are children of others, such as node 0 \"body\""),
    ("fewer_bind_matrices_than_joints", WHITE, 8, &[("Clip", 1)], "has 2 usable matrices, expected 3"),
    ("specgloss_beside_empty_pbr", ORANGE, 2, &[], ""),
    ("hidden_node", WHITE, 8, &[], "1 nodes with a mesh are hidden by KHR_node_visibility; left out"),
    ("webp_base_color", ORANGE, 2, &[], ""),
    ("texture_without_source", WHITE, 2, &[], "/textures/0: has no `source`"),
    ("base_color_image_missing", WHITE, 2, &[], "names the image file \"gone.png\": it does not exist"),
    ("base_color_image_cut_off", WHITE, 2, &[], "cannot be decoded"),
    ("backslash_in_image_uri", ORANGE, 2, &[], "\"textures\\fox.png\" does not exist; \"textures/fox.png\" is read"),
    ("channel_on_missing_node", WHITE, 8, &[("Clip", 1)], "is 99, expected less than 4, the number of nodes; left out"),
    ("interpolation_is_a_number", WHITE, 8, &[], "is 0, expected a string; left out of clip \"Clip\""),
    ("material_minus_one", WHITE, 8, &[], "material; treated as absent"),
    ("colour_only_in_emission", ORANGE, 2, &[], "its emission is used as base colour"),
];

#[test]
fn cases_of_models_are_read_as_their_list_says() {
    let Some(data) = data("cases_of_models_are_read_as_their_list_says") else { return };
    for (name, expected, triangles, channels, warning) in CASES {
        let path = data.join(format!("cases/{name}.gltf"));
        let model = read_model(&path, &ImportOptions::default(), Reach::OwnFolder).unwrap_or_else(|e| panic!("{e}"));
        assert_sound(&model);
        let found = (color(&model, 0), model.mesh.triangles.len(), clips(&model));
        assert_eq!(found, (*expected, *triangles, channels.to_vec()), "{name}: {:?}", model.warnings);
        match *warning {
            "" => assert!(model.warnings.is_empty(), "{name}: {:?}", model.warnings),
            text => assert_warns(&model, text),
        }
    }
}

/// Returns a chain of nodes, each 1 above its parent: 0 is the child of 1, 1 of 2, and so on. Node 0 has a triangle.
fn chain(nodes: usize, scene: &[usize]) -> Doc {
    let mut doc = Doc::new();
    let position = doc.triangle();
    doc.show(json!({"attributes": {"POSITION": position}}));
    doc.json["nodes"][0]["translation"] = json!([0, 0, 1]);
    for child in 0..nodes - 1 {
        doc.push("nodes", json!({"children": [child], "translation": [0, 0, 1], "name": format!("n{}", child + 1)}));
    }
    doc.push("scenes", json!({"nodes": scene}));
    doc
}

#[test]
fn nodes_whose_mesh_is_missing_are_left_out() {
    for (mesh, text) in [(json!(7), "is 7, expected less than 1, the number of meshes"), (json!("a"), "is \"a\"")] {
        let mut doc = chain(1, &[0, 1]);
        doc.push("nodes", json!({"mesh": mesh}));
        let model = doc.model();
        assert_eq!(model.mesh.triangles.len(), 1);
        assert_warns(&model, &format!("/nodes/1/mesh: {text}"));
    }
}

#[test]
fn children_listed_by_a_scene_are_drawn_once_under_parents_of_the_scene_only() {
    for (scene, height) in [
        (&[0][..], 1.0),
        (&[1], 2.0),
        (&[3], 4.0),
        // A listed ancestor is part of the scene and applies, in whatever order the nodes are listed.
        (&[0, 3], 4.0),
        (&[3, 0], 4.0),
        (&[2, 0, 1], 3.0),
        (&[0, 2, 0], 3.0),
    ] {
        let model = chain(4, scene).model();
        assert_eq!(model.mesh.triangles.len(), 1, "{scene:?}");
        assert_near(model.mesh.positions[0], [0.0, 0.0, height]);
        let told = model.warnings.iter().any(|w| w.contains("children of others"));
        assert_eq!(told, scene != [3], "{scene:?}: {:?}", model.warnings);
    }
}

#[test]
fn clips_of_parents_outside_the_scene_move_nothing() {
    let mut doc = chain(3, &[0]);
    let (input, output) = (doc.floats(&[0., 1.], "SCALAR"), doc.floats(&[0., 0., 0., 5., 0., 0.], "VEC3"));
    let channel = |node| json!({"sampler": 0, "target": {"node": node, "path": "translation"}});
    doc.push(
        "animations",
        json!({"name": "slide", "samplers": [{"input": input, "output": output}], "channels": [channel(2)]}),
    );
    assert!(doc.model().animation.is_none());
    doc.json["animations"][0]["channels"] = json!([channel(0), channel(1)]);
    let model = doc.model();
    assert_eq!((clips(&model), model.animation.as_ref().unwrap().nodes.len()), (vec![("slide", 1)], 1));
    doc.json["scenes"][0]["nodes"] = json!([0, 2]);
    assert_eq!(doc.model().animation.unwrap().nodes.len(), 3);
}

/// Checks a scene that lists all children of a large node. Linear time is needed: a quadratic search takes minutes.
#[test]
fn scenes_may_list_many_children() {
    const CHILDREN: usize = 200_000;
    let mut doc = chain(2, &[]);
    let children: Vec<usize> = (3..3 + CHILDREN).collect();
    doc.push("nodes", json!({"children": children.clone()}));
    doc.json["nodes"].as_array_mut().unwrap().extend(std::iter::repeat_n(json!({}), CHILDREN));
    let listed: Vec<usize> = [0].into_iter().chain(children).collect();
    doc.json["scenes"][0]["nodes"] = json!(listed);
    let model = doc.model();
    assert_warns(&model, "the scene lists 200001 nodes that are children of others");
    assert_near(model.mesh.positions[0], [0.0, 0.0, 1.0]);
}

#[test]
fn faulty_scenes_draw_what_they_can() {
    let mut doc = chain(2, &[1, 9]);
    let model = doc.model();
    assert_warns(&model, "/scenes/0/nodes/1: is 9, expected less than 2, the number of nodes; left out");
    assert_near(model.mesh.positions[0], [0.0, 0.0, 2.0]);
    for scene in [json!(7), json!("x"), json!(-1)] {
        doc.json["scene"] = scene;
        assert_near(doc.model().mesh.positions[0], [0.0, 0.0, 2.0]);
    }
    // A node with two parents is drawn under the first of them.
    doc.push("nodes", json!({"children": [0], "translation": [7, 0, 0]}));
    doc.json["scenes"][0]["nodes"] = json!([1, 2]);
    let model = doc.model();
    assert_warns(&model, "/nodes/2/children/0 is 0, which is also a child of node 1, expected one parent");
    assert_eq!(model.mesh.triangles.len(), 1);
    assert_near(model.mesh.positions[0], [0.0, 0.0, 2.0]);
    // Nothing remains.
    doc.json["scenes"][0]["nodes"] = json!([9]);
    assert!(doc.fault().1.contains("no triangles"));
}

/// Checks that a node and all its descendants and instances are hidden, also where the extension is required.
#[test]
fn hidden_nodes_are_left_out_with_their_children() {
    let hide = |visible: Value| json!({"KHR_node_visibility": {"visible": visible}});
    let mut doc = chain(3, &[2]);
    doc.json["extensionsRequired"] = json!(["KHR_node_visibility"]);
    doc.json["nodes"][2]["mesh"] = json!(0);
    doc.json["nodes"][1]["extensions"] = hide(json!(false));
    let model = doc.model();
    assert_warns(&model, "1 nodes with a mesh are hidden by KHR_node_visibility; left out");
    assert_eq!(positions(&model)[0], Vec3::Z);
    // The child's own flag does not show it again.
    doc.json["nodes"][0]["extensions"] = hide(json!(true));
    assert_eq!(doc.model().mesh.triangles.len(), 1);
    // A parent outside the scene does not hide its children.
    doc.json["scenes"][0]["nodes"] = json!([0]);
    assert_near(doc.model().mesh.positions[0], [0.0, 0.0, 1.0]);
    doc.json["scenes"][0]["nodes"] = json!([2]);
    for visible in [json!(null), json!(true), json!("no")] {
        doc.json["nodes"][1]["extensions"] = hide(visible.clone());
        let model = doc.model();
        assert_eq!(model.mesh.triangles.len(), 2, "{visible}");
        assert_eq!(model.warnings.len(), usize::from(visible == "no"), "{:?}", model.warnings);
    }
    doc.json["nodes"][2]["extensions"] = hide(json!(false));
    let (place, reason) = doc.fault();
    assert!(place == "/" && reason.ends_with("; 2 nodes with a mesh are hidden"), "{reason}");
}

#[test]
fn hidden_instances_are_left_out_and_hidden_joints_are_not() {
    let mut doc = chain(1, &[0]);
    let places = doc.floats(&[0., 0., 5., 0., 0., 9.], "VEC3");
    let instanced = json!({"attributes": {"TRANSLATION": places}});
    doc.push(
        "nodes",
        json!({"mesh": 0, "extensions":
        {"EXT_mesh_gpu_instancing": instanced, "KHR_node_visibility": {"visible": false}}}),
    );
    doc.json["scenes"][0]["nodes"] = json!([0, 1]);
    let model = doc.model();
    assert_eq!(model.mesh.triangles.len(), 1);
    assert_warns(&model, "1 nodes with a mesh are hidden");
    // Joints below a hidden node still move the skin of a visible one.
    doc.json["nodes"][1] = json!({"translation": [0, 0, 3], "extensions": {"KHR_node_visibility": {"visible": false}}});
    let (joints, weights) =
        (doc.accessor(&[0; 12], U8, "VEC4", 3), doc.floats(&[[1., 0., 0., 0.]; 3].concat(), "VEC4"));
    let attributes = &mut doc.json["meshes"][0]["primitives"][0]["attributes"];
    (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (json!(joints), json!(weights));
    doc.push("skins", json!({"joints": [1]}));
    doc.json["nodes"][0]["skin"] = json!(0);
    let model = doc.model();
    assert_eq!(positions(&model)[0], Vec3::new(0.0, 0.0, 3.0));
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
}

#[test]
fn animated_visibility_is_reported() {
    let mut doc = chain(2, &[1]);
    let (input, output) = (doc.floats(&[0., 1.], "SCALAR"), doc.floats(&[0., 0., 0., 5., 0., 0.], "VEC3"));
    let pointer = json!({"KHR_animation_pointer": {"pointer": "/nodes/0/extensions/KHR_node_visibility/visible"}});
    doc.push(
        "animations",
        json!({"name": "blink\u{1b}", "samplers": [{"input": input, "output": output}], "channels": [
            {"sampler": 0, "target": {"path": "pointer", "extensions": pointer}},
            {"sampler": 0, "target": {"node": 1, "path": "translation"}},
        ]}),
    );
    let model = doc.model();
    assert_warns(&model, "clip \"blink\u{fffd}\" shows or hides /nodes/0, which pelage does not support");
    assert_eq!(model.animation.unwrap().clips[0].channels.len(), 1);
}

/// Checks that the diffuse colour of specular-glossiness is used, whatever fallback is beside it.
#[test]
fn specular_glossiness_goes_before_any_fallback() {
    let orange = [230, 140, 60].map(srgb_to_linear);
    let factor = json!([orange[0], orange[1], orange[2], 1.0]);
    let gray = json!({"baseColorFactor": [0.2, 0.2, 0.2, 1], "metallicFactor": 1, "baseColorTexture": {"index": 0}});
    for fallback in [json!(null), json!({}), json!({"baseColorFactor": [0, 0, 1, 1]}), gray] {
        let with = |extension: Value| {
            let specular = json!({"KHR_materials_pbrSpecularGlossiness": extension});
            let mut doc = textured(json!({"pbrMetallicRoughness": fallback, "extensions": specular}));
            for rgb in [[9, 9, 9], ORANGE] {
                let view = doc.view(&png(rgb));
                texture(&mut doc, json!({"bufferView": view}));
            }
            doc.model()
        };
        let by_factor = with(json!({"diffuseFactor": factor}));
        assert_eq!(color(&by_factor, 0), ORANGE, "{fallback}");
        assert!(by_factor.images.is_empty(), "the image of the fallback is not opened");
        let by_image = with(json!({"diffuseTexture": {"index": 1}}));
        assert_eq!((color(&by_image, 0), by_image.images.len()), (ORANGE, 1), "{fallback}");
        // A fallback says nothing about how the material shines.
        assert_eq!((by_image.materials[0].roughness, by_image.materials[0].metallic), (None, None));
    }
}

/// Checks that WebP is read, lossless and lossy, embedded and as a file, through the extension and without it.
#[test]
fn webp_is_read() {
    let lossless = encoded(ORANGE, image::ImageFormat::WebP);
    let material = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}});
    let mut doc = textured(material);
    let view = doc.view(&lossless);
    texture(&mut doc, json!({"bufferView": view, "mimeType": "image/webp"}));
    assert_eq!(color(&doc.model(), 0), ORANGE);
    doc.json["extensionsRequired"] = json!(["EXT_texture_webp"]);
    doc.json["textures"][0] = json!({"extensions": {"EXT_texture_webp": {"source": 0}}});
    assert_eq!(color(&doc.model(), 0), ORANGE);
    // If the fallback image beside the extension is lost, the WebP replaces it.
    doc.push("images", json!({"uri": "gone.png"}));
    doc.json["textures"][0]["source"] = json!(1);
    let model = doc.model();
    assert_eq!((color(&model, 0), model.warnings.len()), (ORANGE, 0), "{:?}", model.warnings);
    doc.json["images"][0] = json!({"uri": "coat.webp"});
    assert_eq!(color(&with_files(&doc, &[("coat.webp", &lossless)]), 0), ORANGE);
    // Damaged data: cut off, flipped, or with a canvas of another size.
    doc.json["textures"][0].as_object_mut().unwrap().remove("source");
    for length in 12..lossless.len() {
        let model = with_files(&doc, &[("coat.webp", &lossless[..length])]);
        assert!(model.images.is_empty() && !model.warnings.is_empty(), "cut to {length}");
        let mut flipped = lossless.clone();
        flipped[length] ^= 0x55;
        with_files(&doc, &[("coat.webp", &flipped)]);
    }
}

/// Checks that textures that pelage does not use are not opened, and that their formats and faults do not matter.
#[test]
fn images_that_are_not_used_are_never_opened() {
    let mut doc = textured(json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 1}},
        "normalTexture": {"index": 2}, "occlusionTexture": {"index": 3}, "emissiveTexture": {"index": 1},
        "emissiveFactor": [1, 1, 1],
    }));
    let view = doc.view(&png(ORANGE));
    texture(&mut doc, json!({"bufferView": view}));
    for uri in ["metal.webp", "normal.ktx2"] {
        texture(&mut doc, json!({"uri": uri}));
    }
    doc.push("textures", json!({"extensions": {"KHR_texture_basisu": {"source": 99}}}));
    doc.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}}));
    // A second mesh with the second material is hidden.
    doc.push("meshes", json!({"primitives": [{"attributes": {"POSITION": 0}, "material": 1}]}));
    doc.push("nodes", json!({"mesh": 1, "extensions": {"KHR_node_visibility": {"visible": false}}}));
    doc.json["extensionsRequired"] = json!(["EXT_texture_webp", "KHR_texture_basisu", "KHR_node_visibility"]);
    let mut resolve = |uri: &str, _: u64| -> Result<Vec<u8>, BakeError> { panic!("{uri} was opened") };
    let model = import("m.glb", &doc.glb(), &mut resolve, &ImportOptions::default()).unwrap();
    assert_eq!((color(&model, 0), model.images.len(), model.materials.len()), (ORANGE, 1, 1));
    assert_eq!(model.warnings.len(), 1, "{:?}", model.warnings);
}

/// Checks that one lost image costs only that image: the other material keeps its own.
#[test]
fn one_lost_image_leaves_the_others() {
    let mut doc = textured(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
    doc.json["meshes"][0]["primitives"].as_array_mut().unwrap().extend([
        json!({"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 1}),
        json!({"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 2}),
    ]);
    let factor = json!([0.0, 0.0, 1.0, 1.0]);
    doc.push(
        "materials",
        json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 1}, "baseColorFactor": factor}}),
    );
    doc.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 2}}}));
    for uri in ["coat.png", "../eye.png"] {
        texture(&mut doc, json!({"uri": uri}));
    }
    doc.push("textures", json!({"source": 1}));
    let model = with_files(&doc, &[("coat.png", &png(ORANGE))]);
    assert_eq!([0, 1, 2].map(|m| color(&model, m)), [ORANGE, [0, 0, 255], WHITE]);
    assert_warns(&model, "/images/1/uri: names the image file \"../eye.png\": it leads out of the model's folder");
    assert_warns(&model, "/textures/2/source: is 1, an image that cannot be read; the colour factor alone is used");
}

/// Checks the names of files: backslashes, names that are not percent-encoded, and names that are encoded twice.
#[test]
fn misspelt_file_names_are_found() {
    for (uri, file, told) in [
        ("textures\\fox.png", "textures/fox.png", true),
        ("textures%5Cfox.png", "textures/fox.png", true),
        (".\\a\\b/fox%20coat.png", "a/b/fox coat.png", true),
        ("100%25.png", "100%.png", false),
        ("100%.png", "100%.png", false),
        ("fox%20coat.png", "fox%20coat.png", true),
        ("50%25off.png", "50%25off.png", true),
        ("fox%2520coat.png", "fox coat.png", true),
        ("fox%2520coat.png", "fox%20coat.png", false),
        ("maps\\fox%2520coat.png", "maps/fox coat.png", true),
    ] {
        let mut doc = textured(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
        texture(&mut doc, json!({"uri": uri}));
        let model = with_files(&doc, &[(file, &png(ORANGE))]);
        assert_eq!(color(&model, 0), ORANGE, "{uri}: {:?}", model.warnings);
        assert_eq!(model.warnings.len(), usize::from(told), "{uri}: {:?}", model.warnings);
        let name = Path::new(file).file_name().unwrap().to_str().unwrap();
        assert_eq!(model.inputs[1].role, "image");
        assert!(!told || model.warnings[0].contains(name), "{uri}: {:?}", model.warnings);
    }
    // Other spellings do not lead out of the folder either.
    for uri in ["..\\outside.png", "%2e%2e%5Coutside.png", "%252e%252e%252foutside.png"] {
        let mut doc = textured(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
        texture(&mut doc, json!({"uri": uri}));
        let model = with_files(&doc, &[]);
        assert_warns(&model, "leads out of the model's folder");
    }
}

/// Checks that buffers follow the same rule as images.
#[test]
fn misspelt_buffers_are_found() {
    let mut doc = Doc::new();
    let position = doc.triangle();
    doc.show(json!({"attributes": {"POSITION": position}}));
    doc.json["buffers"] = json!([{"byteLength": 36, "uri": "bin\\fox.bin"}]);
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("bin")).unwrap();
    std::fs::write(folder.path().join("bin/fox.bin"), &doc.bin).unwrap();
    let path = folder.path().join("fox.gltf");
    std::fs::write(&path, serde_json::to_vec(&doc.json).unwrap()).unwrap();
    let model = read_model(&path, &ImportOptions::default(), Reach::OwnFolder).unwrap();
    assert_warns(&model, "\"bin\\fox.bin\" does not exist; \"bin/fox.bin\" is read instead");
}

#[test]
fn minus_one_stands_for_none() {
    let mut doc = textured(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
    doc.json["nodes"][0]["skin"] = json!(-1);
    doc.json["nodes"][0]["camera"] = json!(-1.0);
    doc.json["nodes"][0]["extras"] = json!({"node": -1});
    doc.push("nodes", json!({"mesh": -1}));
    doc.push("textures", json!({"source": -1}));
    doc.json["scene"] = json!(-1);
    let model = doc.model();
    assert_warns(&model, "5 indices are -1, such as /scene; treated as absent");
    assert_warns(&model, "/textures/0: has no `source`");
    assert_eq!((color(&model, 0), model.mesh.triangles.len()), (WHITE, 1));
}

/// Checks which materials take their colour from emission: black ones that emit light.
#[test]
fn emission_colours_black_materials_only() {
    let orange = [230, 140, 60].map(srgb_to_linear);
    let with = |material: Value| {
        let mut doc = textured(material);
        for rgb in [ORANGE, [4, 4, 4]] {
            let view = doc.view(&png(rgb));
            texture(&mut doc, json!({"bufferView": view}));
        }
        let model = doc.model();
        (color(&model, 0), model.warnings.len())
    };
    let black = json!({"baseColorFactor": [0, 0, 0, 1]});
    let [one, two] = [0, 1].map(|index| json!({"index": index}));
    for (material, expected, warnings) in [
        (json!({"pbrMetallicRoughness": black, "emissiveFactor": orange}), ORANGE, 1),
        (json!({"pbrMetallicRoughness": black, "emissiveFactor": [1, 1, 1], "emissiveTexture": one}), ORANGE, 1),
        // Light that an extension strengthens keeps its colour.
        (
            json!({"pbrMetallicRoughness": black, "emissiveFactor": orange,
                "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 20}}}),
            ORANGE,
            1,
        ),
        // The base colour is black by its image.
        (json!({"pbrMetallicRoughness": {"baseColorTexture": two}, "emissiveFactor": orange}), ORANGE, 1),
        (
            json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0, 0, 0, 1]}},
                "emissiveFactor": orange}),
            ORANGE,
            1,
        ),
        // A lost emission texture leaves the factor.
        (json!({"pbrMetallicRoughness": black, "emissiveFactor": orange, "emissiveTexture": {"index": 9}}), ORANGE, 2),
        // Black on purpose, and colours with a glow.
        (json!({"pbrMetallicRoughness": black}), [0; 3], 0),
        (json!({"pbrMetallicRoughness": black, "emissiveTexture": one}), [0; 3], 0),
        (json!({"pbrMetallicRoughness": black, "emissiveFactor": [0, 0, 0]}), [0; 3], 0),
        (json!({"pbrMetallicRoughness": {"baseColorTexture": one}, "emissiveFactor": [0, 0, 1]}), ORANGE, 0),
        (json!({"emissiveFactor": [0, 0, 1]}), WHITE, 0),
    ] {
        assert_eq!(with(material.clone()), (expected, warnings), "{material}");
    }
}

#[test]
fn faulty_materials_keep_what_is_sound() {
    for (material, expected, text) in [
        (
            json!({"pbrMetallicRoughness": {"baseColorFactor": [1, 0]}}),
            WHITE,
            "has 2 numbers, expected 4; white is used",
        ),
        (json!({"alphaMode": "CLIP"}), WHITE, "is \"CLIP\", expected OPAQUE, MASK or BLEND; drawn opaque"),
        (json!({"alphaMode": "MASK", "alphaCutoff": "x"}), WHITE, "is \"x\", expected a number; drawn opaque"),
        (json!({"doubleSided": 1}), WHITE, "is 1, expected true or false; drawn one-sided"),
        (
            json!({"pbrMetallicRoughness": {"roughnessFactor": [], "baseColorFactor": [0, 0, 1, 1]}}),
            [0, 0, 255],
            "is an array of 0, expected a number; left out",
        ),
        (
            json!({"pbrMetallicRoughness": {"baseColorTexture":
                {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [1]}}}}}),
            ORANGE,
            "has 1 numbers, expected 2; TEXCOORD_0 is used without a transform",
        ),
        (
            json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": "x"}}}),
            ORANGE,
            "is \"x\", expected a whole number >= 0; TEXCOORD_0 is used without a transform",
        ),
    ] {
        let mut doc = textured(material.clone());
        let view = doc.view(&png(ORANGE));
        texture(&mut doc, json!({"bufferView": view}));
        let model = doc.model();
        assert_eq!(color(&model, 0), expected, "{material}");
        assert_warns(&model, text);
    }
}

/// Checks that an OBJ follows the same rules: a lost image, WebP, misspelt names, and colour only in emission.
#[test]
fn material_files_follow_the_same_rules() {
    let folder = tempfile::tempdir().unwrap();
    let files = [("coat.webp", encoded(ORANGE, image::ImageFormat::WebP)), ("my coat.png", png(ORANGE))];
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let [r, g, b] = ORANGE.map(srgb_to_linear);
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n";
    std::fs::write(folder.path().join("a.obj"), obj).unwrap();
    for (material, expected, text) in [
        ("map_Kd coat.webp".to_owned(), ORANGE, ""),
        (
            "map_Kd my%20coat.png".to_owned(),
            ORANGE,
            "\"my%20coat.png\" does not exist; \"my coat.png\" is read instead",
        ),
        ("Kd 0 0 1\nmap_Kd gone.png".to_owned(), [0, 0, 255], "only Kd is used"),
        (format!("Kd 0 0 0\nKe {r} {g} {b}"), ORANGE, "its emission is used as base colour"),
        ("Kd 0 0 0\nKe 1 1 1\nmap_Ke coat.webp".to_owned(), ORANGE, "its emission is used as base colour"),
        ("Kd 0 0 0\nKe 0 0 0".to_owned(), [0; 3], ""),
        ("Kd 0 0 1\nKe 1 1 1".to_owned(), [0, 0, 255], ""),
        ("Kd 0 0 0\nKe 1 1 1\nmap_Kd coat.webp".to_owned(), ORANGE, "has a black Kd and a texture; read as white"),
    ] {
        std::fs::write(folder.path().join("a.mtl"), format!("newmtl a\n{material}\n")).unwrap();
        let model = read_model(&folder.path().join("a.obj"), &ImportOptions::default(), Reach::OwnFolder).unwrap();
        assert_eq!(color(&model, 0), expected, "{material}: {:?}", model.warnings);
        match text {
            "" => assert!(model.warnings.is_empty(), "{material}: {:?}", model.warnings),
            text => assert_warns(&model, text),
        }
    }
}
