//! Frame of a head.

use glam::Vec3;

/// Frame of a head. Lengths are in units of the model's size.
#[derive(Clone, Copy, Debug)]
pub(super) struct HeadFrame {
    pub(super) nose: Vec3,
    /// Unit direction of the snout.
    pub(super) axis: Vec3,
    /// Unit normal of the plane of symmetry.
    pub(super) across: Vec3,
    /// Unit direction across both.
    pub(super) up: Vec3,
    /// About the length of the head without ears.
    pub(super) length: f32,
}

impl HeadFrame {
    /// Returns the frame of a head; `None` if it has no length.
    ///
    /// * `nose`, `middle`: tip of the nose, and centre of the head
    /// * `forward`: horizontal or falling direction in the plane of symmetry
    pub(super) fn new(nose: Vec3, middle: Vec3, forward: Vec3) -> Option<Self> {
        let across = forward.cross(Vec3::Y).try_normalize()?;
        let way = (nose - middle).reject_from_normalized(across);
        let axis = way.try_normalize()?;
        Some(Self { nose, axis, across, up: across.cross(axis), length: 2.0 * way.length() })
    }

    /// Returns coordinates in lengths of the head: distance behind the nose, to the side, and above the axis.
    pub(super) fn coordinates(&self, p: Vec3) -> Vec3 {
        let d = (p - self.nose) / self.length;
        Vec3::new(-d.dot(self.axis), d.dot(self.across), d.dot(self.up))
    }

    /// Whether a spot with this centre is the nose.
    pub(super) fn is_nose(&self, center: Vec3) -> bool {
        let at = self.coordinates(center);
        at.length() < 0.3 && at.y.abs() < 0.1
    }
}
