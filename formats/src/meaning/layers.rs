//! Layers of fur: their heights, and the layers drawn at each level of detail.

use crate::DetailLevel;

/// Number of layers, layer 0 included, that are drawn into a map of the fur's total transmittance. The transmittance
/// hardly depends on the layer count.
pub const TOTAL_MAP_LAYERS: u32 = 3;

/// Returns the height of a layer, as a share of the fur's height: 0 for layer 0, on the surface, and 1 for the
/// outermost. `layers` is the layer count, layer 0 included, 2 or more.
pub fn layer_height(layer: u32, layers: u32) -> f32 {
    layer as f32 / (layers - 1) as f32
}

/// Returns how many of the `baked` layers the layer `layer`, in 1..`baked`, represents at a level of detail with step
/// `step`: itself and the layers below it, down to the next drawn layer. 0 if the level does not draw it; a level of
/// step 0 draws no layers.
pub fn represented_layers(layer: u32, baked: u32, step: u32) -> u32 {
    if step == 0 || !(baked - 1 - layer).is_multiple_of(step) { 0 } else { step.min(layer) }
}

/// Returns the number of layers, of `baked`, that a level of detail with step `step` draws; layer 0 is excluded.
pub fn detail_count(baked: u32, step: u32) -> u32 {
    if step == 0 || baked < 2 { 0 } else { (baked - 2) / step + 1 }
}

/// Returns the number of layers that a level with step `step`, 1 or more, draws but the next level, with step `2 *
/// step`, does not.
pub fn detail_pairs(baked: u32, step: u32) -> u32 {
    detail_count(baked, step) - detail_count(baked, 2 * step)
}

/// Returns the lowest layer drawn if every `step`-th of `baked` layers, 2 or more, is drawn.
fn lowest(baked: u32, step: u32) -> u32 {
    (baked - 2) % step + 1
}

/// Returns how far the transition of a layer in 1..`baked` to the next level has progressed, 0..=1. `step` is the step
/// of the current level. `gone` is the number of the [`detail_pairs`] layers that have been removed; a fraction means
/// that the next one is fading.
///
/// Layers are removed one after another, from the surface outwards. Each gives its opacity to the next drawn layer
/// above; all others stay as they are. So the transition passes through every layer count between the two levels.
pub fn detail_fade(layer: u32, baked: u32, step: u32, gone: f32) -> f32 {
    let kept = lowest(baked, 2 * step);
    // The lowest layer that the next level keeps may have no drawn layer below it.
    let first = u32::from(kept <= step);
    let pair = (layer + step).saturating_sub(kept) / (2 * step);
    (gone - pair.saturating_sub(first) as f32).clamp(0.0, 1.0)
}

/// Returns the `index`-th drawn layer, from the surface outwards, during the transition to the next level. Before the
/// transition, every `step`-th of `baked` layers, 2 or more, is drawn. `gone` is the number of the [`detail_pairs`]
/// layers that have been removed.
pub fn detail_layer(index: u32, baked: u32, step: u32, gone: f32) -> u32 {
    let kept = lowest(baked, 2 * step);
    let first = u32::from(kept <= step);
    // Number of pairs of layers of which only the upper one is left. If the lowest kept layer has no partner, it counts
    // as such a pair.
    let thinned = gone as u32 + first;
    if gone >= 1.0 && index < thinned {
        kept + 2 * step * index
    } else {
        lowest(baked, step) + step * (index + gone as u32)
    }
}

/// Returns the index of the level of detail for fur that is `px` pixels high, and the progress of the transition to the
/// next level, 0..=1.
///
/// During a transition, the number of layers equals the height of the fur in pixels.
pub fn detail_position(levels: &[DetailLevel], px: f32) -> (usize, f32) {
    let last = levels.len().saturating_sub(1);
    let level = levels.iter().position(|level| px > level.gone_px).unwrap_or(last);
    let Some(found) = levels.get(level).filter(|found| level < last && px < found.full_px) else { return (level, 0.0) };
    // If `gone_px` is 0, the level never fades.
    let fade = if found.gone_px > 0.0 { (found.full_px - px) / (found.full_px - found.gone_px) } else { 0.0 };
    (level, fade.clamp(0.0, 1.0))
}

/// Maximum deviation, in pixels, of a simplified index list from the mesh that it replaces.
pub const MOST_DEVIATION_PX: f32 = 0.5;

/// Returns the simplest index list that deviates by at most [`MOST_DEVIATION_PX`]: 0 for the mesh itself, k for list
/// number k − 1.
///
/// * `deviations_m`: deviation of each list, metres, ascending
/// * `px_per_m`: pixels per metre
pub fn simplest_list(deviations_m: &[f32], px_per_m: f32) -> usize {
    deviations_m.partition_point(|deviation| deviation * px_per_m <= MOST_DEVIATION_PX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projected_size_selects_the_level() {
        let level = |step, full_px, gone_px| DetailLevel { step, full_px, gone_px, fins: 1.0, density: 1.0 };
        let levels = [level(1, 16.0, 12.0), level(2, 8.0, 8.0), level(4, 2.0, 1.0), level(0, 0.0, 0.0)];
        let at = |px| detail_position(&levels, px);
        assert_eq!([f32::INFINITY, 100.0, 16.0].map(at), [(0, 0.0); 3]);
        assert_eq!([12.0, 9.0, 8.5].map(at), [(1, 0.0); 3]);
        assert_eq!([8.0, 7.0, 2.0].map(at), [(2, 0.0); 3], "levels without a range switch at once");
        assert_eq!([1.0, 0.1, 0.0].map(at), [(3, 0.0); 3]);
        assert_eq!((at(14.0), at(1.25)), ((0, 0.5), (2, 0.75)), "layers are as many as pixels");
        // The last level of a package without far layer never fades.
        let endless = [level(1, 4.0, 0.0), level(2, 0.0, 0.0)];
        assert_eq!((detail_position(&endless, 0.5), detail_position(&endless[..1], 0.0)), ((0, 0.0), (0, 0.0)));
    }

    #[test]
    fn simplest_list_within_the_pixel_tolerance_is_selected() {
        let deviations = [0.5, 2.0];
        assert_eq!([2.0, 1.0, 0.26, 0.25, 0.0].map(|px_per_m| simplest_list(&deviations, px_per_m)), [0, 1, 1, 2, 2]);
        // The mesh itself is selected if the eye is inside the bounds, or if the package has no lists.
        assert_eq!((simplest_list(&deviations, f32::INFINITY), simplest_list(&[], 1.0)), (0, 0));
    }

    #[test]
    fn layer_heights_are_evenly_spaced() {
        assert_eq!([0, 5, 10].map(|layer| layer_height(layer, 11)), [0.0, 0.5, 1.0]);
        assert_eq!(layer_height(1, 2), 1.0);
    }

    #[test]
    fn every_layer_is_represented_once() {
        for baked in [2u32, 3, 4, 5, 9, 16, 17, 64] {
            for step in [1u32, 2, 4, 8] {
                let drawn: Vec<u32> =
                    (0..detail_count(baked, step)).map(|i| detail_layer(i, baked, step, 0.0)).collect();
                assert_eq!(drawn.last(), Some(&(baked - 1)), "the outermost is always drawn");
                let found: Vec<u32> = (1..baked).filter(|l| represented_layers(*l, baked, step) > 0).collect();
                assert_eq!(drawn, found);
                let sum: u32 = drawn.iter().map(|l| represented_layers(*l, baked, step)).sum();
                assert_eq!(sum, baked - 1, "{baked} layers, step {step}");
            }
            assert_eq!((detail_count(baked, 0), represented_layers(1, baked, 0)), (0, 0));
        }
    }

    #[test]
    fn levels_transition_one_layer_at_a_time() {
        for baked in [2u32, 3, 9, 16, 17, 64, 256] {
            for step in [1u32, 2, 4, 8] {
                let (all, pairs) = (detail_count(baked, step), detail_pairs(baked, step));
                let drawn = |gone: u32| -> Vec<u32> {
                    (0..all - gone).map(|i| detail_layer(i, baked, step, gone as f32)).collect()
                };
                for gone in 0..=pairs {
                    let layers = drawn(gone);
                    assert!(layers.is_sorted_by(|a, b| a < b), "{layers:?}: {baked} layers, step {step}, {gone} gone");
                    // `detail_fade` must give the same layers. A half-faded layer is still drawn.
                    let whole: Vec<u32> = drawn(0)
                        .into_iter()
                        .filter(|l| {
                            represented_layers(*l, baked, 2 * step) > 0
                                || detail_fade(*l, baked, step, gone as f32) < 1.0
                        })
                        .collect();
                    assert_eq!(layers, whole, "{baked} layers, step {step}, {gone} gone");
                    let half = (0..all - gone).map(|i| detail_layer(i, baked, step, gone as f32 + 0.5));
                    assert_eq!(layers, half.collect::<Vec<_>>());
                }
                let next = (0..detail_count(baked, 2 * step)).map(|i| detail_layer(i, baked, 2 * step, 0.0));
                assert_eq!(drawn(pairs), next.collect::<Vec<_>>(), "{baked} layers, step {step}");
            }
        }
    }
}
