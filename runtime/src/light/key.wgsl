//! uses light/baked, light/forms, light/gloss, light/point, light/scatter, light/visibility, shared/frame,
//! shared/kajiya_kay, shared/skinning, surface/place
// Key light and ambient light on hair: Yang 2006, eqs. (2) and (3) (formulas 4.1).

// Light that reaches a point. Geometries may compute parts of it per vertex.
struct Arriving {
    // Coefficient ka times the ambient light, times the share that reaches the point's height.
    ambient: vec3<f32>,
    // Coefficient kd times the key light.
    diffuse: vec3<f32>,
    // Coefficient ks times the key light.
    specular: vec3<f32>,
    // Direction towards the key light in the tile frame; its length is near 1.
    light_ts: vec3<f32>,
    // Half vector H in the tile frame, with a length near 1. With lighting at vertices, the factors from
    // half_or_factors instead.
    half_ts: vec3<f32>,
    // Back attenuation Attenu_Back.
    facing: f32,
    // Share t of the key light that the hair lets through.
    visible: f32,
    // Share of the key light that other objects let through, Attenu_Shadow.
    past: f32,
}

// Returns the light that reaches a point at this relative height in the fur.
fn arriving_at(height: f32, light_ts: vec3<f32>, half_ts: vec3<f32>, visible: f32, past: f32) -> Arriving {
    var out: Arriving;
    out.ambient = instance.ambient * ambient_attenuation(height, instance.ambient_floor);
    out.diffuse = instance.diffuse;
    out.specular = instance.specular;
    out.light_ts = light_ts;
    out.half_ts = half_ts;
    out.facing = back_attenuation(light_ts.z, instance.back_light_range);
    out.visible = visible;
    out.past = past;
    return out;
}

// Returns the key light and ambient light that hair sends to the eye: eq. (3), or scattering by fibres (formulas 4.1,
// 4.12, 4.13).
fn key_light_on_hair(p: HairPoint, coat: Coat) -> vec3<f32> {
    let a = p.arriving;
    var visible = a.visible;
    if !DEEP_SHADOW {
        visible *= visible_past_strands(p.baked, a.light_ts);
    }
    if SCATTERING {
        // With scattering, the specular colour is the colour of the light, and the diffuse constant is 1.
        let eye = eye_of(a.light_ts, a.half_ts, 1.0);
        if (!BAKED_SHADOW || DEEP_SHADOW) && !(HANGS && SOFT_SHADOW) {
            // Near the outline, a body hides the light from its own fur; the maps do not store this.
            visible *= back_attenuation(a.light_ts.z, max(material.rim * p.baked.texel.w, 1e-3));
        }
        let light = normalize_or(a.light_ts, eye);
        let above = above_rim(a.light_ts.z, p.baked.texel.w);
        let sent = scatter(p.direction, light, eye, coat, above, visible);
        return p.color * a.ambient + a.specular * (sent.once + sent.often) * (a.past * p.opacity);
    }
    visible *= a.past;
    let sent = key_fibre(p.direction, a.light_ts, a.half_ts, p.wetness) * (a.facing * visible);
    return p.color * (a.ambient + a.diffuse * sent.x) + a.specular * (sent.y * p.opacity);
}

// Returns the key light on a bare surface, by Lambert's law with the package's constants (formulas 4.1). Bare parts are
// as bright as the fur beside them.
fn key_light_on_bare(color: vec3<f32>, n_dot_l: f32, visible: f32, spot: Spot, gloss: GlossPoint) -> vec3<f32> {
    let enters = past_gloss(gloss, direction_to(frame.light_ws, spot.position_ws));
    let light = key_on_bare() * enters * (max(n_dot_l, 0.0) * visible);
    return color * (instance.ambient * past_gloss_around(gloss) + light);
}

// Returns the colour of the key light on bare surface.
fn key_on_bare() -> vec3<f32> {
    return select(instance.diffuse, instance.specular, SCATTERING);
}
