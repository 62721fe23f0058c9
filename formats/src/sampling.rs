//! Sampling of the `ANIM` section: clip and time to joint matrices. Used by bake (rest state) and runtime (every
//! frame).

use crate::sections::animation::{Animation, Channel, Interpolation, MorphChannel, Property};
use glam::{Mat4, Quat, Vec3, Vec4};

/// Joint matrices at one time. Keep a `Pose` between frames to reuse its buffers.
#[derive(Clone, Debug, Default)]
pub struct Pose {
    /// Transforms from mesh space to world space, one per joint.
    pub joints: Vec<Mat4>,
    /// Transforms from node to world space, one per node.
    pub nodes: Vec<Mat4>,
    /// Difference of each morph target's weight from its value at rest, one per target.
    pub shifts: Vec<f32>,
}

impl Pose {
    /// Poses the skeleton at `time_s` of clip number `clip`; at rest for `None` or a clip that does not exist.
    ///
    /// Times before the first and after the last key use that key's value; a NaN time uses the first. Looping is up to
    /// the caller.
    ///
    /// Never panics and never gives NaN, whatever the animation. A channel with inconsistent counts leaves the node at
    /// rest. A rotation without direction (0, 0, 0, 0) and a matrix that overflows f32 become the identity.
    pub fn sample(&mut self, animation: &Animation, clip: Option<usize>, time_s: f32) {
        self.place(animation, locals(animation, clip, time_s));
        self.shifts = shifts(animation, clip, time_s);
    }

    /// Poses the skeleton by several layers, of one clip or several, applied in order. Each layer is blended over the
    /// result of the layers before it, by its share. Without layers the pose is at rest. A character can thus blend
    /// from one motion into the next, and into a third before the second is fully reached.
    ///
    /// Translations and scales are interpolated linearly. Rotations take the shorter arc, each about the node's parent,
    /// so that limbs keep their lengths. Weights of morph targets are interpolated linearly. Everything else is as for
    /// [`Self::sample`].
    pub fn blend(&mut self, animation: &Animation, layers: &[ClipLayer]) {
        let mut all = locals(animation, None, 0.0);
        self.shifts = shifts(animation, None, 0.0);
        for ClipLayer { clip, time_s, share } in layers {
            let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
            for (node, other) in all.iter_mut().zip(locals(animation, *clip, *time_s)) {
                node.blend_to(other, share);
            }
            for (shift, other) in self.shifts.iter_mut().zip(shifts(animation, *clip, *time_s)) {
                *shift = if share >= 1.0 { other } else { *shift + (other - *shift) * share };
            }
        }
        self.place(animation, all);
    }

    /// Sets the weights of some morph targets; the others keep theirs. Targets that do not exist are ignored. A weight
    /// that is not finite is replaced by the weight at rest.
    pub fn morph(&mut self, animation: &Animation, weights: &[(usize, f32)]) {
        let targets = &animation.morphs.targets;
        self.shifts.resize(targets.len(), 0.0);
        for (target, weight) in weights {
            if let (Some(shift), Some(target)) = (self.shifts.get_mut(*target), targets.get(*target)) {
                *shift = Some(weight - target.weight).filter(|shift| shift.is_finite()).unwrap_or_default();
            }
        }
    }

    fn place(&mut self, animation: &Animation, locals: Vec<LocalTransform>) {
        self.nodes.clear();
        for (node, LocalTransform { translation, rotation, scale }) in animation.nodes.iter().zip(locals) {
            let rotation = normalize_or_identity(rotation);
            let local = Mat4::from_scale_rotation_translation(scale, rotation, translation);
            let world = match node.parent.and_then(|p| self.nodes.get(p as usize)) {
                Some(parent) => *parent * local,
                None => local,
            };
            self.nodes.push(finite_or_identity(world));
        }
        self.joints.clear();
        self.joints.extend(animation.joints.iter().map(|joint| {
            let node = self.nodes.get(joint.node as usize).copied().unwrap_or(Mat4::IDENTITY);
            finite_or_identity(node * Mat4::from_cols_array(&joint.inverse_bind))
        }));
    }
}

/// Time in a clip, and the clip's share in a blended pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipLayer {
    /// Index of the clip; the pose at rest for `None` or a clip that does not exist.
    pub clip: Option<usize>,
    /// Time in the clip, seconds.
    pub time_s: f32,
    /// Share of this layer, 0..=1; the rest comes from the layers before it. Clamped; NaN counts as 0.
    pub share: f32,
}

/// Transform of a node in its parent's space.
struct LocalTransform {
    translation: Vec3,
    rotation: Quat,
    scale: Vec3,
}

impl LocalTransform {
    fn blend_to(&mut self, other: Self, share: f32) {
        // At shares 0 and 1, one of both is kept: unlike interpolation, this is exact.
        if share <= 0.0 {
            return;
        }
        if share >= 1.0 {
            *self = other;
            return;
        }
        self.translation = self.translation.lerp(other.translation, share);
        self.scale = self.scale.lerp(other.scale, share);
        // glam's slerp takes the shorter arc.
        #[expect(clippy::disallowed_methods, reason = "poses are only drawn, never stored in a package")]
        let turned = normalize_or_identity(self.rotation).slerp(normalize_or_identity(other.rotation), share);
        self.rotation = turned;
    }
}

fn locals(animation: &Animation, clip: Option<usize>, time_s: f32) -> Vec<LocalTransform> {
    let at_rest = animation.nodes.iter().map(|node| LocalTransform {
        translation: node.translation.into(),
        rotation: Quat::from_array(node.rotation),
        scale: node.scale.into(),
    });
    let mut locals: Vec<LocalTransform> = at_rest.collect();
    let channels = clip.and_then(|c| animation.clips.get(c)).map_or(&[][..], |c| &c.channels);
    for channel in channels {
        let Some(local) = locals.get_mut(channel.node as usize) else { continue };
        let Some(value) = sample_channel(channel, time_s) else { continue };
        match channel.property {
            Property::Translation => local.translation = value.truncate(),
            Property::Rotation => local.rotation = Quat::from_vec4(value),
            Property::Scale => local.scale = value.truncate(),
        }
    }
    locals
}

fn finite_or_identity(matrix: Mat4) -> Mat4 {
    if matrix.is_finite() { matrix } else { Mat4::IDENTITY }
}

/// Returns `q` at unit length. A zero quaternion (from cubic keys that cross the origin, or a damaged file) becomes the
/// identity. Dividing by the largest component first keeps the squares of very short and very long quaternions in
/// range.
fn normalize_or_identity(q: Quat) -> Quat {
    let largest = q.x.abs().max(q.y.abs()).max(q.z.abs()).max(q.w.abs());
    if q.is_finite() && largest >= f32::MIN_POSITIVE {
        Quat::from_vec4((Vec4::from(q) / largest).normalize())
    } else {
        Quat::IDENTITY
    }
}

/// Returns the channel's value at `time_s`, with as many components as its property has; `None` if its counts are
/// inconsistent.
fn sample_channel(channel: &Channel, time_s: f32) -> Option<Vec4> {
    let n = channel.property.components();
    if channel.expected_values() != Some(channel.values.len()) {
        return None;
    }
    let value = |index: usize| {
        let mut v = Vec4::ZERO;
        for (k, x) in channel.values[index * n..(index + 1) * n].iter().enumerate() {
            v[k] = *x;
        }
        v
    };
    let cubic = channel.interpolation == Interpolation::Cubic;
    let key = |k: usize| if cubic { value(3 * k + 1) } else { value(k) };
    let (before, t, span) = match key_position(&channel.times, time_s) {
        KeyPosition::Key(k) => return Some(key(k)),
        KeyPosition::Between { before, t, span_s } => (before, t, span_s),
    };
    let next = before + 1;
    let rotation = channel.property == Property::Rotation;
    Some(match channel.interpolation {
        Interpolation::Step => key(before),
        Interpolation::Linear if rotation => {
            let (a, b) = (Quat::from_vec4(key(before)), Quat::from_vec4(key(next)));
            // glam's slerp takes the shorter arc, as glTF requires.
            #[expect(clippy::disallowed_methods, reason = "poses are only drawn, never stored in a package")]
            let turned = normalize_or_identity(a).slerp(normalize_or_identity(b), t);
            turned.into()
        }
        Interpolation::Linear => key(before).lerp(key(next), t),
        Interpolation::Cubic => {
            let [a, out_of_a, b, into_b] = hermite(t, span);
            key(before) * a + value(3 * before + 2) * out_of_a + key(next) * b + value(3 * next) * into_b
        }
    })
}

/// Returns the difference of each target's weight from its value at rest.
fn shifts(animation: &Animation, clip: Option<usize>, time_s: f32) -> Vec<f32> {
    let motion = &animation.morphs;
    let mut shifts = vec![0.0; motion.targets.len()];
    for channel in motion.channels.iter().filter(|channel| Some(channel.clip as usize) == clip) {
        let first = channel.target as usize;
        for k in 0..channel.count as usize {
            let (Some(shift), Some(target)) = (shifts.get_mut(first + k), motion.targets.get(first + k)) else { break };
            let found = sample_weight(channel, k, time_s).map(|weight| weight - target.weight);
            *shift = found.filter(|shift| shift.is_finite()).unwrap_or_default();
        }
    }
    shifts
}

/// Returns the weight of the channel's target number `k` at `time_s`; `None` if its counts are inconsistent.
fn sample_weight(channel: &MorphChannel, k: usize, time_s: f32) -> Option<f32> {
    if channel.times.is_empty() || channel.expected_values() != Some(channel.values.len()) {
        return None;
    }
    let value = |row: usize| channel.values[row * channel.count as usize + k];
    let cubic = channel.interpolation == Interpolation::Cubic;
    let key = |k: usize| if cubic { value(3 * k + 1) } else { value(k) };
    Some(match key_position(&channel.times, time_s) {
        KeyPosition::Key(k) => key(k),
        KeyPosition::Between { before, t, span_s } => match channel.interpolation {
            Interpolation::Step => key(before),
            Interpolation::Linear => key(before) + (key(before + 1) - key(before)) * t,
            Interpolation::Cubic => {
                let [a, out_of_a, b, into_b] = hermite(t, span_s);
                key(before) * a
                    + value(3 * before + 2) * out_of_a
                    + key(before + 1) * b
                    + value(3 * before + 3) * into_b
            }
        },
    })
}

/// Position of a time relative to a channel's keys.
enum KeyPosition {
    /// Before the first key, or at or after the last: the value of this key holds.
    Key(usize),
    /// Between key `before` and the next, `span_s` seconds later, at the fraction `t`, 0..1.
    Between { before: usize, t: f32, span_s: f32 },
}

/// Returns the position of a time among `times`, which are ascending and not empty.
fn key_position(times: &[f32], time_s: f32) -> KeyPosition {
    let next = times.partition_point(|t| *t <= time_s);
    if next == 0 || next == times.len() {
        return KeyPosition::Key(next.saturating_sub(1));
    }
    let before = next - 1;
    // Compute in f64, in which the difference of two distinct f32 is finite and not zero.
    let span = f64::from(times[next]) - f64::from(times[before]);
    let t = ((f64::from(time_s) - f64::from(times[before])) / span) as f32;
    KeyPosition::Between { before, t, span_s: span as f32 }
}

/// Returns the factors of a key's value, its out-tangent, the next key's value and that key's in-tangent, at fraction
/// `t` between them. See glTF 2.0, appendix C.5: cubic Hermite with tangents scaled by the key distance.
fn hermite(t: f32, span_s: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [2.0 * t3 - 3.0 * t2 + 1.0, (t3 - 2.0 * t2 + t) * span_s, 3.0 * t2 - 2.0 * t3, (t3 - t2) * span_s]
}
