//! Error of a fur picture against the true one, as a single figure that rises when hair is lost.
//!
//! Mean FLIP alone cannot detect lost hair. A bare body under a detached outline (a ghost) has the right colours on
//! average; FLIP ranked such a picture above a picture with four times the layers and fins. Three quantities are
//! therefore measured against the reference image:
//!
//! * `flip`: mean FLIP over all pixels ([`super::compare`]), 0..=1
//! * `outline`: mean absolute difference of coverage, pixel by pixel, in the ring, 0..=1. The ring contains the pixels
//!   on either side of the true outline, up to a distance of the fur's projected height. Coverage is compared pixel by
//!   pixel, because a line detached from the body covers as much on average as hair does
//! * `contrast`: local contrast of the picture divided by that of the truth; 1 means equal, less means blurred or bare.
//!   Local contrast is the standard deviation of luminance in the 9 by 9 pixels around a pixel. Only pixels that both
//!   pictures cover by half are included. It is averaged over all such pixels
//!
//! The error is the mean over all pixels of the sum:
//!
//! ```text
//! error = 0.4 · flip + 1.6 · ring · outline + 0.2 · covered · (1 − min(contrast, 1 / contrast))
//! ```
//!
//! `ring` is the fraction of the picture in the ring, 0..=1. `covered` is the fraction that both pictures cover by
//! half, 0..=1. The error has no unit and is in 0..=2.2; for faithful pictures of a whole animal it is 0.01 to 0.06.
//! Like mean FLIP, it is proportional to the fraction of the picture that the animal covers.
//!
//! The weights are calibrated on pairs of pictures that a person ranks at a glance (`tests/golden/likeness/pairs.txt`).
//! A missing pixel of outline weighs as much as four times the largest FLIP. If all strands are present but cover other
//! pixels, `outline` is 0.02 to 0.1. For a ghost it is only a third larger, while its FLIP can be a sixth smaller.
//! Contrast distinguishes blurred fur from crisp fur with the same outline. It must not compensate for a lost outline,
//! because few layers of a fine tile are crisp. The weights are scaled so that the built-in hare with its recipe has
//! the same error as mean FLIP, 0.018. A limit found with mean FLIP thus means much the same if no hair is lost.

use super::compare::{CompareParams, Comparison, compare_pictures};
use pelage_bake::mask::Mask;
use pelage_bake::picture::Picture;
use pelage_formats::meaning::luminance;
use pelage_import::BakeError;

/// Weight of mean FLIP.
const FLIP: f64 = 0.4;
/// Weight of a pixel in the ring.
const OUTLINE: f64 = 1.6;
/// Weight of contrast in a pixel that both pictures cover.
const CONTRAST: f64 = 0.2;

/// Half width of the window, without its middle pixel, pixels.
const REACH: usize = 4;
/// Coverage from which a pixel belongs to the animal.
const COVERED: f32 = 0.5;
/// Minimum width of the ring on either side, pixels, because the outline of short fur is not sharp either.
const LEAST_RING_PX: f64 = 2.0;

/// Error of a picture against the truth, with its components.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Likeness {
    /// Total error, 0 for equal pictures; see the [module](self).
    pub error: f64,
    /// Mean FLIP, 0..=1.
    pub flip: f64,
    /// Mean absolute difference of coverage in the ring, 0..=1; 0 without a ring.
    pub outline: f64,
    /// Local contrast divided by that of the truth, above 0; 1 if there is none to compare.
    pub contrast: f64,
}

impl Likeness {
    /// Likeness of equal pictures.
    pub const SAME: Self = Self { error: 0.0, flip: 0.0, outline: 0.0, contrast: 1.0 };

    /// Compares a picture with the true one.
    ///
    /// * `fur_px`: height of the fur on the screen, pixels
    ///
    /// Fails with [`BakeError::Params`] if the sizes differ, or if the pictures have no pixels.
    pub fn of(picture: &Picture, truth: &Picture, fur_px: f64) -> Result<Self, BakeError> {
        let (compared, _) = compare_pictures(picture, truth, &CompareParams::default())?;
        Ok(Self::of_compared(&compared, picture, truth, fur_px))
    }

    /// Computes [`Self::of`] for two pictures whose comparison with [`CompareParams::default`] is already known. Saves
    /// time, because FLIP takes longest.
    pub fn of_compared(compared: &Comparison, picture: &Picture, truth: &Picture, fur_px: f64) -> Self {
        let flip = compared.flip.mean;
        let pixels = truth.pixels.len() as f64;

        let ring = ring(truth, fur_px.max(LEAST_RING_PX));
        let alphas = picture.pixels.iter().zip(&truth.pixels).map(|(p, t)| f64::from(p[3] - t[3]).abs());
        let missing: f64 = alphas.zip(&ring).filter(|(_, inside)| **inside).map(|(apart, _)| apart).sum();
        let ring_pixels = ring.iter().filter(|inside| **inside).count();

        let solid = |p: &[f32; 4]| p[3] >= COVERED;
        let both: Vec<bool> = picture.pixels.iter().zip(&truth.pixels).map(|(p, t)| solid(p) && solid(t)).collect();
        let covered = both.iter().filter(|inside| **inside).count() as f64 / pixels;
        let contrast = ratio(local_contrast(picture, &both), local_contrast(truth, &both));
        let lost = 1.0 - contrast.min(1.0 / contrast);
        Self {
            error: FLIP * flip + OUTLINE * missing / pixels + CONTRAST * covered * lost,
            flip,
            outline: missing / ring_pixels.max(1) as f64,
            contrast,
        }
    }

    /// Returns the mean of several views; [`Self::SAME`] for none.
    pub fn mean(views: &[Self]) -> Self {
        if views.is_empty() {
            return Self::SAME;
        }
        let mean = |of: fn(&Self) -> f64| views.iter().map(of).sum::<f64>() / views.len() as f64;
        Self {
            error: mean(|l| l.error),
            flip: mean(|l| l.flip),
            outline: mean(|l| l.outline),
            contrast: mean(|l| l.contrast),
        }
    }
}

/// Returns a mask of the pixels within `reach` pixels of the outline of `truth`, on either side.
fn ring(truth: &Picture, reach: f64) -> Vec<bool> {
    let (width, height) = (truth.width, truth.height);
    let far_from = |covered: bool| {
        let pixels = truth.pixels.iter().map(|p| (p[3] >= COVERED) == covered).collect();
        Mask { width, height, pixels }.distances()
    };
    far_from(true).iter().zip(far_from(false)).map(|(outside, inside)| outside.max(inside) <= reach).collect()
}

/// Returns the ratio of two contrasts. Each is clamped to at least one 8-bit step, because flat colour has no contrast
/// to compare.
fn ratio(found: f64, expected: f64) -> f64 {
    const STEP: f64 = 1.0 / 255.0;
    found.max(STEP) / expected.max(STEP)
}

/// Returns the mean local contrast over the pixels in the mask `inside`. Local contrast is the standard deviation of
/// sRGB-encoded luminance, 0..=1, over the pixels of the window that are in the mask. Windows with less than half of
/// their pixels in the mask are skipped.
fn local_contrast(picture: &Picture, inside: &[bool]) -> f64 {
    let (width, height) = (picture.width as usize, picture.height as usize);
    // At most half of a pixel's colour is background, and the background is the same for both pictures.
    let bytes = picture.composite_over(CompareParams::default().over);
    let luminance = |c: &[u8]| luminance([c[0], c[1], c[2]].map(|byte| f64::from(byte) / 255.0).into());
    let values: Vec<[f64; 3]> = bytes
        .chunks_exact(3)
        .zip(inside)
        .map(|(c, inside)| if *inside { [1.0, luminance(c), luminance(c).powi(2)] } else { [0.0; 3] })
        .collect();
    let sums = window_sums(&values, width, height);
    let half = 0.5 * ((2 * REACH + 1) as f64).powi(2);
    let (mut total, mut count) = (0.0, 0_u32);
    for ([n, sum, squares], _) in sums.iter().zip(inside).filter(|([n, ..], inside)| **inside && *n >= half) {
        total += (squares / n - (sum / n).powi(2)).max(0.0).sqrt();
        count += 1;
    }
    total / f64::from(count.max(1))
}

/// Returns the sum over each value's window of `2 * REACH + 1` by `2 * REACH + 1` values, clipped to the picture.
fn window_sums(values: &[[f64; 3]], width: usize, height: usize) -> Vec<[f64; 3]> {
    let add = |a: [f64; 3], b: &[f64; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
    let window = |at: usize, length: usize| at.saturating_sub(REACH)..(at + REACH + 1).min(length);
    let places = || (0..values.len()).map(|i| (i % width, i / width));
    let rows: Vec<[f64; 3]> =
        places().map(|(x, y)| values[y * width..][window(x, width)].iter().fold([0.0; 3], add)).collect();
    places().map(|(x, y)| window(y, height).map(|y| &rows[y * width + x]).fold([0.0; 3], add)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_bake::noise::uniform;

    /// Draws a disc of noisy fur with a border of single hairs, 64 by 64 pixels. `texel` returns colour and coverage
    /// for a pixel index and the distance from the centre.
    fn disc(texel: impl Fn(u64, f64) -> (f32, f32)) -> Picture {
        let pixels = (0..64 * 64_u32).map(|i| {
            let (x, y) = (f64::from(i % 64) - 31.5, f64::from(i / 64) - 31.5);
            let (grey, alpha) = texel(u64::from(i), x.hypot(y));
            [grey * alpha, grey * alpha, grey * alpha, alpha]
        });
        Picture { width: 64, height: 64, pixels: pixels.collect() }
    }

    /// Returns the coverage of single hairs between the body at 18 pixels and tips at 26 pixels.
    fn hairs(i: u64, r: f64) -> f32 {
        if r < 18.0 || r < 26.0 && uniform(3, i) < 0.6 { 1.0 } else { 0.0 }
    }

    fn fur(i: u64, r: f64) -> (f32, f32) {
        (0.2 + 0.2 * uniform(1, i), hairs(i, r))
    }

    fn against_fur(texel: impl Fn(u64, f64) -> (f32, f32)) -> Likeness {
        Likeness::of(&disc(texel), &disc(fur), 8.0).unwrap()
    }

    #[test]
    fn identical_pictures_have_zero_likeness_error() {
        assert_eq!(against_fur(fur), Likeness::SAME);
        let nothing = disc(|_, _| (0.0, 0.0));
        assert_eq!(Likeness::of(&nothing, &nothing, 8.0).unwrap(), Likeness::SAME);
        assert_eq!(Likeness::mean(&[]), Likeness::SAME);
        let other = Picture { width: 32, height: 128, ..nothing.clone() };
        assert!(Likeness::of(&nothing, &other, 8.0).is_err());
    }

    /// Checks that each term responds to its kind of loss, with the documented weight.
    #[test]
    fn each_likeness_term_responds_to_its_own_loss() {
        let bald = against_fur(|i, r| (fur(i, r).0, if r < 18.0 { 1.0 } else { 0.0 }));
        assert!(bald.outline > 0.15 && (bald.contrast - 1.0).abs() < 0.05, "{bald:?}");
        let flat = against_fur(|i, r| (0.3, hairs(i, r)));
        assert!(flat.outline == 0.0 && flat.contrast < 0.2, "{flat:?}");
        let noisy = against_fur(|i, r| (0.1 + 0.4 * uniform(1, i), hairs(i, r)));
        assert!(noisy.contrast > 1.3 && noisy.outline == 0.0, "{noisy:?}");
        // The expected error is computed from pixel counts.
        let truth = disc(fur);
        let share = |of: &dyn Fn(&[f32; 4]) -> bool| {
            truth.pixels.iter().filter(|p| of(p)).count() as f64 / truth.pixels.len() as f64
        };
        let covered = share(&|p| p[3] >= 0.5);
        for (name, found, lost) in [("flat", flat, 1.0 - flat.contrast), ("noisy", noisy, 1.0 - 1.0 / noisy.contrast)] {
            let expected = 0.4 * found.flip + 0.2 * covered * lost;
            assert!((found.error - expected).abs() < 1e-12, "{name}: {found:?}, {expected}");
        }
        let skin = disc(|_, r| (0.0, if r < 18.0 { 1.0 } else { 0.0 }));
        let missing = covered - skin.pixels.iter().filter(|p| p[3] > 0.0).count() as f64 / skin.pixels.len() as f64;
        // The ring extends eight pixels inside the outline of single hairs, so it contains all of the missing hair.
        let expected = 0.4 * bald.flip + 1.6 * missing;
        assert!((bald.error - expected).abs() < 0.003, "{bald:?}, {expected}");
    }

    /// Compares a ghost (body, a gap, and a closed line where the tips end) with complete, soft hair.
    #[test]
    fn a_detached_outline_is_worse_than_soft_hair() {
        let ghost = against_fur(|_, r| (0.3, if (18.0..22.0).contains(&r) || r >= 26.0 { 0.0 } else { 1.0 }));
        let soft = |i, r: f64| if (18.0..26.0).contains(&r) { 0.25 + 0.5 * hairs(i, r) } else { hairs(i, r) };
        let soft = against_fur(|i, r| (0.3, soft(i, r)));
        assert!(ghost.error > 1.3 * soft.error, "{ghost:?}, {soft:?}");
    }

    /// Checks that the ring extends by the fur's height on both sides of the outline, and at least two pixels.
    #[test]
    fn likeness_ring_is_as_wide_as_the_fur() {
        let solid = disc(|_, r| (0.3, if r < 20.0 { 1.0 } else { 0.0 }));
        for (fur_px, width) in [(5.0, 5.0), (0.0, 2.0)] {
            let inside = ring(&solid, f64::max(fur_px, LEAST_RING_PX));
            for (i, inside) in inside.iter().enumerate() {
                let r = ((i % 64) as f64 - 31.5).hypot((i / 64) as f64 - 31.5);
                let far = (r - 20.0).abs();
                assert!(*inside || far > width - 1.0, "{fur_px}: {far}");
                assert!(!*inside || far < width + 1.0, "{fur_px}: {far}");
            }
        }
    }
}
