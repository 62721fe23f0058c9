//! The node tree: parents, order and transforms.

use super::elements::Component;
use super::json::{JsonNode, shorten};
use super::source::Source;
use crate::BakeError;
use glam::{DMat3, DMat4, DVec3, Mat3, Mat4, Quat, Vec3};

#[derive(Debug)]
pub(super) struct TreeNode<'a> {
    pub at: JsonNode<'a>,
    pub parent: Option<usize>,
    /// Transform to the parent's space.
    pub local: Mat4,
    /// `local` as translation, rotation and scale; shear is dropped.
    pub trs: (Vec3, Quat, Vec3),
    /// Visibility of its mesh.
    pub shows: MeshVisibility,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MeshVisibility {
    /// Shown at the node.
    Mesh,
    /// Shown by the node's instances only.
    Instances,
    /// Shown at this node, which stands for one instance. It is a child of the node with the mesh, but not a node of
    /// the document.
    Instance,
}

/// Node tree of the document.
#[derive(Debug)]
pub(super) struct Tree<'a> {
    /// Nodes as numbered in the document, followed by the instances that `EXT_mesh_gpu_instancing` creates.
    pub nodes: Vec<TreeNode<'a>>,
    /// All nodes, parents first, siblings in the order of the document.
    pub order: Vec<usize>,
    /// Nodes of the scene, parents first.
    pub scene: Vec<usize>,
    /// Whether each node is hidden by itself or by an ancestor (`KHR_node_visibility`).
    hidden: Vec<bool>,
    /// Number of nodes of the scene with a mesh that is hidden.
    pub hidden_meshes: usize,
}

impl<'a> Tree<'a> {
    pub fn read(source: &mut Source<'a, '_>) -> Result<Self, BakeError> {
        let mut nodes = Vec::new();
        if let Some(list) = source.root.get("nodes") {
            for at in list.entries()? {
                let (local, trs) = transform(&at, source);
                nodes.push(TreeNode { at, parent: None, local, trs, shows: MeshVisibility::Mesh });
            }
        }
        let mut children = vec![Vec::new(); nodes.len()];
        for (parent, list) in children.iter_mut().enumerate() {
            let Some(named) = nodes[parent].at.get("children") else { continue };
            for reference in named.entries()? {
                let (child, _) = source.root.follow("nodes", &reference)?;
                if let Some(other) = nodes[child].parent {
                    source.warn(format!(
                        "{} is {child}, which is also a child of node {other}, expected one parent; drawn there only",
                        reference.place
                    ));
                    continue;
                }
                nodes[child].parent = Some(parent);
                list.push(child);
            }
        }
        let of_document = nodes.len();
        for parent in 0..of_document {
            let left = MOST_INSTANCES.saturating_sub(nodes.len() - of_document);
            let Some(instances) = instances(source, &nodes[parent].at, left)? else { continue };
            nodes[parent].shows = MeshVisibility::Instances;
            for (local, trs) in instances {
                let at = nodes[parent].at.clone();
                children[parent].push(nodes.len());
                children.push(Vec::new());
                nodes.push(TreeNode { at, parent: Some(parent), local, trs, shows: MeshVisibility::Instance });
            }
        }
        let roots: Vec<usize> = (0..nodes.len()).filter(|i| nodes[*i].parent.is_none()).collect();
        let order = walk(&roots, &children);
        if order.len() < nodes.len() {
            // Every node has at most one parent, so nodes that the roots do not reach form a cycle.
            let mut reached = vec![false; nodes.len()];
            order.iter().for_each(|i| reached[*i] = true);
            let lost = reached.iter().position(|r| !r).unwrap_or_default();
            return Err(nodes[lost].at.fault("is its own ancestor; expected a tree"));
        }
        let roots = match scene_nodes(source, nodes.len()) {
            Some(listed) => detach_roots(source, &listed, &order, &mut nodes, &mut children),
            None => roots,
        };
        let scene = walk(&roots, &children);
        let mut hidden = vec![false; nodes.len()];
        for i in &order {
            hidden[*i] = nodes[*i].parent.is_some_and(|p| hidden[p]) || is_hidden(source, &nodes[*i].at);
        }
        let of_mesh = |i: &&usize| nodes[**i].shows != MeshVisibility::Instance && nodes[**i].at.get("mesh").is_some();
        let hidden_meshes = scene.iter().filter(of_mesh).filter(|i| hidden[**i]).count();
        if hidden_meshes > 0 {
            source.warn(format!("{hidden_meshes} nodes with a mesh are hidden by KHR_node_visibility; left out"));
        }
        Ok(Self { nodes, order, scene, hidden, hidden_meshes })
    }

    /// Returns the nodes of the scene whose mesh (if any) is shown, parents first.
    pub fn shown(&self) -> impl Iterator<Item = usize> {
        let shown = |node: &usize| self.nodes[*node].shows != MeshVisibility::Instances && !self.hidden[*node];
        self.scene.iter().copied().filter(shown)
    }

    /// Returns the transforms to world space, one per node, under `root`.
    pub fn world(&self, root: Mat4) -> Vec<Mat4> {
        let mut world = vec![root; self.nodes.len()];
        for i in &self.order {
            let node = &self.nodes[*i];
            world[*i] = node.parent.map_or(root, |p| world[p]) * node.local;
        }
        world
    }

    /// Returns `node` and its ancestors.
    pub fn lineage(&self, node: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(node), |i| self.nodes.get(*i).and_then(|n| n.parent))
    }
}

/// Returns the nodes below `roots` in depth-first order. Does not recurse, because trees may be deep.
fn walk(roots: &[usize], children: &[Vec<usize>]) -> Vec<usize> {
    let mut order = Vec::new();
    let mut open: Vec<usize> = roots.iter().rev().copied().collect();
    while let Some(node) = open.pop() {
        order.push(node);
        open.extend(children[node].iter().rev());
    }
    order
}

/// Returns whether a node hides itself and its descendants (`KHR_node_visibility`).
fn is_hidden(source: &mut Source<'_, '_>, node: &JsonNode<'_>) -> bool {
    let visible = node.extension("KHR_node_visibility").filter(|at| at.get("visible").is_some());
    visible.and_then(|at| source.or_warn(at.flag("visible"), "drawn")) == Some(false)
}

/// Returns the nodes that the default scene lists, or the first scene if none is the default, each once. `None` without
/// scenes: then all roots of the document are shown.
fn scene_nodes(source: &mut Source<'_, '_>, count: usize) -> Option<Vec<usize>> {
    let root = source.root.clone();
    let default = root.get("scene").and_then(|reference| {
        source.or_warn(root.follow("scenes", &reference), "the first scene is drawn, or all nodes if there is none")
    });
    let scene = default.map(|(_, scene)| scene).or_else(|| root.get("scenes")?.entry(0))?;
    let mut listed = Vec::new();
    let mut seen = vec![false; count];
    let nodes = scene.get("nodes").and_then(|nodes| source.or_warn(nodes.entries(), "nothing is drawn"));
    for reference in nodes.into_iter().flatten() {
        let Some((index, _)) = source.or_warn(root.follow("nodes", &reference), "left out") else { continue };
        if std::mem::replace(&mut seen[index], true) {
            source.warn(format!("{}: node {index} is listed twice; it is used once", reference.place));
        } else {
            listed.push(index);
        }
    }
    Some(listed)
}

/// Returns the listed nodes that are not below other listed nodes. Detaches each from its parent, which is then outside
/// the scene and must not move it.
fn detach_roots(
    source: &mut Source<'_, '_>,
    listed: &[usize],
    order: &[usize],
    nodes: &mut [TreeNode<'_>],
    children: &mut [Vec<usize>],
) -> Vec<usize> {
    let nested: Vec<usize> = listed.iter().copied().filter(|node| nodes[*node].parent.is_some()).collect();
    let Some(first) = nested.first() else { return listed.to_vec() };
    source.warn(format!(
        "the scene lists {} nodes that are children of others, such as node {first} \"{}\", expected root nodes; each \
         is drawn once, without parents outside the scene",
        nested.len(),
        shorten(nodes[*first].at.name())
    ));
    let mut is_listed = vec![false; nodes.len()];
    listed.iter().for_each(|node| is_listed[*node] = true);
    let mut below = vec![false; nodes.len()];
    for node in order {
        below[*node] = nodes[*node].parent.is_some_and(|parent| is_listed[parent] || below[parent]);
    }
    let is_root = |node: &usize| is_listed[*node] && !below[*node];
    for list in children {
        list.retain(|child| !is_root(child));
    }
    let roots: Vec<usize> = listed.iter().copied().filter(is_root).collect();
    roots.iter().for_each(|root| nodes[*root].parent = None);
    roots
}

/// A matrix, and its decomposition into translation, rotation and scale (shear is dropped).
type Transform = (Mat4, (Vec3, Quat, Vec3));

/// Maximum number of mesh instances in a document: the maximum number of joints of a skin, because each instance may
/// follow its own joint.
const MOST_INSTANCES: usize = 1 << 16;

/// Reads the transforms of a node's instances (`EXT_mesh_gpu_instancing`), in the node's space. More than `most` are an
/// error. `None` if the node lacks the extension or a mesh, or has a skin.
fn instances<'a>(
    source: &mut Source<'a, '_>,
    node: &JsonNode<'a>,
    most: usize,
) -> Result<Option<Vec<Transform>>, BakeError> {
    let Some(at) = node.extension("EXT_mesh_gpu_instancing") else { return Ok(None) };
    if node.get("mesh").is_none() {
        return Ok(None);
    }
    if node.get("skin").is_some() {
        source.warn(format!(
            "{}: a skinned mesh is placed by its joints, not by its instances; it is shown once",
            at.place
        ));
        return Ok(None);
    }
    let attributes = at.require("attributes")?;
    // The extension leaves other attributes, such as `_ID`, to the application.
    let [translation, rotation, scale] = ["TRANSLATION", "ROTATION", "SCALE"].map(|name| attributes.get(name));
    let mut count: Option<(u64, &'static str)> = None;
    for (reference, name) in [(&translation, "TRANSLATION"), (&rotation, "ROTATION"), (&scale, "SCALE")] {
        let Some(reference) = reference else { continue };
        let found = source.accessor_count(reference)?;
        let (wanted, first) = *count.get_or_insert((found, name));
        if found != wanted {
            return Err(reference.fault(format!("has {found} elements, expected {wanted}, as many as {first}")));
        }
        if found > most as u64 {
            let reason = format!("has {found} elements, expected at most {MOST_INSTANCES} instances in a document");
            return Err(reference.fault(reason));
        }
    }
    let Some((count, _)) = count else {
        return Err(attributes.fault("has none of TRANSLATION, ROTATION and SCALE, expected at least one"));
    };
    let mut read = |reference: Option<JsonNode<'a>>, width: usize, components: &[Component], plain: [f32; 4]| {
        let Some(reference) = reference else { return Ok(vec![plain; count as usize]) };
        let numbers = source.accessor(&reference, &[width], components)?.to_f32s(false);
        let vectors = numbers.chunks_exact(width).enumerate().map(|(i, vector)| {
            let mut all = plain;
            all[..width].copy_from_slice(vector);
            let fault = || reference.fault(format!("element {i} is {vector:?}, expected finite numbers"));
            vector.iter().all(|x| x.is_finite()).then_some(all).ok_or_else(fault)
        });
        vectors.collect::<Result<Vec<[f32; 4]>, BakeError>>()
    };
    let translations = read(translation, 3, &[Component::F32], [0.0; 4])?;
    let rotations = read(rotation, 4, &[Component::F32, Component::I8, Component::I16], [0.0, 0.0, 0.0, 1.0])?;
    let scales = read(scale, 3, &[Component::F32], [1.0; 4])?;
    let places = translations.iter().zip(&rotations).zip(&scales).map(|((t, r), s)| {
        let rotation = unit(*r).map_or(Quat::IDENTITY, |(rotation, _)| rotation);
        let (translation, scale) = (Vec3::new(t[0], t[1], t[2]), Vec3::new(s[0], s[1], s[2]));
        (Mat4::from_scale_rotation_translation(scale, rotation, translation), (translation, rotation, scale))
    });
    Ok(Some(places.collect()))
}

/// Returns a rotation normalised to length 1, and its original length; `None` if the original length is 0. Computes in
/// f64, because squares of small numbers underflow in f32.
fn unit(q: [f32; 4]) -> Option<(Quat, f64)> {
    let length = q.iter().map(|x| f64::from(*x) * f64::from(*x)).sum::<f64>().sqrt();
    (length > 1e-12).then(|| (Quat::from_array(q.map(|x| (f64::from(x) / length) as f32)), length))
}

/// Reads the transform of a node as a matrix and as translation, rotation and scale. A faulty part is left out.
fn transform(at: &JsonNode<'_>, source: &mut Source<'_, '_>) -> Transform {
    if let Some(matrix_at) = at.get("matrix") {
        let numbers = source.or_warn(matrix_at.numbers(), "the node is not transformed");
        let mut matrix = numbers.map_or(Mat4::IDENTITY, |numbers| Mat4::from_cols_array(&numbers));
        let row = matrix.row(3);
        if row != glam::Vec4::W {
            source.warn(format!(
                "{} has the last row {row}, expected [0, 0, 0, 1] (column-major order); read as that",
                matrix_at.place
            ));
            (matrix.x_axis.w, matrix.y_axis.w, matrix.z_axis.w, matrix.w_axis.w) = (0.0, 0.0, 0.0, 1.0);
        }
        let trs = decompose(matrix);
        if shear(matrix, trs) > 1e-4 {
            source.warn(format!("{} contains shear, which is left out where the model is animated", matrix_at.place));
        }
        return (matrix, trs);
    }
    let mut vector = |key: &str| source.or_warn(at.get(key)?.numbers().map(Vec3::from_array), "left out");
    let (translation, scale) = (vector("translation").unwrap_or_default(), vector("scale").unwrap_or(Vec3::ONE));
    let rotation_at = at.get("rotation");
    let mut rotation = Quat::IDENTITY;
    if let Some((place, q)) =
        rotation_at.and_then(|at| Some((at.place.clone(), source.or_warn(at.numbers(), "left out")?)))
    {
        match unit(q) {
            None => {
                let q = Quat::from_array(q);
                source.warn(format!("{place} is {q}, which is not a rotation; treated as no rotation"));
            }
            Some((turned, length)) => {
                if (length - 1.0).abs() > 1e-2 {
                    source.warn(format!("{place} has length {length:.3}; normalised"));
                }
                rotation = turned;
            }
        }
    }
    (Mat4::from_scale_rotation_translation(scale, rotation, translation), (translation, rotation, scale))
}

/// Decomposes an affine matrix. A reflection becomes a negative z scale. A collapsed axis gets a scale of zero and an
/// arbitrary direction.
fn decompose(matrix: Mat4) -> (Vec3, Quat, Vec3) {
    let m = DMat4::from_cols_array(&matrix.to_cols_array().map(f64::from));
    let [cx, cy, cz] = [m.x_axis.truncate(), m.y_axis.truncate(), m.z_axis.truncate()];
    let unit = |v: DVec3| v.try_normalize();
    let x = unit(cx)
        .or_else(|| unit(cy.cross(cz)))
        .or_else(|| unit(cy.any_orthogonal_vector()))
        .or_else(|| unit(cz.any_orthogonal_vector()));
    let x = x.unwrap_or(DVec3::X);
    // Gram-Schmidt: y minus its component along x. If nothing remains, y is derived from z.
    let y = unit_or_none(cy - x * x.dot(cy), cy.length()).or_else(|| unit_or_none(cz.cross(x), cz.length()));
    let y = y.unwrap_or_else(|| x.any_orthonormal_vector());
    let z = x.cross(y);
    let rotation = glam::DQuat::from_mat3(&DMat3::from_cols(x, y, z)).as_quat().normalize();
    let scale = DVec3::new(x.dot(cx), y.dot(cy), z.dot(cz)).as_vec3();
    (matrix.w_axis.truncate(), rotation, scale)
}

fn unit_or_none(v: DVec3, of: f64) -> Option<DVec3> {
    if v.length() > 1e-9 * of { v.try_normalize() } else { None }
}

/// Returns the difference between the matrix and its recomposed parts, relative to its longest axis.
fn shear(matrix: Mat4, (translation, rotation, scale): (Vec3, Quat, Vec3)) -> f32 {
    let back = Mat3::from_mat4(Mat4::from_scale_rotation_translation(scale, rotation, translation));
    let linear = Mat3::from_mat4(matrix);
    let size = linear.x_axis.length().max(linear.y_axis.length()).max(linear.z_axis.length());
    let difference = (back - linear).to_cols_array().into_iter().fold(0.0_f32, |a, b| a.max(b.abs()));
    if size > 0.0 { difference / size } else { 0.0 }
}

/// Returns whether a matrix mirrors. Computes in f64, because the product of three small scales underflows in f32.
pub(super) fn mirrors(matrix: &Mat4) -> bool {
    DMat4::from_cols_array(&matrix.to_cols_array().map(f64::from)).determinant() < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_rebuilds(matrix: Mat4) {
        let (t, r, s) = decompose(matrix);
        assert!(r.is_normalized());
        let back = Mat4::from_scale_rotation_translation(s, r, t);
        for (a, b) in back.to_cols_array().into_iter().zip(matrix.to_cols_array()) {
            assert!((a - b).abs() < 1e-5, "{matrix} became {back}");
        }
    }

    #[test]
    fn decomposition_rebuilds_rotation_scale_and_mirroring() {
        let r = Quat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0);
        for scale in [
            Vec3::ONE,
            Vec3::new(2.0, 3.0, 0.5),
            Vec3::new(-1.0, 1.0, 1.0),
            Vec3::new(-1.0, -2.0, -3.0),
            Vec3::new(1e-3, 1e-3, 1e-3),
            Vec3::new(0.0, 1.0, 2.0),
            Vec3::new(1.0, 0.0, 2.0),
            Vec3::new(1.0, 2.0, 0.0),
            Vec3::new(0.0, 0.0, 2.0),
            Vec3::new(0.0, 2.0, 0.0),
            Vec3::new(2.0, 0.0, 0.0),
            Vec3::ZERO,
        ] {
            assert_rebuilds(Mat4::from_scale_rotation_translation(scale, r, Vec3::new(1.0, 2.0, 3.0)));
        }
    }

    #[test]
    fn shear_is_detected() {
        let sheared = Mat4::from_cols_array(&[1., 0., 0., 0., 0.5, 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.]);
        assert!(shear(sheared, decompose(sheared)) > 0.4);
        let plain = Mat4::from_rotation_y(0.7) * Mat4::from_scale(Vec3::new(2.0, -3.0, 0.1));
        assert!(shear(plain, decompose(plain)) < 1e-6);
    }

    #[test]
    fn mirroring_is_detected_at_any_scale() {
        for size in [1e-14_f32, 1.0, 1e12] {
            assert!(mirrors(&Mat4::from_scale(Vec3::new(-size, size, size))));
            assert!(!mirrors(&Mat4::from_scale(Vec3::new(-size, -size, size))));
        }
    }
}
