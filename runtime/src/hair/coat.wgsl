//! uses hair/hair, light/baked, light/key, light/point, shared/detail, shared/layer_shadow, shared/opacity,
//! surface/place
// Far fur layer: all fur layers as seen from above, flattened into one on the mesh surface. Used for fur too small to
// be drawn in layers.

// The far fur layer is drawn on the surface.
override COAT: bool = false;

// Returns the transmittance of all layers together for the key light that reaches the surface below.
fn visible_below_coat(far: Hair, grown: f32, n_dot_l: f32, length: f32) -> f32 {
    return layer_transmittance(far.color.a * grown, frame.hair_density * path_through(slanted_path(n_dot_l), length));
}

// Returns the far fur layer over the undercoat. `share`: share of its hair that grows, times how far it has replaced
// the layers; `visible`: share of the key light that passes other objects; `length`: length of the hair here over the
// tile's; `slope`: slope added by the vertex.
fn with_coat(
    baked: Baked,
    far: Hair,
    undercoat: vec3<f32>,
    base: vec3<f32>,
    spot: Spot,
    light_ts: vec3<f32>,
    half_ts: vec3<f32>,
    length: f32,
    slope: f32,
    share: f32,
    wetness: f32,
    visible: f32,
) -> vec3<f32> {
    if far.color.a < LEAST_ALPHA {
        return undercoat;
    }
    // Same as for the layers that it replaces: where half of the hair grows, half of the optical depth is left.
    let alpha = resampled_opacity(far.color.a, share);
    // No shadow map is drawn for it: the package stores how light enters it.
    var arrives = 1.0;
    if !BAKED_SHADOW {
        let path = path_through(slanted_path(light_ts.z), length);
        arrives = coat_light(path, instance.coat_light_base, instance.coat_light_slope);
    }
    let point = HairPoint(
        spot, grown(far.direction, length, slope), far.color.rgb * (alpha / far.color.a) * base, alpha, vec3(1.0),
        mean_of_layer(u32(0.5 * instance.coat_ambient_height * f32(instance.baked_layers)), far.color.rgb / far.color.a) * base, wetness,
        arriving_at(instance.coat_ambient_height, light_ts, half_ts, arrives, visible), baked,
    );
    return light_hair(point) + (1.0 - alpha) * undercoat;
}
