//! Morph targets (glTF 2.0, section 3.7.2.2): applies the default weights, and reads the deltas that each weight adds.

use super::json::{JsonNode, shorten};
use super::memory::MeshMemory;
use super::per_vertex::read_per_vertex;
use super::source::Source;
use crate::BakeError;
use crate::mesh::{Mesh, MorphRows, RowDelta};
use glam::Vec3;
use pelage_formats::MorphTarget;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Maximum number of morph targets of a model: the limit of a package.
const MOST_TARGETS: usize = 1 << 12;

/// Names and default weights of the morph targets of a mesh as shown by a node.
#[derive(Clone, Debug, Default)]
pub(super) struct TargetInfo {
    names: Vec<String>,
    weights: Vec<f32>,
}

impl TargetInfo {
    /// Reads the targets of a mesh, with the node's weights if it has any.
    pub(super) fn from_mesh(
        source: &mut Source<'_, '_>,
        mesh: &JsonNode<'_>,
        node_weights: Option<&JsonNode<'_>>,
    ) -> Self {
        let list = node_weights.cloned().or_else(|| mesh.get("weights"));
        let weights = list.map(|list| list.entries()?.map(|w| w.number()).collect::<Result<Vec<f32>, _>>());
        let weights = weights.and_then(|weights| source.or_warn(weights, "all weights are 0")).unwrap_or_default();
        // `targetNames` is not part of glTF, but all exporters write it.
        let names = mesh.get("extras").and_then(|extras| extras.get("targetNames"));
        let names =
            names.and_then(|list| Some(list.entries().ok()?.map(|name| name.string().unwrap_or_default().to_owned())));
        Self { names: names.into_iter().flatten().collect(), weights }
    }
}

/// Morph targets of a primitive, as deltas of its vertices.
#[derive(Clone, Debug, Default)]
pub(super) struct Morph {
    pub(super) targets: TargetInfo,
    /// Number of targets.
    pub(super) count: usize,
    /// Deltas of each vertex. Their target indices refer to the targets of the mesh.
    rows: Vec<Vec<RowDelta>>,
}

impl Morph {
    /// Returns the number of deltas of all vertices.
    pub(super) fn delta_count(&self) -> u64 {
        self.rows.iter().map(|row| row.len() as u64).sum()
    }
}

/// Applies the morph targets of a primitive at their default weights. Returns the deltas relative to that state, and
/// adds their number and memory to the totals of the whole model.
pub(super) fn read<'a>(
    source: &mut Source<'a, '_>,
    memory: &mut MeshMemory,
    at: &JsonNode<'a>,
    label: &str,
    targets: &TargetInfo,
    positions: &mut [Vec3],
    mut normals: Option<&mut [Vec3]>,
) -> Result<Option<Morph>, BakeError> {
    let Some(list) = at.get("targets") else { return Ok(None) };
    let count = source.or_warn(list.len(), "no morph targets are read").unwrap_or_default();
    if count == 0 {
        return Ok(None);
    }
    if count > MOST_TARGETS {
        return Err(list.fault(format!("holds {count} morph targets, expected at most {MOST_TARGETS}")));
    }
    let weights = &targets.weights;
    if !weights.is_empty() && weights.len() != count {
        source.warn(format!("{label} has {count} morph targets and {} weights; missing weights are 0", weights.len()));
    }
    let mut rows: Vec<Vec<RowDelta>> = vec![Vec::new(); positions.len()];
    for (number, target) in list.entries()?.enumerate() {
        let mut deltas = |key: &str, wanted: bool| {
            let reference = target.get(key).filter(|_| wanted)?;
            let deltas = read_per_vertex(source, &reference, &[3], positions.len(), false);
            let deltas = deltas.and_then(|deltas| match deltas.iter().position(|x| !x.is_finite()) {
                Some(i) => Err(reference.fault(format!("element {} is not finite, expected finite numbers", i / 3))),
                None => Ok(deltas),
            });
            source.or_warn(deltas, "left out of the morph target")
        };
        let (position, normal) = (deltas("POSITION", true), deltas("NORMAL", normals.is_some()));
        let at = |deltas: &Option<Vec<f32>>, v: usize| {
            deltas.as_ref().and_then(|deltas| Some(Vec3::from_slice(deltas.get(3 * v..3 * v + 3)?)))
        };
        let (mut deltas, mut grown) = (0, 0);
        for (v, row) in rows.iter_mut().enumerate() {
            let (position, normal) = (at(&position, v).unwrap_or_default(), at(&normal, v));
            if position != Vec3::ZERO || normal.is_some_and(|n| n != Vec3::ZERO) {
                let before = row.capacity();
                row.push(RowDelta { target: number as u32, position, normal, hidden_at: None });
                grown += row.capacity() - before;
                deltas += 1;
            }
        }
        memory.add_deltas(source, &target, deltas, grown * size_of::<RowDelta>())?;
    }
    for (v, row) in rows.iter_mut().enumerate() {
        for delta in &*row {
            let weight = weights.get(delta.target as usize).copied().unwrap_or_default();
            positions[v] += delta.position * weight;
            if let (Some(normals), Some(normal)) = (normals.as_deref_mut(), delta.normal) {
                normals[v] += normal * weight;
            }
        }
        // Normals are normalised later, so their deltas are divided by the length of the normal.
        let length = normals.as_deref().map_or(1.0, |normals| normals[v].length());
        if length > 0.0 && length.is_finite() {
            row.iter_mut().for_each(|delta| delta.normal = delta.normal.map(|normal| normal / length));
        }
    }
    let known = |list: usize| list.min(count);
    let (mut names, mut weights) = (targets.names[..known(targets.names.len())].to_vec(), weights.clone());
    names.resize(count, String::new());
    weights.resize(count, 0.0);
    Ok(Some(Morph { targets: TargetInfo { names, weights }, count, rows }))
}

#[derive(Debug)]
pub(super) struct ModelMorphs {
    /// Targets in the order of the package.
    pub(super) targets: Vec<MorphTarget>,
    rows: MorphRows,
    /// Index of each row in `rows`, by the bits of its contents. Equal rows are thus stored once.
    known: BTreeMap<Vec<u32>, u32>,
    /// Nodes with targets: document node, index of its first target, and number of targets.
    pub(super) of_nodes: Vec<(usize, u32, u32)>,
}

impl ModelMorphs {
    /// Returns an empty collection. Row 0 belongs to vertices that no target moves.
    pub(super) fn new() -> Self {
        let known = BTreeMap::from([(Vec::new(), 0)]);
        Self { targets: Vec::new(), rows: MorphRows(vec![Vec::new()]), known, of_nodes: Vec::new() }
    }

    /// Adds the morph targets of a node to the model, and returns the index of the first one. `node` is the node's
    /// index in the document, `number` its index in the package.
    pub(super) fn add_node(
        &mut self,
        at: &JsonNode<'_>,
        node: usize,
        number: u32,
        morph: &Morph,
    ) -> Result<u32, BakeError> {
        let first = self.targets.len();
        if first + morph.count > MOST_TARGETS {
            let (name, total) = (shorten(at.name()), first + morph.count);
            return Err(at.fault(format!(
                "with \"{name}\" the model has {total} morph targets, expected at most {MOST_TARGETS}"
            )));
        }
        let named = morph.targets.names.iter().zip(&morph.targets.weights);
        self.targets.extend(named.map(|(name, weight)| MorphTarget {
            name: name.clone(),
            node: number,
            weight: *weight,
        }));
        self.of_nodes.push((node, first as u32, morph.count as u32));
        Ok(first as u32)
    }

    /// Adds the rows of a primitive's vertices to the model, and their indices to `mesh`. `morph` holds the primitive's
    /// morph targets, and the index of the first of them in the model.
    ///
    /// Fails with [`BakeError::Input`] at `at`, the primitive, if the rows exceed the memory that the meshes may take.
    pub(super) fn add_rows<'a>(
        &mut self,
        source: &mut Source<'a, '_>,
        memory: &mut MeshMemory,
        at: &JsonNode<'a>,
        morph: Option<(&Morph, u32)>,
        vertices: usize,
        mesh: &mut Mesh,
    ) -> Result<(), BakeError> {
        let Some((morph, first)) = morph else {
            mesh.morph_rows.extend(std::iter::repeat_n(0, vertices));
            return Ok(());
        };
        for row in &morph.rows {
            let moved: Vec<RowDelta> = row.iter().map(|d| RowDelta { target: d.target + first, ..*d }).collect();
            let bits = |v: Vec3| v.to_array().map(f32::to_bits);
            let key = moved.iter().flat_map(|d| {
                let normal = d.normal.map_or([u32::MAX; 3], bits);
                [d.target].into_iter().chain(bits(d.position)).chain(normal)
            });
            let rows = &mut self.rows.0;
            let number = match self.known.entry(key.collect()) {
                Entry::Occupied(known) => *known.get(),
                Entry::Vacant(new) => {
                    memory.place_row(source, at, moved.len())?;
                    rows.push(moved);
                    *new.insert(rows.len() as u32 - 1)
                }
            };
            mesh.morph_rows.push(number);
        }
        Ok(())
    }

    /// Returns the targets and rows. Without targets, clears the row indices of `mesh`.
    pub(super) fn finish(self, mesh: &mut Mesh) -> (Vec<MorphTarget>, MorphRows) {
        if self.targets.is_empty() {
            mesh.morph_rows = Vec::new();
            return Default::default();
        }
        (self.targets, self.rows)
    }
}
