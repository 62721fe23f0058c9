//! Compares the importer with the `gltf` crate's own reader on valid files, number by number.
#![allow(clippy::unwrap_used, reason = "tests")]

use crate::import::support::*;
use glam::{DMat4, DVec3, Mat4, Vec2, Vec3};
use gltf::animation::util::ReadOutputs;
use pelage_bake::io::{Reach, read_model};
use pelage_bake::pipeline::{BakeInput, bake};
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::groom::MapImages;
use pelage_formats::meaning::posed_vertices;
use pelage_formats::{Limits, Package, Pose, Property};
use pelage_import::ImportOptions;
use std::path::Path;

#[derive(Default)]
struct GltfReading {
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
    joints: Vec<[u16; 4]>,
    weights: Vec<[f32; 4]>,
}

/// Collects nodes depth first, which is the order of the importer's parts.
fn collect_mesh(node: &gltf::Node<'_>, parent: Mat4, blob: &[u8], seen: &mut GltfReading) {
    let world = parent * Mat4::from_cols_array_2d(&node.transform().matrix());
    for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
        let reader = primitive.reader(|_| Some(blob));
        let base = seen.positions.len() as u32;
        let place = if node.skin().is_some() { Mat4::IDENTITY } else { world };
        seen.positions.extend(reader.read_positions().unwrap().map(|p| place.transform_point3(p.into())));
        let count = seen.positions.len();
        match reader.read_tex_coords(0) {
            Some(uvs) => seen.uvs.extend(uvs.into_f32().map(Vec2::from)),
            None => seen.uvs.resize(count, Vec2::ZERO),
        }
        let indices: Vec<u32> = match reader.read_indices() {
            Some(indices) => indices.into_u32().map(|i| i + base).collect(),
            None => (base..count as u32).collect(),
        };
        seen.triangles.extend(indices.as_chunks::<3>().0);
        seen.joints.extend(reader.read_joints(0).into_iter().flat_map(gltf::mesh::util::ReadJoints::into_u16));
        seen.weights.extend(reader.read_weights(0).into_iter().flat_map(gltf::mesh::util::ReadWeights::into_f32));
    }
    for child in node.children() {
        collect_mesh(&child, world, blob, seen);
    }
}

const FILES: [&str; 11] = [
    "skinned/Fox.glb",
    "skinned/CesiumMan.glb",
    "skinned/quaternius_Alpaca.glb",
    "skinned/quaternius_Cow.glb",
    "skinned/quaternius_Horse.glb",
    "skinned/quaternius_Velociraptor.glb",
    "static/Duck.glb",
    "hard-gltf/ShapeCollection.glb",
    "hard-gltf/bevy_faces.glb",
    "hard-gltf/trimesh_monkey.glb",
    "hard-gltf/trimesh_nested.glb",
];

#[test]
fn importer_and_gltf_crate_read_the_same_vertices() {
    let Some(data) = data("importer_and_gltf_crate_read_the_same_vertices") else { return };
    for name in FILES {
        let path = data.join("meshes").join(name);
        let model = read_model(&path, &ImportOptions::default(), Reach::OwnFolder).unwrap();
        let gltf = gltf::Gltf::from_slice_without_validation(&std::fs::read(&path).unwrap()).unwrap();
        let blob = gltf.blob.as_deref().unwrap();
        let mut seen = GltfReading::default();
        for node in gltf.default_scene().or(gltf.scenes().next()).unwrap().nodes() {
            collect_mesh(&node, Mat4::IDENTITY, blob, &mut seen);
        }
        let mesh = &model.mesh;
        assert_eq!(mesh.positions.len(), seen.positions.len(), "{name}");
        let size = seen.positions.iter().fold(0.0_f32, |a, p| a.max(p.length()));
        assert!(mesh.positions.iter().zip(&seen.positions).all(|(a, b)| a.abs_diff_eq(*b, 1e-5 * size)), "{name}");
        assert_eq!(mesh.uvs, seen.uvs, "{name}");
        // The importer moves the triangles of the duck's eyes to the end.
        let [mut found, mut expected] = [mesh.triangles.clone(), seen.triangles.clone()];
        found.sort_unstable();
        expected.sort_unstable();
        assert_eq!(found, expected, "{name}");
        assert_eq!(mesh.skin.len(), seen.joints.len(), "{name}");
        // The importer sorts joints by weight and replaces those of weight zero, so the total weight per joint is
        // compared.
        for ((found, joints), weights) in mesh.skin.iter().zip(&seen.joints).zip(&seen.weights) {
            let total: f32 = weights.iter().sum();
            let share = |joints: &[u16; 4], weights: &[f32; 4], joint: u16| -> f32 {
                joints.iter().zip(weights).filter(|(j, _)| **j == joint).map(|(_, w)| w).sum()
            };
            for joint in joints {
                let (a, b) = (share(&found.joints, &found.weights, *joint), share(joints, weights, *joint) / total);
                assert!((a - b).abs() < 1e-5, "{name}: joint {joint} has {a}, expected {b}");
            }
        }
    }
}

#[test]
fn importer_and_gltf_crate_read_the_same_animation_keys() {
    let Some(data) = data("importer_and_gltf_crate_read_the_same_animation_keys") else { return };
    let mut compared = 0;
    for name in FILES.iter().filter(|n| n.starts_with("skinned")) {
        let path = data.join("meshes").join(name);
        let animation = read_model(&path, &ImportOptions::default(), Reach::OwnFolder).unwrap().animation.unwrap();
        let gltf = gltf::Gltf::from_slice_without_validation(&std::fs::read(&path).unwrap()).unwrap();
        let blob = gltf.blob.as_deref().unwrap();
        for (clip, expected) in animation.clips.iter().zip(gltf.animations()) {
            assert_eq!(clip.name, expected.name().map_or(format!("clip_{}", expected.index()), str::to_owned));
            let mut channels = clip.channels.iter();
            for channel in expected.channels() {
                let target = channel.target().node();
                // The importer drops nodes that move no vertex, and several nodes may have an empty name.
                let node = target.name().unwrap_or_default();
                if !animation.nodes.iter().any(|n| n.name == node) {
                    continue;
                }
                let reader = channel.reader(|_| Some(blob));
                let (property, values): (_, Vec<f32>) = match reader.read_outputs().unwrap() {
                    ReadOutputs::Translations(v) => (Property::Translation, v.flatten().collect()),
                    ReadOutputs::Rotations(v) => (Property::Rotation, v.into_f32().flatten().collect()),
                    ReadOutputs::Scales(v) => (Property::Scale, v.flatten().collect()),
                    ReadOutputs::MorphTargetWeights(_) => continue,
                };
                let found = channels.next().unwrap();
                let found_node = animation.nodes[found.node as usize].name.as_str();
                assert_eq!((found_node, found.property), (node, property), "{name}, {}", clip.name);
                assert_eq!(found.times, reader.read_inputs().unwrap().collect::<Vec<_>>());
                assert_eq!(found.values, values);
                compared += 1;
            }
            assert_eq!(channels.next(), None, "{name}, {}", clip.name);
        }
    }
    assert!(compared > 500, "{compared} channels compared");
}

const MORPHED: [&str; 2] = ["morph/AnimatedMorphCube/AnimatedMorphCube.gltf", "morph/MorphStressTest.gltf"];

/// Reads the buffers of a `.gltf` file.
fn buffers(gltf: &gltf::Gltf, folder: &Path) -> Vec<Vec<u8>> {
    let bytes = |uri: &str| match uri.split_once("base64,") {
        Some((_, text)) => base64::Engine::decode(&base64::engine::general_purpose::STANDARD, text).unwrap(),
        None => std::fs::read(folder.join(uri)).unwrap(),
    };
    gltf.buffers()
        .map(|buffer| match buffer.source() {
            gltf::buffer::Source::Uri(uri) => bytes(uri),
            gltf::buffer::Source::Bin => panic!("no .glb is read here"),
        })
        .collect()
}

/// Returns the weights of a node's morph targets at a time of a clip, interpolated linearly between keys.
fn weights_at(node: &gltf::Node<'_>, clip: &gltf::Animation<'_>, time_s: f64, buffers: &[Vec<u8>]) -> Vec<f64> {
    let own = node.weights().or(node.mesh().and_then(|mesh| mesh.weights())).unwrap_or_default();
    let mut weights: Vec<f64> = own.iter().map(|w| f64::from(*w)).collect();
    for channel in clip.channels().filter(|channel| channel.target().node().index() == node.index()) {
        let reader = channel.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
        let Some(ReadOutputs::MorphTargetWeights(values)) = reader.read_outputs() else { continue };
        assert_eq!(channel.sampler().interpolation(), gltf::animation::Interpolation::Linear);
        let times: Vec<f64> = reader.read_inputs().unwrap().map(f64::from).collect();
        let values: Vec<f64> = values.into_f32().map(f64::from).collect();
        let count = values.len() / times.len();
        let time_s = time_s.clamp(times[0], times[times.len() - 1]);
        let from = times.iter().rposition(|key| *key <= time_s).unwrap().min(times.len() - 2);
        let share = (time_s - times[from]) / (times[from + 1] - times[from]);
        let at = |key: usize, target: usize| values[key * count + target];
        weights = (0..count).map(|t| at(from, t) * (1.0 - share) + at(from + 1, t) * share).collect();
    }
    weights
}

/// Computes the morphed vertex positions of a file in double precision.
fn morphed_positions(
    node: &gltf::Node<'_>,
    parent: DMat4,
    weights: &dyn Fn(&gltf::Node<'_>) -> Vec<f64>,
    buffers: &[Vec<u8>],
) -> Vec<DVec3> {
    let world = parent * Mat4::from_cols_array_2d(&node.transform().matrix()).as_dmat4();
    let mut found = Vec::new();
    let weights_here = weights(node);
    for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
        let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
        let vector = |v: [f32; 3]| Vec3::from(v).as_dvec3();
        let mut positions: Vec<DVec3> = reader.read_positions().unwrap().map(vector).collect();
        for ((moves, _, _), weight) in reader.read_morph_targets().zip(&weights_here) {
            positions.iter_mut().zip(moves.unwrap()).for_each(|(p, d)| *p += vector(d) * weight);
        }
        found.extend(positions.iter().map(|p| world.transform_point3(*p)));
    }
    found.extend(node.children().flat_map(|child| morphed_positions(&child, world, weights, buffers)));
    found
}

/// Checks that a package poses morph targets as the glTF file does in double precision. Every vertex of the package
/// must be a vertex of the file, and every vertex of the file one of the package. Normals are not compared, because the
/// fur has its own normals, which are smooth over hard edges.
#[test]
fn morphed_package_matches_its_gltf_file() {
    let Some(data) = data("morphed_package_matches_its_gltf_file") else { return };
    let mut worst: f64 = 0.0;
    for name in MORPHED {
        let path = data.join("meshes").join(name);
        let model = read_model(&path, &ImportOptions::default(), Reach::OwnFolder).unwrap();
        let text = "[hair]\ncoat = \"natural\"\nstyle = \"straight\"\ndensity = 10\n[surface]\nrounded = false\n";
        let recipe = Recipe::parse_recorded("test", text).unwrap();
        let baked = bake(&BakeInput::new(name, name, &recipe, &MapImages::default()), &model, &mut |_| ()).unwrap();
        let package = Package::open(&baked.package, &Limits::default()).unwrap();
        let (mesh, animation) = (package.mesh().unwrap().unwrap(), package.animation().unwrap().unwrap());
        let morphs = package.morphs().unwrap().unwrap();
        let gltf = gltf::Gltf::from_slice_without_validation(&std::fs::read(&path).unwrap()).unwrap();
        let buffers = buffers(&gltf, path.parent().unwrap());
        for (number, clip) in gltf.animations().enumerate() {
            for step in 0..4 {
                let time_s = animation.clips[number].duration_s * (0.1 + 0.25 * step as f32);
                let mut pose = Pose::default();
                pose.sample(&animation, Some(number), time_s);
                let weights = |node: &gltf::Node<'_>| weights_at(node, &clip, f64::from(time_s), &buffers);
                let roots = gltf.default_scene().unwrap().nodes();
                let expected: Vec<DVec3> =
                    roots.flat_map(|node| morphed_positions(&node, DMat4::IDENTITY, &weights, &buffers)).collect();
                let size = expected.iter().fold(0.0_f64, |all, p| all.max(p.length()));
                let posed: Vec<DVec3> = posed_vertices(&mesh, Some(&morphs), &pose)
                    .inspect(|v| assert!((Vec3::from(v.normal).length() - 1.0).abs() < 1e-4, "{name}: {v:?}"))
                    .map(|v| Vec3::from(v.position).as_dvec3())
                    .collect();
                for (of, among) in [(&posed, &expected), (&expected, &posed)] {
                    let nearest = |a: &DVec3| among.iter().map(|b| a.distance(*b)).fold(f64::INFINITY, f64::min);
                    let off = of.iter().map(nearest).fold(0.0, f64::max) / size;
                    assert!(off < 1e-5, "{name}, clip {number} at {time_s} s: off by {off} of the model's size");
                    worst = worst.max(off);
                }
            }
        }
    }
    println!("vertices are off by {worst:.1e} of the size at most");
}
