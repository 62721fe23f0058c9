//! Extent of a model, as a set of points that a camera must frame.

use crate::framing::outermost;
use crate::{NamedPackage, StageError};
use glam::Vec3;
use pelage_formats::meaning::hair_groups::triangle_frame;
use pelage_formats::meaning::{morphed, posed, skin_matrix};
use pelage_formats::{Animation, GeometryVertex, HairGroup, MeshView, Package, Pose, SkinVertex, TrianglePoint};
use pelage_params::glob;

/// Number of times per second at which a clip is sampled. A trot takes half a second, so each swing of a leg is sampled
/// five times.
const MOMENTS_PER_S: f32 = 20.0;
/// Minimum and maximum number of sampled times per clip. Clips of up to half a minute are sampled at the full rate.
const MOMENTS: [f32; 2] = [16.0, 600.0];
/// Minimum sum of a vertex's weights on the matching joints at which the vertex itself matches.
const MIN_MATCH_WEIGHT: f32 = 0.5;

/// Returns points that enclose one model: its vertices at rest, or those over the whole length of a clip.
///
/// For a clip, the outermost vertices of each joint are posed at twenty times per second. The other vertices stay
/// between them, except where the surface bends at a joint.
///
/// * `package`: the opened `file`
/// * `clip`: index and length in seconds, as returned by [`crate::find_clip`]
/// * `look_at`: keeps only vertices of materials or joints whose name matches; the result is empty if no name does. `*`
///   matches any number of characters and `?` a single one; case is ignored. A joint's children belong to it.
///
/// Fails with [`StageError::Package`] for a damaged package.
pub fn outline(
    file: &NamedPackage<'_>,
    package: &Package<'_>,
    clip: Option<(usize, f32)>,
    look_at: Option<&str>,
) -> Result<Vec<Vec3>, StageError> {
    let animation = package.animation().map_err(|error| file.fault(error))?.unwrap_or_default();
    let Some(mesh) = package.mesh().map_err(|error| file.fault(error))? else { return Ok(Vec::new()) };
    let kept = look_at.map(|pattern| matching_vertices(package, &mesh, &animation, pattern));
    let is_kept = |i: usize| kept.as_ref().is_none_or(|kept| kept.get(i).is_some_and(|kept| *kept));
    let mut pose = Pose::default();
    let morphs = package.morphs().map_err(|error| file.fault(error))?;
    let mut skin = mesh.skin();
    let all: Vec<_> = mesh.geometry().enumerate().map(|(i, vertex)| (i, vertex, skin.next())).collect();
    let vertices: Vec<_> = all.iter().enumerate().filter(|(i, _)| is_kept(*i)).map(|(_, vertex)| *vertex).collect();
    let mut tips = guide_tips(&package.hair_groups().map_err(|error| file.fault(error))?, &mesh);
    tips.retain(|tip| tip.corners.iter().all(|v| is_kept(*v as usize)));
    let place = |pose: &Pose, (i, vertex, skin): &SkinnedVertex| match skin {
        Some(skin) => {
            let deltas = morphs.as_ref().map_or(&[][..], |morphs| morphs.of_vertex(*i));
            Vec3::from(posed(&morphed(vertex, deltas, &pose.shifts), skin_matrix(pose, skin)).position)
        }
        None => Vec3::from(vertex.position),
    };
    let Some((clip, duration_s)) = clip.filter(|_| mesh.skin().next().is_some()) else {
        pose.sample(&animation, None, 0.0);
        let hair = tips.iter().map(|tip| tip.place(|v| place(&pose, &all[v as usize])));
        return Ok(vertices.iter().map(|vertex| place(&pose, vertex)).chain(hair).collect());
    };
    let outer = outermost_of_joints(&vertices, animation.joints.len());
    let steps = (duration_s * MOMENTS_PER_S).ceil().clamp(MOMENTS[0], MOMENTS[1]) as usize;
    let mut points = Vec::with_capacity(outer.len() * (steps + 1));
    for step in 0..=steps {
        pose.sample(&animation, Some(clip), duration_s * step as f32 / steps as f32);
        points.extend(outer.iter().map(|i| place(&pose, &vertices[*i])));
        points.extend(tips.iter().map(|tip| tip.place(|v| place(&pose, &all[v as usize]))));
    }
    Ok(points)
}

/// Index of a vertex, with its geometry and its joint weights.
type SkinnedVertex = (usize, GeometryVertex, Option<SkinVertex>);

/// Maximum number of guides sampled per group.
const MAX_TIPS: usize = 64;

struct GuideTip {
    /// Corners of the triangle that contains the guide's root.
    corners: [u32; 3],
    root: TrianglePoint,
    /// Offset from the root, in the frame of the root triangle.
    offset: Vec3,
}

impl GuideTip {
    fn place(&self, position: impl Fn(u32) -> Vec3) -> Vec3 {
        let corners = self.corners.map(position);
        self.root.position(corners) + triangle_frame(corners) * self.offset
    }
}

fn guide_tips(groups: &[HairGroup], mesh: &MeshView<'_>) -> Vec<GuideTip> {
    let indices: Vec<u32> = if groups.is_empty() { Vec::new() } else { mesh.indices().collect() };
    let of = |group: &HairGroup| {
        let roots: Vec<TrianglePoint> = group.roots().collect();
        let some = (0..roots.len()).step_by(roots.len().div_ceil(MAX_TIPS).max(1));
        let tip = |i: usize| {
            let first = 3 * roots[i].triangle as usize;
            let corners = [indices[first], indices[first + 1], indices[first + 2]];
            GuideTip { corners, root: roots[i], offset: group.guide(i).last().copied().unwrap_or_default() }
        };
        some.map(tip).collect::<Vec<_>>()
    };
    groups.iter().flat_map(of).collect()
}

/// Returns the outermost vertices of each joint, in 26 directions in the stored pose. A vertex belongs to the joint
/// that influences it most.
fn outermost_of_joints(vertices: &[SkinnedVertex], joints: usize) -> Vec<usize> {
    let mut of_joint = vec![Vec::new(); joints + 1];
    for (i, (_, _, skin)) in vertices.iter().enumerate() {
        let first = |skin: &SkinVertex| (0..4).max_by(|a, b| skin.weights[*a].total_cmp(&skin.weights[*b]));
        let joint = skin.as_ref().and_then(|skin| first(skin).map(|k| usize::from(skin.joints[k])));
        of_joint[joint.unwrap_or(joints).min(joints)].push(i);
    }
    let sides = [-1.0, 0.0, 1.0];
    let directions: Vec<Vec3> = (0..27).map(|i| Vec3::new(sides[i / 9], sides[i / 3 % 3], sides[i % 3])).collect();
    let mut outer = Vec::new();
    for owned in of_joint {
        let points: Vec<Vec3> = owned.iter().map(|i| Vec3::from(vertices[*i].1.position)).collect();
        outer.extend(outermost(&points, directions.iter().copied()).into_iter().map(|k| owned[k]));
    }
    outer
}

/// Returns for each vertex whether it belongs to a material or joint whose name matches the pattern.
fn matching_vertices(package: &Package<'_>, mesh: &MeshView<'_>, animation: &Animation, pattern: &str) -> Vec<bool> {
    let manifest = package.manifest();
    let mut nodes: Vec<bool> = Vec::with_capacity(animation.nodes.len());
    for node in &animation.nodes {
        // Parents precede their children.
        let hangs = node.parent.and_then(|parent| nodes.get(parent as usize).copied()).unwrap_or(false);
        nodes.push(hangs || glob(pattern, &node.name));
    }
    let joints: Vec<bool> =
        animation.joints.iter().map(|joint| nodes.get(joint.node as usize).copied().unwrap_or(false)).collect();
    let share = |skin: SkinVertex| -> f32 {
        let has = |k: &usize| joints.get(usize::from(skin.joints[*k])).copied().unwrap_or(false);
        (0..4).filter(has).map(|k| skin.weights[k]).sum()
    };
    let mut kept: Vec<bool> = mesh.skin().map(|skin| share(skin) >= MIN_MATCH_WEIGHT).collect();
    kept.resize(mesh.geometry().count(), false);
    for part in &manifest.parts {
        let named = manifest.materials.get(part.material as usize).is_some_and(|m| glob(pattern, &m.name));
        for index in mesh.indices().skip(part.first_index as usize).take(part.index_count as usize).filter(|_| named) {
            if let Some(kept) = kept.get_mut(index as usize) {
                *kept = true;
            }
        }
    }
    kept
}

/// Returns the error for a name that matches nothing. Its text lists the existing names.
pub fn no_match_error<'a>(
    packages: impl Iterator<Item = (&'a NamedPackage<'a>, &'a Package<'a>)>,
    part: &str,
) -> StageError {
    let mut has = Vec::new();
    for (file, package) in packages {
        let list = |names: Vec<String>| if names.is_empty() { "none".into() } else { names.join(", ") };
        let materials = package.manifest().materials.iter().map(|material| format!("{:?}", material.name)).collect();
        let animation = package.animation().ok().flatten().unwrap_or_default();
        let named = |joint: &pelage_formats::Joint| animation.nodes.get(joint.node as usize).map(|n| n.name.clone());
        let joints = animation.joints.iter().filter_map(named).map(|name| format!("{name:?}")).collect();
        has.push(format!("{} has the materials {} and the joints {}", file.name, list(materials), list(joints)));
    }
    StageError::Request {
        what: format!("look-at {part:?}"),
        reason: format!("no material and no joint with vertices has that name; {}", has.join("; ")),
    }
}
