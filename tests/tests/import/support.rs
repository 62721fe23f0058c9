//! Builds small glTF models in code, and checks the properties that every imported model must have.
#![allow(clippy::unwrap_used, reason = "tests")]

use base64::Engine as _;
use glam::Vec3;
use pelage_bake::stages::import::{ImportOptions, import};
use pelage_formats::{Animation, MorphMotion};
use pelage_import::BakeError;
use pelage_import::mesh::{Model, RestPose};
pub use pelage_needs::data;
use serde_json::{Value, json};

pub const I8: u32 = 5120;
pub const U8: u32 = 5121;
pub const I16: u32 = 5122;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;
pub const F32: u32 = 5126;

/// glTF document under construction, with one buffer.
#[derive(Clone)]
pub struct Doc {
    pub json: Value,
    pub bin: Vec<u8>,
}

/// Converts numbers to little-endian bytes.
pub trait Bytes {
    fn bytes(&self) -> Vec<u8>;
}
macro_rules! bytes {
    ($($t:ty),*) => {$(impl Bytes for [$t] {
        fn bytes(&self) -> Vec<u8> {
            self.iter().flat_map(|x| x.to_le_bytes()).collect()
        }
    })*};
}
bytes!(i8, u8, i16, u16, u32, f32);

impl Doc {
    pub fn new() -> Self {
        Self { json: json!({"asset": {"version": "2.0"}, "accessors": [], "bufferViews": []}), bin: Vec::new() }
    }

    /// Appends a value to a list of the document; returns its index.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        let root = self.json.as_object_mut().unwrap();
        let list = root.entry(list).or_insert_with(|| json!([])).as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    /// Adds a buffer view with `bytes`, aligned to 4; returns its index.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    pub fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        self.push("accessors", json!({"bufferView": view, "componentType": component, "type": kind, "count": count}))
    }

    /// Adds an accessor of floats. The number of elements follows from their type `kind`.
    pub fn floats(&mut self, values: &[f32], kind: &str) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        self.accessor(&values.bytes(), F32, kind, values.len() / width)
    }

    /// Adds a POSITION accessor of the triangle (0,0,0) (1,0,0) (0,1,0), facing +z.
    pub fn triangle(&mut self) -> usize {
        self.floats(&[0., 0., 0., 1., 0., 0., 0., 1., 0.], "VEC3")
    }

    /// Adds a mesh with one primitive, and a node with the mesh; returns the index of the node.
    pub fn show(&mut self, primitive: Value) -> usize {
        let mesh = self.push("meshes", json!({"name": "body", "primitives": [primitive]}));
        self.push("nodes", json!({"mesh": mesh}))
    }

    pub fn glb(&self) -> Vec<u8> {
        let mut root = self.json.clone();
        root["buffers"] = json!([{"byteLength": self.bin.len()}]);
        glb(serde_json::to_string(&root).unwrap().as_bytes(), &self.bin)
    }

    /// Returns the document as JSON, with the buffer in a data URI.
    pub fn gltf(&self) -> Vec<u8> {
        let mut root = self.json.clone();
        let data = base64::engine::general_purpose::STANDARD.encode(&self.bin);
        let uri = format!("data:application/octet-stream;base64,{data}");
        root["buffers"] = json!([{"byteLength": self.bin.len(), "uri": uri}]);
        serde_json::to_vec(&root).unwrap()
    }

    pub fn import(&self) -> Result<Model, BakeError> {
        import_bytes(&self.glb())
    }

    /// Imports the document, checks the result with [`assert_sound`], and returns it.
    pub fn model(&self) -> Model {
        let model = self.import().unwrap();
        assert_sound(&model);
        model
    }

    /// Imports the document, which must fail. Returns the location and reason of the error.
    pub fn fault(&self) -> (String, String) {
        fault(self.import())
    }
}

pub fn glb(json: &[u8], bin: &[u8]) -> Vec<u8> {
    pelage_glb::container_of_text(json.to_vec(), bin).unwrap()
}

/// Imports a file that names no other files.
pub fn import_bytes(bytes: &[u8]) -> Result<Model, BakeError> {
    let mut resolve = |uri: &str, _: u64| -> Result<Vec<u8>, BakeError> {
        Err(BakeError::Input { file: uri.into(), place: "test".into(), reason: "no such file in this test".into() })
    };
    import("folder/model.glb", bytes, &mut resolve, &ImportOptions::default())
}

pub fn fault(result: Result<Model, BakeError>) -> (String, String) {
    match result {
        Err(BakeError::Input { place, reason, .. }) => (place, reason),
        other => panic!("expected an input error, found {other:?}"),
    }
}

/// Asserts the properties that every imported model must have.
pub fn assert_sound(model: &Model) {
    let mesh = &model.mesh;
    let n = mesh.positions.len();
    assert!(n > 0 && !mesh.triangles.is_empty());
    assert_eq!([mesh.normals.len(), mesh.uvs.len(), mesh.colors.len()], [n; 3]);
    assert!(mesh.triangles.iter().flatten().all(|i| (*i as usize) < n));
    assert!(mesh.positions.iter().all(|p| p.is_finite()));
    assert!(mesh.uvs.iter().all(|p| p.is_finite()));
    assert!(mesh.normals.iter().all(|p| (p.length() - 1.0).abs() < 1e-4));
    let mut next = 0;
    for part in &mesh.parts {
        assert_eq!(part.first_triangle, next);
        assert!(part.triangle_count > 0 && part.material < model.materials.len());
        next += part.triangle_count;
    }
    assert_eq!(next, mesh.triangles.len());
    for image in &model.images {
        assert_eq!(image.rgba.len(), image.width as usize * image.height as usize * 4);
    }
    for material in &model.materials {
        assert!(material.base_color_image.is_none_or(|i| i < model.images.len()));
    }
    assert_eq!(mesh.skin.len(), if model.animation.is_some() { n } else { 0 });
    if let Some(animation) = &model.animation {
        let joints = animation.joints.len();
        for v in &mesh.skin {
            assert!((v.weights.iter().sum::<f32>() - 1.0).abs() < 1e-5);
            assert!(v.weights.iter().all(|w| (0.0..=1.0).contains(w)));
            assert!(v.joints.iter().all(|j| usize::from(*j) < joints));
        }
        // The package reader checks the remaining properties: order of nodes, indices, counts, increasing keys, finite
        // numbers.
        let manifest = pelage_formats::Manifest::default();
        let bytes = pelage_formats::PackageWriter::new(manifest).animation(animation).finish().unwrap();
        let limits = pelage_formats::Limits::default();
        let package = pelage_formats::Package::open(&bytes, &limits).unwrap();
        // Motion of morph targets is omitted, because it is stored in a separate section.
        let skeleton = Animation { morphs: MorphMotion::default(), ..animation.clone() };
        assert_eq!(package.animation().unwrap().as_deref(), Some(&skeleton));
    }
    let targets = model.animation.as_ref().map_or(0, |animation| animation.morphs.targets.len());
    assert_eq!(mesh.morph_rows.len(), if targets > 0 { n } else { 0 });
    for row in &mesh.morph_rows {
        let row = &model.morph_rows.0[*row as usize];
        assert!(row.iter().all(|delta| (delta.target as usize) < targets && delta.position.is_finite()));
    }
    let rest = RestPose::of(mesh, model.animation.as_ref());
    assert!(mesh.triangles.iter().flatten().all(|i| rest.positions[*i as usize].is_finite()));
}

/// Returns the normal of a triangle in the rest pose. Its length is twice the area.
pub fn face_normal(model: &Model, triangle: usize) -> Vec3 {
    let rest = RestPose::of(&model.mesh, model.animation.as_ref());
    let [a, b, c] = model.mesh.triangles[triangle].map(|i| rest.positions[i as usize]);
    (b - a).cross(c - a)
}

pub fn assert_near(found: Vec3, expected: [f32; 3]) {
    assert!(found.abs_diff_eq(Vec3::from(expected), 1e-5), "found {found}, expected {expected:?}");
}

#[track_caller]
pub fn assert_warns(model: &Model, text: &str) {
    assert!(model.warnings.iter().any(|w| w.contains(text)), "no warning with `{text}` in {:?}", model.warnings);
}
