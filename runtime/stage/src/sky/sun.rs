//! Separation of the sun from the rest of a sky.

use super::panorama::Panorama;
use glam::DVec3;
use pelage_formats::meaning::environment::Sun;
use pelage_formats::meaning::luminance;
use std::f64::consts::PI;

/// Candidate angular radii of a sun or lamp, degrees, including lens glare. Wider sources are modelled as lobes.
const REACHES_DEG: [f64; 4] = [3.0, 4.5, 6.0, 8.0];
/// Width of the ring around the sun, degrees. Light in the ring approximates the sky without the sun.
const RING_DEG: f64 = 3.0;
/// Edge criterion of the sun: the ring around it has at most this fraction of the sun's mean light.
const EDGE_SHARE: f64 = 0.1;

/// Separates the sun from a sky. Returns the sun, if it has at least the fraction `least` of all light, and the sky
/// without it.
pub(super) fn split(sky: &Panorama, least: f64) -> (Option<Sun>, Panorama) {
    let (width, height) = sky.size();
    let places = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let bright = |(x, y): (u32, u32)| luminance(sky.at(x, y));
    let none = || (None, sky.clone());
    let Some(peak) = places().max_by(|a, b| bright(*a).total_cmp(&bright(*b))) else { return none() };
    let towards = sky.towards(peak.0, peak.1);
    // If a pixel is wider than the sun, only the pixel at its centre belongs to it.
    let cosine = |(x, y): (u32, u32)| if (x, y) == peak { 1.0 } else { towards.dot(sky.towards(x, y)) };
    let mean = |of: &[((u32, u32), f64)]| {
        let angle = |(_, y): (u32, u32)| sky.solid_angle(y);
        let whole: f64 = of.iter().map(|(place, _)| angle(*place)).sum();
        let light: DVec3 = of.iter().map(|(place, _)| sky.at(place.0, place.1) * angle(*place)).sum();
        if whole > 0.0 { light / whole } else { DVec3::ZERO }
    };
    let farthest = libm::cos((REACHES_DEG[REACHES_DEG.len() - 1] + RING_DEG).to_radians());
    let near: Vec<_> = places().map(|place| (place, cosine(place))).filter(|(_, cosine)| *cosine > farthest).collect();
    let split_at = |reach: f64| {
        let [inside, outside] = [reach, reach + RING_DEG].map(|deg| libm::cos(deg.to_radians()));
        let about = near.iter().copied().filter(|(_, cosine)| *cosine > outside);
        let (disc, ring): (Vec<_>, Vec<_>) = about.partition(|(_, cosine)| *cosine > inside);
        let ends = luminance(mean(&ring)) <= EDGE_SHARE * luminance(mean(&disc));
        ends.then_some((disc, ring))
    };
    let Some((disc, ring)) = REACHES_DEG.into_iter().find_map(split_at) else { return none() };
    let around = mean(&ring);
    let mut pixels = sky.pixels().to_vec();
    let (mut light, mut middle) = (DVec3::ZERO, DVec3::ZERO);
    for ((x, y), _) in &disc {
        let more = (sky.at(*x, *y) - around).max(DVec3::ZERO) * sky.solid_angle(*y);
        light += more;
        middle += sky.towards(*x, *y) * luminance(more);
        let pixel = &mut pixels[*y as usize * width as usize + *x as usize];
        *pixel = (sky.at(*x, *y).min(around)).as_vec3().into();
    }
    let whole = luminance(sky.total());
    if whole <= 0.0 || luminance(light) < least * whole {
        return none();
    }
    let sun = Sun {
        towards: middle.normalize_or(towards).as_vec3().into(),
        // Light of colour 1 causes an irradiance of π.
        color: (light / PI).as_vec3().into(),
    };
    (Some(sun), sky.with_pixels(pixels))
}
