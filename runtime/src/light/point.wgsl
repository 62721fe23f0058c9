//! uses light/baked, light/environment, light/fills, light/key, light/scatter, shared/environment, shared/tile_frame,
//! surface/place
// Point of hair as the lights see it, independent of the geometry, and the single function that lights it.

// Location of a point, for lights that are evaluated per pixel.
struct Spot {
    position_ws: vec3<f32>,
    normal_ws: vec3<f32>,
    // Direction along +u of the tile, with the handedness in w.
    tangent: vec4<f32>,
    // Openness of the body, as returned by unpack_openness.
    open: vec3<f32>,
}

// Returns the location of a point at `position`, world space, which belongs to the vertex `v`.
fn spot_of(v: Vertex, position: vec3<f32>, tile: TileFrame) -> Spot {
    let tangent = vec4(tile.tangent_ws, v.tangent.w * instance.handedness);
    return Spot(position, tile.normal_ws, tangent, unpack_openness(v.groom.zw));
}

// Point of hair with everything that the lights need.
struct HairPoint {
    spot: Spot,
    // Unit vector along the hair in the tile frame.
    direction: vec3<f32>,
    // Colour of the hair, premultiplied by its opacity. `tint` is applied by lights whose own colour does not include
    // it.
    color: vec3<f32>,
    opacity: f32,
    tint: vec3<f32>,
    // Colour of the hair below this point, neither premultiplied nor tinted.
    deeper: vec3<f32>,
    // Wetness, 0..=1.
    wetness: f32,
    // Ambient light and key light that reach the point.
    arriving: Arriving,
    baked: Baked,
    // Light of the environment, if there is one.
    sky: Sky,
}

// Lights the undercoat: a mat of hair too short to resolve, which reflects all light.
fn light_undercoat(p: HairPoint) -> vec3<f32> {
    if !SCATTERING {
        return light_hair(p);
    }
    let a = p.arriving;
    let direct = a.visible * visible_past_strands(p.baked, a.light_ts);
    let color = p.color * a.diffuse / max(p.opacity, 1e-6);
    var lit = p.color * a.diffuse * a.specular * (reaches_mat(a.light_ts.z, color, direct) * a.past);
    if FILL_LIGHTS {
        lit += p.color * p.tint * fill_lights_on_mat(p, color);
    }
    if ENVIRONMENT {
        lit += p.color * p.tint * environment_on_mat(p, color * p.tint);
    }
    return p.color * a.ambient + lit;
}

// Returns the premultiplied light that a point of hair sends to the eye, summed over all lights.
fn light_hair(p: HairPoint) -> vec3<f32> {
    var coat: Coat;
    if SCATTERING {
        coat = coat_of(p.color * p.tint / max(p.opacity, 1e-6), p.deeper * p.tint);
    }
    var lit = vec3(0.0);
    if !DARK_KEY {
        lit = key_light_on_hair(p, coat);
    }
    if FILL_LIGHTS {
        lit += fill_lights_on_hair(p, coat);
    }
    if ENVIRONMENT {
        lit += environment_on_hair(p, coat);
    }
    return lit;
}
