//! Bounding volumes in world space.

use glam::{Mat4, Vec2, Vec3, Vec4};

/// A sphere in world space, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre of the sphere.
    pub center: Vec3,
    /// Radius, at least 0.
    pub radius: f32,
}

/// Points in world space that the shadow maps must cover, each with a margin in metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Hull(pub(crate) Vec<(Vec3, f32)>);

impl Hull {
    pub(crate) fn widened(&self, by_m: f32) -> Self {
        Self(self.0.iter().map(|(point, margin)| (*point, margin + by_m)).collect())
    }

    /// Returns the least and greatest coordinate of the hull along the unit vector `axis`, relative to `origin`.
    pub(crate) fn range(&self, origin: Vec3, axis: Vec3) -> (f32, f32) {
        let along = self.0.iter().map(|(point, margin)| ((*point - origin).dot(axis), *margin));
        along.fold((f32::INFINITY, f32::NEG_INFINITY), |(min, max), (x, m)| (min.min(x - m), max.max(x + m)))
    }

    /// Returns the number of pixels per metre perpendicular to the view direction, at the point of the hull nearest to
    /// the eye. Infinite if the eye is inside the hull.
    pub(crate) fn px_per_m(&self, clip_from_view: Mat4, clip_from_world: Mat4, height_px: u32) -> f32 {
        let w = clip_from_world.row(3);
        // Length of the gradient of clip-space w. In a perspective view, w is the depth; in a parallel view, it is 1
        // everywhere.
        let reach = w.truncate().length();
        let ahead = self.0.iter().map(|(p, margin)| w.dot(p.extend(1.0)) - reach * margin);
        let nearest = ahead.fold(f32::INFINITY, f32::min);
        let px_per_m = 0.5 * height_px as f32 * clip_from_view.y_axis.y.abs() / nearest;
        if nearest > 0.0 { px_per_m } else { f32::INFINITY }
    }

    /// Returns the bounding sphere of the hull's bounding box; `None` if the hull is empty.
    pub(crate) fn sphere(&self) -> Option<Sphere> {
        let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| self.range(Vec3::ZERO, axis));
        let (min, max) = (Vec3::new(x.0, y.0, z.0), Vec3::new(x.1, y.1, z.1));
        (!self.0.is_empty()).then(|| Sphere { center: 0.5 * (min + max), radius: 0.5 * (max - min).length() })
    }

    /// Whether any part of the hull may be visible. Returns false only if the whole hull is outside one of the six
    /// planes of the view volume.
    pub(crate) fn may_be_visible(&self, clip_from_world: Mat4) -> bool {
        let rows: [Vec4; 4] = std::array::from_fn(|k| clip_from_world.row(k));
        let [x, y, z, w] = rows;
        let beyond = |side: Vec4| {
            let reach = side.truncate().length();
            self.0.iter().all(|(point, margin)| side.dot(point.extend(1.0)) + reach * margin < 0.0)
        };
        self.0.is_empty() || ![w + x, w - x, w + y, w - y, z, w - z].into_iter().any(beyond)
    }

    /// Returns the screen rectangle that may contain the hull: left, top, right and bottom, pixels. `margin_px` is
    /// added on each side. Returns the whole viewport if any part of the hull is level with the eye or behind it.
    pub(crate) fn screen_rect(&self, clip_from_world: Mat4, viewport: [u32; 2], margin_px: f32) -> [u32; 4] {
        let size = Vec2::from(viewport.map(|n| n as f32));
        let (mut least, mut most) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for (point, margin) in &self.0 {
            // Without a margin, all eight corners coincide.
            for corner in 0..if *margin > 0.0 { 8 } else { 1 } {
                let side = Vec3::from([1, 2, 4].map(|bit| if corner & bit == 0 { -1.0 } else { 1.0 }));
                let clip = clip_from_world * (*point + *margin * side).extend(1.0);
                // A NaN counts as visible, as in `may_be_visible`.
                if clip.w.is_nan() || clip.w <= 1e-6 {
                    return [0, 0, viewport[0], viewport[1]];
                }
                let place = (Vec2::new(clip.x, -clip.y) / clip.w * 0.5 + 0.5) * size;
                (least, most) = (least.min(place), most.max(place));
            }
        }
        let clamped = |v: Vec2| v.clamp(Vec2::ZERO, size).to_array().map(|n| if n.is_finite() { n as u32 } else { 0 });
        let ([left, top], [right, bottom]) = (clamped((least - margin_px).floor()), clamped((most + margin_px).ceil()));
        [left, top, right.max(left), bottom.max(top)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Projection};

    #[test]
    fn visible_bounds_are_never_culled() {
        let perspective = Projection::Perspective { fov_y_rad: 1.0, aspect: 2.0, near_m: 0.1, far_m: f32::INFINITY };
        let parallel = Projection::Orthographic { height_m: 2.0, aspect: 2.0, near_m: 0.1, far_m: 10.0 };
        for (projection, reversed) in [(perspective, false), (perspective, true), (parallel, false), (parallel, true)] {
            let camera = Camera::look_at(Vec3::Z * 5.0, Vec3::ZERO, projection);
            let clip_from_world = projection.clip_from_view(reversed) * camera.view_from_world;
            let seen = |center: Vec3, margin: f32| Hull(vec![(center, margin)]).may_be_visible(clip_from_world);
            assert!(seen(Vec3::ZERO, 0.0) && seen(Vec3::X * 1.9, 0.0), "{projection:?}");
            // The spheres are to the right of the picture, above it, and behind the eye. They are visible only if their
            // margin extends into the view.
            for (center, reach) in [(Vec3::X * 20.0, 19.0), (Vec3::Y * 20.0, 19.5), (Vec3::Z * 8.0, 3.5)] {
                assert!(!seen(center, 0.5), "{projection:?} {center}");
                assert!(seen(center, reach), "{projection:?} {center}");
            }
            // The two points are beyond opposite sides of the picture, so the hull between them may cross it.
            assert!(Hull(vec![(Vec3::X * -20.0, 0.0), (Vec3::X * 20.0, 0.0)]).may_be_visible(clip_from_world));
            assert!(Hull::default().may_be_visible(clip_from_world), "a hull without known points must not be culled");
            assert!(seen(Vec3::NAN, 0.0));
        }
    }
}
