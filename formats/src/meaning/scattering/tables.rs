//! What a frame looks up instead of the equations: two tables, of what happens along a fibre and around it (after Nguyen and Donnelly 2005, with other axes).
//!
//! - Along it lobes are narrow about sin θh = 0 and change slowly with tan(θd / 2); those are the axes, the first drawn out about its middle.
//! - Around it: cos θd, and φ / π. Printed was cos φ, which has next to no texels where glints are.
//! - Colour is no part of them: with the light of a path stands how far it goes within the fibre, and what absorbs is applied to that. One table serves all colours.

use super::azimuthal::Way;
use super::optics::LEAST_COS_D;
use super::{Angles, Fibre, PATHS, mean_of};
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
    /// Row by row from tan(θd / 2) = −1 to 1, by [`drawn_out`] of sin θh from −1 to 1: the four paths along the fibre, times cos θi.
    pub along: Vec<[f32; PATHS]>,
    /// Row by row from [`LEAST_COS_D`] to cos θd = 1, by φ / π from 0 to 1: the light of R, TT and TRT, and the lengths of TT and TRT.
    pub around: Vec<[f32; 5]>,
    /// From [`LEAST_COS_D`] to cos θd = 1: the light of all other paths, which is the same all around, and their length.
    pub rest: Vec<[f32; 2]>,
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
        let (mut around, mut rest) = (Vec::with_capacity(size * size), Vec::with_capacity(size));
        for j in 0..size {
            let section = fibre.section(LEAST_COS_D + (1.0 - LEAST_COS_D) * share(j));
            let [r, tt, trt] = from_fn(|p| section.mean_ways(p as u32, &phis, REFERENCE_SIGMA));
            let texel =
                |i: usize| [r[i].light, tt[i].light, trt[i].light, tt[i].length, trt[i].length].map(|x| x as f32);
            around.extend((0..size).map(texel));
            let way = mean_of(section.rest(0.0), section.rest(REFERENCE_SIGMA), REFERENCE_SIGMA);
            rest.push([way.light as f32, way.length as f32]);
        }
        Self { size, along, around, rest }
    }

    /// What is along a fibre, as [`Fibre::along`].
    pub fn along(&self, angles: &Angles) -> [f64; PATHS] {
        let cos_d = angles.cos_d();
        let sin_h = (0.5 * (angles.from.0 + angles.to.0) / cos_d.max(1e-9)).clamp(-1.0, 1.0);
        // Which of both is nearer to the tip is known, where the sign of the difference is.
        let half = (1.0 - cos_d * cos_d).max(0.0).sqrt().copysign(angles.to.0 - angles.from.0) / (1.0 + cos_d);
        between(&self.along, self.size, [drawn_out(sin_h), half].map(|place| 0.5 + 0.5 * place))
    }

    /// The four paths around it.
    pub fn around(&self, angles: &Angles) -> [Way; PATHS] {
        let row = (angles.cos_d() - LEAST_COS_D) / (1.0 - LEAST_COS_D);
        let [r, tt, trt, through, within] = between(&self.around, self.size, [angles.phi.abs() / PI, row]);
        let y = row.clamp(0.0, 1.0) * (self.size - 1) as f64;
        let top = (y as usize).min(self.size - 2);
        let [light, length] = from_fn(|k| {
            let [a, b] = [0, 1].map(|j| f64::from(self.rest[top + j][k]));
            a + (b - a) * (y - top as f64)
        });
        [(r, 0.0), (tt, through), (trt, within), (light, length)].map(|(light, length)| Way { light, length })
    }

    /// As [`Fibre::scatter`], from the tables.
    pub fn scatter(&self, sigma: [f64; 3], angles: &Angles) -> [f64; 3] {
        let (along, around) = (self.along(angles), self.around(angles));
        sigma.map(|sigma| along.iter().zip(&around).map(|(along, way)| along * way.left(sigma)).sum())
    }
}
