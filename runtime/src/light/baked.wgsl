//! uses light/scatter, shared/visibility, surface/place
// Baked lighting of a point of hair: the share of each light that the other strands let through.

// Whether the package contains baked visibility, and the frame uses it.
override BAKED_SHADOW: bool = false;
// Whether single strands shadow each other in the key light by the deep opacity map.
override DEEP_SHADOW: bool = false;

// Baked lighting data at a point of hair.
struct Baked {
    // Texel of the baked visibility, in the form that visibility_towards expects.
    texel: vec4<f32>,
    // Share of the hair that grows at the point.
    kept: f32,
    // Hair length relative to that of the hair tile.
    length: f32,
    // Slope that the lean of the vertex adds to the hair.
    slope: f32,
    // Value of light_within for a layer that represents others below it.
    within: f32,
}

// Factor of rho for a single direct light (formulas 4.13).
const RIM_OF_DIRECT: f32 = 1.41;

// Returns the sine of a light's elevation above the surface, s' of formulas 4.13. `open`: share of ambient light that
// reaches the hair. Returns 0 if the body occludes the light.
fn above_rim(height: f32, open: f32) -> f32 {
    let rim = max(RIM_OF_DIRECT * material.rim * open, 1e-3);
    let risen = max(height + rim, 0.0);
    return select(0.25 * risen * risen / rim, height, height > rim);
}

// Returns the share of a light that other strands let through (formulas 4.9). `light_ts`: direction towards the light
// in the tile frame.
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
    // Hair that does not grow casts no shadow.
    return b.within * (1.0 - b.kept * (1.0 - visibility_towards(b.texel, towards, material.horizon)));
}
