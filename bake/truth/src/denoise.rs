//! Removal of noise: an edge-avoiding à-trous wavelet filter (Dammertz 2010), whose tolerance for differences of light
//! is the noise of each pixel (after Schied 2017). The filter therefore does less the more samples a picture has.
//!
//! Colours are filtered without their coverage, which has little noise and stays as it is.

use super::lighting::frame;
use super::tracer::{Hit, Tracer};
use glam::{DVec3, Vec3};
use pelage_formats::meaning::luminance;
use rayon::prelude::*;

/// Weights of the B3 spline, from the centre outwards.
const SPLINE: [f32; 3] = [0.375, 0.25, 0.0625];
/// Number of passes; the distance of the samples doubles from pass to pass.
const PASSES: u32 = 3;
/// Tolerance for differences of luminance, in standard deviations of the noise.
const NOISE: f32 = 1.0;
/// Tolerances for differences of direction and of colour.
const DIRECTION: f32 = 0.35;
const COLOR: f32 = 0.1;

/// Sums over the samples of a pixel that hit anything; they guide the filter.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Guide {
    /// Colour of hair or surface, linear.
    color: Vec3,
    /// Direction of the hair, or normal of the surface.
    direction: Vec3,
    /// Distance from the eye and its square.
    distance: [f32; 2],
    /// Square of the luminance.
    squares: f32,
}

impl Guide {
    /// Adds a sample with the radiance `light`.
    pub(super) fn add(&mut self, tracer: &Tracer, hit: &Hit, distance: f64, light: DVec3) {
        let (color, direction) = match *hit {
            Hit::Hair { point, share, .. } => {
                let (a, b) = (&tracer.curves.points[point], &tracer.curves.points[point + 1]);
                (a.color.lerp(b.color, share as f32), (b.position_ws - a.position_ws).normalize_or_zero())
            }
            Hit::Skin { triangle, weights, .. } => {
                let skin = &tracer.skin;
                (skin.base_color(triangle, weights).truncate(), frame(skin, triangle, weights)[0].as_vec3())
            }
        };
        self.color += color;
        self.direction += direction;
        self.distance[0] += distance as f32;
        self.distance[1] += (distance * distance) as f32;
        self.squares += luminance(light).powi(2) as f32;
    }
}

/// A covered pixel during the filter.
#[derive(Clone, Copy, Default)]
struct Pixel {
    /// Linear colour without coverage.
    light: Vec3,
    /// Variance of the luminance of `light`.
    variance: f32,
    /// Number of samples that hit anything.
    met: f32,
    color: Vec3,
    direction: Vec3,
    distance: f32,
    /// Variance of the distance within the pixel.
    distance_variance: f32,
}

impl Pixel {
    fn new((color, met, guide): (DVec3, u32, Guide)) -> Self {
        if met == 0 {
            return Self::default();
        }
        let count = f64::from(met);
        let light = color / count;
        let each = 1.0 / count as f32;
        let spread = (f64::from(guide.squares) / count - luminance(light).powi(2)).max(0.0);
        let distance = guide.distance[0] * each;
        Self {
            light: light.as_vec3(),
            // The estimate from one sample is zero.
            variance: if met > 1 { spread / (count - 1.0) } else { luminance(light).powi(2) } as f32,
            met: count as f32,
            color: guide.color * each,
            direction: guide.direction * each,
            distance,
            distance_variance: (guide.distance[1] * each - distance * distance).max(0.0),
        }
    }

    /// Returns the difference of what is visible in two pixels, in tolerances.
    fn difference(&self, other: &Self) -> f32 {
        let distance = self.distance - other.distance;
        // Surfaces that slant within a pixel have a spread; flat ones need a little tolerance.
        let spread = self.distance_variance + other.distance_variance + (1e-3 * self.distance).powi(2);
        self.direction.distance_squared(other.direction) / (DIRECTION * DIRECTION)
            + self.color.distance_squared(other.color) / (COLOR * COLOR)
            + distance * distance / (4.0 * spread).max(1e-20)
    }
}

/// Returns the light of all pixels without coverage and without most of the noise.
///
/// * `sums`: for each pixel, row by row, sum of the light, number of samples that hit anything, and guide
pub(super) fn denoise(size: (u32, u32), sums: impl Iterator<Item = (DVec3, u32, Guide)>) -> Vec<Vec3> {
    let size = [i64::from(size.0), i64::from(size.1)];
    let mut pixels: Vec<Pixel> = sums.map(Pixel::new).collect();
    for pass in 0..PASSES {
        let filtered = |i: usize| filter(&pixels, size, i as i64, 1 << pass);
        pixels = (0..pixels.len()).into_par_iter().map(filtered).collect();
    }
    pixels.iter().map(|pixel| pixel.light).collect()
}

/// Returns pixel `i`, averaged with others that are one and two `step`s away.
fn filter(pixels: &[Pixel], size: [i64; 2], i: i64, step: i64) -> Pixel {
    let own = pixels[i as usize];
    if own.met == 0.0 {
        return own;
    }
    let (x, y) = (i % size[0], i / size[0]);
    let around = |reach: i64, step: i64| {
        let both = (-reach..=reach).flat_map(move |dy| (-reach..=reach).map(move |dx| (dx, dy)));
        both.filter_map(move |(dx, dy)| {
            let (x, y) = (x + dx * step, y + dy * step);
            let inside = (0..size[0]).contains(&x) && (0..size[1]).contains(&y);
            inside.then(|| (SPLINE[dx.unsigned_abs() as usize] * SPLINE[dy.unsigned_abs() as usize], (x, y)))
        })
    };
    let at = |(x, y): (i64, i64)| &pixels[(y * size[0] + x) as usize];
    let bright = |of: &Pixel| luminance(of.light.as_dvec3()) as f32;
    let (mut light, mut variance, mut whole) = (Vec3::ZERO, 0.0, 0.0);
    for (weight, place) in around(2, step) {
        let other = at(place);
        if other.met == 0.0 {
            continue;
        }
        // The noise of both counts: otherwise dark pixels would lose their light to bright ones, but get none back.
        let tolerance = NOISE * (own.variance + other.variance).sqrt() + 1e-6;
        let unlike = own.difference(other) + (bright(&own) - bright(other)).abs() / tolerance;
        let weight = weight * other.met * libm::expf(-unlike);
        light += other.light * weight;
        variance += other.variance * weight * weight;
        whole += weight;
    }
    Pixel { light: light / whole, variance: variance / (whole * whole), ..own }
}

#[cfg(test)]
#[path = "denoise_tests.rs"]
mod tests;
