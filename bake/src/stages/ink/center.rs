//! Choice of the wash's centre, if the recipe gives none.
//!
//! In Fang 2006, §3, the user picks a centre CP on the model. The wash W at a surface point V with unit normal N
//! depends on (V − CP)·N. Here, points spread evenly over the washed mesh surface are scored as centres. A high score
//! needs the following:
//!
//! * The wash W, clamped, varies strongly over the surface (standard deviation, weighted by area).
//! * It is darker above than below, because a painter applies more ink to back and head and leaves the belly to the
//!   paper.
//! * It is pale rather than dark.
//! * Little of the surface is black. The wash can become black where (V − CP)·N is negative, behind a hollow.

use super::product::wash_product;
use glam::Vec3;
use pelage_formats::InkShading;
use rayon::prelude::*;

/// Number of candidate points that are scored.
const CANDIDATES: usize = 96;
/// Bonus for a wash that is dark above and pale below, as a share of the standard deviation.
const DARK_ABOVE_BONUS: f64 = 0.6;
/// Grey below which the wash counts as black.
const BLACK: f32 = 0.3;

/// Point of the washed mesh surface at rest, in world space.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceSample {
    pub(super) place: Vec3,
    pub(super) normal: Vec3,
    /// Area represented by the point, multiplied by the amount of wash there.
    pub(super) weight: f64,
}

/// Returns the best of the candidate centres; `None` if the model has no wash.
///
/// * `radius`: radius of the model's bounding sphere, metres
pub(super) fn pick(spots: &[SurfaceSample], radius: f32, shading: &InkShading) -> Option<Vec3> {
    let washed: Vec<_> = spots.iter().copied().filter(|s| s.weight > 0.0).collect();
    let scores = spread(&washed, CANDIDATES);
    let scores: Vec<_> = scores.par_iter().map(|i| (score(&washed, washed[*i].place, radius, shading), *i)).collect();
    // The first of equal scores wins, so that the choice does not depend on the order of evaluation.
    let best = scores.iter().copied().reduce(|best, next| if next.0 > best.0 { next } else { best });
    best.map(|(_, i)| washed[i].place)
}

/// Returns the indices of at most `count` samples that are far from each other, starting with the sample of greatest
/// height.
fn spread(spots: &[SurfaceSample], count: usize) -> Vec<usize> {
    let mut away = vec![f32::INFINITY; spots.len()];
    let highest = (0..spots.len()).reduce(|a, b| if spots[b].place.y > spots[a].place.y { b } else { a });
    let mut next = highest;
    let mut chosen = Vec::new();
    while let Some(i) = next.filter(|_| chosen.len() < count) {
        chosen.push(i);
        for (away, spot) in away.iter_mut().zip(spots) {
            *away = away.min(spot.place.distance_squared(spots[i].place));
        }
        let farthest = (0..spots.len()).reduce(|a, b| if away[b] > away[a] { b } else { a });
        next = farthest.filter(|i| away[*i] > 0.0);
    }
    chosen
}

/// Returns the score of a centre; higher is better.
fn score(spots: &[SurfaceSample], center: Vec3, radius: f32, shading: &InkShading) -> f64 {
    let grey = |spot: &SurfaceSample| {
        let [literal, normalised] = wash_product(spot.place, spot.normal, center, radius);
        let x = if shading.normalised { normalised } else { literal };
        // Compresses negative products, as the runtime does.
        let x = if x < 0.0 { x / (1.0 - 2.0 * x) } else { x };
        x * shading.wash_speed + shading.wash_range
    };
    let (mut weight, mut black) = (0.0, 0.0);
    let (mut sum, mut squares, mut up, mut ups, mut both) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for spot in spots {
        let (w, grey, y) = (spot.weight, grey(spot), f64::from(spot.normal.y));
        let g = f64::from(grey.clamp(0.0, 1.0));
        weight += w;
        black += if grey < BLACK { w } else { 0.0 };
        sum += w * g;
        squares += w * g * g;
        up += w * y;
        ups += w * y * y;
        both += w * g * y;
    }
    let (grey, y) = (sum / weight, up / weight);
    let deviation = (squares / weight - grey * grey).max(0.0).sqrt();
    let slant = (ups / weight - y * y).max(0.0).sqrt();
    // Correlation of darkness with upward normals.
    let above = if deviation * slant > 1e-9 { (grey * y - both / weight) / (deviation * slant) } else { 0.0 };
    let drowned = 1.0 - black / weight;
    // The cube of the mean grey favours pale washes: most of a painting is paper.
    deviation * (1.0 + DARK_ABOVE_BONUS * above) * (drowned * drowned) * (grey * grey * grey)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sphere() -> Vec<SurfaceSample> {
        let at = |i: usize| {
            let y = 1.0 - 2.0 * (i as f32 + 0.5) / 800.0;
            let (sin, cos) = (i as f32 * 2.399_963).sin_cos();
            let normal = Vec3::new(cos * (1.0 - y * y).sqrt(), y, sin * (1.0 - y * y).sqrt());
            SurfaceSample { place: 2.0 * normal, normal, weight: 1.0 }
        };
        (0..800).map(at).collect()
    }

    #[test]
    fn wash_centre_of_a_sphere_is_at_the_top() {
        let center = pick(&sphere(), 2.0, &InkShading::default()).unwrap_or_default();
        assert!(center.y > 1.7, "{center}");
    }

    #[test]
    fn wash_centre_minimises_the_black_surface() {
        // Two bodies face each other. For a centre on one of them, the side of the other body that faces it becomes
        // black.
        let spot = |y: f32, ny: f32| SurfaceSample { place: Vec3::new(0.0, y, 0.0), normal: ny * Vec3::Y, weight: 1.0 };
        let spots = [spot(1.0, 1.0), spot(0.4, -1.0), spot(-0.4, 1.0), spot(-1.0, -1.0)];
        let shading = InkShading { wash_speed: 1.0, wash_range: 0.3, ..InkShading::default() };
        let drowned = |c: Vec3| spots.iter().filter(|s| (s.place - c).dot(s.normal) + 0.3 < BLACK).count();
        let center = pick(&spots, 1.0, &shading).unwrap_or_default();
        let least = spots.iter().map(|s| drowned(s.place)).min();
        assert_eq!(Some(drowned(center)), least, "{center}");
    }

    #[test]
    fn only_washed_skin_has_a_centre() {
        let mut spots = sphere();
        spots.iter_mut().filter(|s| s.place.y > 0.0).for_each(|s| s.weight = 0.0);
        let center = pick(&spots, 2.0, &InkShading::default()).unwrap_or(Vec3::Y);
        assert!(center.y <= 0.0, "{center}");
        spots.iter_mut().for_each(|s| s.weight = 0.0);
        assert_eq!(pick(&spots, 2.0, &InkShading::default()), None);
        assert_eq!(pick(&[], 2.0, &InkShading::default()), None);
    }
}
