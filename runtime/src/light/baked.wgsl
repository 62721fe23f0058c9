//! uses light/scatter, shared/visibility, surface/place
// Baked lighting of a point of hair: the share of each light that passes the other strands.

// The package contains baked visibility, and the frame uses it.
override BAKED_SHADOW: bool = false;
// Single strands shadow each other by the deep opacity map, for the key light.
override DEEP_SHADOW: bool = false;

struct Baked {
    // Texel for visibility_towards.
    texel: vec4<f32>,
    // Share of the hair that grows there; length of the hair over the tile's; slope added by the lean of the vertex.
    kept: f32,
    length: f32,
    slope: f32,
    // Value of light_within for a layer that represents others below it.
    within: f32,
}

// Returns the sine of a light's height above the surface, s' of formulas 4.13, for hair that the share `open` of
// ambient light reaches; 0 if the body hides the light.
fn above_rim(height: f32, open: f32) -> f32 {
    let rim = max(material.rim * open, 1e-3);
    let risen = max(height + rim, 0.0);
    return select(0.25 * risen * risen / rim, height, height > rim);
}

// Returns the share of a light from that direction, in the tile frame, that other strands let through (formulas 4.9).
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
    // Hair that does not grow hides nothing.
    return b.within * (1.0 - b.kept * (1.0 - visibility_towards(b.texel, towards, material.horizon)));
}
