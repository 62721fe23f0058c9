//! glTF skins: joints and inverse bind matrices, and the list of joints of the whole model.

use super::elements::{Component, grouped};
use super::json::JsonNode;
use super::source::Source;
use super::weights::Influence;
use crate::BakeError;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// A glTF skin of the document.
#[derive(Debug)]
pub(super) struct Skin {
    /// Joints, as nodes of the document.
    pub joints: Vec<usize>,
    /// Inverse bind matrices, one per joint, column-major.
    pub inverse_binds: Vec<[f32; 16]>,
    /// Whether the file lacks the matrix of each joint, which is then the identity. A file without any lacks none.
    lacks_bind: Vec<bool>,
}

const IDENTITY: [f32; 16] = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];

impl Skin {
    fn read<'a>(source: &mut Source<'a, '_>, at: &JsonNode<'a>) -> Result<Self, BakeError> {
        let mut joints = Vec::new();
        let joints_at = at.require("joints")?;
        for reference in joints_at.entries()? {
            joints.push(source.root.follow("nodes", &reference)?.0);
        }
        if joints.is_empty() {
            return Err(joints_at.fault("is empty, expected at least one joint"));
        }
        let mut inverse_binds = vec![IDENTITY; joints.len()];
        let mut lacks_bind = vec![false; joints.len()];
        if let Some(reference) = at.get("inverseBindMatrices") {
            let read = source.accessor(&reference, &[16], &[Component::F32]);
            let numbers = source.or_warn(read, "no matrix is read").map(|elements| elements.to_f32s(false));
            let mut matrices = grouped::<16>(numbers.as_deref().unwrap_or_default());
            for (slot, lacks) in inverse_binds.iter_mut().zip(&mut lacks_bind) {
                match matrices.next().filter(|matrix| matrix.iter().all(|x| x.is_finite())) {
                    // The last row is [0, 0, 0, 1] by definition; some files have rounding errors in it.
                    Some([a, b, c, _, d, e, f, _, g, h, i, _, j, k, l, _]) => {
                        *slot = [a, b, c, 0.0, d, e, f, 0.0, g, h, i, 0.0, j, k, l, 1.0];
                    }
                    None => *lacks = true,
                }
            }
            let (lost, expected) = (lacks_bind.iter().filter(|lacks| **lacks).count(), joints.len());
            if lost > 0 {
                let (place, found) = (&reference.place, expected - lost);
                source.warn(format!(
                    "{place} has {found} usable matrices, expected {expected}, one per joint; a missing one is the \
                     identity"
                ));
            }
        }
        Ok(Self { joints, inverse_binds, lacks_bind })
    }

    /// Returns the number of vertices that follow joints without an inverse bind matrix.
    fn count_without_bind(&self, influences: &[Influence]) -> usize {
        if !self.lacks_bind.contains(&true) {
            return 0;
        }
        let lacks = |joint: &u32| self.lacks_bind.get(*joint as usize) == Some(&true);
        let lost = |(joints, weights): &&Influence| joints.iter().zip(weights).any(|(j, w)| *w > 0.0 && lacks(j));
        influences.iter().filter(lost).count()
    }
}

/// Owner of a range of joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Owner {
    /// A skin; owns all its joints.
    Skin(usize),
    /// A node with a rigid mesh; owns the joint that the mesh follows.
    Node(usize),
}

/// Joints of the model: those of each skin, and one for each node with a rigid mesh.
#[derive(Debug, Default)]
pub(super) struct Joints {
    /// Document node and inverse bind matrix of each joint.
    pub list: Vec<(usize, [f32; 16])>,
    first: BTreeMap<Owner, usize>,
    skins: BTreeMap<usize, Skin>,
}

impl Joints {
    /// Returns the index of the skin that `reference` names; reads it on first use.
    pub fn skin<'a>(&mut self, source: &mut Source<'a, '_>, reference: &JsonNode<'a>) -> Result<usize, BakeError> {
        let (index, at) = source.root.follow("skins", reference)?;
        if let Entry::Vacant(slot) = self.skins.entry(index) {
            slot.insert(Skin::read(source, &at)?);
        }
        Ok(index)
    }

    /// Warns about vertices of a primitive that follow joints without an inverse bind matrix.
    pub fn check_binds(&self, source: &mut Source<'_, '_>, skin: usize, label: &str, influences: &[Influence]) {
        let count = self.skins.get(&skin).map_or(0, |skin| skin.count_without_bind(influences));
        if count > 0 {
            source.warn(format!(
                "{label}: {count} vertices follow joints without an inverse bind matrix and may be out of place"
            ));
        }
    }

    /// Returns the joints of a skin that was already read: document node and inverse bind matrix of each.
    pub fn binds(&self, skin: usize) -> Vec<(usize, [f32; 16])> {
        let skin = self.skins.get(&skin);
        skin.into_iter().flat_map(|s| s.joints.iter().copied().zip(s.inverse_binds.iter().copied())).collect()
    }

    /// Returns the index of the first joint of a skin, and the number of its joints.
    pub fn of_skin(&mut self, at: &JsonNode<'_>, skin: usize) -> Result<(usize, usize), BakeError> {
        let entries = self.binds(skin);
        let count = entries.len();
        Ok((self.add(at, Owner::Skin(skin), entries)?, count))
    }

    /// Returns the index of the joint of a node with a rigid mesh.
    pub fn of_node(&mut self, at: &JsonNode<'_>, node: usize) -> Result<usize, BakeError> {
        self.add(at, Owner::Node(node), vec![(node, IDENTITY)])
    }

    fn add(&mut self, at: &JsonNode<'_>, owner: Owner, entries: Vec<(usize, [f32; 16])>) -> Result<usize, BakeError> {
        if let Some(first) = self.first.get(&owner) {
            return Ok(*first);
        }
        let first = self.list.len();
        if first + entries.len() > usize::from(u16::MAX) + 1 {
            return Err(at.fault("gives the model more than 65536 joints (those of all skins and one per rigid part)"));
        }
        self.list.extend(entries);
        self.first.insert(owner, first);
        Ok(first)
    }
}
