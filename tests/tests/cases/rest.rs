//! Parts that are hidden at rest and shown by a clip, models that look along −z, and pictures that show nothing.
#![allow(clippy::unwrap_used, reason = "tests")]

use glam::Vec3;
use pelage_bake::io::{Reach, read_model};
use pelage_bake::pipeline::{self, BakeInput};
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::groom::{MapImages, find_furred_materials};
use pelage_bake::stages::import::{ImportOptions, import};
use pelage_bake::strands::{PosedMesh, grow_groups};
use pelage_formats::{ClipLayer, Limits, Package};
use pelage_import::mesh::{Model, RestPose};
use pelage_needs::data;
use pelage_tests::binary::Sandbox;
use pelage_tests::gpu::gpu;
use serde_json::{Value, json};
use std::path::Path;

fn read(data: &Path, name: &str) -> Model {
    read_model(&data.join("cases").join(name), &ImportOptions::default(), Reach::OwnFolder).unwrap()
}

/// Bakes a model with a short hair of few layers. Returns the package and the warnings.
fn bake(model: &Model) -> (Vec<u8>, Vec<String>) {
    bake_with(model, "")
}

fn bake_with(model: &Model, recipe: &str) -> (Vec<u8>, Vec<String>) {
    let mut recipe = Recipe::parse("r.toml", recipe).unwrap();
    let small = ["slice.layers=4", "slice.tile_texels=16", "hair.density=20", "visibility.enabled=false"];
    for set in small.into_iter().chain(["ink.enabled=false", "pack.shell_format=rgba8", "groom.by_body=0"]) {
        recipe.set(set).unwrap();
    }
    let images = MapImages::default();
    let baked = pipeline::bake(&BakeInput::new("m", "m", &recipe, &images), model, &mut |_| ()).unwrap();
    (baked.package, baked.warnings)
}

/// Triangles of a posed package on one side of a plane.
#[derive(Clone, Copy, Debug, Default)]
struct Side {
    triangles: usize,
    /// Area in the pose, square metres.
    area: f64,
    /// Area in hair tiles.
    tiles: f64,
    /// Least and greatest height of the fur, metres.
    fur: [f64; 2],
}

/// Measures a package at `time_s` of a clip, or at rest: first where `is_prop` holds for the centre of a triangle, then
/// elsewhere.
fn sides(package: &[u8], clip: Option<(usize, f32)>, is_prop: impl Fn(Vec3) -> bool) -> [Side; 2] {
    let package = Package::open(package, &Limits::default()).unwrap();
    let layer = clip.map(|(clip, time_s)| ClipLayer { clip: Some(clip), time_s, share: 1.0 });
    let mesh = PosedMesh::posed("m", &package, layer.as_slice()).unwrap();
    let mut sides = [Side { fur: [f64::INFINITY, 0.0], ..Side::default() }; 2];
    for corners in (0..mesh.triangles.len()).map(|triangle| mesh.corners(triangle)) {
        let [a, b, c] = corners.map(|corner| corner.position_ws);
        let [p, q, r] = corners.map(|corner| corner.tile_uv);
        let side = &mut sides[usize::from(!is_prop(((a + b + c) / 3.0).as_vec3()))];
        side.triangles += 1;
        side.area += (b - a).cross(c - a).length() / 2.0;
        side.tiles += (q - p).perp_dot(r - p).abs() / 2.0;
        for corner in corners {
            side.fur = [side.fur[0].min(corner.fur_height_m), side.fur[1].max(corner.fur_height_m)];
        }
    }
    sides
}

/// Checks that a prop hidden at rest has as much fur per area as the body at `time_s` of a clip, and none at rest.
fn check_shown(package: &[u8], triangles: usize, clip: usize, time_s: f32, is_prop: impl Fn(Vec3) -> bool + Copy) {
    let [prop, body] = sides(package, Some((clip, time_s)), is_prop);
    assert_eq!([prop.triangles, body.triangles], [triangles; 2], "{prop:?} {body:?}");
    assert!(prop.fur[0] > 0.0 && (prop.fur[1] / body.fur[1] - 1.0).abs() < 0.5, "{prop:?} {body:?}");
    let density = |side: Side| side.tiles / side.area;
    assert!((density(prop) / density(body) - 1.0).abs() < 0.1, "{prop:?} {body:?}");
    let [hidden, _] = sides(package, None, is_prop);
    assert!(hidden.area < 1e-9 && hidden.fur[1] == 0.0, "nothing stands where it is hidden: {hidden:?}");
}

#[test]
fn what_a_clip_unhides_by_scale_has_fur() {
    let Some(data) = data("what_a_clip_unhides_by_scale_has_fur") else { return };
    for (name, triangles) in [("joint_scale0_at_rest.gltf", 2), ("node_scale0_at_rest.gltf", 8)] {
        let model = read(&data, name);
        let (package, warnings) = bake(&model);
        assert!(warnings.iter().all(|w| !w.contains("without area")), "{name}: {warnings:?}");
        let prop = |p: Vec3| if name.starts_with("joint") { p.y > 1.0 } else { p.x < 0.6 };
        check_shown(&package, triangles, 0, 0.999, prop);
    }
}

/// Animation of a node in a clip: node, and time and value of each key. The value is a uniform scale, or the weight of
/// the morph target if the node's mesh has one.
type Keys<'a> = (usize, &'a [(f32, f32)]);

/// Imports a document of squares with edges of 1 m.
///
/// * `nodes`: the nodes; `{"mesh": 0}` shows a square from the origin along +x and +y. Mesh 1 is like it with the
///   material `prop`. Meshes 2 and 3 are smaller by the factors 0 and 0.001, and their morph target enlarges them to
///   the square. Mesh 4 is the square, and its target makes it smaller by 0.001; mesh 5 does so at rest. The target of
///   mesh 6 lifts a corner of the square
/// * `clips`: each with what it animates
fn squares(nodes: &Value, clips: &[&[Keys<'_>]]) -> Model {
    squares_of(&json!({}), nodes, clips)
}

/// Imports the document of [`squares`] with further members of its root.
fn squares_of(root: &Value, nodes: &Value, clips: &[&[Keys<'_>]]) -> Model {
    let (document, bytes) = squares_document(root, nodes, clips);
    let text = document.to_string();
    import("m.gltf", text.as_bytes(), &mut |_: &str, _: u64| Ok(bytes.clone()), &ImportOptions::default()).unwrap()
}

/// Returns the document of [`squares_of`], and its buffer, `b.bin`.
fn squares_document(root: &Value, nodes: &Value, clips: &[&[Keys<'_>]]) -> (Value, Vec<u8>) {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0_f32]];
    let mut bytes: Vec<u8> = corners.iter().flat_map(|[x, y]| [*x, *y, 0.0]).flat_map(f32::to_le_bytes).collect();
    let mut views = vec![json!({"buffer": 0, "byteOffset": 0, "byteLength": 48})];
    let mut accessors = vec![json!({"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"})];
    let mut add = |kind: &str, count: usize, component: u32, data: Vec<u8>| {
        views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": data.len()}));
        accessors
            .push(json!({"bufferView": views.len() - 1, "componentType": component, "count": count, "type": kind}));
        bytes.extend(data);
        accessors.len() - 1
    };
    let reals = |values: Vec<f32>| values.into_iter().flat_map(f32::to_le_bytes).collect::<Vec<u8>>();
    let indices = add("SCALAR", 6, 5125, [0u32, 1, 2, 0, 2, 3].into_iter().flat_map(u32::to_le_bytes).collect());
    let corner = |[x, y]: [f32; 2], size: f32| [0.3 + size * (x - 0.3), 0.4 + size * (y - 0.4), 0.0];
    let mut shape = |of: &dyn Fn([f32; 2]) -> [f32; 3]| add("VEC3", 4, 5126, reals(corners.map(of).concat()));
    let sized = [0.0, 0.001].map(|size| shape(&|p| corner(p, size)));
    let grown = [0.0, 0.001].map(|size| shape(&|p| [0, 1, 2].map(|k| corner(p, 1.0)[k] - corner(p, size)[k])));
    let shrunk = shape(&|p| [0, 1, 2].map(|k| corner(p, 0.001)[k] - corner(p, 1.0)[k]));
    let lifted = shape(&|p| if p == [1.0; 2] { [0.0, 0.0, 0.2] } else { [0.0; 3] });
    let mesh = |material: Option<u32>, position: usize, target: Option<usize>, weight: f32| {
        let mut primitive = json!({"attributes": {"POSITION": position}, "indices": indices});
        material.into_iter().for_each(|material| primitive["material"] = json!(material));
        let Some(target) = target else { return json!({"primitives": [primitive]}) };
        primitive["targets"] = json!([{"POSITION": target}]);
        json!({"primitives": [primitive], "weights": [weight]})
    };
    let meshes = json!([
        mesh(None, 0, None, 0.0),
        mesh(Some(0), 0, None, 0.0),
        mesh(None, sized[0], Some(grown[0]), 0.0),
        mesh(Some(0), sized[1], Some(grown[1]), 0.0),
        mesh(None, 0, Some(shrunk), 0.0),
        mesh(None, 0, Some(shrunk), 1.0),
        mesh(None, 0, Some(lifted), 0.0),
    ]);
    let mut animations = Vec::new();
    for clip in clips {
        let (mut channels, mut samplers) = (Vec::new(), Vec::new());
        for (node, keys) in *clip {
            let input = add("SCALAR", keys.len(), 5126, reals(keys.iter().map(|key| key.0).collect()));
            let morphs = nodes[*node]["mesh"].as_u64().is_some_and(|mesh| mesh > 1);
            let (kind, path, width) = if morphs { ("SCALAR", "weights", 1) } else { ("VEC3", "scale", 3) };
            let values = keys.iter().flat_map(|key| std::iter::repeat_n(key.1, width)).collect();
            let output = add(kind, keys.len(), 5126, reals(values));
            channels.push(json!({"sampler": samplers.len(), "target": {"node": node, "path": path}}));
            samplers.push(json!({"input": input, "output": output}));
        }
        animations.push(json!({"channels": channels, "samplers": samplers}));
    }
    let mut document = json!({
        "asset": {"version": "2.0"},
        "nodes": nodes,
        "meshes": meshes,
        "materials": [{"name": "prop"}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"uri": "b.bin", "byteLength": bytes.len()}],
    });
    if !animations.is_empty() {
        document["animations"] = Value::Array(animations);
    }
    document.as_object_mut().unwrap().extend(root.as_object().unwrap().clone());
    (document, bytes)
}

fn body() -> Value {
    json!({"mesh": 0, "name": "body", "translation": [2.0, 0.0, 0.0]})
}

const SHOWN: &[(f32, f32)] = &[(0.0, 0.0), (1.0, 1.0)];

#[test]
fn props_hidden_at_rest_are_measured_where_a_clip_shows_them() {
    let prop = |p: Vec3| p.x < 1.5;
    for scale in [0.0, 0.001, 0.01] {
        let nodes = json!([{"mesh": 0, "scale": [scale, scale, scale]}, body()]);
        check_shown(&bake(&squares(&nodes, &[&[(0, SHOWN)]])).0, 2, 0, 1.0, prop);
        // The second clip shows it, the first keeps it hidden.
        let hidden = [(0.0, scale), (1.0, scale)];
        check_shown(&bake(&squares(&nodes, &[&[(0, &hidden)], &[(0, SHOWN)]])).0, 2, 1, 1.0, prop);
        // A clip shows it only in between.
        let between = [(0.0, scale), (1.0, 1.0), (2.0, scale)];
        check_shown(&bake(&squares(&nodes, &[&[(0, &between)]])).0, 2, 0, 1.0, prop);
        let nested = json!([
            {"scale": [scale, scale, scale], "children": [1]},
            {"mesh": 0, "scale": [scale, scale, scale]},
            body(),
        ]);
        check_shown(&bake(&squares(&nested, &[&[(0, SHOWN), (1, SHOWN)]])).0, 2, 0, 1.0, prop);
    }
}

#[test]
fn props_hidden_by_morph_targets_are_measured_where_a_clip_shows_them() {
    let prop = |p: Vec3| p.x < 1.5;
    for mesh in [2, 3] {
        let nodes = json!([{"mesh": mesh}, body()]);
        check_shown(&bake(&squares(&nodes, &[&[(0, SHOWN)]])).0, 2, 0, 1.0, prop);
        // The second clip shows it only in between, the first keeps it hidden.
        let between = [(0.0, 0.0), (1.0, 1.0), (2.0, 0.0)];
        check_shown(&bake(&squares(&nodes, &[&[(0, &[(0.0, 0.0)])], &[(0, &between)]])).0, 2, 1, 1.0, prop);
    }
    let nodes = json!([{"mesh": 5}, body()]);
    check_shown(&bake(&squares(&nodes, &[&[(0, &[(0.0, 1.0), (1.0, 0.0)])]])).0, 2, 0, 1.0, prop);
    // A prop that is visible at rest has no hair where a clip hides it.
    let package = bake(&squares(&json!([{"mesh": 4}]), &[&[(0, SHOWN)]])).0;
    let [[shown, _], [hidden, _]] = [None, Some((0, 1.0))].map(|time| sides(&package, time, prop));
    assert!(shown.fur[0] > 0.0 && hidden.fur[1] == 0.0, "{shown:?} {hidden:?}");
}

#[test]
fn surface_that_morph_targets_only_bend_is_measured_at_rest() {
    // Without a clip that shows it, hidden surface has no shape to be measured in.
    for (mesh, clips) in [(6, &[&[(0, SHOWN)][..]][..]), (4, &[&[(0, SHOWN)][..]]), (3, &[])] {
        let model = squares(&json!([{"mesh": mesh}, body()]), clips);
        assert!(model.morph_rows.0.iter().flatten().all(|delta| delta.hidden_at.is_none()), "{mesh}");
        let positions = RestPose::of(&model.mesh, model.animation.as_ref()).positions;
        let size = if mesh == 3 { 0.001 } else { 1.0 };
        assert!((positions[1].x - positions[0].x - size).abs() < 1e-6, "{mesh}: {positions:?}");
    }
}

/// Recipe of guided hair on the material `prop`.
const GUIDED: &str =
    "[[strands.group]]\nname = \"mane\"\nmaterial = \"prop\"\nguides = 20\nhairs = 400\nlength_m = 0.3\n";

#[test]
fn guided_hair_grows_on_props_hidden_at_rest_and_is_hidden_with_them() {
    let zero = json!([{"mesh": 1, "scale": [0, 0, 0]}, body()]);
    for nodes in [zero, json!([{"mesh": 3}, body()])] {
        let package = bake_with(&squares(&nodes, &[&[(0, SHOWN)]]), GUIDED).0;
        let package = Package::open(&package, &Limits::default()).unwrap();
        let groups = package.hair_groups().unwrap();
        for time_s in [0.0, 1.0] {
            let layer = ClipLayer { clip: Some(0), time_s, share: 1.0 };
            let curves = grow_groups(&groups, &PosedMesh::posed("m", &package, &[layer]).unwrap());
            assert_eq!(curves.len(), 400);
            for hair in 0..curves.len() {
                let points: Vec<Vec3> = curves.strand(hair).iter().map(|point| point.position_ws).collect();
                let length = points.windows(2).map(|ends| ends[0].distance(ends[1])).sum::<f32>();
                let expected = if time_s > 0.0 { 0.1..=0.5 } else { 0.0..=1e-6 };
                assert!(expected.contains(&length), "{length} m long at {time_s} s");
                assert!((-1e-5..=1.0 + 1e-5).contains(&points[0].x), "{} is not on the prop", points[0]);
            }
            let spread =
                |of: fn(f32, f32) -> f32| (0..400).map(|hair| curves.strand(hair)[0].position_ws.x).fold(0.5, of);
            assert_eq!(spread(f32::max) - spread(f32::min) > 0.9, time_s > 0.0, "the roots cover the prop");
        }
    }
}

#[test]
fn pictures_show_hair_of_props_only_where_a_clip_shows_them() {
    let name = "pictures_show_hair_of_props_only_where_a_clip_shows_them";
    let Some(_) = gpu(name) else { return };
    let sandbox = Sandbox::new();
    let (document, bytes) = squares_document(&json!({}), &json!([{"mesh": 3}, body()]), &[&[(0, SHOWN)]]);
    sandbox.write("m.gltf", document.to_string());
    sandbox.write("b.bin", bytes);
    let rows = ["[slice]", "layers = 4", "tile_texels = 16", "[groom]", "by_body = 0"].join("\n");
    let picture = |recipe: &str, time: &str| {
        sandbox.write("r.toml", recipe);
        let bake = ["bake", "m.gltf", "-o", "m.pelage", "--recipe", "r.toml"];
        let render = ["render", "m.pelage", "-o", "p.png", "--size=96x64", "--camera=0.5,0.5,3/0.5,0.5,0/25"];
        for args in [&bake[..], &[&render[..], &["--clip=clip_0", "--time", time]].concat()] {
            let run = sandbox.run(args);
            assert_eq!(run.code, Some(0), "{run:?}");
        }
        sandbox.read("p.png")
    };
    let bare = format!("[model]\nbare = [\"prop\"]\n{rows}\n");
    let guided = format!("{bare}{GUIDED}");
    let furred = format!("{rows}\n");
    let [hidden, shown] = ["0", "0.999"].map(|time| picture(&bare, time));
    for (hair, recipe) in [("guided hair", guided), ("fur", furred)] {
        assert!(picture(&recipe, "0") == hidden, "{hair} is hidden at rest");
        assert!(picture(&recipe, "0.999") != shown, "{hair} is shown by the clip");
    }
}

#[test]
fn parts_that_are_never_shown_are_left_out_and_reported() {
    let nodes = json!([{"mesh": 0, "scale": [0, 0, 0]}, body()]);
    let grown = [(0.0, 1.0), (1.0, 1.5)];
    for clips in [&[][..], &[&[(1, &grown[..])][..]]] {
        let (package, warnings) = bake(&squares(&nodes, clips));
        let [prop, body] = sides(&package, None, |p| p.x < 1.5);
        assert_eq!([prop.triangles, body.triangles], [0, 2]);
        assert!(warnings.iter().any(|w| w.contains("2 triangles without area dropped")), "{warnings:?}");
    }
}

#[test]
fn a_model_that_is_small_as_a_whole_at_rest_keeps_its_size() {
    let nodes = json!([{"mesh": 0, "scale": [0.001, 0.001, 0.001]}]);
    let model = squares(&nodes, &[&[(0, SHOWN)]]);
    let extent = |model: &Model| {
        let positions = RestPose::of(&model.mesh, model.animation.as_ref()).positions;
        positions.iter().fold(0.0_f32, |a, p| a.max(p.x))
    };
    assert_eq!(extent(&model), 0.001);
    // A model that is nothing at rest is measured where it is shown.
    let nodes = json!([{"mesh": 0, "scale": [0, 0, 0]}]);
    assert_eq!(extent(&squares(&nodes, &[&[(0, &[(0.0, 0.0), (1.0, 2.0)])]])), 2.0);
}

#[test]
fn vrm_0_models_are_turned_to_look_along_plus_z() {
    let Some(data) = data("vrm_0_models_are_turned_to_look_along_plus_z") else { return };
    let model = read(&data, "vrm0_faces_minus_z.gltf");
    let is_dark = |color: &[u8; 4]| color[1] < 100;
    // Faces without normals are flat, so that each of the four has a vertex of its own at the nose.
    let noses = model.mesh.colors.iter().zip(&model.mesh.positions).filter(|(color, _)| is_dark(color));
    let heights: Vec<f32> = noses.map(|(_, position)| position.z).collect();
    assert_eq!(heights, [1.4; 4], "the nose");
    assert!(model.warnings.iter().any(|w| w.contains("VRM 0.x") && w.contains("turned")), "{:?}", model.warnings);
    // Models of other kinds are not turned.
    let nodes = json!([{"mesh": 0, "translation": [0.0, 0.0, -1.0]}]);
    for (root, expected) in [
        (json!({}), -1.0),
        (json!({"extensionsUsed": ["VRM"]}), 1.0),
        (json!({"extensionsUsed": ["VRM"], "extensionsRequired": ["VRM"], "extensions": {"VRM": {}}}), 1.0),
        (json!({"extensionsUsed": ["VRMC_vrm"], "extensions": {"VRMC_vrm": {"specVersion": "1.0"}}}), -1.0),
    ] {
        for clips in [&[][..], &[&[(0, SHOWN)][..]]] {
            let model = squares_of(&root, &nodes, clips);
            let position = RestPose::of(&model.mesh, model.animation.as_ref()).positions[1];
            assert_eq!(position, Vec3::new(-expected, 0.0, expected), "{root}");
            assert_eq!(model.warnings.iter().any(|w| w.contains("VRM")), expected > 0.0, "{:?}", model.warnings);
        }
    }
}

/// Renames all materials of a binary glTF as Blender names new ones.
fn without_material_names(glb: &[u8]) -> Vec<u8> {
    let length = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    let (json, rest) = glb[20..].split_at(length(12));
    let mut document: Value = serde_json::from_slice(json).unwrap();
    for (number, material) in document["materials"].as_array_mut().unwrap().iter_mut().enumerate() {
        material["name"] = json!(format!("Material.{number:03}"));
    }
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = 20 + json.len() + rest.len();
    let sizes = [total as u32, json.len() as u32].map(u32::to_le_bytes);
    [&glb[..8], &sizes[0], &sizes[1], &glb[16..20], &json, rest].concat()
}

#[test]
fn eyes_and_noses_of_animals_without_names_are_bare() {
    let Some(data) = data("eyes_and_noses_of_animals_without_names_are_bare") else { return };
    for (animal, bare) in [
        ("Wolf", &["Material.002/eyes", "Material.003/nose"][..]),
        (
            "ShibaInu",
            &[
                "Material.002/eye rims",
                "Material.003/eyes",
                "Material.004/eyes",
                "Material.005/eyes",
                "Material.002/nose",
            ],
        ),
        ("Alpaca", &["Material.005/eyes", "Material.006/eyes"]),
        ("Cow", &["Material.004/eyes", "Material.005/eyes"]),
        ("Velociraptor", &["Material.002/claws"]),
    ] {
        let bytes = std::fs::read(data.join(format!("meshes/skinned/quaternius_{animal}.glb"))).unwrap();
        let mut no_files = |uri: &str, _: u64| panic!("the model names the file {uri}");
        let bytes = without_material_names(&bytes);
        let model = import("m.glb", &bytes, &mut no_files, &ImportOptions::default()).unwrap();
        let rest = RestPose::of(&model.mesh, model.animation.as_ref());
        let found = find_furred_materials(&model, &rest, None, &mut Vec::new());
        assert_eq!(found.bare, bare, "{animal}: {:?}", found.decision);
    }
}

#[test]
fn model_bare_takes_nodes_and_joints_and_lists_their_names() {
    let nodes = json!([{"mesh": 0, "name": "Gizmo"}, body()]);
    let still = squares(&nodes, &[]);
    let mut recipe = Recipe::default();
    for (list, bare, warned) in [
        ("[\"giz*\"]", [false, true], None),
        ("[\"Saddle\"]", [true, true], Some("\"Saddle\" matches no material; the model has [\"\"], the nodes")),
    ] {
        recipe.set(&format!("model.bare={list}")).unwrap();
        let images = MapImages::default();
        let laid = pipeline::lay_out_model(&BakeInput::new("m", "m", &recipe, &images), &still).unwrap();
        let mut furred: Vec<bool> = laid.surface.mesh.parts.iter().map(|part| laid.furred[part.material]).collect();
        furred.sort_unstable();
        assert_eq!(furred, bare, "{list}");
        let warns = |text: &&str| laid.warnings.iter().any(|w| w.contains(*text) && w.contains("\"Gizmo\""));
        assert!(warned.iter().all(warns), "{:?}", laid.warnings);
        assert_eq!(laid.warnings.iter().any(|w| w.contains("model.bare")), warned.is_some(), "{:?}", laid.warnings);
    }
}

#[test]
fn empty_pictures_are_reported_with_a_reason() {
    let name = "empty_pictures_are_reported_with_a_reason";
    let (Some(data), Some(_)) = (data("empty_pictures_are_reported_with_a_reason"), gpu(name)) else { return };
    let sandbox = Sandbox::new();
    let model = data.join("cases/one_sided_plane_looks_down.gltf").display().to_string();
    sandbox.fixture(&[&model[..], "-o", "m.pelage", "--set=slice.layers=4", "--set=slice.tile_texels=16"]);
    let size = ["--size", "64x64"];
    for (command, more, expected) in [
        ("render", &["--style", "bare"][..], "warning: the picture shows nothing: the camera sees only back faces"),
        (
            "reference",
            &["--style", "bare", "--samples", "1"],
            "warning: the picture shows nothing: the camera sees only back faces",
        ),
        ("render", &["--camera", "0,0,9/0,0,20/40"], "no surface is in front of the camera"),
    ] {
        let run = sandbox.run(&[&[command, "m.pelage", "-o", "p.png"], &size[..], more].concat());
        assert_eq!(run.code, Some(0), "{run:?}");
        assert!(run.stderr.contains(expected), "{command} {more:?}: {}", run.stderr);
    }
    let seen = sandbox.run(&[&["render", "m.pelage", "-o", "p.png", "--orbit=0,-60"], &size[..]].concat());
    assert!(seen.code == Some(0) && !seen.stderr.contains("shows nothing"), "{seen:?}");
}
