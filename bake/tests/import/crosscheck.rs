//! A second opinion: what the `gltf` crate's own reader finds in sound files, number by number.
#![allow(clippy::unwrap_used, reason = "tests")]

use crate::support::*;
use glam::{Mat4, Vec2, Vec3};
use gltf::animation::util::ReadOutputs;
use pelage_bake::io::{Reach, read_model};
use pelage_bake::stages::import::ImportOptions;
use pelage_formats::Property;

#[derive(Default)]
struct Seen {
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
    joints: Vec<[u16; 4]>,
    weights: Vec<[f32; 4]>,
}

/// Depth first, as the importer lists parts.
fn gather(node: &gltf::Node<'_>, parent: Mat4, blob: &[u8], seen: &mut Seen) {
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
        gather(&child, world, blob, seen);
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
fn both_readers_see_the_same_vertices() {
    let Some(data) = data("both_readers_see_the_same_vertices") else { return };
    for name in FILES {
        let path = data.join("meshes").join(name);
        let model = read_model(&path, &ImportOptions::default(), Reach::OwnFolder).unwrap();
        let gltf = gltf::Gltf::from_slice_without_validation(&std::fs::read(&path).unwrap()).unwrap();
        let blob = gltf.blob.as_deref().unwrap();
        let mut seen = Seen::default();
        for node in gltf.default_scene().or(gltf.scenes().next()).unwrap().nodes() {
            gather(&node, Mat4::IDENTITY, blob, &mut seen);
        }
        let mesh = &model.mesh;
        assert_eq!(mesh.positions.len(), seen.positions.len(), "{name}");
        let size = seen.positions.iter().fold(0.0_f32, |a, p| a.max(p.length()));
        assert!(mesh.positions.iter().zip(&seen.positions).all(|(a, b)| a.abs_diff_eq(*b, 1e-5 * size)), "{name}");
        assert_eq!(mesh.uvs, seen.uvs, "{name}");
        assert_eq!(mesh.triangles, seen.triangles, "{name}");
        assert_eq!(mesh.skin.len(), seen.joints.len(), "{name}");
        // The importer sorts by weight and lists joints of weight zero as 0, so what counts is each joint's share.
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
fn both_readers_see_the_same_keys() {
    let Some(data) = data("both_readers_see_the_same_keys") else { return };
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
                // Nodes that move no vertex are dropped; several may share the empty name.
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
