// A point of hair as lights meet it, whatever geometry it is on, and the one function that lights it.

// Where a point is, for lights that vertices know nothing of.
struct Spot {
    position_ws: vec3<f32>,
    normal_ws: vec3<f32>,
    // Along +u of the tile; handedness.
    tangent: vec4<f32>,
    // What the body leaves open, as open_to_hair has it.
    open: vec3<f32>,
}

fn spot_of(v: Vertex, position: vec3<f32>, tile: TileFrame) -> Spot {
    return Spot(position, tile.normal_ws, vec4(tile.tangent_ws, v.tangent.w * instance.handedness), open_to_hair(v.groom.zw));
}

struct HairPoint {
    spot: Spot,
    // Unit vector along the hair, in the tile frame.
    direction: vec3<f32>,
    // Of the hair, premultiplied with its opacity. `tint` colours it for those lights whose colour does not hold it already.
    color: vec3<f32>,
    opacity: f32,
    tint: vec3<f32>,
    // Of the hair below it, neither premultiplied nor tinted.
    deeper: vec3<f32>,
    // 0..=1.
    wetness: f32,
    // What reaches it of the ambient light and the key light.
    arriving: Arriving,
    baked: Baked,
}

// The undercoat: a mat of hair too short to be told apart, whose light all comes back.
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

// Premultiplied light that a point of hair sends to the eye: the sum of what each of the lights makes of it.
fn light_hair(p: HairPoint) -> vec3<f32> {
    var lit = vec3(0.0);
    if !DARK_KEY {
        lit = key_light_on_hair(p);
    }
    if FILL_LIGHTS {
        lit += fill_lights_on_hair(p);
    }
    if ENVIRONMENT {
        lit += environment_on_hair(p);
    }
    return lit;
}
