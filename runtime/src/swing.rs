//! What the renderer keeps of the hair of each owner that moves: where its body was, and how long nothing has moved it.

use crate::instance::Instance;
use crate::params::{FrameParams, HairMotionParams};
use glam::{Mat3, Mat4, Vec3};
use pelage_formats::Pose;
use pelage_formats::meaning::hair_motion::{Capsule, steps};

/// Where a body was in the last frame.
#[derive(Clone, Debug)]
pub(crate) struct Past {
    transform: Mat4,
    colliders: Vec<Capsule>,
    params: HairMotionParams,
    cut: u32,
    step_s: f32,
    calm_s: f32,
}

/// How the hair of an instance moves in a frame.
#[derive(Clone, Debug)]
pub(crate) struct Swing {
    pub(crate) params: HairMotionParams,
    pub(crate) world_from_model: Mat3,
    /// Where the model's origin is in the world, and how far it went.
    pub(crate) origin: Vec3,
    pub(crate) went: Vec3,
    pub(crate) steps: u32,
    pub(crate) step_s: f32,
    pub(crate) before_s: f32,
    /// Before and now, relative to the origin now.
    pub(crate) colliders: Vec<[Capsule; 2]>,
    /// Hair begins as it was groomed.
    pub(crate) is_fresh: bool,
    /// Hair is at rest: nothing is to be done but for sets that were not there before.
    pub(crate) is_at_rest: bool,
}

/// The colliders of an instance in world space: those of its body, and the application's.
fn colliders(instance: &Instance, pose: &Pose) -> Vec<Capsule> {
    let of_body = instance.model.colliders().iter().map(|collider| {
        let joint = pose.joints.get(collider.joint as usize).copied().unwrap_or(Mat4::IDENTITY);
        let place = instance.transform * joint;
        let scale = Mat3::from_mat4(place).determinant().abs().cbrt();
        let [from, to] = [collider.from, collider.to].map(|end| place.transform_point3(end.into()));
        Capsule { from, to, radius_m: collider.radius * scale }
    });
    of_body.chain(instance.colliders.iter().copied()).collect()
}

/// How the hair moves in this frame, and what is to be remembered of it; `None` where none does.
///
/// * `is_posed`: the skin is another than in the frame before
pub(crate) fn swing(
    past: Option<&Past>,
    instance: &Instance,
    params: &FrameParams,
    pose: &Pose,
    is_posed: bool,
) -> Option<(Swing, Past)> {
    let (moved, rest_s) = (params.hair_motion?, instance.model.hair_rest_s()?);
    let now = colliders(instance, pose);
    let (steps, step_s) = steps(params.time_step_s);
    let is_fresh = past.is_none_or(|past| past.cut != instance.cut || past.colliders.len() != now.len());
    let wind = moved.wind;
    let is_gusty = !wind.is_still() && (wind.gust > 0.0 || wind.turbulence > 0.0) && step_s > 0.0;
    // The time of air that does not change is no change.
    let timeless = |params: HairMotionParams| params.with(|p| p.wind.time_s = 0.0);
    let is_calm = past.is_some_and(|past| {
        past.transform == instance.transform && past.colliders == now && timeless(past.params) == timeless(moved)
    });
    let is_moved = is_fresh || is_posed || is_gusty || !is_calm;
    let passed_s = steps as f32 * step_s;
    let calm_s = if is_moved { 0.0 } else { past.map_or(0.0, |past| past.calm_s) + passed_s };
    let origin = instance.transform.w_axis.truncate();
    let from = past.filter(|_| !is_fresh);
    let then = from.map_or(&now, |past| &past.colliders);
    let relative = |c: &Capsule| Capsule { from: c.from - origin, to: c.to - origin, ..*c };
    let swing = Swing {
        params: moved,
        world_from_model: Mat3::from_mat4(instance.transform),
        origin,
        went: from.map_or(Vec3::ZERO, |past| origin - past.transform.w_axis.truncate()),
        steps,
        step_s,
        before_s: from.filter(|past| past.step_s > 0.0).map_or(step_s, |past| past.step_s),
        colliders: then.iter().zip(&now).map(|(a, b)| [relative(a), relative(b)]).collect(),
        is_fresh,
        is_at_rest: !is_moved && (calm_s > rest_s || step_s == 0.0),
    };
    let step_s = if step_s > 0.0 { step_s } else { swing.before_s };
    let past = Past { transform: instance.transform, colliders: now, params: moved, cut: instance.cut, step_s, calm_s };
    Some((swing, past))
}
