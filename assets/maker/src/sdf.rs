//! Implicit shapes: signed distances (negative inside) of a few solids, and their smooth union and difference.
//!
//! Only `+ - * /` and square roots are used, so that the same source gives the same bits on every machine. The
//! ellipsoid's function is not an exact distance: its zero set is correct, but its gradient is only roughly of length
//! 1. [`project`] therefore divides its Newton steps by the squared gradient.

use glam::{DMat3, DVec3};

/// Solid, in metres.
#[derive(Clone, Debug)]
pub enum Solid {
    /// Ellipsoid around `centre` with half lengths `radii` along the columns of `axes`.
    Ellipsoid {
        /// Centre.
        centre: DVec3,
        /// Half lengths along the columns of `axes`.
        radii: DVec3,
        /// Orthonormal axes as columns.
        axes: DMat3,
    },
    /// Hull of two spheres.
    RoundCone {
        /// Centre of the first sphere.
        a: DVec3,
        /// Centre of the second sphere.
        b: DVec3,
        /// Radius at `a`.
        ra: f64,
        /// Radius at `b`.
        rb: f64,
    },
    /// Hull of two spheres, flattened: offsets from `a` along `across` are scaled by `share`.
    Oval {
        /// Centre of the first sphere, which flattening does not move.
        a: DVec3,
        /// Centre of the second sphere, already flattened.
        b: DVec3,
        /// Radius at `a`, before flattening.
        ra: f64,
        /// Radius at `b`, before flattening.
        rb: f64,
        /// Unit direction of flattening.
        across: DVec3,
        /// Width along `across` relative to the spheres, above 0 and at most 1.
        share: f64,
    },
    /// Union of the hulls of consecutive spheres along a curve, as one solid. If the hulls were added separately, their
    /// blends would bulge at the joints.
    Chain {
        /// Centres and radii, at least two.
        line: Vec<(DVec3, f64)>,
    },
    /// Plate with a half-round rim. Its outline is that of a round cone, in the plane through `a` with unit normal
    /// `normal`.
    Leaf {
        /// Centre of the outline's first circle.
        a: DVec3,
        /// Centre of the outline's second circle, in the plane.
        b: DVec3,
        /// Radius at `a`.
        ra: f64,
        /// Radius at `b`.
        rb: f64,
        /// Unit normal of the plane.
        normal: DVec3,
        /// Half the thickness: the radius of the rim.
        rim: f64,
    },
}

impl Solid {
    /// Returns a bounding sphere (centre, radius) and a growth rate. Outside the sphere, [`Solid::distance`] grows by
    /// at least this rate per metre away from the sphere. Inside the sphere, the solid's distance is at least the
    /// sphere's.
    pub fn bound(&self) -> (DVec3, f64, f64) {
        match *self {
            Self::Chain { ref line } => {
                let (low, high) = line.iter().fold((DVec3::MAX, DVec3::MIN), |m, k| (m.0.min(k.0), m.1.max(k.0)));
                let middle = (low + high) * 0.5;
                (middle, line.iter().fold(0.0, |m, k| f64::max(m, (k.0 - middle).length() + k.1)), 1.0)
            }
            Self::Ellipsoid { centre, radii, .. } => {
                let longest = radii.max_element();
                (centre, longest, radii.min_element() / longest)
            }
            Self::RoundCone { a, b, ra, rb } => ((a + b) * 0.5, (b - a).length() * 0.5 + ra.max(rb), 1.0),
            Self::Oval { a, b, ra, rb, share, .. } => ((a + b) * 0.5, (b - a).length() * 0.5 + ra.max(rb), share),
            Self::Leaf { a, b, ra, rb, rim, .. } => ((a + b) * 0.5, (b - a).length() * 0.5 + ra.max(rb) + rim, 1.0),
        }
    }

    /// Returns the signed distance of `p` (approximate, see the module documentation).
    pub fn distance(&self, p: DVec3) -> f64 {
        match *self {
            Self::Ellipsoid { centre, radii, axes } => {
                let q = axes.transpose() * (p - centre);
                let k0 = (q / radii).length();
                let k1 = (q / (radii * radii)).length();
                // Numerator and denominator vanish at the centre, where any value up to minus the smallest radius is
                // valid.
                if k1 < 1e-9 { -radii.min_element() } else { k0 * (k0 - 1.0) / k1 }
            }
            Self::RoundCone { a, b, ra, rb } => round_cone(p, a, b, ra, rb),
            Self::Chain { ref line } => {
                line.windows(2).fold(f64::MAX, |m, k| m.min(round_cone(p, k[0].0, k[1].0, k[0].1, k[1].1)))
            }
            Self::Oval { a, b, ra, rb, across, share } => {
                let widen = |q: DVec3| q + across * (across.dot(q - a) * (1.0 / share - 1.0));
                let (wide, b) = (widen(p), widen(b));
                let (foot, radius) = round_cone_foot(wide, a, b, ra, rb);
                let away = wide - foot;
                let length = away.length();
                // Dividing the scaled distance by the length of its gradient makes it accurate near the surface, so
                // that blends keep their requested width.
                let slope = away + across * (away.dot(across) * (1.0 / share - 1.0));
                (length - radius) * length / slope.length().max(1e-12)
            }
            Self::Leaf { a, b, ra, rb, normal, rim } => {
                let height = (p - a).dot(normal);
                let outside = (round_cone(p - normal * height, a, b, ra, rb) + rim).max(0.0);
                (outside * outside + height * height).sqrt() - rim
            }
        }
    }
}

/// Returns the distance to the hull of two spheres.
fn round_cone(p: DVec3, a: DVec3, b: DVec3, ra: f64, rb: f64) -> f64 {
    let (foot, radius) = round_cone_foot(p, a, b, ra, rb);
    (p - foot).length() - radius
}

/// Returns the centre and radius of the sphere nearest to `p`, among all spheres interpolated linearly between the two.
/// `t` is the parameter of that sphere, and `l` the distance between the two centres. With `h` along the axis and `q`
/// across it, `(h - t l) / distance = (ra - rb) / l`. This gives `t` in closed form.
fn round_cone_foot(p: DVec3, a: DVec3, b: DVec3, ra: f64, rb: f64) -> (DVec3, f64) {
    let length = (b - a).length();
    if length <= (ra - rb).abs() {
        // The larger sphere contains the smaller one.
        return if ra > rb { (a, ra) } else { (b, rb) };
    }
    let axis = (b - a) / length;
    let h = (p - a).dot(axis);
    let q = ((p - a) - axis * h).length();
    let slope = (ra - rb) / length;
    let t = ((h - slope * q / (1.0 - slope * slope).sqrt()) / length).clamp(0.0, 1.0);
    (a + (b - a) * t, ra + (rb - ra) * t)
}

/// Returns the minimum of two distances, rounded where they differ by less than `k`; all in metres.
pub fn smooth_min(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k * 0.25
}

/// Returns the maximum of two distances, rounded like [`smooth_min`].
pub fn smooth_max(a: f64, b: f64, k: f64) -> f64 {
    -smooth_min(-a, -b, k)
}

/// Returns the gradient of `field` at `p`, by central differences with a step of 0.1 mm.
pub fn gradient(field: &dyn Fn(DVec3) -> f64, p: DVec3) -> DVec3 {
    let e = 1e-4;
    let along = |axis: DVec3| (field(p + axis * e) - field(p - axis * e)) / (2.0 * e);
    DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
}

/// Returns the outward unit normal of the level set through `p`.
pub fn normal(field: &dyn Fn(DVec3) -> f64, p: DVec3) -> DVec3 {
    gradient(field, p).normalize_or(DVec3::Y)
}

/// Moves `p` onto the zero set of `field` by at most `steps` Newton steps along the gradient.
pub fn project(field: &dyn Fn(DVec3) -> f64, mut p: DVec3, steps: usize) -> DVec3 {
    for _ in 0..steps {
        let value = field(p);
        if value.abs() < 1e-7 {
            break;
        }
        let g = gradient(field, p);
        p -= g * (value / g.length_squared().max(1e-3));
    }
    p
}
