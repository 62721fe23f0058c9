//! Default environment maps, computed by formulas and identical on every machine.

use glam::DVec3;
use pelage_import::BakeError;
use pelage_stage::sky::Panorama;

/// Width and height of the painted maps, pixels.
const SIZE: (u32, u32) = (512, 256);

/// Environment map with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedSky {
    /// Name; for a file, its name without folder and extension.
    pub name: String,
    /// Image of the environment.
    pub panorama: Panorama,
}

/// Paints a clear sky with a low sun over a meadow, and a dim room with two windows and a lamp.
///
/// # Errors
///
/// [`BakeError::Internal`] for a fault of this code.
pub fn painted() -> Result<Vec<NamedSky>, BakeError> {
    let paint = |name: &str, radiance: fn(DVec3) -> DVec3| {
        let panorama = Panorama::from_fn(SIZE, radiance).map_err(|error| BakeError::Internal(error.to_string()))?;
        Ok::<_, BakeError>(NamedSky { name: name.into(), panorama })
    };
    Ok(vec![paint("clear sky", clear_sky)?, paint("room", room)?])
}

fn clear_sky(way: DVec3) -> DVec3 {
    let sun = DVec3::new(0.6, 0.35, -0.7).normalize();
    let cosine = way.dot(sun);
    if way.y < 0.0 {
        return DVec3::new(0.12, 0.16, 0.06);
    }
    // The sky is paler towards the horizon and glows around the sun. The disc is three pixels wide and sends as much
    // light as a disc of half a degree.
    let high = way.y.sqrt();
    let blue = DVec3::new(0.9, 1.0, 1.1) * (1.0 - high) + DVec3::new(0.25, 0.5, 1.1) * high;
    let glow = DVec3::new(2.0, 1.6, 1.0) * libm::exp(12.0 * (cosine - 1.0));
    let disc = if cosine > libm::cos(1.0_f64.to_radians()) { DVec3::new(1500.0, 1200.0, 800.0) } else { DVec3::ZERO };
    blue + glow + disc
}

fn room(way: DVec3) -> DVec3 {
    // Intersection of the direction with the walls of a box around the centre.
    let half = DVec3::new(3.0, 1.4, 2.2);
    let reach = (half / way.abs().max(DVec3::splat(1e-9))).min_element();
    let place = way * reach;
    let near = |a: f64, b: f64| (a - b).abs() < 1e-6;
    let window = near(place.x, half.x) && place.y > -0.3 && place.y < 1.0 && (place.z.abs() - 0.9).abs() < 0.55;
    let lamp = near(place.y, half.y) && place.x < -0.8 && place.x > -1.4 && place.z.abs() < 0.3;
    if window {
        DVec3::new(6.0, 7.0, 8.0)
    } else if lamp {
        DVec3::new(20.0, 14.0, 8.0)
    } else if near(place.y, -half.y) {
        DVec3::new(0.12, 0.08, 0.05)
    } else {
        DVec3::new(0.3, 0.29, 0.27)
    }
}
