//! Hair motion state that the renderer keeps per owner: the last transform of the owner's body, and how long the body
//! has not moved.
//!
//! The hair of an owner advances by one update when the time of its frames changes. Updates are numbered, and each
//! strand set stores the number of the last one applied to it. If several cameras show the same time, each visible
//! strand set is therefore simulated only once.

use crate::instance::Instance;
use crate::params::{HairMotionParams, Wind};
use crate::shared::shader_struct::shader_struct;
use glam::{Mat3, Mat4, Vec3};
use pelage_formats::Pose;
use pelage_formats::meaning::hair_motion::{Capsule, steps};

/// Period after which the wind's time restarts at 0, seconds. It keeps that time precise as an f32. The jump at the
/// restart is visible only if a gust is blowing then.
const WIND_REPEATS_S: f64 = 4096.0;

/// State of a body in the last frame that advanced its hair.
#[derive(Clone, Debug)]
pub(crate) struct GuideMotionState {
    transform: Mat4,
    colliders: Vec<Capsule>,
    cut: u32,
    time_s: f64,
    step_s: f32,
    frame_s: f32,
    calm_s: f32,
    swing: GuideMotion,
}

/// Hair motion of an instance in a frame.
#[derive(Clone, Debug)]
pub(crate) struct GuideMotion {
    pub(crate) params: HairMotionParams,
    /// Number of this update.
    pub(crate) update: u64,
    /// Number of the previous update, if there was one.
    pub(crate) previous_update: Option<u64>,
    pub(crate) world_from_model: Mat3,
    /// World position of the model's origin.
    pub(crate) origin: Vec3,
    /// Displacement of the origin since the previous update.
    pub(crate) displacement: Vec3,
    /// Time at which the wind is evaluated, seconds.
    pub(crate) time_s: f32,
    pub(crate) steps: u32,
    pub(crate) step_s: f32,
    pub(crate) before_s: f32,
    /// Duration of the previous frame, seconds, of which `before_s` is one step.
    pub(crate) frame_before_s: f32,
    /// Colliders before and after the frame, relative to the current origin.
    pub(crate) colliders: Vec<[Capsule; 2]>,
    /// Whether the hair is reset to its groomed state.
    pub(crate) is_fresh: bool,
    /// Whether the hair is at rest; then only newly drawn strand sets are updated.
    pub(crate) is_at_rest: bool,
}

/// Returns the colliders of an instance in world space: those of its body and those set by the application.
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

shader_struct! {
    /// Wind in a frame; layout as in `hair/wind.wgsl`.
    #[derive(Default)]
    pub(crate) struct WindBlock {
        pub(crate) velocity: [f32; 3],
        pub(crate) gust: f32,
        pub(crate) gust_s: f32,
        pub(crate) turbulence: f32,
        pub(crate) eddy_m: f32,
        pub(crate) time_s: f32,
    }
}

impl GuideMotion {
    pub(crate) fn wind(&self) -> WindBlock {
        let Wind { velocity, gust, gust_s, turbulence, eddy_m } = self.params.wind;
        WindBlock { velocity: velocity.to_array(), gust, gust_s, turbulence, eddy_m, time_s: self.time_s }
    }

    /// Returns the simulated time of the frame, seconds.
    pub(crate) fn seconds(&self) -> f32 {
        self.steps as f32 * self.step_s
    }

    /// Returns the length scale of the character: the cube root of its transform's absolute determinant.
    pub(crate) fn scale(&self) -> f32 {
        self.world_from_model.determinant().abs().cbrt()
    }
}

/// Returns the hair motion in this frame, and the state to keep. If the time is unchanged and nothing has moved, the
/// stored update is returned.
///
/// * `rest_s`: time without movement after which hair comes to rest, seconds
/// * `is_posed`: whether the surface has changed since the previous frame
/// * `life`: number for a new update
pub(crate) fn advance_motion(
    past: Option<&GuideMotionState>,
    instance: &Instance,
    (moved, time_s): (HairMotionParams, f64),
    rest_s: f32,
    pose: &Pose,
    is_posed: bool,
    life: u64,
) -> (GuideMotion, GuideMotionState) {
    let now = colliders(instance, pose);
    let past = past.filter(|past| past.cut == instance.hair_revision && past.colliders.len() == now.len());
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
    let swing = GuideMotion {
        params: moved,
        update: life,
        previous_update: past.map(|past| past.swing.update),
        world_from_model: Mat3::from_mat4(instance.transform),
        origin,
        displacement: past.map_or(Vec3::ZERO, |past| origin - past.transform.w_axis.truncate()),
        time_s: time_s.rem_euclid(WIND_REPEATS_S) as f32,
        steps,
        step_s,
        before_s: past.filter(|past| past.step_s > 0.0).map_or(step_s, |past| past.step_s),
        frame_before_s: past.filter(|past| past.frame_s > 0.0).map_or(frame_s, |past| past.frame_s),
        colliders: then.iter().zip(&now).map(|(a, b)| [relative(a), relative(b)]).collect(),
        is_fresh: past.is_none(),
        is_at_rest: !is_moved && (calm_s > rest_s || step_s == 0.0),
    };
    let past = GuideMotionState {
        transform: instance.transform,
        colliders: now,
        cut: instance.hair_revision,
        time_s,
        step_s: if step_s > 0.0 { step_s } else { swing.before_s },
        frame_s: if frame_s > 0.0 { frame_s } else { swing.frame_before_s },
        calm_s,
        swing: swing.clone(),
    };
    (swing, past)
}
