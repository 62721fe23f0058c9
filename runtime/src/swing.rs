//! What the renderer keeps of the hair of each owner that moves: where its body was, and how long nothing has moved it.
//!
//! An owner's hair lives from one moment to the next. A life has a number; each set of strands knows the last that it lived through, so that a moment that
//! several cameras look at is lived through once, by each set that any of them draws.

use crate::instance::Instance;
use crate::params::{HairMotionParams, Wind};
use bytemuck::{Pod, Zeroable};
use glam::{Mat3, Mat4, Vec3};
use pelage_formats::Pose;
use pelage_formats::meaning::hair_motion::{Capsule, steps};

/// The time of the wind is told in f32: so many seconds after its beginning it begins again, which nobody sees but in the gust that blows then.
const WIND_REPEATS_S: f64 = 4096.0;

/// Where a body was in the last frame that moved its hair.
#[derive(Clone, Debug)]
pub(crate) struct Past {
    transform: Mat4,
    colliders: Vec<Capsule>,
    cut: u32,
    time_s: f64,
    step_s: f32,
    frame_s: f32,
    calm_s: f32,
    swing: Swing,
}

/// How the hair of an instance moves in a frame.
#[derive(Clone, Debug)]
pub(crate) struct Swing {
    pub(crate) params: HairMotionParams,
    /// Its number, and that of the life before, if there was one.
    pub(crate) life: u64,
    pub(crate) follows: Option<u64>,
    pub(crate) world_from_model: Mat3,
    /// Where the model's origin is in the world, and how far it went.
    pub(crate) origin: Vec3,
    pub(crate) went: Vec3,
    /// The moment as the wind knows it.
    pub(crate) time_s: f32,
    pub(crate) steps: u32,
    pub(crate) step_s: f32,
    pub(crate) before_s: f32,
    /// How long the frame before was, of which those are steps.
    pub(crate) frame_before_s: f32,
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

/// What the air does in a frame, as `hair/wind.wgsl` has it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct WindBlock {
    pub(crate) velocity: [f32; 3],
    pub(crate) gust: f32,
    pub(crate) gust_s: f32,
    pub(crate) turbulence: f32,
    pub(crate) eddy_m: f32,
    pub(crate) time_s: f32,
}

impl Swing {
    /// What the air does.
    pub(crate) fn wind(&self) -> WindBlock {
        let Wind { velocity, gust, gust_s, turbulence, eddy_m } = self.params.wind;
        WindBlock { velocity: velocity.to_array(), gust, gust_s, turbulence, eddy_m, time_s: self.time_s }
    }

    /// How long the frame is for hair.
    pub(crate) fn seconds(&self) -> f32 {
        self.steps as f32 * self.step_s
    }

    /// Scale of lengths of the character.
    pub(crate) fn scale(&self) -> f32 {
        self.world_from_model.determinant().abs().cbrt()
    }
}

/// How the hair moves in this frame, and what is to be remembered of it. It is the life that was remembered where this frame is of
/// the same moment and nothing is elsewhere.
///
/// * `rest_s`: seconds after which it has come to rest where nothing moves it
/// * `is_posed`: the skin is another than in the frame before
/// * `life`: the number of a new life
pub(crate) fn swing(
    past: Option<&Past>,
    instance: &Instance,
    (moved, time_s): (HairMotionParams, f64),
    rest_s: f32,
    pose: &Pose,
    is_posed: bool,
    life: u64,
) -> (Swing, Past) {
    let now = colliders(instance, pose);
    let past = past.filter(|past| past.cut == instance.cut && past.colliders.len() == now.len());
    let is_calm = !is_posed
        && past.is_some_and(|past| {
            past.transform == instance.transform && past.colliders == now && past.swing.params == moved
        });
    if let Some(past) = past.filter(|past| is_calm && past.time_s == time_s) {
        return (past.swing.clone(), past.clone());
    }
    let passed_s = past.map_or(0.0, |past| (time_s - past.time_s).max(0.0) as f32);
    let (steps, step_s) = steps(passed_s);
    let is_moved = !is_calm || moved.wind.changes() && step_s > 0.0;
    let frame_s = steps as f32 * step_s;
    let calm_s = if is_moved { 0.0 } else { past.map_or(0.0, |past| past.calm_s) + frame_s };
    let origin = instance.transform.w_axis.truncate();
    let then = past.map_or(&now, |past| &past.colliders);
    let relative = |c: &Capsule| Capsule { from: c.from - origin, to: c.to - origin, ..*c };
    let swing = Swing {
        params: moved,
        life,
        follows: past.map(|past| past.swing.life),
        world_from_model: Mat3::from_mat4(instance.transform),
        origin,
        went: past.map_or(Vec3::ZERO, |past| origin - past.transform.w_axis.truncate()),
        time_s: time_s.rem_euclid(WIND_REPEATS_S) as f32,
        steps,
        step_s,
        before_s: past.filter(|past| past.step_s > 0.0).map_or(step_s, |past| past.step_s),
        frame_before_s: past.filter(|past| past.frame_s > 0.0).map_or(frame_s, |past| past.frame_s),
        colliders: then.iter().zip(&now).map(|(a, b)| [relative(a), relative(b)]).collect(),
        is_fresh: past.is_none(),
        is_at_rest: !is_moved && (calm_s > rest_s || step_s == 0.0),
    };
    let past = Past {
        transform: instance.transform,
        colliders: now,
        cut: instance.cut,
        time_s,
        step_s: if step_s > 0.0 { step_s } else { swing.before_s },
        frame_s: if frame_s > 0.0 { frame_s } else { swing.frame_before_s },
        calm_s,
        swing: swing.clone(),
    };
    (swing, past)
}
