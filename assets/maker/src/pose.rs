//! Poses of a model at any time of a clip, per glTF 2.0 (§3.7.3.3 and Appendix C). Used for pictures and for measuring
//! gaits.

use glam::{DAffine3, DQuat, DVec3, DVec4};

use super::glb::{Channel, Clip, Interpolation, Model, Target};

/// Returns the model with its vertices moved by `clip` at `time_s`. Times outside the keys are clamped to the first or
/// last key.
pub fn posed(model: &Model, clip: &Clip, time_s: f64) -> Model {
    let moved = skin_transforms(model, clip, time_s);
    let mut posed = model.clone();
    for p in &mut posed.primitives {
        for v in 0..p.len() {
            let own = |f: &dyn Fn(&DAffine3) -> DVec3| -> DVec3 {
                p.weights[v].iter().map(|&(joint, w)| moved.get(joint as usize).map_or(DVec3::ZERO, f) * w).sum()
            };
            let (at, n) = (p.positions[v], p.normals[v]);
            let position = own(&|m| m.transform_point3(at));
            let normal = own(&|m| m.transform_vector3(n)).normalize_or(DVec3::Y);
            (p.positions[v], p.normals[v]) = (position, normal);
        }
    }
    posed
}

/// Returns, for each joint, the transform that moves a point from the rest pose to the pose at `time_s`.
pub fn skin_transforms(model: &Model, clip: &Clip, time_s: f64) -> Vec<DAffine3> {
    let joints = model.skeleton.as_deref().unwrap_or_default();
    let mut worlds: Vec<DAffine3> = Vec::new();
    for (j, joint) in joints.iter().enumerate() {
        let (mut scale, mut rotation, mut translation) = (DVec3::ONE, DQuat::IDENTITY, joint.translation);
        for channel in clip.channels.iter().filter(|c| c.joint == j) {
            let value = sample(channel, time_s);
            match channel.target {
                Target::Rotation => rotation = DQuat::from_vec4(value).normalize(),
                Target::Scale => scale = value.truncate(),
                Target::Translation => translation = value.truncate(),
            }
        }
        let local = DAffine3::from_scale_rotation_translation(scale, rotation, translation);
        worlds.push(joint.parent.map_or(local, |parent| worlds[parent] * local));
    }
    worlds.iter().zip(joints).map(|(world, joint)| *world * DAffine3::from_translation(-joint.world)).collect()
}

/// Evaluates the channel at `time_s`. The fourth component is 0 for values with three components.
fn sample(channel: &Channel, time_s: f64) -> DVec4 {
    let width = if channel.target == Target::Rotation { 4 } else { 3 };
    let vector = |place: usize| {
        let at = |k: usize| if k < width { channel.values[place * width + k] } else { 0.0 };
        DVec4::new(at(0), at(1), at(2), at(3))
    };
    let last = channel.times.len() - 1;
    let next = channel.times.partition_point(|t| *t <= time_s);
    let (a, b) = (next.saturating_sub(1), next.min(last));
    let gap = channel.times[b] - channel.times[a];
    let share = if gap > 0.0 { ((time_s - channel.times[a]) / gap).clamp(0.0, 1.0) } else { 0.0 };
    match channel.interpolation {
        Interpolation::Linear if width == 4 => {
            #[expect(clippy::disallowed_methods, reason = "poses are for previews only; no model stores them")]
            let turned = DQuat::from_vec4(vector(a)).slerp(DQuat::from_vec4(vector(b)), share);
            turned.into()
        }
        Interpolation::Linear => vector(a).lerp(vector(b), share),
        Interpolation::CubicSpline => {
            let (from, leaving) = (vector(3 * a + 1), vector(3 * a + 2) * gap);
            let (to, arriving) = (vector(3 * b + 1), vector(3 * b) * gap);
            hermite(from, leaving, to, arriving, share)
        }
    }
}

/// Evaluates the cubic Hermite curve at `s` in 0..=1, from `from` with slope `leaving` to `to` with slope `arriving`.
pub fn hermite(from: DVec4, leaving: DVec4, to: DVec4, arriving: DVec4, s: f64) -> DVec4 {
    let (s2, s3) = (s * s, s * s * s);
    from * (2.0 * s3 - 3.0 * s2 + 1.0)
        + leaving * (s3 - 2.0 * s2 + s)
        + to * (3.0 * s2 - 2.0 * s3)
        + arriving * (s3 - s2)
}
