// Levels of detail: which layers of hair a level draws, and how many layers each stands for.

// How many of the baked layers a layer stands for in a level of that step: itself and those below it, down to the next that is drawn. 0
// where the level does not draw it, and in a level of step 0, which draws none. layer: 1..baked.
fn layers_stood_for(layer: u32, baked: u32, step: u32) -> u32 {
    if step == 0u || (baked - 1u - layer) % step != 0u {
        return 0u;
    }
    return min(step, layer);
}

// Exponent of a layer's transmittance between the levels of the steps `step` and `next`, for resampled_opacity. here and there: share of
// each level, times its density.
fn detail_exponent(layer: u32, baked: u32, step: u32, next: u32, here: f32, there: f32) -> f32 {
    return here * f32(layers_stood_for(layer, baked, step)) + there * f32(layers_stood_for(layer, baked, next));
}

// Share of the fur's height at which the hair is lit that is seen in a layer which stands for so many: what shows of those below lies a
// quarter of their number lower on average, the denser they are the less.
fn seen_height(height: f32, stood_for: f32, layers: u32) -> f32 {
    return height - 0.25 * max(stood_for - 1.0, 0.0) / f32(layers - 1u);
}

// The index-th layer that a level of that step draws, from the skin outwards. step: 1 or more; baked: 2 or more.
fn detail_layer(index: u32, baked: u32, step: u32) -> u32 {
    return (baked - 2u) % step + 1u + index * step;
}

// Share of the key light that reaches the hair seen in the far coat, where the way through a layer is that long over its thickness.
fn coat_light(path: f32, base: f32, slope: f32) -> f32 {
    return 1.0 / (base + slope * path);
}
