//! What the `ANIM` section means: clip and time to joint matrices. Bake (rest state) and runtime (every frame) share it.

use crate::animation::{Animation, Channel, Interpolation, Property};
use glam::{Mat4, Quat, Vec3, Vec4};

/// Joint matrices of one moment. Keep it between frames: its buffers are reused.
#[derive(Clone, Debug, Default)]
pub struct Pose {
    /// Mesh space to world space, one per joint.
    pub joints: Vec<Mat4>,
    /// Node to world, one per node.
    pub nodes: Vec<Mat4>,
}

impl Pose {
    /// Poses the skeleton at `time_s` of clip number `clip`, or at rest for `None` or a clip that does not exist.
    ///
    /// Times before the first and after the last key hold that key's value; looping is the caller's choice.
    pub fn sample(&mut self, animation: &Animation, clip: Option<usize>, time_s: f32) {
        let mut locals: Vec<(Vec3, Quat, Vec3)> = animation
            .nodes
            .iter()
            .map(|n| (n.translation.into(), Quat::from_array(n.rotation), n.scale.into()))
            .collect();
        let channels = clip.and_then(|c| animation.clips.get(c)).map_or(&[][..], |c| &c.channels);
        for channel in channels {
            let Some((translation, rotation, scale)) = locals.get_mut(channel.node as usize) else { continue };
            let value = sample_channel(channel, time_s);
            match channel.property {
                Property::Translation => *translation = value.truncate(),
                Property::Rotation => *rotation = Quat::from_vec4(value),
                Property::Scale => *scale = value.truncate(),
            }
        }
        self.nodes.clear();
        for (node, (translation, rotation, scale)) in animation.nodes.iter().zip(locals) {
            let rotation = normalize_or_identity(rotation);
            let local = Mat4::from_scale_rotation_translation(scale, rotation, translation);
            let world = match node.parent.and_then(|p| self.nodes.get(p as usize)) {
                Some(parent) => *parent * local,
                None => local,
            };
            self.nodes.push(world);
        }
        self.joints.clear();
        self.joints.extend(animation.joints.iter().map(|joint| {
            let node = self.nodes.get(joint.node as usize).copied().unwrap_or(Mat4::IDENTITY);
            node * Mat4::from_cols_array(&joint.inverse_bind)
        }));
    }
}

/// A zero quaternion (from cubic keys that cross the origin, or a broken file) has no direction: no rotation then.
fn normalize_or_identity(q: Quat) -> Quat {
    if q.length_squared() > 1e-12 && q.is_finite() { q.normalize() } else { Quat::IDENTITY }
}

fn sample_channel(channel: &Channel, time_s: f32) -> Vec4 {
    let n = channel.property.components();
    let value = |index: usize| {
        let mut v = Vec4::ZERO;
        for (k, x) in channel.values[index * n..(index + 1) * n].iter().enumerate() {
            v[k] = *x;
        }
        v
    };
    let cubic = channel.interpolation == Interpolation::Cubic;
    let key = |k: usize| if cubic { value(3 * k + 1) } else { value(k) };
    let times = &channel.times;
    let next = times.partition_point(|t| *t <= time_s);
    if next == 0 {
        return key(0);
    }
    if next == times.len() {
        return key(next - 1);
    }
    let before = next - 1;
    let span = times[next] - times[before];
    let t = (time_s - times[before]) / span;
    let rotation = channel.property == Property::Rotation;
    match channel.interpolation {
        Interpolation::Step => key(before),
        Interpolation::Linear if rotation => {
            let (a, b) = (Quat::from_vec4(key(before)), Quat::from_vec4(key(next)));
            // glam's slerp takes the shorter arc, as glTF asks.
            normalize_or_identity(a).slerp(normalize_or_identity(b), t).into()
        }
        Interpolation::Linear => key(before).lerp(key(next), t),
        Interpolation::Cubic => {
            let (out_tangent, in_tangent) = (value(3 * before + 2) * span, value(3 * next) * span);
            let (t2, t3) = (t * t, t * t * t);
            // glTF 2.0, appendix C.5: cubic Hermite with tangents scaled by the key distance.
            key(before) * (2.0 * t3 - 3.0 * t2 + 1.0)
                + out_tangent * (t3 - 2.0 * t2 + t)
                + key(next) * (3.0 * t2 - 2.0 * t3)
                + in_tangent * (t3 - t2)
        }
    }
}
