//! Fur patterns: small images that repeat in both directions.

use super::body::ramp;
use glam::DVec2;
use image::{Rgb, RgbImage};
use std::f64::consts::TAU;

/// Width and height, texels.
pub const SIDE: u32 = 192;

/// Returns wavy black stripes on white, of uneven width and occasionally forked.
pub fn zebra() -> RgbImage {
    paint(|p| {
        let wave = 0.20 * libm::sin(TAU * p.y)
            + 0.09 * libm::sin(TAU * (2.0 * p.y + p.x))
            + 0.05 * libm::sin(TAU * (5.0 * p.y - p.x));
        let width = 0.10 + 0.30 * libm::sin(TAU * (p.y + 2.0 * p.x)) * libm::cos(TAU * p.x);
        let stripe = libm::sin(TAU * (5.0 * p.x + wave)) + width;
        mix([24, 20, 18], [255, 252, 244], ramp(-0.12, 0.12, stripe))
    })
}

/// Returns a tabby pattern: narrow, wavy brown stripes on tan, of uneven width and occasionally interrupted.
pub fn tabby() -> RgbImage {
    paint(|p| {
        let wave = 0.10 * libm::sin(TAU * p.y)
            + 0.07 * libm::sin(TAU * (2.0 * p.y + p.x))
            + 0.05 * libm::sin(TAU * (4.0 * p.y - 2.0 * p.x));
        let width = 0.35 * libm::sin(TAU * (2.0 * p.y + 3.0 * p.x)) * libm::cos(TAU * (p.y - p.x))
            + 0.20 * libm::cos(TAU * (3.0 * p.y - 2.0 * p.x))
            - 0.25;
        let stripe = libm::sin(TAU * (6.0 * p.x + 1.6 * wave)) + width;
        mix([226, 190, 146], [92, 66, 48], ramp(-0.3, 0.5, stripe))
    })
}

/// Returns all patterns with their file names in `patterns`.
pub fn all() -> [(&'static str, RgbImage); 3] {
    [("zebra", zebra()), ("spots", spots()), ("tabby", tabby())]
}

/// Returns dark spots of uneven size on white.
pub fn spots() -> RgbImage {
    // Each cell of a grid has one spot at a random position. The spots are even enough to look natural, and the grid
    // stays invisible.
    const CELLS: i64 = 7;
    let spot = |x: i64, y: i64| {
        let key = (x.rem_euclid(CELLS) * CELLS + y.rem_euclid(CELLS)) as u64;
        let random = |n: u64| {
            let mut z = (key * 4 + n + 77).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            (z >> 40) as f64 / f64::from(1 << 24)
        };
        let place = DVec2::new(x as f64 + 0.3 + 0.4 * random(0), y as f64 + 0.3 + 0.4 * random(1));
        (place, 0.24 + 0.15 * random(2), TAU * random(3))
    };
    paint(|p| {
        let q = p * CELLS as f64;
        let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy)));
        let inside = around.map(|(dx, dy)| {
            let (place, radius, turn) = spot(q.x.floor() as i64 + dx, q.y.floor() as i64 + dy);
            // Spots are egg-shaped, at random angles.
            let way = q - place;
            let angle = libm::atan2(way.y, way.x) + turn;
            let radius = radius * (1.0 + 0.14 * libm::cos(2.0 * angle) + 0.06 * libm::cos(3.0 * angle + turn));
            radius - way.length()
        });
        mix([255, 250, 240], [52, 32, 20], ramp(-0.035, 0.035, inside.fold(f64::MIN, f64::max)))
    })
}

fn paint(color: impl Fn(DVec2) -> [u8; 3]) -> RgbImage {
    RgbImage::from_fn(SIDE, SIDE, |x, y| Rgb(color((DVec2::new(f64::from(x), f64::from(y)) + 0.5) / f64::from(SIDE))))
}

fn mix(a: [u8; 3], b: [u8; 3], t: f64) -> [u8; 3] {
    std::array::from_fn(|c| (f64::from(a[c]) + (f64::from(b[c]) - f64::from(a[c])) * t).round() as u8)
}
