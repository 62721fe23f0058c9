//! Lookup tables of the scattering along and around a fibre (after Nguyen and Donnelly 2005, with other axes).
//!
//! - Along the fibre, the axes are sin θh and tan(θd / 2). Lobes are narrow about sin θh = 0 and change slowly with
//!   tan(θd / 2), so the first axis is stretched about its middle.
//! - Around the fibre, the axes are cos θd and φ / π. The paper uses cos φ, which has almost no texels where glints
//!   are.
//! - Colour is not part of the tables: the light of a path is stored with its length in the fibre, to which absorption
//!   is applied. One table serves all colours.
//! - Light that a medulla scatters is part of TRT: both cross the fibre twice, and TRT spreads nearly as far. The sum
//!   over all azimuths is exact.
//! - Values that hardly depend on the azimuth, or not at all, need no table: [`FibreMeans`].

use super::azimuthal::PathContribution;
use super::means::{FibreMeans, REFERENCE_SIGMA};
use super::optics::LEAST_COS_D;
use super::{Angles, Fibre, PATHS, SCATTERED};
use core::array::from_fn;
use core::f64::consts::{PI, TAU};

/// Weight of the linear term of [`stretched`]. Around sin θh = 0, the axis is stretched by the reciprocal of this
/// weight.
const DRAWN_OUT: f64 = 0.3;

/// Tables of a fibre.
#[derive(Clone, Debug, PartialEq)]
pub struct ScatteringTables {
    /// Texels along each edge, 2 or more.
    pub size: usize,
    /// Index of refraction.
    pub eta: f64,
    /// Longitudinal factors of the paths, times cos θi. Rows run over tan(θd / 2) from −1 to 1, columns over
    /// [`stretched`] of sin θh from −1 to 1. The last component is for all light reflected inside more than once. It
    /// already contains the light per radian of that path, which is the same at every azimuth.
    pub along: Vec<[f32; PATHS]>,
    /// Light per radian of R, TT, and TRT with scattered light, and path length of TT in the fibre, in radii. Rows run
    /// over cos θd from [`LEAST_COS_D`] to 1, columns over φ / π from 0 to 1.
    pub around: Vec<[f32; PATHS]>,
    /// Properties that need no table.
    pub means: FibreMeans,
}

/// Returns the coordinate of sin θh on the stretched axis, −1..=1.
pub fn stretched(sin_h: f64) -> f64 {
    sin_h / (DRAWN_OUT + (1.0 - DRAWN_OUT) * sin_h.abs())
}

/// Inverse of [`stretched`].
fn unstretched(place: f64) -> f64 {
    DRAWN_OUT * place / (1.0 - (1.0 - DRAWN_OUT) * place.abs())
}

/// Interpolates between four texels of a square table; both coordinates are 0..=1.
///
/// * `size`: texels along each edge, 2 or more
pub fn between<T: Copy + Into<f64>, const N: usize>(table: &[[T; N]], size: usize, [x, y]: [f64; 2]) -> [f64; N] {
    let last = (size - 1) as f64;
    let [x, y] = [x, y].map(|of| of.clamp(0.0, 1.0) * last);
    let (left, top) = ((x as usize).min(size - 2), (y as usize).min(size - 2));
    let (a, b) = (x - left as f64, y - top as f64);
    let texel = |i: usize, j: usize| &table[(top + j) * size + left + i];
    from_fn(|k| {
        let row = |j: usize| texel(0, j)[k].into() * (1.0 - a) + texel(1, j)[k].into() * a;
        row(0) * (1.0 - b) + row(1) * b
    })
}

impl ScatteringTables {
    /// Computes the tables of a fibre.
    ///
    /// * `size`: texels along each edge, 2 to 1024
    pub fn new(fibre: &Fibre, size: usize) -> Self {
        let size = size.clamp(2, 1024);
        let share = |i: usize| i as f64 / (size - 1) as f64;
        let mut along = Vec::with_capacity(size * size);
        for j in 0..size {
            let d = 2.0 * libm::atan(2.0 * share(j) - 1.0);
            let section = fibre.section(libm::cos(d));
            let (rest, inside, scattered) = (section.rest(0.0), section.section.energy(2), section.scattered(0.0));
            for i in 0..size {
                let h = libm::asin(unstretched(2.0 * share(i) - 1.0).clamp(-1.0, 1.0));
                // θ beyond ±π/2 is not a direction. Clamping it extends the lobe evenly to these texels, for
                // interpolation.
                let [from, to] = [h - d, h + d].map(|theta| theta.clamp(-0.5 * PI, 0.5 * PI));
                let of = |theta: f64| (libm::sin(theta), libm::cos(theta).max(0.0));
                let angles = Angles { from: of(from), to: of(to), phi: 0.0 };
                let [r, tt, mut trt, others] = fibre.along(&angles);
                if fibre.medulla.scatters() {
                    let even = fibre.path_along(SCATTERED as u32, &angles) * fibre.section(angles.to.1).scattered(0.0);
                    trt = (inside * trt + TAU * even) / (inside + TAU * scattered);
                }
                along.push([r, tt, trt, others * rest].map(|x| x as f32));
            }
        }
        let phis: Vec<f64> = (0..size).map(|i| PI * share(i)).collect();
        let mut around = Vec::with_capacity(size * size);
        for j in 0..size {
            let section = fibre.section(LEAST_COS_D + (1.0 - LEAST_COS_D) * share(j));
            let [r, tt, trt] = from_fn(|p| section.mean_contributions(p as u32, &phis, REFERENCE_SIGMA));
            let scattered = section.scattered(0.0);
            let texel = |i: usize| [r[i].light, tt[i].light, trt[i].light + scattered, tt[i].length];
            around.extend((0..size).map(|i| texel(i).map(|x| x as f32)));
        }
        Self { size, eta: fibre.eta, along, around, means: FibreMeans::new(fibre) }
    }

    /// Returns the position, 0..=1 each, in the table along the fibre for the directions of light and eye.
    pub fn along_place(angles: &Angles) -> [f64; 2] {
        let cos_d = angles.cos_d();
        let sin_h = (0.5 * (angles.from.0 + angles.to.0) / cos_d.max(1e-9)).clamp(-1.0, 1.0);
        // The sign of sin θo − sin θi shows which of the two directions is closer to the tip.
        let half = (1.0 - cos_d * cos_d).max(0.0).sqrt().copysign(angles.to.0 - angles.from.0) / (1.0 + cos_d);
        [stretched(sin_h), half].map(|place| 0.5 + 0.5 * place)
    }

    /// Returns the position, 0..=1 each, in the table around the fibre for the directions of light and eye.
    pub fn around_place(angles: &Angles) -> [f64; 2] {
        [angles.phi.abs() / PI, (angles.cos_d() - LEAST_COS_D) / (1.0 - LEAST_COS_D)]
    }

    /// Returns the two array layers of the texture, each row by row.
    pub fn layers(&self) -> [&[[f32; PATHS]]; 2] {
        [&self.along, &self.around]
    }

    /// Creates tables from the two array layers of a texture. `None` if they are not square, differ in size, or have
    /// fewer than 2 texels per edge.
    pub fn of_layers(eta: f64, means: FibreMeans, [along, around]: [Vec<[f32; PATHS]>; 2]) -> Option<Self> {
        let size = along.len().isqrt();
        let same = along.len() == size * size && around.len() == size * size;
        (same && size >= 2).then_some(Self { size, eta, along, around, means })
    }

    /// Returns [`Fibre::scatter`] from the tables.
    pub fn scatter(&self, sigma: [f64; 3], angles: &Angles) -> [f64; 3] {
        let along = between(&self.along, self.size, Self::along_place(angles));
        let around = between(&self.around, self.size, Self::around_place(angles));
        self.of_texels(along, around, sigma, angles)
    }

    /// Returns the scattered light, computed from texels of both tables.
    pub fn of_texels(&self, along: [f64; PATHS], around: [f64; PATHS], sigma: [f64; 3], angles: &Angles) -> [f64; 3] {
        let [r, tt, trt, length] = around;
        let [r, tt, trt, others] = [along[0] * r, along[1] * tt, along[2] * trt, along[3]];
        sigma.map(|sigma| {
            let left = self.means.transmittance(angles.cos_d(), self.eta, sigma);
            r + PathContribution { light: tt, length }.attenuated(sigma) + left * left * (trt + left * others)
        })
    }
}
