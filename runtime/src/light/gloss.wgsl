//! uses light/environment, light/fills, light/key, light/point, shared/environment, shared/frame, shared/gloss,
//! shared/skinning, shared/tile_frame, surface/place
// Highlights and mirrored light on bare surface (formulas 4.16).

// Whether the bare surface of the material is glossy.
override GLOSS: bool = false;

// Half width of the edge of the sky that the body leaves open, as a cosine.
const OPEN_EDGE: f32 = 0.25;

// Glossy point of a surface, and the eye that sees it.
struct GlossPoint {
    // Reflectance at normal incidence.
    f0: vec3<f32>,
    roughness: f32,
    // Squared width of the GGX distribution.
    alpha_squared: f32,
    // Unit normal on the side of the eye.
    normal_ws: vec3<f32>,
    // Unit vector towards the eye.
    eye_ws: vec3<f32>,
    n_dot_e: f32,
}

// Returns the glossy point with that colour. Must be called in uniform control flow, because the curvature on screen
// widens its highlights.
fn gloss_point(base: vec3<f32>, spot: Spot, side: f32) -> GlossPoint {
    var out: GlossPoint;
    if !GLOSS {
        return out;
    }
    out.normal_ws = normalize_or(spot.normal_ws, vec3(0.0, 1.0, 0.0)) * side;
    let across = dpdx(out.normal_ws);
    let down = dpdy(out.normal_ws);
    // A pixel spans normals with a quarter of the variance of their squared steps (Kaplanyan 2016); the squared width
    // of the distribution is twice the variance.
    let curved = 0.5 * (dot(across, across) + dot(down, down));
    let filtered = min(curved, mix(GLOSS_FILTER.x, GLOSS_FILTER.y, material.gloss.w));
    out.f0 = mix(vec3(material.gloss.y), base, material.gloss.z);
    out.roughness = material.gloss.x;
    out.alpha_squared = min(pow(out.roughness, 4.0) + filtered, 1.0);
    out.eye_ws = direction_to(frame.eye_ws, spot.position_ws);
    out.n_dot_e = max(dot(out.normal_ws, out.eye_ws), 1e-3);
    return out;
}

// Returns the share of a light from that direction which enters the surface, and is scattered below it.
fn past_gloss(g: GlossPoint, towards_ws: vec3<f32>) -> vec3<f32> {
    if !GLOSS {
        return vec3(1.0);
    }
    let fresnel = gloss_fresnel(g.f0, dot(towards_ws, half_vector(towards_ws, g.eye_ws)));
    return (1.0 - fresnel) * (1.0 - material.gloss.z);
}

// Returns the share of light from all directions that enters the surface.
fn past_gloss_around(g: GlossPoint) -> vec3<f32> {
    if !GLOSS {
        return vec3(1.0);
    }
    return (1.0 - gloss_albedo(g.f0, g.roughness, g.n_dot_e)) * (1.0 - material.gloss.z);
}

// Returns the share of a light of colour 1 from that direction which is reflected to the eye.
fn highlight_of(g: GlossPoint, towards_ws: vec3<f32>) -> vec3<f32> {
    let half = half_vector(towards_ws, g.eye_ws);
    let width = min(g.alpha_squared + GLOSS_OF_LIGHTS, 1.0);
    let lobe = gloss_lobe(width, dot(g.normal_ws, half), dot(g.normal_ws, towards_ws), g.n_dot_e);
    return gloss_fresnel(g.f0, dot(towards_ws, half)) * lobe;
}

// Returns the share of the light around `way_ws` that the body does not hide from the point.
fn open_towards(spot: Spot, way_ws: vec3<f32>) -> f32 {
    let share = clamp(length(spot.open), LEAST_OPEN, 1.0 / USUALLY_OPEN);
    // The open directions are treated as a cone.
    let rim = 1.0 - 2.0 * USUALLY_OPEN * share;
    let cosine = dot(to_tile(tile_of(spot), way_ws), spot.open) / share;
    return clamp(0.5 + 0.5 * (cosine - rim) / OPEN_EDGE, 0.0, 1.0);
}

// Returns the light that the surface mirrors to the eye, summed over all lights. `visible`: share of the key light that
// reaches the point; `side`: -1 for the back of a double-sided part.
fn gloss_color(g: GlossPoint, visible: f32, spot: Spot, side: f32) -> vec3<f32> {
    if !GLOSS {
        return vec3(0.0);
    }
    let all_around = gloss_albedo(g.f0, g.roughness, g.n_dot_e);
    let key = direction_to(frame.light_ws, spot.position_ws);
    let mirrored_ws = reflect(-g.eye_ws, g.normal_ws);
    let open = select(open_towards(spot, mirrored_ws), 1.0, side < 0.0);
    var sum = key_on_bare() * visible * highlight_of(g, key) + instance.ambient * all_around * open;
    if FILL_LIGHTS {
        for (var i = 0u; i < frame.fill_lights; i++) {
            let towards = direction_to(fill_lights[i].light_ws, spot.position_ws);
            sum += instance.diffuse_constant * fill_lights[i].color.rgb * highlight_of(g, towards);
        }
    }
    if ENVIRONMENT {
        var around = frame.environment_even;
        for (var i = 0u; i < frame.environment_lobes; i++) {
            let lobe = fill_lights[MAX_FILL_LIGHTS + i];
            let cosine = dot(lobe.light_ws.xyz, mirrored_ws);
            around += lobe.color.rgb * gloss_of_gaussian(g.alpha_squared, g.n_dot_e, lobe.light_ws.w, cosine);
        }
        sum += instance.diffuse_constant * all_around * around * open;
    }
    return sum;
}
