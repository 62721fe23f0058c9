//! What a frame looks up instead of the equations: tables of what happens along a fibre and around it (after Nguyen and Donnelly 2005, with other axes).
//!
//! - Along it lobes are narrow about sin θh = 0 and change slowly with tan(θd / 2); those are the axes, the first drawn out about its middle.
//! - Around it: cos θd, and φ / π. Printed was cos φ, which has next to no texels where glints are.
//! - Colour is no part of them: with the light of a path stands how far it goes within the fibre, and what absorbs is applied to that. One table serves all colours.
//! - What fibres do to light that many of them have scattered needs less: how much of it goes on, and how much comes back, by the colour of the coat.

use super::azimuthal::Way;
use super::optics::LEAST_COS_D;
use super::{Angles, Around, Fibre, PATHS, colour, mean_of};
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
    /// Row by row from [`LEAST_COS_D`] to cos θd = 1, by φ / π from 0 to 1: the light of R, TT, TRT and all other paths, a radian.
    pub around: Vec<[f32; PATHS]>,
    /// By the same: how far TT, TRT and all other paths go within the fibre; 1 / [`colour::depth`], everywhere.
    pub lengths: Vec<[f32; PATHS]>,
    /// Row by row from [`LEAST_COS_D`] to cos θ = 1, by the colour of the coat from 0 to 1: the share of light that goes on, on the far side of the fibre,
    /// and the share that comes back; 0; 0.
    pub sides: Vec<[f32; PATHS]>,
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

/// Integrals of an even function of φ over the half of the turn about φ = 0, and over the other half, from its values evenly from 0 to π.
fn halves(values: &[f64]) -> [f64; 2] {
    let step = PI / (values.len() - 1) as f64;
    let at = |phi: f64| {
        let place = phi / step;
        let below = (place as usize).min(values.len() - 2);
        values[below] + (values[below + 1] - values[below]) * (place - below as f64)
    };
    // Trapezia over both quarters, each of as many as there are texels.
    let pieces = values.len();
    let quarter = |from: f64| {
        let width = 0.5 * PI / pieces as f64;
        (0..pieces)
            .map(|i| 0.5 * width * (at(from + width * i as f64) + at(from + width * (i + 1) as f64)))
            .sum::<f64>()
    };
    [2.0 * quarter(0.0), 2.0 * quarter(0.5 * PI)]
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
        let (mut around, mut lengths, mut sides) = (Vec::new(), Vec::new(), Vec::new());
        let scale = if let Around::Rough(scale) = fibre.around { scale } else { 0.0 };
        let depth = colour::depth(scale);
        let sigmas: Vec<f64> = (0..size).map(|i| colour::absorption([share(i); 3], scale)[0]).collect();
        for j in 0..size {
            let section = fibre.section(LEAST_COS_D + (1.0 - LEAST_COS_D) * share(j));
            let [r, tt, trt] = from_fn(|p| section.mean_ways(p as u32, &phis, REFERENCE_SIGMA));
            let rest = mean_of(section.rest(0.0), section.rest(REFERENCE_SIGMA), REFERENCE_SIGMA);
            let ways = |i: usize| [r[i], tt[i], trt[i], rest];
            around.extend((0..size).map(|i| ways(i).map(|way| way.light as f32)));
            let lengths_of = |[_, tt, trt, rest]: [Way; PATHS]| [tt.length, trt.length, rest.length, 1.0 / depth];
            lengths.extend((0..size).map(|i| lengths_of(ways(i)).map(|length| length as f32)));
            sides.extend(sigmas.iter().map(|sigma| {
                let left = |i: usize| ways(i).iter().map(|way| way.left(*sigma)).sum::<f64>();
                let [back, on] = halves(&(0..size).map(left).collect::<Vec<_>>());
                [on as f32, back as f32, 0.0, 0.0]
            }));
        }
        Self { size, along, around, lengths, sides }
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
        let place = [angles.phi.abs() / PI, (angles.cos_d() - LEAST_COS_D) / (1.0 - LEAST_COS_D)];
        let light = between(&self.around, self.size, place);
        let [tt, trt, rest, _] = between(&self.lengths, self.size, place);
        let lengths = [0.0, tt, trt, rest];
        from_fn(|p| Way { light: light[p], length: lengths[p] })
    }

    /// Of light at an angle of that cosine to the plane across the fibre, the share that goes on and the share that comes back, of each channel of the colour
    /// of a coat, 0..=1.
    pub fn sides(&self, cos_theta: f64, color: [f64; 3]) -> [[f64; 3]; 2] {
        let row = (cos_theta - LEAST_COS_D) / (1.0 - LEAST_COS_D);
        let of = color.map(|c| between(&self.sides, self.size, [c, row]));
        [0, 1].map(|side| of.map(|of| of[side]))
    }

    /// The four layers of a texture, one after the other, row by row.
    pub fn layers(&self) -> [&[[f32; PATHS]]; 4] {
        [&self.along, &self.around, &self.lengths, &self.sides]
    }

    /// The tables of such layers; `None` where they are not square, not all of one size, or smaller than 2.
    pub fn of_layers([along, around, lengths, sides]: [Vec<[f32; PATHS]>; 4]) -> Option<Self> {
        let size = along.len().isqrt();
        let same = [&along, &around, &lengths, &sides].iter().all(|layer| layer.len() == size * size);
        (same && size >= 2).then_some(Self { size, along, around, lengths, sides })
    }

    /// As [`Fibre::scatter`], from the tables.
    pub fn scatter(&self, sigma: [f64; 3], angles: &Angles) -> [f64; 3] {
        let (along, around) = (self.along(angles), self.around(angles));
        sigma.map(|sigma| along.iter().zip(&around).map(|(along, way)| along * way.left(sigma)).sum())
    }
}
