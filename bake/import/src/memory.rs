//! Bound on the memory of meshes, checked before they are read.
//!
//! A small file could otherwise expand to any amount of memory: accessors may hold no data, primitives may share
//! accessors, and nodes may share meshes.

use super::json::JsonNode;
use super::source::Source;
use super::weights::{Influence, MAX_SETS};
use crate::BakeError;
use crate::mesh::RowDelta;
use glam::{DVec3, Vec2, Vec3};
use pelage_formats::{Limits, MorphDelta, SkinVertex};

/// Memory that the meshes of any model may take, bytes: three quarters of the 1 GiB of a bake.
const MAX_MESHES: u64 = 768 << 20;
/// Memory that the meshes of a model may take for each byte of its buffers, bytes. Vertices with data of their own take
/// less, so that only the limits of a package hold for them.
const PER_BUFFER_BYTE: u64 = 24;

/// Maximum number of morph deltas of a model: the limit of a section of a package.
const MOST_DELTAS: u64 = (256 << 20) / size_of::<MorphDelta>() as u64;

/// Memory of a vertex, bytes: position, normal, texture coordinates and colour.
const STREAMS: usize = 2 * size_of::<Vec3>() + size_of::<Vec2>() + size_of::<[u8; 4]>();
/// Memory of a vertex of the whole model, bytes: with joints, row of morph deltas, the rest pose, and flat normals.
const PLACED: usize = STREAMS
    + size_of::<SkinVertex>()
    + size_of::<u32>()
    + 2 * size_of::<Vec3>()
    + size_of::<Vec3>()
    + size_of::<Option<Vec3>>();
/// Memory of a triangle, bytes.
const TRIANGLE: u64 = size_of::<[u32; 3]>() as u64;
/// Memory for each vertex while an attribute is converted: bytes, numbers and vectors.
const CONVERTED: usize = 3 * size_of::<Vec3>();
/// Memory for each vertex and each of its sets of weights while they are read.
const WEIGHT_SET: usize = size_of::<[u32; 4]>() + size_of::<[f32; 4]>();
/// Memory for each vertex while normals are computed: a sum of its own, and a hash table entry, of up to three slots.
const NORMAL_SUMS: usize = size_of::<DVec3>() + 3 * size_of::<([u32; 3], DVec3)>();
/// Memory of a distinct row of morph deltas in the whole model, bytes, with its key and its share of the search tree.
const DISTINCT_ROW: usize = 2 * size_of::<Vec<u32>>() + 64;
/// Memory of a delta in such a row, bytes, with its part of the key.
const DISTINCT_DELTA: usize = 3 * size_of::<RowDelta>();

/// Number of vertices and indices of the meshes counted so far, and the memory that they take.
#[derive(Debug, Default)]
pub(super) struct MeshMemory {
    vertices: u64,
    indices: u64,
    /// Memory of the primitives as they are read, bytes.
    read: u64,
    /// Memory of the whole model, to which the primitives are copied, bytes.
    placed: u64,
    /// Largest limit for `read` and `placed` found so far, bytes; 0 if the limit for all models was not reached.
    limit: u64,
    /// Number of morph target deltas.
    deltas: u64,
}

impl MeshMemory {
    /// Adds a primitive that will be read.
    ///
    /// Fails with [`BakeError::Input`] at `at` if the meshes exceed the limits of a package, or the memory that they
    /// may take.
    pub fn count_primitive<'a>(
        &mut self,
        source: &mut Source<'a, '_>,
        at: &JsonNode<'a>,
        skinned: bool,
    ) -> Result<(), BakeError> {
        let attribute = |name: &str| at.get("attributes").and_then(|attributes| attributes.get(name));
        let count = |reference: Option<JsonNode<'a>>| reference.map_or(Ok(0), |r| source.accessor_count(&r));
        let listed = at.get("indices");
        let has_list = listed.is_some();
        let (vertices, indices) = (count(attribute("POSITION"))?, count(listed)?);
        self.count(at, vertices, indices)?;
        let corners = if has_list { indices } else { vertices };
        let triangles = if at.unsigned_or("mode", 4).unwrap_or(4) > 4 { corners } else { corners / 3 };
        let mut kept = STREAMS;
        let mut working = CONVERTED;
        if skinned {
            let sets = (0..MAX_SETS).take_while(|n| attribute(&format!("JOINTS_{n}")).is_some()).count();
            kept += size_of::<Influence>();
            working = working.max((sets + 1) * WEIGHT_SET);
        }
        if at.get("targets").is_some() {
            kept += size_of::<Vec<RowDelta>>();
        }
        if attribute("NORMAL").is_none() {
            working = working.max(NORMAL_SUMS);
        }
        self.read += vertices * kept as u64 + triangles * TRIANGLE;
        self.placed += vertices * PLACED as u64 + triangles * TRIANGLE;
        let working = vertices * working as u64 + corners * 2 * size_of::<u32>() as u64;
        self.check(source, at, working)
    }

    /// Adds morph deltas that were read, and the memory that they take.
    ///
    /// Fails like [`Self::count_primitive`]; also for more deltas than a package may have.
    pub fn add_deltas<'a>(
        &mut self,
        source: &mut Source<'a, '_>,
        at: &JsonNode<'a>,
        deltas: u64,
        bytes: usize,
    ) -> Result<(), BakeError> {
        self.read += bytes as u64;
        self.check(source, at, 0)?;
        self.count_deltas(at, deltas)
    }

    /// Returns the memory of a model of which nothing is placed yet, when all its primitives are read.
    pub fn before_placing(self) -> Self {
        Self { read: self.read, limit: self.limit, ..Self::default() }
    }

    /// Adds a primitive that a node shows.
    ///
    /// Fails like [`Self::add_deltas`].
    pub fn place<'a>(
        &mut self,
        source: &mut Source<'a, '_>,
        at: &JsonNode<'a>,
        vertices: usize,
        triangles: usize,
        deltas: u64,
    ) -> Result<(), BakeError> {
        let (vertices, triangles) = (vertices as u64, triangles as u64);
        self.count_deltas(at, deltas)?;
        self.count(at, vertices, 3 * triangles)?;
        self.placed += vertices * PLACED as u64 + triangles * TRIANGLE;
        self.check(source, at, 0)
    }

    /// Adds a distinct row of morph deltas of the whole model.
    ///
    /// Fails like [`Self::count_primitive`].
    pub fn place_row<'a>(
        &mut self,
        source: &mut Source<'a, '_>,
        at: &JsonNode<'a>,
        deltas: usize,
    ) -> Result<(), BakeError> {
        self.placed += (DISTINCT_ROW + deltas * DISTINCT_DELTA) as u64;
        self.check(source, at, 0)
    }

    /// Adds vertices and indices. Fails if a model exceeds the limits of a package.
    fn count(&mut self, at: &JsonNode<'_>, vertices: u64, indices: u64) -> Result<(), BakeError> {
        self.vertices = self.vertices.saturating_add(vertices);
        self.indices = self.indices.saturating_add(indices);
        let (found, limits) = (self.found(), Limits::default());
        if self.vertices <= limits.vertices.into() && self.indices <= limits.indices.into() {
            return Ok(());
        }
        Err(at.fault(format!("{found}, expected at most {} and {}", limits.vertices, limits.indices)))
    }

    /// Adds morph deltas. Fails if a model has more than a package may have.
    fn count_deltas(&mut self, at: &JsonNode<'_>, deltas: u64) -> Result<(), BakeError> {
        self.deltas += deltas;
        if self.deltas <= MOST_DELTAS {
            return Ok(());
        }
        Err(at.fault(format!("makes the morph targets move more than {MOST_DELTAS} vertices in total")))
    }

    fn found(&self) -> String {
        format!("takes the model to {} vertices and {} indices", self.vertices, self.indices)
    }

    /// Fails if the meshes take more memory than they may. `working`: memory while a primitive is read, bytes. It is
    /// free again before the whole model is made.
    fn check<'a>(&mut self, source: &mut Source<'a, '_>, at: &JsonNode<'a>, working: u64) -> Result<(), BakeError> {
        let bytes = self.read.saturating_add(self.placed.max(working));
        if bytes <= self.limit.max(MAX_MESHES) {
            return Ok(());
        }
        source.load_buffer_of(at);
        self.limit = MAX_MESHES.max(PER_BUFFER_BYTE.saturating_mul(source.buffer_bytes()));
        if bytes <= self.limit {
            return Ok(());
        }
        let [needed, limit] = [bytes.div_ceil(1 << 20), self.limit >> 20];
        Err(at.fault(format!(
            "{} that need {needed} MiB of memory, expected at most {limit} MiB; data without a buffer, or used by \
             several primitives and nodes, counts each time",
            self.found()
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::notes::Notes;
    use serde_json::json;

    /// Counts a primitive of `vertices` and `indices` with positions that all have data of their own or none. Returns
    /// the reason of an error.
    fn count(vertices: usize, indices: usize, data: bool) -> Option<String> {
        let bin = vec![0; if data { 12 * vertices } else { 12 }];
        let mut positions = json!({"componentType": 5126, "count": vertices, "type": "VEC3"});
        if data {
            positions["bufferView"] = json!(0);
        }
        let document = json!({
            "accessors": [positions, {"componentType": 5125, "count": indices, "type": "SCALAR"}],
            "bufferViews": [{"buffer": 0, "byteLength": bin.len()}],
            "buffers": [{"byteLength": bin.len()}],
            "primitive": {"attributes": {"POSITION": 0}, "indices": 1},
        });
        let root = JsonNode::root("m", &document);
        let at = root.get("primitive").unwrap();
        let mut no_files = |_: &str, _: u64| unreachable!("the document names no files");
        let mut source = Source::new(root, Some(&bin), &mut no_files, Notes::default());
        let error = MeshMemory::default().count_primitive(&mut source, &at, false).err()?;
        let BakeError::Input { reason, .. } = error else { unreachable!("expected an input error") };
        Some(reason)
    }

    #[test]
    fn only_shared_or_absent_data_is_limited_by_memory() {
        for (vertices, indices, data) in
            [(4_000_000, 3_000_000, false), (4_000_000, 3_000_000, true), (1 << 24, 3, true)]
        {
            assert_eq!(count(vertices, indices, data), None, "{vertices} vertices, data {data}");
        }
        let most = count((1 << 24) + 1, 3, false).unwrap();
        let expected = "takes the model to 16777217 vertices and 3 indices, expected at most 16777216 and 100663296";
        assert_eq!(most, expected);
        let found = count(6_000_000, 3, false).unwrap();
        assert!(found.starts_with("takes the model to 6000000 vertices and 3 indices that need "), "{found}");
        assert!(found.contains(" MiB of memory, expected at most 768 MiB;"), "{found}");
    }
}
