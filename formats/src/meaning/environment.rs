//! Environment lighting as a constant term, spherical Gaussians (Xu 2011) and a sun. This approximation of a sky or a
//! room is small enough to store, rotate and blend.

use super::scattering::gaussian_light::GaussianLight;
use super::srgb::luminance;
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// Environment light of a sky or a room, as it lights hair. Colours are linear RGB. Constant radiance 1 makes a white
/// surface as bright as a perpendicular light of colour 1.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Environment {
    /// Constant radiance from all directions, 0 or more.
    #[serde(default)]
    pub even: [f32; 3],
    /// Sun: a source bright enough to be a separate light and small enough to cast sharp shadows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sun: Option<Sun>,
    /// Light lobes; at most [`Environment::MOST_LOBES`].
    #[serde(default, rename = "lobe", skip_serializing_if = "Vec::is_empty")]
    pub lobes: Vec<LightLobe>,
}

/// Light lobe: a spherical Gaussian with radiance · exp((cos − 1) / width²), where cos is the cosine of the angle from
/// its axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightLobe {
    /// Direction towards the centre of the lobe, of any length but 0; y is up.
    pub towards: [f32; 3],
    /// Standard deviation, degrees, [`LightLobe::WIDTHS`].
    pub width_deg: f32,
    /// Radiance at the centre, 0 or more.
    pub radiance: [f32; 3],
}

/// Light small enough to have a single direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sun {
    /// Direction towards the sun, of any length but 0; y is up.
    pub towards: [f32; 3],
    /// Colour, as for any light: 1 gives an irradiance of π on a perpendicular surface.
    pub color: [f32; 3],
}

impl LightLobe {
    /// Range of lobe widths, degrees. Narrower light is stored as the sun, wider light as constant light.
    pub const WIDTHS: core::ops::RangeInclusive<f32> = 4.0..=120.0;

    /// Returns the lobe as a spherical Gaussian with radiance 1 at its centre.
    pub fn light(&self) -> GaussianLight {
        let width = f64::from(self.width_deg).to_radians();
        GaussianLight { towards: unit(self.towards), sharpness: 1.0 / (width * width) }
    }

    /// Returns the integral of the radiance over all directions.
    pub fn integral(&self) -> DVec3 {
        color(self.radiance) * self.light().integral()
    }
}

impl Environment {
    /// Maximum number of lobes in an environment.
    pub const MOST_LOBES: usize = 32;
    /// Maximum of a colour channel; limited by half floats, with room for sums.
    pub const BRIGHTEST: f32 = 1e9;
    /// Width of the lobe that represents a gradient, degrees.
    const GRADIENT_DEG: f32 = 55.0;

    /// Returns constant light from all directions.
    pub fn constant(radiance: [f32; 3]) -> Self {
        Self { even: radiance, ..Self::default() }
    }

    /// Returns light that changes from `below` in the downward direction to `above` in the upward direction.
    pub fn gradient(above: [f32; 3], below: [f32; 3]) -> Self {
        let lobe = |up: f32, more: [f32; 3], less: [f32; 3]| LightLobe {
            towards: [0.0, up, 0.0],
            width_deg: Self::GRADIENT_DEG,
            radiance: core::array::from_fn(|i| (more[i] - less[i]).max(0.0)),
        };
        let lobes = [lobe(1.0, above, below), lobe(-1.0, below, above)];
        Self {
            even: core::array::from_fn(|i| above[i].min(below[i])),
            lobes: lobes.into_iter().filter(|lobe| lobe.radiance != [0.0; 3]).collect(),
            sun: None,
        }
    }

    /// Returns the radiance from a direction of unit length, without the sun.
    pub fn radiance(&self, from: DVec3) -> DVec3 {
        let of = |lobe: &LightLobe| color(lobe.radiance) * lobe.light().radiance(from);
        self.lobes.iter().fold(color(self.even), |sum, lobe| sum + of(lobe))
    }

    /// Returns the integral of all light over all directions, including the sun's irradiance.
    pub fn total(&self) -> DVec3 {
        let sun = self.sun.map_or(DVec3::ZERO, |sun| color(sun.color) * core::f64::consts::PI);
        let even = color(self.even) * (4.0 * core::f64::consts::PI);
        self.lobes.iter().fold(sun + even, |sum, lobe| sum + lobe.integral())
    }

    /// Returns the irradiance of a horizontal surface under the environment, including the sun, divided by π. This is
    /// the radiance of white ground, which reflects evenly in all directions.
    pub fn ground_irradiance(&self) -> DVec3 {
        const ROWS: u32 = 32;
        const COLUMNS: u32 = 64;
        let sun = self.sun.map_or(DVec3::ZERO, |sun| color(sun.color) * unit(sun.towards).y.max(0.0));
        let row = |y: u32| {
            // Equal steps of the squared sine of the elevation contribute equally to the irradiance of a horizontal
            // surface.
            let up = ((f64::from(y) + 0.5) / f64::from(ROWS)).sqrt();
            let out = (1.0 - up * up).sqrt();
            let at = |x: u32| {
                let (sin, cos) = libm::sincos(core::f64::consts::TAU * (f64::from(x) + 0.5) / f64::from(COLUMNS));
                self.radiance(DVec3::new(out * cos, up, out * sin))
            };
            (0..COLUMNS).map(at).sum::<DVec3>()
        };
        sun + (0..ROWS).map(row).sum::<DVec3>() / f64::from(ROWS * COLUMNS)
    }

    /// Returns the mean direction of the light, of unit length; upwards if the light has no predominant direction.
    pub fn mean_direction(&self) -> DVec3 {
        let lobe = |lobe: &LightLobe| {
            let light = lobe.light();
            light.towards * (luminance(lobe.integral()) * mean_cosine(light.sharpness))
        };
        let sun = self
            .sun
            .map_or(DVec3::ZERO, |sun| unit(sun.towards) * (luminance(color(sun.color)) * core::f64::consts::PI));
        let sum = self.lobes.iter().map(lobe).fold(sun, |sum, of| sum + of);
        sum.normalize_or(DVec3::Y)
    }

    /// Returns the environment rotated by `yaw_deg` degrees about the vertical axis, from +x towards −z. Models are
    /// rotated in the same sense.
    pub fn turned(&self, yaw_deg: f32) -> Self {
        let (sin, cos) = libm::sincos(f64::from(yaw_deg).to_radians());
        let turn = |way: [f32; 3]| {
            let [x, y, z] = way.map(f64::from);
            [x * cos + z * sin, y, z * cos - x * sin].map(|x| x as f32)
        };
        let mut out = self.clone();
        out.lobes.iter_mut().for_each(|lobe| lobe.towards = turn(lobe.towards));
        if let Some(sun) = &mut out.sun {
            sun.towards = turn(sun.towards);
        }
        out
    }

    /// Returns the environment with its brightness multiplied by `strength`.
    pub fn scaled(&self, strength: f32) -> Self {
        let scaled = |color: [f32; 3]| color.map(|x| x * strength);
        let mut out = self.clone();
        out.even = scaled(out.even);
        out.lobes.iter_mut().for_each(|lobe| lobe.radiance = scaled(lobe.radiance));
        if let Some(sun) = &mut out.sun {
            sun.color = scaled(sun.color);
        }
        out
    }

    /// Blends two environments: share 0 is `self`, 1 is `other`. Radiances are mixed, so that lights do not move. If
    /// the result has too many lobes, the most similar ones are merged. Two suns are treated as the same sun at
    /// different times, so their direction is interpolated.
    pub fn blended(&self, other: &Self, share: f32) -> Self {
        let (here, there) = (self.scaled(1.0 - share), other.scaled(share));
        let mut lobes = here.lobes;
        lobes.extend(there.lobes);
        lobes.retain(|lobe| lobe.radiance != [0.0; 3]);
        while lobes.len() > Self::MOST_LOBES {
            merge_nearest(&mut lobes);
        }
        let sun = match (here.sun, there.sun) {
            (Some(a), Some(b)) => {
                let [from, to] = [self.sun, other.sun].map(|sun| sun.map_or(DVec3::Y, |sun| unit(sun.towards)));
                let towards = from.lerp(to, f64::from(share)).normalize_or(from).as_vec3();
                Some(Sun { towards: towards.into(), color: core::array::from_fn(|i| a.color[i] + b.color[i]) })
            }
            (a, b) => a.or(b),
        };
        Self { even: core::array::from_fn(|i| here.even[i] + there.even[i]), lobes, sun }
    }

    /// Returns the environment with at most `most` lobes (1 or more). Until few enough are left, the two most similar
    /// lobes are merged. Constant light and sun are unchanged.
    pub fn with_fewer(&self, most: usize) -> Self {
        let mut out = self.clone();
        while out.lobes.len() > most.max(1) {
            merge_nearest(&mut out.lobes);
        }
        out
    }

    /// Returns the first invalid value, if any: its path, such as `lobe[0].width_deg`, and what was found and expected.
    pub fn fault(&self) -> Option<(String, String)> {
        let (least, most) = (LightLobe::WIDTHS.start(), LightLobe::WIDTHS.end());
        let colour = |key: String, found: [f32; 3]| {
            let bad = !found.iter().all(|x| (0.0..=Self::BRIGHTEST).contains(x));
            bad.then(|| (key, format!("found {found:?}, expected 0 to 1e9 each")))
        };
        let direction = |key: String, found: [f32; 3]| {
            let bad = !(1e-6..=1e6).contains(&Vec3::from(found).length());
            bad.then(|| (key, format!("found {found:?}, expected a direction that is not zero")))
        };
        let of_sun =
            |sun: Sun| direction("sun.towards".into(), sun.towards).or_else(|| colour("sun.color".into(), sun.color));
        let of_lobe = |(i, lobe): (usize, &LightLobe)| {
            let width = !LightLobe::WIDTHS.contains(&lobe.width_deg);
            direction(format!("lobe[{i}].towards"), lobe.towards)
                .or_else(|| {
                    let reason = || format!("found {}, expected {least} to {most} degrees", lobe.width_deg);
                    width.then(|| (format!("lobe[{i}].width_deg"), reason()))
                })
                .or_else(|| colour(format!("lobe[{i}].radiance"), lobe.radiance))
        };
        let too_many = || {
            let count = self.lobes.len();
            (count > Self::MOST_LOBES)
                .then(|| ("lobe".into(), format!("found {count} lobes, expected at most {}", Self::MOST_LOBES)))
        };
        colour("even".into(), self.even)
            .or_else(|| self.sun.and_then(of_sun))
            .or_else(too_many)
            .or_else(|| self.lobes.iter().enumerate().find_map(of_lobe))
    }
}

/// Returns the mean cosine of the angle between the light of a spherical Gaussian and its axis. It is coth κ − 1/κ,
/// where κ is `sharpness`.
pub fn mean_cosine(sharpness: f64) -> f64 {
    if sharpness < 1e-3 {
        return sharpness / 3.0;
    }
    // Compute coth κ from the small quantity 1 − exp(−2 κ).
    let less = -libm::expm1(-2.0 * sharpness);
    (2.0 - less) / less - 1.0 / sharpness
}

/// Returns the sharpness κ of the spherical Gaussian with mean cosine `mean`, below 1. Newton iterations start from the
/// approximation of Banerjee 2005.
pub fn sharpness_of(mean: f64) -> f64 {
    let mean = mean.clamp(0.0, 1.0 - 1e-6);
    let mut k = mean * (3.0 - mean * mean) / (1.0 - mean * mean);
    for _ in 0..4 {
        // The derivative of coth κ − 1/κ is 1/κ² − 1/sinh² κ, which is 1/3 at κ = 0.
        let less = -libm::expm1(-2.0 * k);
        let slope = if k < 1e-2 { 1.0 / 3.0 } else { 1.0 / (k * k) - 4.0 * (1.0 - less) / (less * less) };
        k = (k - (mean_cosine(k) - mean) / slope).max(0.0);
    }
    k
}

/// Merges the two most similar lobes. The result has their total light and, as far as possible, their mean direction
/// and spread.
fn merge_nearest(lobes: &mut Vec<LightLobe>) {
    let pairs = (0..lobes.len()).flat_map(|i| (i + 1..lobes.len()).map(move |j| (i, j)));
    // Cost of merging a pair of lobes: it grows with their light and with the distance between their mean directions.
    let cost = |(i, j): (usize, usize)| {
        let [a, b] = [i, j].map(|i| (luminance(lobes[i].integral()), lobes[i].light()));
        let moved = [a.1, b.1].map(|light| light.towards * mean_cosine(light.sharpness));
        a.0 * b.0 / (a.0 + b.0).max(1e-30) * moved[0].distance_squared(moved[1])
    };
    let nearest = pairs.map(|pair| (pair, cost(pair))).min_by(|a, b| a.1.total_cmp(&b.1));
    let Some(((i, j), _)) = nearest else { return };
    let other = lobes.swap_remove(j);
    lobes[i] = merged(&lobes[i], &other);
}

fn merged(a: &LightLobe, b: &LightLobe) -> LightLobe {
    let (first, second) = (a.integral(), b.integral());
    let moment = |lobe: &LightLobe, whole: DVec3| {
        let light = lobe.light();
        light.towards * (luminance(whole) * mean_cosine(light.sharpness))
    };
    let whole = first + second;
    let middle = moment(a, first) + moment(b, second);
    let mean = middle.length() / luminance(whole).max(1e-30);
    let width = libm::sqrt(1.0 / sharpness_of(mean).max(1e-6)).to_degrees() as f32;
    let towards = middle.normalize_or(unit(a.towards)).as_vec3();
    let shape = LightLobe {
        towards: towards.into(),
        width_deg: width.clamp(*LightLobe::WIDTHS.start(), *LightLobe::WIDTHS.end()),
        radiance: [1.0; 3],
    };
    LightLobe { radiance: (whole / shape.integral()).as_vec3().into(), ..shape }
}

fn color(rgb: [f32; 3]) -> DVec3 {
    Vec3::from(rgb).as_dvec3()
}

fn unit(way: [f32; 3]) -> DVec3 {
    Vec3::from(way).as_dvec3().normalize_or(DVec3::Y)
}

#[cfg(test)]
#[path = "environment_tests.rs"]
mod tests;
