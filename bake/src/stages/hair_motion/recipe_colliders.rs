//! Capsules from a recipe.

use super::FittedColliders;
use crate::recipe::HairColliderParams;
use glam::{Mat3, Vec3};
use pelage_formats::{Animation, BodyCollider, HairMotion, Pose};

/// Merges the recipe's capsules with the fitted ones of all other joints. The recipe's capsules come first; the total
/// is limited to the maximum of a package.
///
/// * `pose`: rest pose; a single matrix for a mesh without a skeleton
pub fn merge(
    fitted: FittedColliders,
    given: &[HairColliderParams],
    animation: Option<&Animation>,
    pose: &Pose,
) -> FittedColliders {
    let mut warnings = fitted.warnings;
    let mut colliders: Vec<BodyCollider> = Vec::new();
    for table in given {
        match joint(table, animation) {
            Ok(joint) => colliders.extend(collider(table, joint, pose)),
            Err(reason) => warnings.push(format!("strands.collider: {:?} has no effect: {reason}", table.name)),
        }
    }
    let is_given = |joint: u32| colliders.iter().any(|collider| collider.joint == joint);
    let kept: Vec<BodyCollider> = fitted.colliders.into_iter().filter(|c| !is_given(c.joint)).collect();
    let most = HairMotion::MOST_COLLIDERS;
    if colliders.len() > most {
        warnings
            .push(format!("strands.collider: {} tables, of which the first {most} have an effect", colliders.len()));
    }
    colliders.extend(kept);
    colliders.truncate(most);
    FittedColliders { colliders, gap_m: fitted.gap_m, warnings }
}

fn joint(table: &HairColliderParams, animation: Option<&Animation>) -> Result<u32, String> {
    let joints = animation.map_or(&[][..], |animation| &animation.joints);
    let name = |joint: &pelage_formats::Joint| {
        let node = animation.and_then(|animation| animation.nodes.get(joint.node as usize));
        node.map_or("", |node| node.name.as_str())
    };
    match (&table.joint, joints.is_empty()) {
        (None, true) => Ok(0),
        (Some(wanted), true) => Err(format!("found joint {wanted:?}, expected none: the model has no skeleton")),
        (None, false) => {
            let names: Vec<_> = joints.iter().map(name).collect();
            Err(format!("found no joint, expected one of {names:?}"))
        }
        (Some(wanted), false) => {
            joints.iter().position(|joint| name(joint) == wanted).map(|i| i as u32).ok_or_else(|| {
                let names: Vec<_> = joints.iter().map(name).collect();
                format!("found joint {wanted:?}, expected one of {names:?}")
            })
        }
    }
}

/// Returns the capsule of a table, in mesh space; `None` if the joint's matrix is singular.
fn collider(table: &HairColliderParams, joint: u32, pose: &Pose) -> Option<BodyCollider> {
    let to_model = *pose.joints.get(joint as usize)?;
    let scale = libm::cbrtf(Mat3::from_mat4(to_model).determinant().abs());
    let (from, radius_m) = (table.from?, table.radius_m?);
    let to_mesh = to_model.inverse();
    let [from, to] = [from, table.to.unwrap_or(from)].map(|end| to_mesh.transform_point3(Vec3::from(end)));
    let radius = radius_m / scale;
    let sane = from.is_finite() && to.is_finite() && radius.is_finite() && radius > 0.0;
    sane.then(|| BodyCollider { joint, from: from.into(), to: to.into(), radius })
}
