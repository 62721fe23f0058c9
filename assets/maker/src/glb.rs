//! A small glTF 2.0 binary writer. It supports one mesh of several primitives, at most one skin, and clips with linear
//! or cubic-spline interpolation.

use anyhow::{Context as _, ensure};
use glam::{DVec3, DVec4};
use pelage_glb::{Buffer, Component, ViewTarget, bounds, container};
use serde_json::{Value, json};

/// Up to four joints with their weights, which sum to one.
pub type Weights = [(u8, f64); 4];

/// Model to be written as glTF.
#[derive(Clone, Debug)]
pub struct Model {
    /// Name of scene, mesh and node.
    pub name: String,
    /// Materials, opaque and not metallic.
    pub materials: Vec<Material>,
    /// Primitives of the one mesh.
    pub primitives: Vec<Primitive>,
    /// Joints, parents before children; the first is the root.
    pub skeleton: Option<Vec<Joint>>,
    /// Clips; they require a skeleton.
    pub clips: Vec<Clip>,
}

/// Material with constant factors.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name.
    pub name: String,
    /// Linear base colour, multiplied with the vertex colours.
    pub color: [f64; 3],
    /// Roughness, 0..=1.
    pub roughness: f64,
}

/// Vertices and triangles of one material.
#[derive(Clone, Debug)]
pub struct Primitive {
    /// Name, written to `extras`.
    pub name: String,
    /// Index into [`Model::materials`].
    pub material: usize,
    /// Positions, metres.
    pub positions: Vec<DVec3>,
    /// Unit normals.
    pub normals: Vec<DVec3>,
    /// Texture coordinates.
    pub uvs: Vec<[f64; 2]>,
    /// Linear colours; the fourth component is the hair length as a share of the longest. All 0..=1.
    pub colors: Vec<DVec4>,
    /// Joints and weights; written only with a skeleton.
    pub weights: Vec<Weights>,
    /// Corner indices.
    pub triangles: Vec<[u32; 3]>,
}

/// Joint in rest pose without rotation or scale.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Name.
    pub name: String,
    /// Index of the parent joint.
    pub parent: Option<usize>,
    /// Offset from the parent, metres.
    pub translation: DVec3,
    /// Position in the model, metres.
    pub world: DVec3,
}

/// Animation clip.
#[derive(Clone, Debug)]
pub struct Clip {
    /// Name.
    pub name: String,
    /// Channels, one sampler each.
    pub channels: Vec<Channel>,
}

/// Keys for one property of one joint.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Index of the joint.
    pub joint: usize,
    /// Animated property.
    pub target: Target,
    /// Interpolation between the keys.
    pub interpolation: Interpolation,
    /// Key times, seconds, ascending.
    pub times: Vec<f64>,
    /// Flat values: 4 (rotation, xyzw) or 3 (scale, translation) per key; three such triples per key for cubic splines.
    pub values: Vec<f64>,
}

/// Animated property.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Rotation, unit quaternion.
    Rotation,
    /// Scale.
    Scale,
    /// Position relative to the parent, metres.
    Translation,
}

/// Interpolation between keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Linear, spherical for rotations.
    Linear,
    /// Cubic Hermite spline.
    CubicSpline,
}

impl Primitive {
    /// Creates an empty primitive.
    pub fn new(name: &str, material: usize) -> Self {
        Self {
            name: name.into(),
            material,
            positions: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            colors: Vec::new(),
            weights: Vec::new(),
            triangles: Vec::new(),
        }
    }

    /// Returns the number of vertices.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Returns true if there are no vertices.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Adds a vertex.
    pub fn push_vertex(&mut self, position: DVec3, normal: DVec3, uv: [f64; 2], color: DVec4, weights: Weights) {
        self.positions.push(position);
        self.normals.push(normal);
        self.uvs.push(uv);
        self.colors.push(color);
        self.weights.push(weights);
    }
}

/// Appends little-endian floats. If `bounded`, the accessor stores the minimum and maximum of the `width`-tuples, which
/// glTF requires for some accessors.
fn push_floats(buffer: &mut Buffer, values: &[f64], width: usize, target: Option<ViewTarget>, bounded: bool) -> usize {
    let floats: Vec<f32> = values.iter().map(|&x| x as f32).collect();
    let bytes: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
    let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"].get(width).copied().unwrap_or("MAT4");
    let more = if bounded { bounds(&floats, width) } else { json!({}) };
    buffer.push(&bytes, target, Component::Float, kind, floats.len() / width, more)
}

fn flat(vectors: &[DVec3]) -> Vec<f64> {
    vectors.iter().flat_map(DVec3::to_array).collect()
}

/// Quantises weights to 16-bit fractions that sum to exactly one. The rounding remainder is added to the first weight,
/// which is the largest.
fn quantise_weights(weights: &Weights) -> [u16; 4] {
    let mut q = weights.map(|(_, w)| (w * 65535.0).round() as u16);
    let rest: u16 = q[1..].iter().sum();
    q[0] = 65535 - rest;
    q
}

impl Model {
    /// Returns the bytes of a .glb file.
    pub fn to_glb(&self) -> anyhow::Result<Vec<u8>> {
        let mut buffer = Buffer::default();
        let primitives =
            self.primitives.iter().map(|p| self.write_primitive(&mut buffer, p)).collect::<anyhow::Result<Vec<_>>>()?;
        let mut root = json!({
            "asset": {
                "version": "2.0",
                "generator": "pelage make_assets",
                "copyright": "The pelage authors, MIT OR Apache-2.0",
            },
            "scene": 0,
            "scenes": [{"name": self.name, "nodes": [0]}],
            "nodes": [{"name": self.name, "mesh": 0}],
            "meshes": [{"name": self.name, "primitives": primitives}],
            "materials": self.materials.iter().map(Material::to_json).collect::<Vec<_>>(),
        });
        if let Some(joints) = &self.skeleton {
            // Joint j is node j + 1, because the mesh's node comes first.
            let matrices: Vec<f64> = joints.iter().flat_map(|j| inverse_translation(j.world)).collect();
            let inverse = push_floats(&mut buffer, &matrices, 16, None, false);
            let joint_nodes: Vec<usize> = (1..=joints.len()).collect();
            root["skins"] = json!([{"inverseBindMatrices": inverse, "skeleton": 1, "joints": joint_nodes}]);
            root["nodes"][0]["skin"] = 0.into();
            root["scenes"][0]["nodes"] = json!([0, 1]);
            let nodes = root["nodes"].as_array_mut().context("nodes: expected an array")?;
            for (j, joint) in joints.iter().enumerate() {
                let translation = joint.translation.to_array().map(|x| x as f32);
                let mut node = json!({"name": joint.name, "translation": translation});
                let children: Vec<usize> =
                    (0..joints.len()).filter(|&c| joints[c].parent == Some(j)).map(|c| c + 1).collect();
                if !children.is_empty() {
                    node["children"] = json!(children);
                }
                nodes.push(node);
            }
        }
        if !self.clips.is_empty() {
            ensure!(self.skeleton.is_some(), "clips need a skeleton");
            root["animations"] = self.clips.iter().map(|c| c.to_json(&mut buffer)).collect();
        }
        root["buffers"] = json!([{"byteLength": buffer.bytes.len()}]);
        root["bufferViews"] = buffer.layout.views.into();
        root["accessors"] = buffer.layout.accessors.into();
        container(&root, &buffer.bytes).context("writing a .glb")
    }

    fn write_primitive(&self, buffer: &mut Buffer, p: &Primitive) -> anyhow::Result<Value> {
        let n = p.len();
        ensure!(n <= 65535, "primitive {:?} has {n} vertices, expected at most 65535 (16-bit indices)", p.name);
        let vertex = Some(ViewTarget::Vertices);
        let uvs: Vec<f64> = p.uvs.iter().flatten().copied().collect();
        let mut attributes = json!({
            "POSITION": push_floats(buffer, &flat(&p.positions), 3, vertex, true),
            "NORMAL": push_floats(buffer, &flat(&p.normals), 3, vertex, false),
            "TEXCOORD_0": push_floats(buffer, &uvs, 2, vertex, false),
        });
        let level = |x: f64| (x.clamp(0.0, 1.0) * 255.0).round() as u8;
        let colors: Vec<u8> = p.colors.iter().flat_map(|c| c.to_array().map(level)).collect();
        let normalized = json!({"normalized": true});
        attributes["COLOR_0"] =
            buffer.push(&colors, vertex, Component::UnsignedByte, "VEC4", n, normalized.clone()).into();
        if self.skeleton.is_some() {
            let joints: Vec<u8> = p.weights.iter().flat_map(|w| w.map(|(j, _)| j)).collect();
            let weights: Vec<u8> = p.weights.iter().flat_map(quantise_weights).flat_map(u16::to_le_bytes).collect();
            attributes["JOINTS_0"] = buffer.push(&joints, vertex, Component::UnsignedByte, "VEC4", n, json!({})).into();
            attributes["WEIGHTS_0"] =
                buffer.push(&weights, vertex, Component::UnsignedShort, "VEC4", n, normalized).into();
        }
        let indices: Vec<u8> = p.triangles.iter().flatten().flat_map(|&v| (v as u16).to_le_bytes()).collect();
        let count = 3 * p.triangles.len();
        let indices =
            buffer.push(&indices, Some(ViewTarget::Indices), Component::UnsignedShort, "SCALAR", count, json!({}));
        Ok(json!({
            "attributes": attributes,
            "indices": indices,
            "material": p.material,
            "extras": {"name": p.name},
        }))
    }
}

impl Material {
    fn to_json(&self) -> Value {
        let [r, g, b] = self.color;
        json!({
            "name": self.name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [r, g, b, 1.0],
                "metallicFactor": 0.0,
                "roughnessFactor": self.roughness,
            },
        })
    }
}

impl Clip {
    fn to_json(&self, buffer: &mut Buffer) -> Value {
        let mut samplers = Vec::new();
        let mut channels = Vec::new();
        for (i, channel) in self.channels.iter().enumerate() {
            let (path, width) = match channel.target {
                Target::Rotation => ("rotation", 4),
                Target::Scale => ("scale", 3),
                Target::Translation => ("translation", 3),
            };
            let interpolation = match channel.interpolation {
                Interpolation::Linear => "LINEAR",
                Interpolation::CubicSpline => "CUBICSPLINE",
            };
            let input = push_floats(buffer, &channel.times, 1, None, true);
            let output = push_floats(buffer, &channel.values, width, None, false);
            samplers.push(json!({"input": input, "interpolation": interpolation, "output": output}));
            channels.push(json!({"sampler": i, "target": {"node": channel.joint + 1, "path": path}}));
        }
        json!({"name": self.name, "samplers": samplers, "channels": channels})
    }
}

fn inverse_translation(at: DVec3) -> [f64; 16] {
    [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -at.x, -at.y, -at.z, 1.0]
}
