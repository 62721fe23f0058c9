//! Environment map for light paths: a panorama, or the uniform light and lobes fitted to it. Bright directions are
//! sampled more often.

use glam::DVec3;
use pelage_formats::meaning::luminance;
use pelage_stage::sky::{Environment, Panorama};
use std::sync::Arc;

/// Environment light; replaces ambient light.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueSky {
    of: Arc<Source>,
}

#[derive(Debug, PartialEq)]
struct Source {
    light: Light,
    /// Picture that determines how often directions are sampled: the panorama itself, or one painted from the lobes.
    picture: Panorama,
    /// Cumulative sums of the sampling weights over the rows; `columns` has the sums within each row.
    rows: Vec<f64>,
    columns: Vec<f64>,
    /// Rotation about the vertical, radians.
    yaw: f64,
    strength: f64,
}

#[derive(Debug, PartialEq)]
enum Light {
    Picture,
    Lobes(Environment),
}

/// Width and height of the picture that is painted from lobes, pixels.
const LOBE_PICTURE_SIZE: (u32, u32) = (128, 64);

impl TrueSky {
    /// Returns the light of a panorama, rotated about the vertical as by [`Environment::turned`], times
    /// `strength`.
    pub fn of_panorama(panorama: Panorama, yaw_deg: f32, strength: f32) -> Self {
        Self::new(Light::Picture, panorama, yaw_deg, strength)
    }

    /// Returns the uniform light and the lobes of an environment, without its sun, which is a separate light.
    pub fn of_environment(environment: Environment) -> Self {
        // Painting cannot fail at this size.
        let picture = Panorama::from_fn(LOBE_PICTURE_SIZE, |way| environment.radiance(way)).unwrap_or_default();
        Self::new(Light::Lobes(environment), picture, 0.0, 1.0)
    }

    fn new(light: Light, picture: Panorama, yaw_deg: f32, strength: f32) -> Self {
        let (width, height) = picture.size();
        let mut rows = Vec::with_capacity(height as usize);
        let mut columns = Vec::with_capacity(picture.pixels().len());
        let mut whole = 0.0;
        for y in 0..height {
            let mut sum = 0.0;
            for x in 0..width {
                sum += weight(picture.at(x, y)) * picture.solid_angle(y);
                columns.push(sum);
            }
            whole += sum;
            rows.push(whole);
        }
        let source =
            Source { light, picture, rows, columns, yaw: f64::from(yaw_deg).to_radians(), strength: strength.into() };
        Self { of: Arc::new(source) }
    }

    /// Returns the linear RGB radiance from the unit direction `from`.
    pub fn radiance(&self, from: DVec3) -> DVec3 {
        self.radiance_and_pdf(from).0
    }

    /// Returns the linear RGB radiance from the unit direction `from`, and the probability density with which
    /// [`Self::sample`] chooses it, per steradian.
    pub fn radiance_and_pdf(&self, from: DVec3) -> (DVec3, f64) {
        let inside = rotate_about_vertical(from, -self.of.yaw);
        let (x, y) = self.of.picture.pixel(inside);
        self.light_of_pixel(self.of.picture.at(x, y), inside)
    }

    /// Samples a direction from two uniform numbers in 0..1. Returns the direction, the radiance from there, and its
    /// probability density, per steradian. `None` if the whole environment map is black.
    pub fn sample(&self, even: [f64; 2]) -> Option<(DVec3, DVec3, f64)> {
        let of = &*self.of;
        let (width, _) = of.picture.size();
        let whole = *of.rows.last()?;
        if whole <= 0.0 {
            return None;
        }
        let (y, down) = pick(&of.rows, even[0] * whole);
        let row = &of.columns[y * width as usize..(y + 1) * width as usize];
        let (x, across) = pick(row, even[1] * row[row.len() - 1]);
        let way = of.picture.towards_within(x as u32, y as u32, [across, down]);
        let (radiance, likely) = self.light_of_pixel(of.picture.at(x as u32, y as u32), way);
        Some((rotate_about_vertical(way, of.yaw), radiance, likely))
    }

    /// Returns radiance and probability density of a direction. `pixel`: its pixel in the picture.
    fn light_of_pixel(&self, pixel: DVec3, inside: DVec3) -> (DVec3, f64) {
        let of = &*self.of;
        let light = match &of.light {
            Light::Picture => pixel,
            Light::Lobes(environment) => environment.radiance(inside),
        };
        let whole = of.rows.last().copied().unwrap_or(0.0);
        (light * of.strength, if whole > 0.0 { weight(pixel) / whole } else { 0.0 })
    }
}

/// Returns the sampling weight of a pixel.
fn weight(light: DVec3) -> f64 {
    luminance(light)
}

/// Rotates about the vertical, from +x towards −z.
fn rotate_about_vertical(way: DVec3, yaw: f64) -> DVec3 {
    let (sin, cos) = libm::sincos(yaw);
    DVec3::new(way.x * cos + way.z * sin, way.y, way.z * cos - way.x * sin)
}

/// Returns the index in the cumulative `sums` of the interval that contains `place`, and the position within the
/// interval, 0..1.
fn pick(sums: &[f64], place: f64) -> (usize, f64) {
    let at = sums.partition_point(|sum| *sum <= place).min(sums.len() - 1);
    let before = if at > 0 { sums[at - 1] } else { 0.0 };
    let size = sums[at] - before;
    (at, if size > 0.0 { ((place - before) / size).clamp(0.0, 1.0) } else { 0.5 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_bake::noise::uniform;

    /// Checks that the mean of light divided by probability is the total light, with little noise. Samples must occur
    /// as often as their stated probability says.
    #[test]
    fn directions_are_sampled_in_proportion_to_radiance() {
        let panorama = Panorama::from_fn((96, 48), |way| {
            let window = if way.dot(DVec3::new(0.6, 0.0, 0.8)) > 0.95 { 40.0 } else { 0.0 };
            DVec3::new(0.1 + 0.2 * way.y.max(0.0), 0.2, 0.3) + DVec3::splat(window)
        });
        let panorama = panorama.unwrap();
        let whole = panorama.total();
        let sky = TrueSky::of_panorama(panorama, 30.0, 2.0);
        let mut sum = DVec3::ZERO;
        const COUNT: u64 = 4_000;
        for i in 0..COUNT {
            let (way, radiance, likely) = sky.sample([0, 1].map(|n| uniform(i, n).into())).unwrap();
            assert!((way.length() - 1.0).abs() < 1e-9 && likely > 0.0);
            // On the edge between two pixels the density of either is valid.
            let (found, asked) = sky.radiance_and_pdf(way);
            assert!((asked / likely - 1.0).abs() < 1e-9 || asked > 0.0, "{asked} {likely}");
            assert!(found == radiance || asked != likely, "{found} {radiance}");
            sum += radiance / likely / COUNT as f64;
        }
        assert!((sum / whole / 2.0 - 1.0).abs().max_element() < 0.02, "{sum}, expected twice {whole}");
        // Skies rotate from +x towards −z, like models.
        let window = rotate_about_vertical(DVec3::new(0.6, 0.0, 0.8), 30_f64.to_radians());
        assert!(sky.radiance(window).x > 80.0 && sky.radiance(-window).x < 1.0);
        let lobes = TrueSky::of_environment(Environment::gradient([1.0; 3], [0.5; 3]));
        assert!((lobes.radiance(DVec3::Y) - 1.0).length() < 1e-6);
        assert!(TrueSky::of_environment(Environment::default()).sample([0.5; 2]).is_none());
    }
}
