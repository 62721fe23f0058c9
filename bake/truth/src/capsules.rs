//! Intersection of rays with tapering hair segments: the convex hull of two balls.

use glam::{DVec3, Vec3};
use obvhs::Boundable;
use obvhs::aabb::Aabb;

/// A straight segment of a strand: the union of all balls whose centre and radius are interpolated between the two
/// ends.
///
/// Stored in f32. Intersected in f64, because in f32 the ray of a distant camera misses a thin hair; the extra cost is
/// small.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Capsule {
    pub(super) from: Vec3,
    pub(super) from_radius: f32,
    pub(super) to: Vec3,
    pub(super) to_radius: f32,
}

impl Boundable for Capsule {
    fn aabb(&self) -> Aabb {
        // Rays have f32 precision; the padding keeps their rounding from missing the box.
        let pad = |p: Vec3, radius: f32| radius + 1e-6 * (1.0 + p.abs().max_element());
        let (a, b) = (pad(self.from, self.from_radius), pad(self.to, self.to_radius));
        Aabb::new((self.from - a).min(self.to - b).to_vec3a(), (self.from + a).max(self.to + b).to_vec3a())
    }
}

impl Capsule {
    /// Returns the distance at which a ray enters the capsule, along the unit vector `way`. Infinity if the ray misses
    /// it, or starts inside or beyond it.
    ///
    /// The side of the capsule is the cone that touches both balls (after Quilez, "round cone intersection").
    pub(super) fn intersect(&self, origin: DVec3, way: DVec3) -> f64 {
        let (a, b) = (self.from.as_dvec3(), self.to.as_dvec3());
        let (ra, rb) = (f64::from(self.from_radius), f64::from(self.to_radius));
        // Distances are relative to the ray's point closest to the first end, which reduces cancellation below.
        let start = (a - origin).dot(way);
        let from = origin + way * start;
        let (axis, oa, ob) = (b - a, from - a, from - b);
        let taper = ra - rb;
        let (length, along_way, along_oa) = (axis.length_squared(), axis.dot(way), axis.dot(oa));
        let way_oa = way.dot(oa);
        let slant = length - taper * taper;
        let ball = |to_start: DVec3, radius: f64| {
            let half = way.dot(to_start);
            let rest = half * half - to_start.length_squared() + radius * radius;
            if rest > 0.0 { -half - rest.sqrt() } else { f64::INFINITY }
        };
        if slant <= 0.0 {
            // The larger ball contains the smaller one, so only the larger one is intersected.
            let enter = if ra > rb { ball(oa, ra) } else { ball(ob, rb) };
            return positive_or_infinity(start + enter);
        }
        let square = slant - along_way * along_way;
        let half = slant * way_oa - along_oa * along_way + along_way * taper * ra;
        let rest = slant * oa.length_squared() - along_oa * along_oa + along_oa * taper * ra * 2.0 - length * ra * ra;
        let root = half * half - rest * square;
        if root < 0.0 {
            return f64::INFINITY;
        }
        let side = (-root.sqrt() - half) / square;
        let height = along_oa - ra * taper + side * along_way;
        if height > 0.0 && height < slant {
            return positive_or_infinity(start + side);
        }
        positive_or_infinity(start + ball(oa, ra).min(ball(ob, rb)))
    }

    /// Returns the orthogonal projection of `point` on the axis as a fraction of its length, clamped to 0..=1.
    pub(super) fn axis_fraction(&self, point: DVec3) -> f64 {
        let (a, axis) = (self.from.as_dvec3(), (self.to - self.from).as_dvec3());
        let length = axis.length_squared();
        if length <= 0.0 {
            return 0.0;
        }
        ((point - a).dot(axis) / length).clamp(0.0, 1.0)
    }
}

fn positive_or_infinity(distance: f64) -> f64 {
    if distance > 0.0 { distance } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the signed distance from a point to the capsule: the minimum over all balls between the two ends.
    ///
    /// Along the axis the distance to a ball's centre is convex and its radius is linear, so a ternary search finds the
    /// minimum.
    fn distance_to_hull(capsule: &Capsule, p: DVec3) -> f64 {
        let ball = |t: f64| {
            let middle = capsule.from.as_dvec3().lerp(capsule.to.as_dvec3(), t);
            let radius = f64::from(capsule.from_radius) * (1.0 - t) + f64::from(capsule.to_radius) * t;
            p.distance(middle) - radius
        };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..48 {
            let third = (high - low) / 3.0;
            if ball(low + third) < ball(high - third) { high -= third } else { low += third }
        }
        ball(0.5 * (low + high)).min(ball(0.0)).min(ball(1.0))
    }

    #[test]
    fn rays_enter_capsules_at_the_hull() {
        let capsules = [
            (Vec3::ZERO, 0.1, Vec3::new(1.0, 0.3, -0.2), 0.1),
            (Vec3::ZERO, 0.2, Vec3::new(0.5, 0.3, 0.2), 0.02),
            (Vec3::new(0.1, 0.2, 0.0), 0.05, Vec3::new(0.5, -0.3, 0.2), 0.0),
            (Vec3::ZERO, 0.5, Vec3::new(0.1, 0.0, 0.0), 0.1),
            (Vec3::ZERO, 0.1, Vec3::ZERO, 0.2),
        ]
        .map(|(from, from_radius, to, to_radius)| Capsule { from, from_radius, to, to_radius });
        let (mut hits, mut misses) = (0, 0);
        for capsule in &capsules {
            for i in 0..400 {
                let turn = |f: f64| (f64::from(i) * f).sin();
                let origin = 3.0 * DVec3::new(turn(1.3), turn(2.1), turn(3.7)).normalize();
                let aim = DVec3::new(turn(5.1), turn(7.3), turn(9.7)) * 0.4 + DVec3::splat(0.1);
                let way = (aim - origin).normalize();
                let enter = capsule.intersect(origin, way);
                if enter.is_finite() {
                    hits += 1;
                    assert!(distance_to_hull(capsule, origin + way * enter).abs() < 1e-4, "{capsule:?}, ray {i}");
                    // Points on the ray before the entry are outside the capsule.
                    let before =
                        (0..50).map(|k| distance_to_hull(capsule, origin + way * (enter * f64::from(k) / 50.0)));
                    assert!(before.fold(f64::INFINITY, f64::min) > -1e-9, "{capsule:?}, ray {i}");
                    assert!(!capsule.intersect(origin, -way).is_finite());
                    assert!(
                        !capsule.intersect(origin + way * (enter + 1e-9), way).is_finite(),
                        "a ray from inside must miss"
                    );
                } else {
                    misses += 1;
                    let nearest = (0..400).map(|k| distance_to_hull(capsule, origin + way * (f64::from(k) / 60.0)));
                    assert!(nearest.fold(f64::INFINITY, f64::min) > -1e-3, "{capsule:?}, ray {i} should hit");
                }
            }
        }
        assert!(hits > 300 && misses > 300, "{hits} hits and {misses} misses are too few");
    }

    #[test]
    fn thin_distant_hair_is_hit() {
        let hair = Capsule { from: Vec3::ZERO, from_radius: 1e-5, to: Vec3::new(0.0, 0.3, 0.0), to_radius: 1e-5 };
        for x in [0.0, 0.9e-5] {
            let t = hair.intersect(DVec3::new(x, 0.1, 1e4), DVec3::NEG_Z);
            assert!((t - 1e4).abs() < 1e-4, "{t}");
        }
        assert!(!hair.intersect(DVec3::new(1.1e-5, 0.1, 1e4), DVec3::NEG_Z).is_finite());
    }
}
