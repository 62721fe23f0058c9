//! Assembly of the meshes of all nodes into one mesh. It is in world space if nothing moves, else bound to joints.

use super::json::JsonNode;
use super::options::ImportOptions;
use super::primitive::{MeshTotals, MeshUse, Primitive, read_mesh};
use super::scene::{MeshVisibility, Tree, mirrors};
use super::skin::Joints;
use super::source::Source;
use super::{clips, comb_lines, hidden, morphs, normals, orient, unfold};
use crate::BakeError;
use crate::mesh::{Mesh, MeshPart, Model, NamedPosition, RestPose};
use glam::{Mat3, Mat4, Quat, Vec3};
use pelage_formats::meaning::transform_normal;
use pelage_formats::{Animation, Joint, MorphMotion, Node, SkinVertex};
use std::collections::BTreeMap;
use std::ops::Range;
use std::rc::Rc;

/// A mesh that a node shows.
struct Instance<'a> {
    /// Node of the document; `None` in a document without nodes.
    node: Option<usize>,
    skin: Option<usize>,
    /// Names of the node and the mesh; empty names are omitted.
    names: Vec<String>,
    primitives: Rc<Vec<Primitive<'a>>>,
}

impl Instance<'_> {
    /// Adds the instance's morph targets to those of the model. Returns the index of the first target added, or `None`
    /// if the instance has no node or no targets.
    fn first_target(
        &self,
        tree: &Tree<'_>,
        morphed: &mut morphs::ModelMorphs,
        number: impl Fn(usize) -> u32,
    ) -> Result<Option<u32>, BakeError> {
        let first = self.primitives.iter().find_map(|p| p.morph.as_ref());
        let (Some(node), Some(morph)) = (self.node, first) else { return Ok(None) };
        if let Some(other) = self.primitives.iter().find(|p| p.morph.as_ref().is_some_and(|m| m.count != morph.count)) {
            let (found, expected) = (other.morph.as_ref().map_or(0, |m| m.count), morph.count);
            let at = other.at.get("targets").unwrap_or_else(|| other.at.clone());
            return Err(
                at.fault(format!("has {found} morph targets, expected {expected} like the mesh's other primitives"))
            );
        }
        morphed.add_node(&tree.nodes[node].at, node, number(node), morph).map(Some)
    }
}

/// Reads the scene of a glTF document into a `Model`.
pub(super) fn model<'a>(source: &mut Source<'a, '_>, options: &ImportOptions) -> Result<Model, BakeError> {
    let tree = Tree::read(source)?;
    let turn = source.forward_turn();
    let root = Mat4::from_scale(Vec3::splat(options.unit_m)) * Mat4::from_quat(turn);
    let mut gathered = MeshTotals::default();
    let mut joints = Joints::default();
    let instances = instances(source, &tree, &mut gathered, &mut joints)?;
    if instances.iter().all(|i| i.primitives.is_empty()) {
        return Err(nothing_to_show(source, gathered.skipped, tree.hidden_meshes));
    }
    let mut memory = std::mem::take(&mut gathered.memory).before_placing();
    for primitive in instances.iter().flat_map(|i| i.primitives.iter()) {
        let deltas = primitive.morph.as_ref().map_or(0, morphs::Morph::delta_count);
        memory.place(source, &primitive.at, primitive.positions.len(), primitive.triangles.len(), deltas)?;
    }

    // Collect the range of joints that the vertices of each primitive may follow if the model moves.
    let mut followed = Vec::new();
    for instance in &instances {
        for primitive in instance.primitives.iter() {
            followed.push(joint_range(&mut joints, &tree, instance, primitive)?);
        }
    }
    let (numbers, nodes) = number_nodes(&tree, &joints, options.unit_m, turn);
    let number = |node: usize| numbers.get(node).copied().flatten().unwrap_or_default();
    let mut morphed = morphs::ModelMorphs::new();
    let first_targets = instances.iter().map(|instance| instance.first_target(&tree, &mut morphed, number));
    let first_targets = first_targets.collect::<Result<Vec<_>, _>>()?;
    let (clips, channels) = clips::read(source, &numbers, &morphed.of_nodes)?;
    let skinned = instances.iter().any(|i| i.skin.is_some() && i.primitives.iter().any(|p| p.influences.is_some()));
    let moving = skinned || !clips.is_empty() || !morphed.targets.is_empty();

    let world = tree.world(root);
    let combs = comb_lines::read_comb_lines(source, &mut memory, &tree, &world, root, &mut joints)?;
    let mut builder = Builder { mesh: Mesh::default(), places: Vec::new(), authored: Vec::new() };
    let mut followed = followed.into_iter();
    // Instances are dropped one by one, so that primitives and their copies do not all take memory at once.
    for (instance, first_target) in instances.into_iter().zip(first_targets) {
        for primitive in instance.primitives.iter() {
            let (first, count) = followed.next().unwrap_or_default();
            let placed = if moving {
                Placement::Bound { first, count }
            } else {
                Placement::At(instance.node.map_or(root, |n| world[n]))
            };
            builder.add(primitive, &instance.names, placed)?;
            let morph = primitive.morph.as_ref().zip(first_target);
            let vertices = primitive.positions.len();
            morphed.add_rows(source, &mut memory, &primitive.at, morph, vertices, &mut builder.mesh)?;
        }
    }
    let Builder { mut mesh, places, authored } = builder;
    let (targets, mut morph_rows) = morphed.finish(&mut mesh);
    let animation = moving.then(|| {
        let joints =
            joints.list.iter().map(|(node, bind)| Joint { node: number(*node), inverse_bind: *bind }).collect();
        let mut animation = Animation { nodes, joints, clips, morphs: MorphMotion { targets, channels } };
        hidden::snap_hidden_scales(&mut animation);
        unfold::unfold(&mut mesh, &mut morph_rows, &animation);
        animation
    });
    let rest = RestPose::of(&mesh, animation.as_ref());
    check_finite(&rest, &places)?;
    orient::face_outward(&mut source.notes, &mut mesh, animation.as_ref(), &rest, &authored);
    normals::flatten(&mut mesh, &authored);
    Ok(Model {
        mesh,
        materials: gathered.materials.materials,
        images: gathered.materials.images.images,
        nodes: named_nodes(&tree, &world),
        combs,
        animation,
        morph_rows,
        inputs: Vec::new(),
        warnings: Vec::new(),
    })
}

/// Returns the named nodes in tree order, parents first.
fn named_nodes(tree: &Tree<'_>, world: &[Mat4]) -> Vec<NamedPosition> {
    let place = |node: &usize| NamedPosition {
        name: tree.nodes[*node].at.name().to_owned(),
        position_ws: world[*node].w_axis.truncate(),
    };
    let is_one = |place: &NamedPosition| !place.name.is_empty() && place.position_ws.is_finite();
    let of_document = |node: &&usize| tree.nodes[**node].shows != MeshVisibility::Instance;
    tree.order.iter().filter(of_document).map(place).filter(is_one).collect()
}

/// Reads the mesh of each node of the scene. A mesh that several nodes use in the same way is read once.
fn instances<'a>(
    source: &mut Source<'a, '_>,
    tree: &Tree<'a>,
    gathered: &mut MeshTotals,
    joints: &mut Joints,
) -> Result<Vec<Instance<'a>>, BakeError> {
    let mut known: BTreeMap<(usize, bool, bool), Rc<Vec<Primitive<'a>>>> = BTreeMap::new();
    let mut instances = Vec::new();
    if tree.nodes.is_empty() {
        return all_meshes(source, gathered);
    }
    // If no other node has a mesh, a missing mesh is an error.
    let is_only_one = tree.shown().filter(|node| tree.nodes[*node].at.get("mesh").is_some()).take(2).count() == 1;
    for node in tree.shown() {
        let at = &tree.nodes[node].at;
        let Some(reference) = at.get("mesh") else { continue };
        let followed = source.root.follow("meshes", &reference);
        let followed = if is_only_one { Some(followed?) } else { source.or_warn(followed, "left out") };
        let Some((index, mesh_at)) = followed else { continue };
        let skin = at.get("skin").map(|s| joints.skin(source, &s)).transpose()?;
        let weights = at.get("weights");
        let combs = [at.name(), mesh_at.name()].into_iter().any(comb_lines::is_comb_name);
        let (key, own) = ((index, skin.is_some(), combs), weights.is_some());
        let names = names([at.name(), mesh_at.name()]);
        let mesh = MeshUse { index, at: mesh_at, weights, skinned: skin.is_some(), combs };
        let primitives = match known.get(&key).filter(|_| !own) {
            Some(primitives) => primitives.clone(),
            None => {
                let primitives = Rc::new(read_mesh(source, gathered, &mesh)?);
                if !own {
                    known.insert(key, primitives.clone());
                }
                primitives
            }
        };
        if let (Some(_), Some(rigid)) = (skin, primitives.iter().find(|p| p.influences.is_none())) {
            source.warn(format!("{} has no joints, but its node has a skin; it follows the node", rigid.label));
        }
        for (skin, primitive) in skin.iter().flat_map(|skin| primitives.iter().map(move |p| (*skin, p))) {
            joints.check_binds(source, skin, &primitive.label, primitive.influences.as_deref().unwrap_or_default());
        }
        instances.push(Instance { node: Some(node), skin, names, primitives });
    }
    Ok(instances)
}

fn names<const N: usize>(names: [&str; N]) -> Vec<String> {
    names.into_iter().filter(|name| !name.is_empty()).map(str::to_owned).collect()
}

/// Reads all meshes of a document without nodes, without a transform.
///
/// By the specification such a document is a library of meshes and shows nothing. A file with one animal and no scene
/// is more likely the output of a careless exporter.
fn all_meshes<'a>(source: &mut Source<'a, '_>, gathered: &mut MeshTotals) -> Result<Vec<Instance<'a>>, BakeError> {
    let Some(meshes) = source.root.get("meshes") else { return Ok(Vec::new()) };
    source.warn("the file has no nodes; all its meshes are shown without transforms");
    let mut instances = Vec::new();
    for (index, at) in meshes.entries()?.enumerate() {
        let names = names([at.name()]);
        let mesh = MeshUse { index, combs: comb_lines::is_comb_name(at.name()), at, weights: None, skinned: false };
        let primitives = Rc::new(read_mesh(source, gathered, &mesh)?);
        instances.push(Instance { node: None, skin: None, names, primitives });
    }
    Ok(instances)
}

/// Returns the index of the first joint that a primitive can follow, and the number of these joints.
fn joint_range<'a>(
    joints: &mut Joints,
    tree: &Tree<'a>,
    instance: &Instance<'a>,
    primitive: &Primitive<'a>,
) -> Result<(usize, usize), BakeError> {
    match (instance.skin, &primitive.influences, instance.node) {
        (Some(skin), Some(_), _) => joints.of_skin(&primitive.at, skin),
        (_, _, Some(node)) => Ok((joints.of_node(&tree.nodes[node].at, node)?, 1)),
        // Without nodes nothing can move.
        (_, _, None) => Ok((0, 0)),
    }
}

/// Numbers the nodes of the joints and their ancestors, parents first. Adds a root node if the model's unit is not the
/// metre, or if the model is turned.
fn number_nodes(tree: &Tree<'_>, joints: &Joints, unit_m: f32, turn: Quat) -> (Vec<Option<u32>>, Vec<Node>) {
    let mut kept = vec![false; tree.nodes.len()];
    for (node, _) in &joints.list {
        for ancestor in tree.lineage(*node) {
            if std::mem::replace(&mut kept[ancestor], true) {
                break;
            }
        }
    }
    let mut nodes = Vec::new();
    let mut unit_root = None;
    if unit_m != 1.0 || turn != Quat::IDENTITY {
        let (name, scale) = ("unit".to_owned(), [unit_m; 3]);
        nodes.push(Node { name, parent: None, translation: [0.0; 3], rotation: turn.into(), scale });
        unit_root = Some(0);
    }
    let mut numbers: Vec<Option<u32>> = vec![None; tree.nodes.len()];
    for i in tree.order.iter().filter(|i| kept[**i]) {
        let node = &tree.nodes[*i];
        let (translation, rotation, scale) = node.trs;
        numbers[*i] = Some(nodes.len() as u32);
        nodes.push(Node {
            name: node.at.name().to_owned(),
            parent: node.parent.map_or(unit_root, |p| numbers[p]),
            translation: translation.into(),
            rotation: rotation.into(),
            scale: scale.into(),
        });
    }
    (numbers, nodes)
}

/// Placement of a primitive's vertices.
#[derive(Clone, Copy)]
enum Placement {
    /// Baked to world space by this matrix.
    At(Mat4),
    /// Kept in mesh space, bound to joints `first .. first + count`.
    Bound { first: usize, count: usize },
}

struct Builder<'a> {
    mesh: Mesh,
    /// Primitive and vertex range of each part.
    places: Vec<(JsonNode<'a>, Range<usize>)>,
    /// Whether the normals of each part are stored in the file.
    authored: Vec<bool>,
}

impl<'a> Builder<'a> {
    fn add(&mut self, primitive: &Primitive<'a>, names: &[String], placed: Placement) -> Result<(), BakeError> {
        let mesh = &mut self.mesh;
        let (base, first_triangle) = (mesh.positions.len(), mesh.triangles.len());
        let mut flip = false;
        match placed {
            Placement::At(world) => {
                flip = mirrors(&world);
                mesh.positions.extend(primitive.positions.iter().map(|p| world.transform_point3(*p)));
                let linear = Mat3::from_mat4(world);
                mesh.normals.extend(primitive.normals.iter().map(|n| transform_normal(linear, *n)));
            }
            Placement::Bound { first, count } => {
                mesh.positions.extend(&primitive.positions);
                mesh.normals.extend(&primitive.normals);
                bind(primitive, first, count, &mut mesh.skin)?;
            }
        }
        mesh.uvs.extend(&primitive.uvs);
        mesh.colors.extend(&primitive.colors);
        let first = base as u32;
        mesh.triangles.extend(primitive.triangles.iter().map(|[a, b, c]| {
            let (b, c) = if flip { (c, b) } else { (b, c) };
            [first + a, first + b, first + c]
        }));
        mesh.parts.push(MeshPart {
            source: primitive.label.clone(),
            names: names.to_vec(),
            material: primitive.material,
            first_triangle,
            triangle_count: primitive.triangles.len(),
            has_uvs: primitive.has_uvs,
        });
        self.places.push((primitive.at.clone(), base..mesh.positions.len()));
        self.authored.push(primitive.has_normals);
        Ok(())
    }
}

/// Appends the joints and weights of each vertex to `skin`.
fn bind(primitive: &Primitive<'_>, first: usize, count: usize, skin: &mut Vec<SkinVertex>) -> Result<(), BakeError> {
    let Some(influences) = primitive.influences.as_ref() else {
        let rigid = SkinVertex { joints: [first as u16, 0, 0, 0], weights: [1.0, 0.0, 0.0, 0.0] };
        skin.extend(std::iter::repeat_n(rigid, primitive.positions.len()));
        return Ok(());
    };
    for (vertex, (joints, weights)) in influences.iter().enumerate() {
        let mut bound = SkinVertex { joints: [0; 4], weights: *weights };
        for ((slot, joint), weight) in bound.joints.iter_mut().zip(joints).zip(weights) {
            if *weight == 0.0 {
                continue;
            }
            if *joint as usize >= count {
                let reason = format!(
                    "vertex {vertex} follows joint {joint}, expected less than {count}, the joint count of its skin"
                );
                return Err(primitive.at.fault(reason));
            }
            *slot = (first + *joint as usize) as u16;
        }
        skin.push(bound);
    }
    Ok(())
}

/// Checks that all positions at rest are finite: a transform of finite numbers may overflow.
fn check_finite(rest: &RestPose, places: &[(JsonNode<'_>, Range<usize>)]) -> Result<(), BakeError> {
    for (at, vertices) in places {
        let positions = &rest.positions[vertices.clone()];
        if let Some(i) = positions.iter().position(|p| !p.is_finite()) {
            let found = positions[i];
            return Err(
                at.fault(format!("vertex {i} is at {found} once its nodes are applied, expected finite numbers"))
            );
        }
    }
    Ok(())
}

fn nothing_to_show(source: &Source<'_, '_>, skipped: usize, hidden: usize) -> BakeError {
    let lists = ["nodes", "meshes", "skins", "animations", "materials", "images", "cameras"];
    let has: Vec<String> = lists
        .into_iter()
        .filter_map(|list| {
            let count = source.root.get(list)?.len().ok().filter(|n| *n > 0)?;
            Some(format!("{list}: {count}"))
        })
        .collect();
    let has = if has.is_empty() { "holds nothing".to_owned() } else { format!("has {}", has.join(", ")) };
    let skipped = if skipped > 0 {
        format!("; {skipped} primitives contain only points, only lines or nothing")
    } else {
        String::new()
    };
    let hidden = if hidden > 0 { format!("; {hidden} nodes with a mesh are hidden") } else { String::new() };
    source.root.fault(format!("the scene has no triangles, expected at least one; the file {has}{skipped}{hidden}"))
}
