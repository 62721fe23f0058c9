//! Layers of hair: how high each lies, and which of them a level of detail draws.

/// Layers, skin counted, that a map of what all hair together lets through is drawn of: what comes through them hardly depends on how many there are.
pub const TOTAL_MAP_LAYERS: u32 = 5;

/// Share of the fur's height at which a layer lies, of so many with the skin counted, 2 or more: 0 for the skin, layer 0, and 1 for the outermost.
pub fn layer_height(layer: u32, layers: u32) -> f32 {
    layer as f32 / (layers - 1) as f32
}

/// How many of the `baked` layers a layer, 1..`baked`, stands for in a level of that step: itself and those below it, down to the next
/// that is drawn. 0 where the level does not draw it, and in a level of step 0, which draws none.
pub fn layers_stood_for(layer: u32, baked: u32, step: u32) -> u32 {
    if step == 0 || !(baked - 1 - layer).is_multiple_of(step) { 0 } else { step.min(layer) }
}

/// The `index`-th layer that a level of that step, 1 or more, draws of `baked`, 2 or more, from the skin outwards.
pub fn detail_layer(index: u32, baked: u32, step: u32) -> u32 {
    (baked - 2) % step + 1 + index * step
}

/// How many layers a level of that step draws of `baked`, skin not counted: the indices of [`detail_layer`].
pub fn detail_count(baked: u32, step: u32) -> u32 {
    if step == 0 || baked < 2 { 0 } else { (baked - 2) / step + 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_lie_evenly_from_skin_to_tips() {
        assert_eq!([0, 5, 10].map(|layer| layer_height(layer, 11)), [0.0, 0.5, 1.0]);
        assert_eq!(layer_height(1, 2), 1.0);
    }

    #[test]
    fn every_layer_is_stood_for_once() {
        for baked in [2u32, 3, 9, 16, 64] {
            for step in [1u32, 2, 4, 8] {
                let drawn: Vec<u32> = (0..detail_count(baked, step)).map(|i| detail_layer(i, baked, step)).collect();
                assert_eq!(drawn.last(), Some(&(baked - 1)), "the outermost is always drawn");
                let found: Vec<u32> = (1..baked).filter(|l| layers_stood_for(*l, baked, step) > 0).collect();
                assert_eq!(drawn, found);
                let sum: u32 = drawn.iter().map(|l| layers_stood_for(*l, baked, step)).sum();
                assert_eq!(sum, baked - 1, "{baked} layers, step {step}");
            }
            assert_eq!((detail_count(baked, 0), layers_stood_for(1, baked, 0)), (0, 0));
        }
    }
}
