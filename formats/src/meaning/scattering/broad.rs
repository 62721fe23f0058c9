//! Lookup tables for broad light: the light that a fibre scatters, by mean cosine of the light, θo, θj and φ.
//!
//! The light is a spherical Gaussian. It is cut off well below its horizon, the plane perpendicular to its axis
//! ([`HORIZON_SINE`]). Light from a sky reaches hair from above the surface and around the curves of the body, but not
//! through the body. A wide Gaussian without the cutoff would shine through the fibre from below, which is visible in
//! dark fur.
//!
//! Around the fibre, the light of each path is a cosine series in n φ, as in
//! [`super::gaussian_light::BroadlyLitFibre`]. The series depends on θd alone and is computed once for all lights.
//! Along the fibre, a 24-point quadrature is used. The tables do not contain colour: a path that crosses the fibre n
//! times keeps the share that remains after n mean crossings ([`FibreMeans::transmittance`]).

use super::azimuthal::legendre;
use super::gaussian_light::{BroadlyLitFibre, TERMS, window};
use super::means::{FibreMeans, REFERENCE_SIGMA};
use super::optics::LEAST_COS_D;
use super::{Angles, Fibre, SCATTERED};
use core::array::from_fn;
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use glam::DVec3;

/// Number of texels along each axis of [`BroadTables`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BroadSize {
    /// Mean cosine of the light.
    pub means: usize,
    /// θo, from −π/2 to π/2.
    pub to: usize,
    /// θj, from −π/2 to π/2.
    pub from: usize,
    /// φ, from 0 to π.
    pub phi: usize,
}

impl Default for BroadSize {
    fn default() -> Self {
        Self { means: 8, to: 24, from: 24, phi: 16 }
    }
}

impl BroadSize {
    /// Returns the total number of texels.
    pub fn texels(&self) -> usize {
        self.means * self.to * self.from * self.phi
    }
}

/// Coordinate of the last texel on the axis of mean cosines. A mean cosine r has the coordinate 1 − √((1 − r) / (1 −
/// [`LEAST_MEAN`])). Narrower light is treated as light at the last texel, which has a standard deviation of 8 degrees.
const LAST_MEAN: f64 = 0.83;

/// Sine of the angle below its horizon at which a broad light is cut off. Hair tips see this far around a body of
/// typical roundness.
pub const HORIZON_SINE: f64 = 0.45;

/// Mean cosine of uniform light above the cutoff.
pub const LEAST_MEAN: f64 = 0.5 * (1.0 - HORIZON_SINE);

/// Upper half of a spherical Gaussian, with the rim of the lower half. The radiance is exp(κ (ω · ω_j − 1)) from
/// directions ω with ω · ω_j > −[`HORIZON_SINE`], and 0 from all others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutGaussianLight {
    /// ω_j, a unit vector.
    pub towards: DVec3,
    /// Mean cosine of the angle to ω_j, below 1; [`LEAST_MEAN`] for uniform light.
    pub mean: f64,
}

impl CutGaussianLight {
    /// Returns the integral of the light over all directions.
    pub fn integral(&self) -> f64 {
        let k = cut_gaussian_sharpness(self.mean);
        if k < 1e-9 { TAU * (1.0 + HORIZON_SINE) } else { TAU * -libm::expm1(-k * (1.0 + HORIZON_SINE)) / k }
    }
}

/// Tables of the light that a fibre scatters from broad light whose integral over all directions is 1.
#[derive(Clone, Debug, PartialEq)]
pub struct BroadTables {
    /// Texels along each axis, 2 or more.
    pub size: BroadSize,
    /// Texels by mean cosine, θo, φ and θj, the last varying fastest. The components, without absorption, are R, TT and
    /// all internally reflected light; the fourth is the path length of TT in the fibre, in radii.
    pub texels: Vec<[f32; 4]>,
    /// Means from which the light that remains after a crossing is computed.
    pub means: FibreMeans,
    eta: f64,
}

/// Number of samples of cos θd, for the light paths.
const SECTIONS: usize = 64;
/// Number of samples of the light's azimuthal sharpness.
const LIGHTS: usize = 32;
/// Number of samples of the azimuth at which the light is cut off.
const ENDS: usize = 33;
/// Number of cosine series: R, TT, TRT, and TT as attenuated by an absorption of [`REFERENCE_SIGMA`] per radius.
const SERIES: usize = 4;
/// Light path to which each series belongs.
const PATH_OF: [usize; SERIES] = [0, 1, 2, 1];

/// Light paths around a fibre as cosine series, by cos θd.
struct PathSeries {
    /// For each sample of cos θd: the terms of each series, and the light per radian of all further paths.
    sections: Vec<([[f64; TERMS]; SERIES], f64)>,
}

/// Returns the index below `share` among evenly spaced values over 0..=1, and the fraction of the step to the next one.
fn interpolation_index(share: f64, count: usize) -> (usize, f64) {
    let place = share.clamp(0.0, 1.0) * (count - 1) as f64;
    let below = (place as usize).min(count - 2);
    (below, place - below as f64)
}

impl PathSeries {
    fn new(lit: &BroadlyLitFibre) -> Self {
        let section = |i: usize| {
            let share = i as f64 / (SECTIONS - 1) as f64;
            let section = lit.fibre().section(LEAST_COS_D + (1.0 - LEAST_COS_D) * share);
            let mut terms = [[0.0; TERMS]; SERIES];
            for p in 0..3 {
                section.for_each_bundle(p as u32, &mut |phi, width, way| {
                    let left = if p == 1 { way.attenuated(REFERENCE_SIGMA) } else { 0.0 };
                    let mut cosines = [0.0; TERMS];
                    let (mut before, mut now, twice) = (libm::cos(phi), 1.0, 2.0 * libm::cos(phi));
                    for (n, cosine) in cosines.iter_mut().enumerate() {
                        *cosine = lit.kept(n, width) * now;
                        (before, now) = (now, twice * now - before);
                    }
                    for (series, light) in [(p, way.light), (3, left)] {
                        terms[series].iter_mut().zip(cosines).for_each(|(term, cosine)| *term += light * cosine);
                    }
                });
            }
            (terms, section.rest(0.0))
        };
        Self { sections: (0..SECTIONS).map(section).collect() }
    }
}

/// Lights of one sharpness that reach a fibre from all inclinations.
struct Light<'a> {
    fibre: &'a Fibre,
    around: &'a PathSeries,
    sharpness: f64,
    /// Terms of the light's cosine series around the fibre. The index is `ENDS` · i + j. Here i is the sample of √(s /
    /// `sharpness`), where s is the azimuthal sharpness, and j that of the azimuth at which the light is cut off.
    terms: Vec<[f64; TERMS]>,
}

impl<'a> Light<'a> {
    fn new(fibre: &'a Fibre, around: &'a PathSeries, sharpness: f64) -> Self {
        let at = |i: usize| {
            let share = (i / ENDS) as f64 / (LIGHTS - 1) as f64;
            cosines_until(sharpness * share * share, PI * (i % ENDS) as f64 / (ENDS - 1) as f64)
        };
        Self { fibre, around, sharpness, terms: (0..LIGHTS * ENDS).map(at).collect() }
    }

    /// Returns the terms of a light that is cut off at azimuth `end`; `share` is its azimuthal sharpness divided by
    /// `sharpness`.
    fn terms_at(&self, share: f64, end: f64) -> [f64; TERMS] {
        let (light, over) = interpolation_index(share.sqrt(), LIGHTS);
        let (until, beyond) = interpolation_index(end / PI, ENDS);
        let corner = |light: usize, until: usize| &self.terms[light * ENDS + until];
        let [a, b, c, d] =
            [corner(light, until), corner(light, until + 1), corner(light + 1, until), corner(light + 1, until + 1)];
        let mixed = |a: f64, b: f64, share: f64| a + (b - a) * share;
        from_fn(|n| mixed(mixed(a[n], b[n], beyond), mixed(c[n], d[n], beyond), over))
    }

    /// Returns the light that the fibre scatters if the axis of the incident light has inclination θj. Each element
    /// belongs to an azimuth of `cosines`: the light of the four series, and of all further and scattered light.
    fn of_angles(&self, theta_o: f64, theta_j: f64, cosines: &[[f64; TERMS]]) -> Vec<([f64; SERIES], f64)> {
        let sines = |theta: f64| (libm::sin(theta), libm::cos(theta).max(0.0));
        let (to, middle) = (sines(theta_o), sines(theta_j));
        let mut sums = [[0.0; TERMS]; SERIES];
        let scattered = self.fibre.section(to.1).scattered(0.0);
        let mut rest = 0.0;
        for p in 0..self.fibre.path_count() {
            let (begin, end) = window(&self.fibre.spread(p as u32), theta_j, theta_o, self.sharpness);
            let (centre, half) = (0.5 * (begin + end), 0.5 * (end - begin).max(0.0));
            for (x, weight) in super::azimuthal::legendre() {
                let theta = (centre + half * x).clamp(-FRAC_PI_2, FRAC_PI_2);
                let from = sines(theta);
                let angles = Angles { from, to, phi: 0.0 };
                let near = libm::exp(self.sharpness * (libm::cos(theta - theta_j) - 1.0));
                let along = weight * half * from.1 * near * self.fibre.path_along(p as u32, &angles);
                if along <= 0.0 {
                    continue;
                }
                let terms = self.terms_at(from.1 * middle.1, cut_azimuth(from, middle));
                if p == SCATTERED {
                    rest += along * TAU * terms[0] * scattered;
                    continue;
                }
                let (below, between) =
                    interpolation_index((angles.cos_d() - LEAST_COS_D) / (1.0 - LEAST_COS_D), SECTIONS);
                let [a, b] = [&self.around.sections[below], &self.around.sections[below + 1]];
                if p == 3 {
                    rest += along * TAU * terms[0] * (a.1 + (b.1 - a.1) * between);
                    continue;
                }
                for (series, _) in PATH_OF.iter().enumerate().filter(|(_, path)| **path == p) {
                    for (n, sum) in sums[series].iter_mut().enumerate() {
                        *sum += along * terms[n] * (a.0[series][n] + (b.0[series][n] - a.0[series][n]) * between);
                    }
                }
            }
        }
        let of = |cosines: &[f64; TERMS]| {
            // A truncated cosine series may be slightly negative where the light is zero.
            let sum = |terms: &[f64; TERMS]| terms.iter().zip(cosines).map(|(a, b)| a * b).sum::<f64>().max(0.0);
            (from_fn(|series| sum(&sums[series])), rest)
        };
        cosines.iter().map(of).collect()
    }
}

impl BroadTables {
    /// Computes the tables of a fibre.
    pub fn new(fibre: &Fibre, size: BroadSize) -> Self {
        let lit = BroadlyLitFibre::new(fibre);
        let around = PathSeries::new(&lit);
        let cosines: Vec<[f64; TERMS]> =
            (0..size.phi).map(|f| from_fn(|n| libm::cos(n as f64 * PI * f as f64 / (size.phi - 1) as f64))).collect();
        let mut texels = Vec::with_capacity(size.texels());
        for m in 0..size.means {
            let mean = mean_at(m as f64 / (size.means - 1) as f64);
            let whole = CutGaussianLight { towards: DVec3::Y, mean }.integral();
            let light = Light::new(fibre, &around, cut_gaussian_sharpness(mean));
            for o in 0..size.to {
                let theta_o = angle_at(o, size.to);
                // Each row holds the light about one θj, at all azimuths.
                let row = |j: usize| light.of_angles(theta_o, angle_at(j, size.from), &cosines);
                let rows: Vec<_> = (0..size.from).map(row).collect();
                for f in 0..size.phi {
                    texels.extend(rows.iter().map(|row| {
                        let ([r, tt, trt, left], rest) = row[f];
                        let length = if tt > 0.0 && left > 0.0 { libm::log(tt / left) / REFERENCE_SIGMA } else { 2.0 };
                        [r / whole, tt / whole, (trt + rest) / whole, length.clamp(0.0, 16.0)].map(|x| x as f32)
                    }));
                }
            }
        }
        Self { size, texels, means: FibreMeans::new(fibre), eta: fibre.eta }
    }

    /// Returns width and height of an image of all texels. It consists of images over θj and φ, arranged vertically by
    /// θo and horizontally by mean cosine.
    pub fn image_size(size: BroadSize) -> [usize; 2] {
        [size.means * size.from, size.to * size.phi]
    }

    /// Returns the image described at [`Self::image_size`], row by row.
    pub fn image(&self) -> Vec<[f32; 4]> {
        let BroadSize { means, to, from, phi } = self.size;
        let at = |(row, column): (usize, usize)| {
            let (o, f, m, j) = (row / phi, row % phi, column / from, column % from);
            self.texels[((m * to + o) * phi + f) * from + j]
        };
        (0..to * phi).flat_map(|row| (0..means * from).map(move |column| (row, column))).map(at).collect()
    }

    /// Returns the integral of [`Fibre::scatter`] over the directions of the light, for each colour, from the tables.
    ///
    /// * `sigma`: absorption of the fibre per radius, 0 or more
    /// * `tip`, `eye`: unit vectors
    pub fn scatter(&self, sigma: [f64; 3], tip: DVec3, light: &CutGaussianLight, eye: DVec3) -> [f64; 3] {
        let angles = Angles::between(tip, light.towards, eye);
        let mean = light.mean;
        let size = &self.size;
        let places = [
            (mean_cosine_coordinate(mean), size.means),
            (0.5 + angle(angles.to) / PI, size.to),
            (angles.phi.abs() / PI, size.phi),
            (0.5 + angle(angles.from) / PI, size.from),
        ];
        let about = places.map(|(share, count)| interpolation_index(share, count));
        let mut texel = [0.0; 4];
        for corner in 0..16 {
            let (mut index, mut weight) = (0, 1.0);
            for (axis, ((below, share), (_, count))) in about.iter().zip(&places).enumerate() {
                let above = corner >> axis & 1;
                index = index * count + below + above;
                weight *= if above == 1 { *share } else { 1.0 - share };
            }
            for (sum, x) in texel.iter_mut().zip(self.texels[index]) {
                *sum += weight * f64::from(x);
            }
        }
        let cos_d = mean_cos_d(tip, light.towards, mean, eye);
        let [r, tt, within, length] = texel;
        sigma.map(|sigma| {
            let left = self.means.transmittance(cos_d, self.eta, sigma);
            let again = self.means.multiple_reflection_share();
            let sum = r + tt * libm::exp(-sigma * length) + left * left * within * (1.0 - again + again * left);
            light.integral() * sum
        })
    }
}

/// Returns the mean of cos θd for light of mean cosine `mean` about the direction `towards`.
fn mean_cos_d(tip: DVec3, towards: DVec3, mean: f64, eye: DVec3) -> f64 {
    let (sin_i, sin_o) = (mean * tip.dot(towards), tip.dot(eye).clamp(-1.0, 1.0));
    let cos_i = (1.0 - mean_square(mean, tip.dot(towards))).max(0.0).sqrt();
    let cos_o = (1.0 - sin_o * sin_o).max(0.0).sqrt();
    (0.5 * (1.0 + cos_i * cos_o + sin_i * sin_o)).clamp(0.0, 1.0).sqrt()
}

/// Returns the mean cosine of the angle between a [`CutGaussianLight`] and its axis; `sharpness` is its κ, 0 or more.
pub fn cut_gaussian_mean_cosine(sharpness: f64) -> f64 {
    let wide = 1.0 + HORIZON_SINE;
    if sharpness < 1e-3 {
        return LEAST_MEAN + sharpness * wide * wide / 12.0;
    }
    // Share of the untruncated exponential that is cut off.
    let cut = libm::exp(-sharpness * wide);
    (1.0 + HORIZON_SINE * cut) / (1.0 - cut) - 1.0 / sharpness
}

/// Returns the κ of a [`CutGaussianLight`] with mean cosine `mean`, clamped to at least [`LEAST_MEAN`].
pub fn cut_gaussian_sharpness(mean: f64) -> f64 {
    // 1 − `mean` is at most 1/κ, and approaches it for large κ.
    let mean = mean.clamp(LEAST_MEAN, 1.0 - 1e-6);
    let (mut low, mut high) = (0.0, 1.0 / (1.0 - mean));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if cut_gaussian_mean_cosine(middle) < mean { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Returns the azimuth, relative to a light's axis, at which the light is cut off, radians. `from` is the inclination
/// of the incident light and `middle` that of the axis, each as sine and cosine.
fn cut_azimuth(from: (f64, f64), middle: (f64, f64)) -> f64 {
    let (sines, cosines) = (from.0 * middle.0 + HORIZON_SINE, from.1 * middle.1);
    if sines >= cosines {
        return PI;
    }
    if sines <= -cosines {
        return 0.0;
    }
    libm::acos(-sines / cosines)
}

/// Returns the cosine series in n φ of a function that is exp(κ (cos φ − 1)) for φ from −`end` to `end`, and 0 beyond.
fn cosines_until(sharpness: f64, end: f64) -> [f64; TERMS] {
    // Number of quadrature parts: each is short enough for the narrowest light and the highest cosine.
    const PARTS: usize = 6;
    let mut terms = [0.0; TERMS];
    let half = 0.5 * end / PARTS as f64;
    for part in 0..PARTS {
        for (x, weight) in legendre() {
            let phi = half * (2.0 * part as f64 + 1.0 + x);
            let light = weight * half * libm::exp(sharpness * (libm::cos(phi) - 1.0));
            let (mut before, mut now, twice) = (libm::cos(phi), 1.0, 2.0 * libm::cos(phi));
            for (n, term) in terms.iter_mut().enumerate() {
                *term += light * now * if n == 0 { 1.0 / PI } else { 2.0 / PI };
                (before, now) = (now, twice * now - before);
            }
        }
    }
    terms
}

/// Returns the mean squared cosine of the angle between a direction and a [`CutGaussianLight`] with mean cosine `mean`.
/// `cosine` is the cosine of the angle between that direction and the light's axis.
pub fn mean_square(mean: f64, cosine: f64) -> f64 {
    // (1 − m) / 2, where m is the mean squared cosine to the axis. The error is at most 0.002, and 0 at both ends.
    let across = (1.0 - mean) * ((1.0 + 2.0 * mean) / 3.0 - (mean - LEAST_MEAN) * (0.525 - 0.501 * mean));
    across + (1.0 - 3.0 * across) * cosine * cosine
}

fn mean_at(share: f64) -> f64 {
    let rest = 1.0 - LAST_MEAN * share;
    1.0 - (1.0 - LEAST_MEAN) * rest * rest
}

/// Returns the coordinate of mean cosine `mean` on its axis of the tables, 0..=1.
pub fn mean_cosine_coordinate(mean: f64) -> f64 {
    ((1.0 - ((1.0 - mean.clamp(LEAST_MEAN, 1.0)) / (1.0 - LEAST_MEAN)).sqrt()) / LAST_MEAN).clamp(0.0, 1.0)
}

fn angle_at(i: usize, count: usize) -> f64 {
    PI * (i as f64 / (count - 1) as f64 - 0.5)
}

fn angle((sin, cos): (f64, f64)) -> f64 {
    libm::atan2(sin, cos)
}

#[cfg(test)]
#[path = "broad_tests.rs"]
mod tests;
