// Levels of detail (formulas 4.7): which hair layers a level draws, and how many layers each of them represents.

// Returns the number of baked layers that a layer represents in a level with the given step. These are the layer itself
// and those below it, down to the next drawn one. The result is 0 if the level does not draw the layer, and for step 0,
// which draws none. `layer`: 1..baked.
fn layers_stood_for(layer: u32, baked: u32, step: u32) -> u32 {
    if step == 0u || (baked - 1u - layer) % step != 0u {
        return 0u;
    }
    return min(step, layer);
}

// Returns the lowest drawn layer if every `step`-th layer is drawn. `baked`: 2 or more.
fn lowest_layer(baked: u32, step: u32) -> u32 {
    return (baked - 2u) % step + 1u;
}

// Returns 1 if the lowest layer of the next level represents no layer below it, otherwise 0.
fn lone_layers(baked: u32, step: u32) -> u32 {
    return select(0u, 1u, lowest_layer(baked, 2u * step) <= step);
}

// Returns how far a layer has changed from a level with the given step to the next level, 0..1. Layers transfer their
// opacity one after another to the next layer above; `gone` is the number that have done so. `layer`: 1..baked; `step`:
// 1 or more.
fn detail_fade(layer: u32, baked: u32, step: u32, gone: f32) -> f32 {
    let kept = lowest_layer(baked, 2u * step);
    let pair = (max(layer + step, kept) - kept) / (2u * step);
    return clamp(gone - f32(pair - min(pair, lone_layers(baked, step))), 0.0, 1.0);
}

// Returns the exponent of a layer's transmittance for resampled_opacity, in a level with the given step (formulas 4.7).
// `gone`: number of layers that have changed to the next level; `here` and `there`: density of the level and of the
// next one.
fn detail_exponent(layer: u32, baked: u32, step: u32, gone: f32, here: f32, there: f32) -> f32 {
    let fade = detail_fade(layer, baked, step, gone);
    let stood_for = f32(layers_stood_for(layer, baked, step));
    return (1.0 - fade) * here * stood_for + fade * there * f32(layers_stood_for(layer, baked, 2u * step));
}

// Mean depth of the hair visible in a layer, relative to the depth of the layers below that it represents (formulas
// 4.7).
const VISIBLE_DEPTH: f32 = 0.25;

// Returns the height at which the hair visible in a layer is lit, relative to the fur height: h' of formulas 4.7.
// `stood_for`: number of layers that the layer represents. On average, visible hair of the represented layers is lower
// than the layer by a quarter of the layers below; by less if these are denser.
fn visible_height(height: f32, stood_for: f32, layers: u32) -> f32 {
    return height - VISIBLE_DEPTH * max(stood_for - 1.0, 0.0) / f32(layers - 1u);
}

// Returns the index-th drawn layer, counted from the mesh surface outwards, if every `step`-th is drawn. `gone`: number
// of layers that have changed to the next level; `step`: 1 or more; `baked`: 2 or more.
fn detail_layer(index: u32, baked: u32, step: u32, gone: f32) -> u32 {
    let whole = u32(gone);
    if whole > 0u && index < whole + lone_layers(baked, step) {
        return lowest_layer(baked, 2u * step) + 2u * step * index;
    }
    return lowest_layer(baked, step) + step * (index + whole);
}

// Returns the share of the key light that reaches the hair visible in the far fur layer (formulas 4.8). `path`: length
// of the light's path through a layer, relative to its thickness.
fn coat_light(path: f32, base: f32, slope: f32) -> f32 {
    return 1.0 / (base + slope * path);
}

// Range of opacities to which light_within is clamped (formulas 4.7).
const WITHIN_ALPHA: vec2<f32> = vec2(1.0 / 255.0, 1.0 - 1.0 / 2048.0);

// Returns the light on the hair visible in a layer of opacity `alpha`, relative to the light on the layer itself: t' /
// t of formulas 4.7. `stood_for`: number of layers that the layer represents. Below the layer are others like it. Each
// hides alpha of what is behind it from the eye, and 1 - sqrt(1 - alpha) from the light.
fn light_within(alpha: f32, stood_for: f32) -> f32 {
    let a = clamp(alpha, WITHIN_ALPHA.x, WITHIN_ALPHA.y);
    let one = 1.0 - a;
    let all = exp2(stood_for * log2(one));
    let share = a * (1.0 - all * sqrt(all)) / ((1.0 - all) * (1.0 - one * sqrt(one)));
    return select(1.0, share, stood_for > 1.0);
}
