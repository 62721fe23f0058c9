//! The slow truths that light in fur is measured against. Nothing of a bake depends on them.
//!
//! * [`SampledVolume`]: transmittance along the true light ray through the volume that the layers were sampled from. What is left between it
//!   and the layer-wise shadow maps is the error of the maps.
//! * [`StrandField`]: the same strands as round, opaque hairs. What is left between it and the volume is the error of slicing.
//! * [`Occluder`]: a mesh between its points and a light that is a disc, for soft shadows.
//! * [`TrueScene`]: the strands of [`pelage_bake::strands`], traced: what a whole picture should look like, by Yang's equation or, with
//!   [`TrueScattering`], by light that goes from fibre to fibre.
//! * [`TrueLines`]: contours, creases and borders of a posed skin as edges of its mesh, hidden parts removed by rays: what ink lines should be.
//! * [`TrueGuide`]: hair on guides that swings, by its equations and steps as short as it takes: what Verlet and its lengths should come to.
//!
//! They share with the fast paths the strands, the layers and the mesh that both read, and what `pelage_formats::meaning` says of them: where a
//! posed vertex stands, and a point of its hair. Else they share no code: an error that both had would not show.

mod camera;
mod capsules;
pub mod compare;
pub mod compare_lines;
pub mod compare_motion;
pub mod decide;
mod disc_light;
pub mod doctor;
mod hair_motion;
mod ink_lines;
mod lighting;
pub mod likeness;
mod part_file;
mod paths;
mod picture;
mod scattering;
mod sight;
mod sky;
mod strand_light;
mod strands;
mod tracer;
mod volume;

pub use camera::{Lens, TrueCamera, Ways};
pub use disc_light::{DiscLight, Occluder};
pub use hair_motion::{Followed, SkinMotion, TrueGuide, TrueSwing};
pub use ink_lines::{ContourForm, LineKind, LineParams, LineSegment, TrueLines, VisibleLines};
pub use lighting::{TrueLight, TrueLighting};
pub use part_file::{OfPicture, TracedPart};
pub use picture::{Part, Portion, Rays, Square, TracedPicture, TrueScene};
pub use scattering::TrueScattering;
pub use sight::{Look, SeenPoint, Sight};
pub use sky::TrueSky;
pub use strand_light::SeenStrand;
pub use strands::StrandField;
pub use volume::SampledVolume;

use glam::DVec2;
use pelage_bake::noise::{hash, uniform};

/// `samples` points of the unit square, rounded up to a square number: one anywhere in each cell of a square grid. The same for the same
/// `seed`.
fn stratified(seed: u64, samples: u32) -> impl ExactSizeIterator<Item = DVec2> {
    let side = samples_per_side(samples);
    (0..side * side).map(move |i| {
        let jitter = [2 * u64::from(i), 2 * u64::from(i) + 1].map(|n| f64::from(uniform(seed, n)));
        (DVec2::new(f64::from(i % side), f64::from(i / side)) + DVec2::from(jitter)) / f64::from(side)
    })
}

/// At least 1, and little enough that its square is a `u32`.
fn samples_per_side(samples: u32) -> u32 {
    (f64::from(samples).sqrt().ceil() as u32).clamp(1, 1 << 12)
}

/// A seed for a place, so that neighbouring places do not share their jitter: shared jitter is a pattern, and no noise.
fn seed_of(place: &[f64]) -> u64 {
    place.iter().fold(0x5eed, |seed, x| hash(seed, x.to_bits()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_has_its_sample() {
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
