// Levels of detail: which layers of hair a level draws, and how many layers each stands for.

// How many of the baked layers a layer stands for in a level of that step: itself and those below it, down to the next that is drawn. 0
// where the level does not draw it, and in a level of step 0, which draws none. layer: 1..baked.
fn layers_stood_for(layer: u32, baked: u32, step: u32) -> u32 {
    if step == 0u || (baked - 1u - layer) % step != 0u {
        return 0u;
    }
    return min(step, layer);
}

// The lowest layer that is drawn where every `step`-th is. baked: 2 or more.
fn lowest_layer(baked: u32, step: u32) -> u32 {
    return (baked - 2u) % step + 1u;
}

// 1 where the lowest layer that the next level keeps stands for none below it, else 0.
fn lone_layers(baked: u32, step: u32) -> u32 {
    return select(0u, 1u, lowest_layer(baked, 2u * step) <= step);
}

// Share in which a layer has gone over from a level of that step to the next: one after another they give their opacity to the next above, and
// so many have. layer: 1..baked; step: 1 or more.
fn detail_fade(layer: u32, baked: u32, step: u32, gone: f32) -> f32 {
    let kept = lowest_layer(baked, 2u * step);
    let pair = (max(layer + step, kept) - kept) / (2u * step);
    return clamp(gone - f32(pair - min(pair, lone_layers(baked, step))), 0.0, 1.0);
}

// Exponent of a layer's transmittance in a level of that step of which so many layers have gone over to the next, for resampled_opacity. here
// and there: density of the level and of the next.
fn detail_exponent(layer: u32, baked: u32, step: u32, gone: f32, here: f32, there: f32) -> f32 {
    let fade = detail_fade(layer, baked, step, gone);
    let stood_for = f32(layers_stood_for(layer, baked, step));
    return (1.0 - fade) * here * stood_for + fade * there * f32(layers_stood_for(layer, baked, 2u * step));
}

// Share of the fur's height at which the hair is lit that is seen in a layer which stands for so many: what shows of those below lies a
// quarter of their number lower on average, the denser they are the less.
fn seen_height(height: f32, stood_for: f32, layers: u32) -> f32 {
    return height - 0.25 * max(stood_for - 1.0, 0.0) / f32(layers - 1u);
}

// The index-th layer that is drawn, from the skin outwards, where every step-th is and so many have gone over to the next level. step: 1 or
// more; baked: 2 or more.
fn detail_layer(index: u32, baked: u32, step: u32, gone: f32) -> u32 {
    let whole = u32(gone);
    if whole > 0u && index < whole + lone_layers(baked, step) {
        return lowest_layer(baked, 2u * step) + 2u * step * index;
    }
    return lowest_layer(baked, step) + step * (index + whole);
}

// Share of the key light that reaches the hair seen in the far coat, where the way through a layer is that long over its thickness.
fn coat_light(path: f32, base: f32, slope: f32) -> f32 {
    return 1.0 / (base + slope * path);
}

// Light on the hair seen in a layer of that opacity which stands for so many, over the light on the layer itself: below it lie others like it, each
// of which hides alpha of what is behind it from the eye, and 1 - sqrt(1 - alpha) from the light.
fn light_within(alpha: f32, stood_for: f32) -> f32 {
    let a = clamp(alpha, 1.0 / 255.0, 1.0 - 1.0 / 2048.0);
    let one = 1.0 - a;
    let all = exp2(stood_for * log2(one));
    let share = a * (1.0 - all * sqrt(all)) / ((1.0 - all) * (1.0 - one * sqrt(one)));
    return select(1.0, share, stood_for > 1.0);
}
