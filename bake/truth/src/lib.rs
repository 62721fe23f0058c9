//! Slow reference renderings of light in fur, for comparison. No bake depends on them.
//!
//! * [`TrueScene`]: the strands of [`pelage_bake::strands`], ray traced. The picture is correct by Yang's equation or,
//!   with [`TrueScattering`], by light paths from fibre to fibre.
//! * [`compare`], [`likeness`]: error of a picture against its reference. [`decide`]: search for a setting within
//!   limits.
//! * [`doctor`]: predicted cost of a package, and advice.
//!
//! The crate `bake/lab` has further references that only charts need.
//!
//! References and fast paths read the same strands, layers and mesh. They share the definitions of
//! `pelage_formats::meaning`: the position of a posed vertex, and of a point of its hair. They share no other code,
//! because an error in shared code would not show.

mod camera;
mod capsules;
pub mod compare;
pub mod decide;
mod denoise;
pub mod doctor;
mod gloss;
mod lighting;
pub mod likeness;
mod part_file;
mod paths;
mod picture;
mod scattering;
mod sky;
mod strand_light;
mod tracer;
mod visibility;

pub use camera::{Lens, RayCaster, TrueCamera, ViewDirections};
pub use lighting::{TrueLight, TrueLighting};
pub use part_file::{PartHeader, TracedPart};
pub use picture::{Part, PictureSums, Portion, Rays, Square, TracedPicture, TrueScene};
pub use scattering::TrueScattering;
pub use sky::TrueSky;
pub use strand_light::VisibleStrand;
pub use visibility::{SurfaceView, SurfaceVisibility, VisiblePoint};

use glam::DVec2;
use pelage_bake::noise::{hash, uniform};
use std::f64::consts::FRAC_PI_4;

/// Returns at least `samples` stratified points of the unit square: one random point in each cell of a square grid.
/// Deterministic in `seed`.
pub fn stratified(seed: u64, samples: u32) -> impl ExactSizeIterator<Item = DVec2> {
    let side = samples_per_side(samples);
    (0..side * side).map(move |i| {
        let jitter = [2 * u64::from(i), 2 * u64::from(i) + 1].map(|n| f64::from(uniform(seed, n)));
        (DVec2::new(f64::from(i % side), f64::from(i / side)) + DVec2::from(jitter)) / f64::from(side)
    })
}

/// Returns the number of cells along a side of the grid: at least 1, and small enough that its square is a `u32`.
fn samples_per_side(samples: u32) -> u32 {
    (f64::from(samples).sqrt().ceil() as u32).clamp(1, 1 << 12)
}

/// Maps the unit square to the unit disc, preserving areas and adjacency (Shirley and Chiu 1997).
pub fn disc(square: DVec2) -> DVec2 {
    let p = 2.0 * square - 1.0;
    if p == DVec2::ZERO {
        return p;
    }
    let (radius, angle) =
        if p.x.abs() > p.y.abs() { (p.x, FRAC_PI_4 * p.y / p.x) } else { (p.y, FRAC_PI_4 * (2.0 - p.x / p.y)) };
    radius * DVec2::from_angle(angle)
}

/// Returns a seed for a position. Neighbouring positions need different seeds: with equal ones, noise would form a
/// pattern.
pub fn seed_of(place: &[f64]) -> u64 {
    place.iter().fold(0x5eed, |seed, x| hash(seed, x.to_bits()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stratified_samples_fill_every_cell() {
        for (samples, side) in [(0, 1u32), (1, 1), (2, 2), (16, 4), (17, 5), (256, 16)] {
            let points: Vec<DVec2> = stratified(7, samples).collect();
            assert_eq!(points.len() as u32, side * side);
            let mut cells: Vec<[u32; 2]> =
                points.iter().map(|p| [(p.y * f64::from(side)) as u32, (p.x * f64::from(side)) as u32]).collect();
            cells.sort_unstable();
            let all: Vec<[u32; 2]> = (0..side).flat_map(|y| (0..side).map(move |x| [y, x])).collect();
            assert_eq!(cells, all, "{samples} samples");
        }
        assert_ne!(seed_of(&[0.25, 0.5]), seed_of(&[0.5, 0.25]));
        assert!(stratified(1, 16).zip(stratified(2, 16)).all(|(a, b)| a != b));
    }
}
