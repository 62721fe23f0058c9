//! Fitting of capsules to a body.

use glam::{Mat3, Vec3};
use pelage_formats::meaning::hair_motion::Capsule;
use pelage_formats::{BodyCollider, MeshData, Pose};

/// Minimum number of vertices that follow a joint; joints with fewer vertices have no capsule.
const FEWEST: usize = 8;
/// Share of a joint's vertices inside the capsule's radius. The other vertices stick out of the capsule: hair can enter
/// the body there, but cannot pass through it.
const INSIDE: f32 = 0.35;
/// Share of a joint's vertices beyond each end of the capsule.
const BEYOND: f32 = 0.05;
/// Minimum radius of a capsule after it was made thinner to exclude hair at rest, as a share of the fitted radius. A
/// capsule that would be thinner is omitted: hair grows through it.
const THINNEST: f32 = 0.25;
/// Largest distance between hair and a capsule, as a multiple of the longest guide's length. Capsules farther away are
/// omitted.
const NEAR: f32 = 1.5;
/// Maximum number of capsules; the largest are kept.
const MOST: usize = 24;

/// Fitted capsules and their quality.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FittedColliders {
    /// Capsules.
    pub colliders: Vec<BodyCollider>,
    /// Largest distance by which the mesh surface extends beyond the capsule of the joint that it follows, metres.
    pub gap_m: f32,
    /// Warnings about recipe tables that match no joint.
    pub warnings: Vec<String>,
}

/// Fits a capsule to the vertices that follow each joint, thin enough that hair at rest is outside.
///
/// * `pose`: rest pose; a single matrix for a mesh without a skeleton
/// * `guides`: movable points of each guide, in model space
pub fn fit(mesh: &MeshData, pose: &Pose, guides: &[Vec<Vec3>]) -> FittedColliders {
    let mut of_joint: Vec<Vec<Vec3>> = vec![Vec::new(); pose.joints.len()];
    for (v, vertex) in mesh.geometry.iter().enumerate() {
        let joint = mesh.skin.get(v).map_or(0, |skin| {
            let most = (0..4).max_by(|a, b| skin.weights[*a].total_cmp(&skin.weights[*b])).unwrap_or(0);
            skin.joints[most] as usize
        });
        if let Some(points) = of_joint.get_mut(joint) {
            points.push(vertex.position.into());
        }
    }
    let length = |guide: &Vec<Vec3>| guide.windows(2).map(|ends| ends[0].distance(ends[1])).sum::<f32>();
    let longest = guides.iter().map(length).fold(0.0, f32::max);
    let mut made: Vec<(f32, f32, BodyCollider)> = Vec::new();
    for (joint, points) in of_joint.iter().enumerate().filter(|(_, points)| points.len() >= FEWEST) {
        let to_model = pose.joints[joint];
        let volume = Mat3::from_mat4(to_model).determinant().abs();
        let scale = libm::cbrtf(volume);
        let fitted = capsule(points);
        let Capsule { from, to, radius_m: radius } = fitted;
        // Guides are in model space, so the ends of the capsule are transformed to it too.
        let [there_from, there_to] = [from, to].map(|end| to_model.transform_point3(end));
        let there = Capsule { from: there_from, to: there_to, radius_m: radius * scale };
        let clear = guides.iter().flatten().map(|p| there.nearest(*p).distance(*p)).fold(f32::INFINITY, f32::min);
        let thin = radius.min(0.98 * clear / scale.max(f32::MIN_POSITIVE));
        let is_near = clear - there.radius_m <= NEAR * longest;
        if thin.is_finite() && thin > 0.0 && thin >= THINNEST * radius && is_near {
            let gap = points.iter().map(|p| fitted.nearest(*p).distance(*p) - thin).fold(0.0, f32::max);
            let size = thin * thin * (thin + from.distance(to)) * volume;
            let collider = BodyCollider { joint: joint as u32, from: from.into(), to: to.into(), radius: thin };
            made.push((size, gap * scale, collider));
        }
    }
    made.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.2.joint.cmp(&b.2.joint)));
    made.truncate(MOST);
    let gap_m = made.iter().map(|(_, gap, _)| *gap).fold(0.0, f32::max);
    FittedColliders {
        colliders: made.into_iter().map(|(.., collider)| collider).collect(),
        gap_m,
        ..FittedColliders::default()
    }
}

/// Returns the capsule around points, in the space of the points.
fn capsule(points: &[Vec3]) -> Capsule {
    let middle = points.iter().sum::<Vec3>() / points.len() as f32;
    let axis = longest_axis(points, middle);
    let mut along: Vec<f32> = points.iter().map(|p| (*p - middle).dot(axis)).collect();
    let mut aside: Vec<f32> = points.iter().map(|p| (*p - middle).reject_from_normalized(axis).length()).collect();
    along.sort_by(f32::total_cmp);
    aside.sort_by(f32::total_cmp);
    let at = |sorted: &[f32], share: f32| sorted[((sorted.len() - 1) as f32 * share).round() as usize];
    let radius = at(&aside, INSIDE);
    let (low, high) = (at(&along, BEYOND) + radius, at(&along, 1.0 - BEYOND) - radius);
    let [low, high] = if low <= high { [low, high] } else { [0.5 * (low + high); 2] };
    Capsule { from: middle + axis * low, to: middle + axis * high, radius_m: radius }
}

/// Returns the direction of largest variance, by the power method on the points' covariance.
fn longest_axis(points: &[Vec3], middle: Vec3) -> Vec3 {
    let outer = |p: Vec3| Mat3::from_cols(p * p.x, p * p.y, p * p.z);
    let covariance = points.iter().fold(Mat3::ZERO, |sum, p| sum + outer(*p - middle));
    // At least one of the three start vectors is not perpendicular to the axis of largest variance.
    let begin = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| covariance * axis);
    let begin = begin.into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or(Vec3::Y);
    (0..64).fold(begin.normalize_or(Vec3::Y), |axis, _| (covariance * axis).normalize_or(axis))
}
