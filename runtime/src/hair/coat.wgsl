//! uses hair/hair, light/baked, light/environment, light/key, light/point, shared/detail, shared/layer_shadow,
//! shared/opacity, surface/place
// Far fur layer: all fur layers as seen from above, flattened into one layer on the mesh surface. Replaces layers where
// fur is too small on screen for them.

// Whether the far fur layer is drawn on the surface.
override COAT: bool = false;

// Returns the combined transmittance of all layers for key light on its way to the mesh surface (formulas 4.2).
fn visible_below_coat(far: Hair, grown: f32, n_dot_l: f32, length: f32) -> f32 {
    return layer_transmittance(far.color.a * grown, frame.hair_density * path_through(slanted_path(n_dot_l), length));
}

// Inputs of the far fur layer at a fragment.
struct FarFur {
    hair: Hair,
    baked: Baked,
    // Lit colour of the undercoat.
    undercoat: vec3<f32>,
    base_color: vec3<f32>,
    spot: Spot,
    // Light of the environment, if there is one.
    sky: Sky,
    // Direction towards the key light in the tile frame.
    light_ts: vec3<f32>,
    // Half vector H in the tile frame.
    half_ts: vec3<f32>,
    // Hair length relative to that of the hair tile.
    length: f32,
    // Slope that the lean of the vertex adds to the hair.
    slope: f32,
    // Share of the hair that grows, times the weight with which the far fur layer has replaced the layers.
    share: f32,
    wetness: f32,
    // Share of the key light that other objects let through.
    past: f32,
}

// Returns the colour of the far fur layer over the undercoat (formulas 4.8).
fn with_coat(far: FarFur) -> vec3<f32> {
    let texel = far.hair.color;
    if texel.a < LEAST_ALPHA {
        return far.undercoat;
    }
    // In the far layer, as in the layers that it replaces, the optical depth is proportional to the share of the hair
    // that grows.
    let alpha = resampled_opacity(texel.a, far.share);
    // The far layer needs no shadow map: the package stores how light enters it.
    let height = instance.coat_ambient_height;
    var arrives = 1.0;
    if !BAKED_SHADOW {
        let path = path_through(slanted_path(far.light_ts.z), far.length);
        arrives = coat_light(path, instance.coat_light_base, instance.coat_light_slope);
    }
    let deeper = u32(0.5 * height * f32(instance.baked_layers));
    var point: HairPoint;
    point.spot = far.spot;
    point.direction = grown(far.hair.direction, far.length, far.slope);
    point.color = texel.rgb * (alpha / texel.a) * far.base_color;
    point.opacity = alpha;
    point.tint = vec3(1.0);
    point.deeper = mean_of_layer(deeper, texel.rgb / texel.a) * far.base_color;
    point.wetness = far.wetness;
    point.arriving = arriving_at(height, far.light_ts, far.half_ts, arrives, far.past);
    point.baked = far.baked;
    point.sky = far.sky;
    return light_hair(point) + (1.0 - alpha) * far.undercoat;
}
