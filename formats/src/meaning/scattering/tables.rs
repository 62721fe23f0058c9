//! What a frame looks up instead of the equations: two tables, of what happens along a fibre and around it (after Nguyen and Donnelly 2005, with other axes).
//!
//! - Along it lobes are narrow about sin θh = 0 and change slowly with tan(θd / 2); those are the axes, the first drawn out about its middle.
//! - Around it: cos θd, and φ / π. Printed was cos φ, which has next to no texels where glints are.
//! - Colour is no part of them: with the light of a path stands how far it goes within the fibre, and what absorbs is applied to that. One table serves all colours.

use super::azimuthal::Way;
use super::optics::LEAST_COS_D;
use super::{Angles, Fibre};
use core::array::from_fn;
use core::f64::consts::PI;

/// Share of the drawn-out axis that is as it was.
const DRAWN_OUT: f64 = 0.3;
/// What is absorbed a radius where mean lengths are right.
pub const REFERENCE_SIGMA: f64 = 0.5;

/// The tables of a fibre.
#[derive(Clone, Debug, PartialEq)]
pub struct Tables {
    /// Texels along each edge, 2 or more.
    pub size: usize,
    /// Row by row from tan(θd / 2) = −1 to 1, by [`drawn_out`] of sin θh from −1 to 1: R, TT, TRT along the fibre, times cos θi.
    pub along: Vec<[f32; 3]>,
    /// Row by row from [`LEAST_COS_D`] to cos θd = 1, by φ / π from 0 to 1: the light of R, TT and TRT, and the lengths of TT and TRT.
    pub around: Vec<[f32; 5]>,
}

/// Where sin θh is on its axis, −1..=1.
pub fn drawn_out(sin_h: f64) -> f64 {
    sin_h / (DRAWN_OUT + (1.0 - DRAWN_OUT) * sin_h.abs())
}

/// The inverse of [`drawn_out`].
fn drawn_in(place: f64) -> f64 {
    DRAWN_OUT * place / (1.0 - (1.0 - DRAWN_OUT) * place.abs())
}

/// A value between four texels.
fn between<const N: usize>(table: &[[f32; N]], size: usize, [x, y]: [f64; 2]) -> [f64; N] {
    let last = (size - 1) as f64;
    let [x, y] = [x, y].map(|of| of.clamp(0.0, 1.0) * last);
    let (left, top) = ((x as usize).min(size - 2), (y as usize).min(size - 2));
    let (a, b) = (x - left as f64, y - top as f64);
    let texel = |i: usize, j: usize| &table[(top + j) * size + left + i];
    from_fn(|k| {
        let row = |j: usize| f64::from(texel(0, j)[k]) * (1.0 - a) + f64::from(texel(1, j)[k]) * a;
        row(0) * (1.0 - b) + row(1) * b
    })
}

impl Tables {
    /// Those of a fibre.
    ///
    /// * `size`: texels along each edge, 2 to 1024
    pub fn new(fibre: &Fibre, size: usize) -> Self {
        let size = size.clamp(2, 1024);
        let share = |i: usize| i as f64 / (size - 1) as f64;
        let mut along = Vec::with_capacity(size * size);
        for j in 0..size {
            let d = 2.0 * libm::atan(2.0 * share(j) - 1.0);
            for i in 0..size {
                let h = libm::asin(drawn_in(2.0 * share(i) - 1.0).clamp(-1.0, 1.0));
                // Beyond a quarter turn neither direction is one: the lobe goes on evenly, for what is between texels.
                let [from, to] = [h - d, h + d].map(|theta| theta.clamp(-0.5 * PI, 0.5 * PI));
                let of = |theta: f64| (libm::sin(theta), libm::cos(theta).max(0.0));
                let angles = Angles { from: of(from), to: of(to), phi: 0.0 };
                along.push(fibre.along(&angles).map(|x| x as f32));
            }
        }
        let phis: Vec<f64> = (0..size).map(|i| PI * share(i)).collect();
        let mut around = Vec::with_capacity(size * size);
        for j in 0..size {
            let section = fibre.section(LEAST_COS_D + (1.0 - LEAST_COS_D) * share(j));
            let [r, tt, trt] = from_fn(|p| section.mean_ways(p as u32, &phis, REFERENCE_SIGMA));
            let texel =
                |i: usize| [r[i].light, tt[i].light, trt[i].light, tt[i].length, trt[i].length].map(|x| x as f32);
            around.extend((0..size).map(texel));
        }
        Self { size, along, around }
    }

    /// What is along a fibre, as [`Fibre::along`].
    pub fn along(&self, angles: &Angles) -> [f64; 3] {
        let cos_d = angles.cos_d();
        let sin_h = (0.5 * (angles.from.0 + angles.to.0) / cos_d.max(1e-9)).clamp(-1.0, 1.0);
        // Which of both is nearer to the tip is known, where the sign of the difference is.
        let half = (1.0 - cos_d * cos_d).max(0.0).sqrt().copysign(angles.to.0 - angles.from.0) / (1.0 + cos_d);
        between(&self.along, self.size, [drawn_out(sin_h), half].map(|place| 0.5 + 0.5 * place))
    }

    /// R, TT and TRT around it.
    pub fn around(&self, angles: &Angles) -> [Way; 3] {
        let row = (angles.cos_d() - LEAST_COS_D) / (1.0 - LEAST_COS_D);
        let [r, tt, trt, through, within] = between(&self.around, self.size, [angles.phi.abs() / PI, row]);
        [Way { light: r, length: 0.0 }, Way { light: tt, length: through }, Way { light: trt, length: within }]
    }

    /// As [`Fibre::scatter`], from the tables.
    pub fn scatter(&self, sigma: [f64; 3], angles: &Angles) -> [f64; 3] {
        let (along, around) = (self.along(angles), self.around(angles));
        sigma.map(|sigma| along.iter().zip(&around).map(|(along, way)| along * way.left(sigma)).sum())
    }
}
