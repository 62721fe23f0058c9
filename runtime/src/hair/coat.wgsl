//! uses hair/hair, light/baked, light/key, light/point, shared/detail, shared/layer_shadow, shared/opacity,
//! surface/place
// Far fur layer: all fur layers as seen from above, flattened into one on the mesh surface. Used for fur too small to
// be drawn in layers.

// The far fur layer is drawn on the surface.
override COAT: bool = false;

// Returns the transmittance of all layers together for the key light that reaches the surface below (formulas 4.2).
fn visible_below_coat(far: Hair, grown: f32, n_dot_l: f32, length: f32) -> f32 {
    return layer_transmittance(far.color.a * grown, frame.hair_density * path_through(slanted_path(n_dot_l), length));
}

// Far fur layer at a fragment.
struct FarFur {
    hair: Hair,
    baked: Baked,
    // Colour of the undercoat, lit.
    undercoat: vec3<f32>,
    base_color: vec3<f32>,
    spot: Spot,
    // Direction towards the key light, and H, in the tile frame.
    light_ts: vec3<f32>,
    half_ts: vec3<f32>,
    // Length of the hair over the tile's; slope added by the vertex.
    length: f32,
    slope: f32,
    // Share of the hair that grows, times how far the far fur layer has replaced the layers.
    share: f32,
    wetness: f32,
    // Share of the key light that passes other objects.
    past: f32,
}

// Returns the far fur layer over the undercoat (formulas 4.8).
fn with_coat(far: FarFur) -> vec3<f32> {
    let texel = far.hair.color;
    if texel.a < LEAST_ALPHA {
        return far.undercoat;
    }
    // Same as for the layers that it replaces: where half of the hair grows, half of the optical depth is left.
    let alpha = resampled_opacity(texel.a, far.share);
    // No shadow map is drawn for it: the package stores how light enters it.
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
    return light_hair(point) + (1.0 - alpha) * far.undercoat;
}
