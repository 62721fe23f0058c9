//! Fit of visibility as a function of the light's direction to the results of rays.

use glam::{DMat4, DVec2, DVec3, DVec4, Vec3, Vec4};
use pelage_formats::meaning::above_horizon;

/// Smallest cosine of the angle between a ray and the normal. Rays at lower elevation are long, and nearly all of them
/// are blocked.
const LEAST_COSINE: f64 = 0.04;
/// Candidate values of `horizon`, the factor k in 1 − exp(−k z). z is the component of the light's direction along the
/// normal, and a sinking light fades over a height of 1 / k. The last value means practically no fading.
const HORIZONS: [f32; 7] = [4.0, 6.0, 8.0, 12.0, 16.0, 32.0, 1000.0];

/// Sample directions over the upper hemisphere, and the contribution of each direction to the four coefficients.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    /// Unit vectors in the tile frame, evenly spaced.
    directions: Vec<Vec3>,
    /// Least-squares contribution of each direction: the coefficients that result from a visibility of 1 in that
    /// direction and 0 in all others.
    shares: Vec<DVec4>,
}

/// Returns `count` directions on a spiral, each for an equal solid angle (Vogel 1979).
fn spiral(count: u32) -> Vec<DVec3> {
    let golden = std::f64::consts::PI * (3.0 - libm::sqrt(5.0));
    let direction = |i| {
        let z = 1.0 - (1.0 - LEAST_COSINE) * (f64::from(i) + 0.5) / f64::from(count);
        let (sin, turn) = (libm::sqrt(1.0 - z * z), golden * f64::from(i));
        DVec3::new(sin * libm::cos(turn), sin * libm::sin(turn), z)
    };
    (0..count).map(direction).collect()
}

/// Returns the horizon for a mean visibility. It is the least-squares fit of s(z) (a + b z), with the function s of
/// [`above_horizon`].
///
/// `seen`: z of each direction, and the mean visibility there.
pub(super) fn horizon(seen: &[(f32, f64)]) -> f32 {
    let residual = |horizon: f32| {
        let basis = |z: f32| DVec2::new(1.0, f64::from(z)) * f64::from(above_horizon(z, horizon));
        let (mut normal, mut right) = ([0.0; 3], DVec2::ZERO);
        for (z, t) in seen {
            let b = basis(*z);
            normal = [normal[0] + b.x * b.x, normal[1] + b.x * b.y, normal[2] + b.y * b.y];
            right += b * *t;
        }
        let [xx, xy, yy] = normal;
        let determinant = (xx * yy - xy * xy).max(1e-12);
        let found = DVec2::new(yy * right.x - xy * right.y, xx * right.y - xy * right.x) / determinant;
        let error = |(z, t): &(f32, f64)| found.dot(basis(*z)) - t;
        seen.iter().map(|s| error(s) * error(s)).sum::<f64>()
    };
    let errors = HORIZONS.map(|horizon| (residual(horizon), horizon));
    let least = errors.iter().fold(f64::INFINITY, |least, (error, _)| least.min(*error));
    // Among several good horizons, the one with the gentlest fading is used: excess light beyond the horizon is
    // conspicuous.
    let good = |error: f64| error <= 1.25 * least + 1e-9;
    errors.into_iter().find(|(error, _)| good(*error)).map_or(HORIZONS[6], |(_, horizon)| horizon)
}

impl Fit {
    /// Creates a fit with `count` directions, 4 or more.
    pub(super) fn new(count: u32, horizon: f32) -> Self {
        let directions = spiral(count);
        let basis = |d: &DVec3| DVec4::new(1.0, d.x, d.y, d.z) * f64::from(above_horizon(d.z as f32, horizon));
        let mut normal = DMat4::ZERO;
        for b in directions.iter().map(basis) {
            normal += DMat4::from_cols(b * b.x, b * b.y, b * b.z, b * b.w);
        }
        let inverse = normal.inverse();
        let shares = directions.iter().map(|d| inverse * basis(d)).collect();
        Self { directions: directions.into_iter().map(DVec3::as_vec3).collect(), shares }
    }

    /// Returns the directions, each rotated around the normal by the angle with the given sine and cosine.
    pub(super) fn rotated_directions(&self, (sin, cos): (f32, f32)) -> impl Iterator<Item = Vec3> {
        self.directions.iter().map(move |d| Vec3::new(cos * d.x - sin * d.y, sin * d.x + cos * d.y, d.z))
    }

    /// Returns the coefficients (c₀, c) of the visibilities that `lit` returns for the directions. All directions are
    /// rotated around the normal by the angle with the given sine and cosine. So neighbouring points use different
    /// directions, and their mean covers all.
    pub(super) fn coefficients(&self, (sin, cos): (f32, f32), mut lit: impl FnMut(Vec3) -> bool) -> Vec4 {
        let mut sum = DVec4::ZERO;
        for (way, share) in self.rotated_directions((sin, cos)).zip(&self.shares) {
            if lit(way) {
                sum += *share;
            }
        }
        let c = sum.as_vec4();
        Vec4::new(c.x, cos * c.y - sin * c.z, sin * c.y + cos * c.z, c.w)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sided_visibility_is_fitted_at_any_rotation() {
        let fit = Fit::new(24, 1000.0);
        assert!(fit.directions.iter().all(|d| (d.length() - 1.0).abs() < 1e-6 && d.z > 0.04));
        assert!((fit.coefficients((0.0, 1.0), |_| true) - Vec4::X).length() < 1e-3);
        assert_eq!(fit.coefficients((0.6, 0.8), |_| false), Vec4::ZERO);
        // The light is visible from one side only: the fit is higher there, and equal from the two perpendicular sides.
        let half = |turn| fit.coefficients(turn, |d| d.x > 0.0);
        let [plain, turned] = [half((0.0, 1.0)), half((0.8, 0.6))];
        assert!(plain.y > 0.5 && plain.z.abs() < 0.1 && (plain - turned).length() < 0.25, "{plain} {turned}");
    }

    #[test]
    fn horizon_follows_the_falloff_towards_grazing_light() {
        let seen = |t: fn(f64) -> f64| spiral(48).iter().map(|d| (d.z as f32, t(d.z))).collect::<Vec<_>>();
        assert_eq!(horizon(&seen(|z| 0.6 * (1.0 - libm::exp(-8.0 * z)))), 8.0);
        // The hair is so thin that light passes from all sides.
        assert_eq!(horizon(&seen(|_| 1.0)), 1000.0);
    }
}
