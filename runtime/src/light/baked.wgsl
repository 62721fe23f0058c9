// What the package says of a point of hair: how much of each light comes past the other strands.

// It says it.
override BAKED_SHADOW: bool = false;
// Single strands shadow each other, in the key light, by the deep opacity map.
override DEEP_SHADOW: bool = false;

struct Baked {
    // visibility_towards reads it.
    texel: vec4<f32>,
    // Share of the hair that grows there; length of it over the tile's; slope that the lean of the vertex adds.
    kept: f32,
    length: f32,
    slope: f32,
    // light_within of a layer that stands for others below it.
    within: f32,
}

// Sine of a light's height above the skin, as hair sees it that the share `open` of other light reaches: 0 where the body hides it.
fn above_rim(height: f32, open: f32) -> f32 {
    let rim = max(material.rim * open, 1e-3);
    let risen = max(height + rim, 0.0);
    return select(0.25 * risen * risen / rim, height, height > rim);
}

// Share of a light in that direction, in the tile frame, that other strands let through.
fn visible_past_strands(b: Baked, light_ts: vec3<f32>) -> f32 {
    if !BAKED_SHADOW {
        return 1.0;
    }
    var towards = light_ts;
    if SHORT || LEAN {
        towards = light_in_tile(light_ts, select(1.0, b.length, SHORT), b.slope);
    }
    if SCATTERING {
        towards.z = above_rim(towards.z, b.texel.w);
    }
    // What does not grow hides nothing.
    return b.within * (1.0 - b.kept * (1.0 - visibility_towards(b.texel, towards, material.horizon)));
}
