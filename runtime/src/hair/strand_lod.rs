//! Level of detail for strands thinner than a pixel: when they replace layers, how many are drawn, and with how many
//! segments.

use crate::model::StrandSet;
use crate::params::{Detail, FurParams, StrandEdges};

/// Samples per pixel that blended edges are equivalent to.
const BLENDED_EFFECTIVE_SAMPLES: u32 = 16;

/// Returns the effective number of samples per pixel for thin strands, in a pass with `samples` per pixel.
pub(super) fn effective_samples(fur: &FurParams, samples: u32) -> u32 {
    match fur.strand_edges {
        StrandEdges::Samples => samples,
        StrandEdges::Blended => BLENDED_EFFECTIVE_SAMPLES,
    }
}

/// Minimum width of hairs on screen, pixels; to be divided by the number of samples per pixel. Instead of thinner
/// hairs, fewer and wider ones are drawn.
const MIN_WIDTH_PX: f32 = 0.36;

/// Minimum widths of hairs with blended edges, pixels: of guided hair, and of fur. Instead of thinner hairs, fewer and
/// wider ones are drawn. Blended edges need a limit because a pixel stores only its eight nearest segments.
const MIN_BLENDED_WIDTH_PX: [f32; 2] = [0.36, 0.18];

/// Minimum share of hairs that are drawn.
const MIN_HAIR_SHARE: f32 = 0.02;

/// Minimum width of multisampled fur strands on screen, pixels; to be divided by the square root of the number of
/// samples per pixel. At this width or above, fur shimmers less than twice as much as the reference image.
const MIN_FUR_WIDTH_PX: f32 = 0.9;

/// Minimum share of multisampled fur strands that are drawn. If fewer would be needed, layers are drawn instead.
const MIN_FUR_SHARE: f32 = 0.25;

/// Samples per pixel from which `MIN_FUR_SHARE` applies. With fewer samples, hairs one pixel wide have jagged edges, so
/// all thinner hair is drawn in layers.
const MIN_SAMPLES_FOR_THINNING: u32 = 4;

/// Returns the minimum share of fur strands; 1 if the application requests full detail.
fn min_fur_share(fur: &FurParams, samples: u32) -> f32 {
    if fur.detail == Detail::Full || samples < MIN_SAMPLES_FOR_THINNING { 1.0 } else { MIN_FUR_SHARE }
}

/// Returns the share of hairs that are drawn, for hairs of `width_px` and the given samples per pixel. The drawn hairs
/// are correspondingly wider.
pub(super) fn drawn_share(fur: &FurParams, guided: bool, width_px: f32, samples: u32) -> f32 {
    let [of_guided, of_coats] = MIN_BLENDED_WIDTH_PX;
    let (thinnest_px, fewest) = match (fur.strand_edges, guided) {
        (StrandEdges::Samples, true) => (MIN_WIDTH_PX / samples as f32, MIN_HAIR_SHARE),
        (StrandEdges::Samples, false) => (MIN_FUR_WIDTH_PX / (samples as f32).sqrt(), min_fur_share(fur, samples)),
        (StrandEdges::Blended, true) => (of_guided, MIN_HAIR_SHARE),
        (StrandEdges::Blended, false) => (of_coats, MIN_HAIR_SHARE),
    };
    (width_px / thinnest_px).clamp(fewest, 1.0)
}

/// Strand width at which strands begin to replace layers, relative to the width at which only strands are left. Between
/// these widths, both are drawn, so the range is narrow.
const MIXED_FROM: f32 = 0.8;

/// Strand width in pixels at and above which strands with blended edges replace layers. The switch is abrupt: strands
/// are as bright as layers, and layers drawn between them would fill gaps that should stay dark.
const BLENDED_FROM_PX: f32 = 0.10125;

/// Progress of the transition from layers to strands at which all strands are present.
const STRANDS_COMPLETE_AT: f32 = 0.6;
/// Progress of the transition from layers to strands at which layers begin to fade.
const LAYERS_FADE_FROM: f32 = 0.4;

/// Returns the share of the strands and of the layers' opacity at a point of the transition from layers, 0, to single
/// strands, 1. The strands first appear between the layers; then the layers fade.
pub(super) fn transition_shares(way: f32) -> [f32; 2] {
    let left = ((1.0 - way) / (1.0 - LAYERS_FADE_FROM)).min(1.0);
    // Many layers together are more opaque than one, so the last layers must fade slowly.
    [(way / STRANDS_COMPLETE_AT).min(1.0), left * left]
}

/// Returns the progress of the transition from layers, 0, to single strands, 1. `width_px`: width of the strands;
/// `samples`: number of samples per pixel of the pass.
pub(super) fn strand_transition(fur: &FurParams, width_px: f32, samples: u32) -> f32 {
    match fur.strand_edges {
        StrandEdges::Samples => {
            let taken_px = min_fur_share(fur, samples) * MIN_FUR_WIDTH_PX / (samples as f32).sqrt();
            ((width_px / taken_px - MIXED_FROM) / (1.0 - MIXED_FROM)).clamp(0.0, 1.0)
        }
        StrandEdges::Blended if width_px < BLENDED_FROM_PX => 0.0,
        StrandEdges::Blended => 1.0,
    }
}

/// Maximum deviation of the mean strand from its simplified shape, pixels; to be divided by the square root of the
/// number of samples per pixel.
const MAX_DEVIATION_PX: f32 = 0.28;

/// Strand width in pixels below which the allowed deviation grows in inverse proportion to the width. At such widths,
/// chance decides which strands the samples hit, and this causes the largest error.
const UNDERSAMPLED_WIDTH_PX: f32 = 0.5;

/// Number of samples above which the allowed deviation no longer decreases.
const MAX_DEVIATION_SAMPLES: u32 = 4;

/// Minimum number of segments per strand; a single straight segment cannot represent fur.
const FEWEST_PIECES: u32 = 2;

/// Returns the stride between the points that are drawn, for `px_per_m` and the given samples per pixel. `most_pieces`:
/// maximum number of segments, if set.
pub(super) fn point_step(strands: &StrandSet, px_per_m: f32, samples: u32, most_pieces: Option<u32>) -> u32 {
    if let Some(most) = most_pieces {
        return strands.steps().find(|step| strands.segments(*step) <= most).unwrap_or(strands.points - 1);
    }
    let few = |step: u32| strands.segments(step) >= FEWEST_PIECES.min(strands.segments(1));
    let thinner = (UNDERSAMPLED_WIDTH_PX / (px_per_m * strands.mean_width_m)).max(1.0);
    let most_px = MAX_DEVIATION_PX * thinner / (samples.min(MAX_DEVIATION_SAMPLES) as f32).sqrt();
    let fits = |step: u32, bent_m: f32| few(step) && bent_m * px_per_m <= most_px;
    strands
        .steps()
        .zip(&strands.deviation_m)
        .filter(|(step, bent_m)| fits(*step, **bent_m))
        .last()
        .map_or(1, |(step, _)| step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hair_share_falls_with_the_width_in_samples() {
        let fur = FurParams::default();
        let widths = [1.0, 0.9, 0.45, 0.225, 0.1];
        assert_eq!(widths.map(|px| drawn_share(&fur, false, px, 1)), [1.0; 5]);
        assert_eq!(widths.map(|px| drawn_share(&fur, false, px / 2.0, 4)), [1.0, 1.0, 0.5, 0.25, 0.25]);
        // At the width at which the last layers disappear, no strand is thinner than the limit.
        assert_eq!([0.11, 0.1125].map(|px| strand_transition(&fur, px, 4) == 1.0), [false, true]);
        let full = FurParams::default().with(|fur| fur.detail = Detail::Full);
        assert_eq!([0.9, 0.45, 0.1].map(|px| drawn_share(&full, false, px, 4)), [1.0; 3]);
        assert_eq!([0.35, 0.46].map(|px| strand_transition(&full, px, 4)), [0.0, 1.0]);
    }

    #[test]
    fn strands_appear_at_the_width_that_samples_resolve() {
        let of = |edges, px, samples| {
            let fur = FurParams::default().with(|fur| fur.strand_edges = edges);
            (1e4 * strand_transition(&fur, px, samples)).round() / 1e4
        };
        assert_eq!([0.7, 0.81, 0.91].map(|px| of(StrandEdges::Samples, px, 1)), [0.0, 0.5, 1.0]);
        assert_eq!([0.08, 0.10125, 0.12].map(|px| of(StrandEdges::Samples, px, 4)), [0.0, 0.5, 1.0]);
        for samples in [1, 4] {
            assert_eq!([0.08, 0.1, 0.105].map(|px| of(StrandEdges::Blended, px, samples)), [0.0, 0.0, 1.0]);
        }
    }
}
