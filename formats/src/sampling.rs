//! What the `ANIM` section means: clip and time to joint matrices. Bake (rest state) and runtime (every frame) share it.

use crate::sections::animation::{Animation, Channel, Interpolation, Property};
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
    /// Times before the first and after the last key hold that key's value, and a NaN time counts as before the first; looping
    /// is the caller's choice.
    ///
    /// Never panics and never gives NaN, whatever the animation: a channel whose counts do not fit leaves the node at rest, a
    /// rotation without direction (0, 0, 0, 0) is no rotation, and a matrix whose numbers overflow f32 is the identity.
    pub fn sample(&mut self, animation: &Animation, clip: Option<usize>, time_s: f32) {
        self.place(animation, locals(animation, clip, time_s));
    }

    /// Poses the skeleton by several moments, of one clip or of more, one after another: each goes over, by its share, from what those before it come to.
    /// None at all is the pose at rest. So a character goes from one motion into the next, and into a third before it has arrived.
    ///
    /// Nodes go straight from one place and scale to the other and turn the shorter way, each about its parent, so that limbs keep their lengths.
    /// Else as [`Self::sample`].
    pub fn blend(&mut self, animation: &Animation, layers: &[ClipLayer]) {
        let mut all = locals(animation, None, 0.0);
        for ClipLayer { clip, time_s, share } in layers {
            let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
            for (node, other) in all.iter_mut().zip(locals(animation, *clip, *time_s)) {
                node.go_over(other, share);
            }
        }
        self.place(animation, all);
    }

    fn place(&mut self, animation: &Animation, locals: Vec<Local>) {
        self.nodes.clear();
        for (node, Local { translation, rotation, scale }) in animation.nodes.iter().zip(locals) {
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

/// A moment of a clip, and how far a pose goes over to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipLayer {
    /// Index of the clip; `None`, or one that does not exist, is the pose at rest.
    pub clip: Option<usize>,
    /// Seconds.
    pub time_s: f32,
    /// Of it, 0..=1, the rest is of what the layers before it come to; outside and for NaN the nearest of these, 0.
    pub share: f32,
}

/// Where a node is in its parent's space.
struct Local {
    translation: Vec3,
    rotation: Quat,
    scale: Vec3,
}

impl Local {
    fn go_over(&mut self, other: Self, share: f32) {
        if share >= 1.0 {
            // Exactly, whatever was before.
            *self = other;
            return;
        }
        self.translation = self.translation.lerp(other.translation, share);
        self.scale = self.scale.lerp(other.scale, share);
        // glam's slerp takes the shorter arc.
        #[expect(clippy::disallowed_methods, reason = "a pose is drawn, no package keeps it")]
        let turned = normalize_or_identity(self.rotation).slerp(normalize_or_identity(other.rotation), share);
        self.rotation = turned;
    }
}

/// One per node.
fn locals(animation: &Animation, clip: Option<usize>, time_s: f32) -> Vec<Local> {
    let at_rest = animation.nodes.iter().map(|node| Local {
        translation: node.translation.into(),
        rotation: Quat::from_array(node.rotation),
        scale: node.scale.into(),
    });
    let mut locals: Vec<Local> = at_rest.collect();
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

/// A zero quaternion (from cubic keys that cross the origin, or a broken file) has no direction: no rotation then. Dividing by
/// the largest component first keeps the squares of very short and very long ones in range.
fn normalize_or_identity(q: Quat) -> Quat {
    let largest = q.x.abs().max(q.y.abs()).max(q.z.abs()).max(q.w.abs());
    if q.is_finite() && largest >= f32::MIN_POSITIVE {
        Quat::from_vec4((Vec4::from(q) / largest).normalize())
    } else {
        Quat::IDENTITY
    }
}

/// The channel's value, in as many components as its property has; `None` where its counts do not fit.
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
    let times = &channel.times;
    let next = times.partition_point(|t| *t <= time_s);
    if next == 0 {
        return Some(key(0));
    }
    if next == times.len() {
        return Some(key(next - 1));
    }
    let before = next - 1;
    // In f64, where the distance of any two f32 is finite and not zero.
    let span = f64::from(times[next]) - f64::from(times[before]);
    let t = ((f64::from(time_s) - f64::from(times[before])) / span) as f32;
    let span = span as f32;
    let rotation = channel.property == Property::Rotation;
    Some(match channel.interpolation {
        Interpolation::Step => key(before),
        Interpolation::Linear if rotation => {
            let (a, b) = (Quat::from_vec4(key(before)), Quat::from_vec4(key(next)));
            // glam's slerp takes the shorter arc, as glTF asks.
            #[expect(clippy::disallowed_methods, reason = "a pose is drawn, no package keeps it")]
            let turned = normalize_or_identity(a).slerp(normalize_or_identity(b), t);
            turned.into()
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
    })
}
