//! Strands thinner than pixels: when they take the place of layers, how many of them are drawn and in how many pieces.

use crate::model::Strands;
use crate::params::{Detail, FurParams, StrandEdges};

/// Samples a pixel that blended edges are as good as.
const BLENDED_AS: u32 = 16;

/// Samples a pixel that thin strands are found by, in a pass of so many.
pub(super) fn found_as(fur: &FurParams, samples: u32) -> u32 {
    match fur.strand_edges {
        StrandEdges::Samples => samples,
        StrandEdges::Blended => BLENDED_AS,
    }
}

/// Width of hairs on screen, pixels over samples, below which fewer and wider ones stand for them.
const THINNEST_PX: f32 = 0.36;

/// The same, pixels, of hair on guides and of coats whose edges are blended: a pixel knows its nearest eight alone.
const THINNEST_BLENDED_PX: [f32; 2] = [0.36, 0.18];

/// Least share of them.
const FEWEST_HAIRS: f32 = 0.02;

/// The same, pixels over the root of the samples, of coats that are drawn in samples. From there on they shimmer less than twice as much as the true
/// picture.
const THINNEST_OF_COAT_PX: f32 = 0.9;

/// Least share of a coat's hairs that is drawn in samples: what would have to be fewer is drawn in layers.
const FEWEST_OF_COAT: f32 = 0.25;

/// Samples a pixel from which that is so. With fewer, hairs a pixel wide have jagged edges, and all that are thinner are drawn in layers.
const FEW_FROM_SAMPLES: u32 = 4;

/// The least share as an application wants it: who asks for all detail gets all hairs.
fn fewest_of_coat(fur: &FurParams, samples: u32) -> f32 {
    if fur.detail == Detail::Full || samples < FEW_FROM_SAMPLES { 1.0 } else { FEWEST_OF_COAT }
}

/// Share of hairs that is drawn, the wider, where they are so many pixels wide and a pixel has so many samples.
pub(super) fn share_of_hairs(fur: &FurParams, guided: bool, width_px: f32, samples: u32) -> f32 {
    let [of_guided, of_coats] = THINNEST_BLENDED_PX;
    let (thinnest_px, fewest) = match (fur.strand_edges, guided) {
        (StrandEdges::Samples, true) => (THINNEST_PX / samples as f32, FEWEST_HAIRS),
        (StrandEdges::Samples, false) => (THINNEST_OF_COAT_PX / (samples as f32).sqrt(), fewest_of_coat(fur, samples)),
        (StrandEdges::Blended, true) => (of_guided, FEWEST_HAIRS),
        (StrandEdges::Blended, false) => (of_coats, FEWEST_HAIRS),
    };
    (width_px / thinnest_px).clamp(fewest, 1.0)
}

/// Width from which strands begin to take the place of layers, over that from which they have. Both are drawn in between, so that it is narrow.
const MIXED_FROM: f32 = 0.8;

/// The same, pixels, of strands with blended edges. They are as bright as layers, and layers between them would fill what is dark: it is one or the other.
const BLENDED_FROM_PX: f32 = 0.2025;

/// Of the way from layers to strands: where all strands have come in, and where layers begin to fade.
const STRANDS_IN: f32 = 0.6;
const LAYERS_STAY: f32 = 0.4;

/// Shares of the strands, and of the layers' opacity, on the way from layers, 0, to single strands, 1: first strands come in between the layers, then
/// the layers fade.
pub(super) fn shares_on_the_way(way: f32) -> [f32; 2] {
    let left = ((1.0 - way) / (1.0 - LAYERS_STAY)).min(1.0);
    // Many layers hide more together than one: the last of them go slowly.
    [(way / STRANDS_IN).min(1.0), left * left]
}

/// How far on the way to single strands hair is where those are so many pixels wide, in a pass of so many samples.
pub(super) fn way_to_strands(fur: &FurParams, width_px: f32, samples: u32) -> f32 {
    match fur.strand_edges {
        StrandEdges::Samples => {
            let taken_px = fewest_of_coat(fur, samples) * THINNEST_OF_COAT_PX / (samples as f32).sqrt();
            ((width_px / taken_px - MIXED_FROM) / (1.0 - MIXED_FROM)).clamp(0.0, 1.0)
        }
        StrandEdges::Blended if width_px < BLENDED_FROM_PX => 0.0,
        StrandEdges::Blended => 1.0,
    }
}

/// How far, in pixels over the root of the samples, the mean strand may bend away from what is left of it when points are left out.
const BENT_PX: f32 = 0.28;

/// Width in pixels below which strands may bend more, in proportion to what they are thinner: which of them samples find is most of the error then.
const FOUND_BY_CHANCE_PX: f32 = 0.5;

/// Samples beyond which more of them let a strand bend no less.
const MOST_BENT_SAMPLES: u32 = 4;

/// Fewest pieces of a strand: what two points leave of a coat is not it.
const FEWEST_PIECES: u32 = 2;

/// Every how many points of strands is drawn, where a metre has so many pixels and a pixel so many samples; in at most `most_pieces`, where that says so.
pub(super) fn point_step(strands: &Strands, px_per_m: f32, samples: u32, most_pieces: Option<u32>) -> u32 {
    if let Some(most) = most_pieces {
        return strands.steps().find(|step| strands.pieces(*step) <= most).unwrap_or(strands.points - 1);
    }
    let few = |step: u32| strands.pieces(step) >= FEWEST_PIECES.min(strands.pieces(1));
    let thinner = (FOUND_BY_CHANCE_PX / (px_per_m * strands.mean_width_m)).max(1.0);
    let most_px = BENT_PX * thinner / (samples.min(MOST_BENT_SAMPLES) as f32).sqrt();
    let fits = |step: u32, bent_m: f32| few(step) && bent_m * px_per_m <= most_px;
    strands
        .steps()
        .zip(&strands.bent_m)
        .filter(|(step, bent_m)| fits(*step, **bent_m))
        .last()
        .map_or(1, |(step, _)| step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_hairs_of_a_coat_are_as_wide_as_samples_find_them() {
        let fur = FurParams::default();
        let widths = [1.0, 0.9, 0.45, 0.225, 0.1];
        assert_eq!(widths.map(|px| share_of_hairs(&fur, false, px, 1)), [1.0; 5]);
        assert_eq!(widths.map(|px| share_of_hairs(&fur, false, px / 2.0, 4)), [1.0, 1.0, 0.5, 0.25, 0.25]);
        // Where layers have gone no hair is thinner than that.
        assert_eq!([0.11, 0.1125].map(|px| way_to_strands(&fur, px, 4) == 1.0), [false, true]);
        let full = FurParams::default().with(|fur| fur.detail = Detail::Full);
        assert_eq!([0.9, 0.45, 0.1].map(|px| share_of_hairs(&full, false, px, 4)), [1.0; 3]);
        assert_eq!([0.35, 0.46].map(|px| way_to_strands(&full, px, 4)), [0.0, 1.0]);
    }

    #[test]
    fn strands_begin_where_samples_find_them() {
        let of = |edges, px, samples| {
            let fur = FurParams::default().with(|fur| fur.strand_edges = edges);
            (1e4 * way_to_strands(&fur, px, samples)).round() / 1e4
        };
        assert_eq!([0.7, 0.81, 0.91].map(|px| of(StrandEdges::Samples, px, 1)), [0.0, 0.5, 1.0]);
        assert_eq!([0.08, 0.10125, 0.12].map(|px| of(StrandEdges::Samples, px, 4)), [0.0, 0.5, 1.0]);
        for samples in [1, 4] {
            assert_eq!([0.175, 0.2, 0.21].map(|px| of(StrandEdges::Blended, px, samples)), [0.0, 0.0, 1.0]);
        }
    }
}
