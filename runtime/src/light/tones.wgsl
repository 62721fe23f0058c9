//! uses light/baked, light/environment, light/key, light/scatter, shared/skinning, surface/place
// Light that fur of a few shades of grey sends to the eye, for evaluation at vertices (formulas 4.17). Fragments
// interpolate between the shades, separately for red, green and blue.

// Grey colours of hair for which light is computed.
const TONES: vec3<f32> = vec3(0.03, 0.25, 0.8);
// Square root of the first, and the steps from there to the square roots of the others.
const ROOT_TONE: f32 = 0.173205;
const TONE_STEP: f32 = 0.326795;
const NEXT_STEP: f32 = 0.394427;
// Opacity of the hair in a texel that a layer shows, for layers that represent others below them.
const SHOWN_ALPHA: f32 = 0.5;
// Minimum of the share of light at a vertex by which the share at a fragment is divided.
const LEAST_OPEN_LAYER: f32 = 0.02;

// Light of hair of the three tones, for mean directions, visibility and colours of a layer.
struct Toned {
    // Light of the environment. Each vector is for one tone.
    sky_once: array<vec3<f32>, 3>,
    sky_often: array<vec3<f32>, 3>,
    // Light of a white key light that other objects do not hide. The components are for the three tones.
    key_once: vec3<f32>,
    key_often: vec3<f32>,
    // Share of light that other strands let through.
    open: f32,
}

// Returns the share of light from all directions that other strands let through.
fn open_share(b: Baked) -> f32 {
    return 1.0 - b.kept * (1.0 - b.texel.w);
}

// Returns the light of hair of the three tones. `direction`: mean direction of the hair; `b`: mean visibility;
// `light_ts`: direction towards the key light; `deeper`: brightness of the hair below, relative to that of the layer.
// Directions are in the tile frame.
fn toned(sky_at_point: Sky, direction: vec3<f32>, b: Baked, light_ts: vec3<f32>, deeper: f32) -> Toned {
    // A copy, because WGSL allows indices that are not constant only for variables.
    var sky = sky_at_point;
    let coat = coat_of(TONES, TONES * deeper);
    var out: Toned;
    for (var part = 0u; part < MOST_PARTS; part++) {
        let light = sky.parts[part];
        if all(light.whole <= vec3(0.0)) {
            continue;
        }
        var white = light;
        white.whole = vec3(1.0);
        white.irradiance = vec3(1.0);
        let around = around_at(white, TONES);
        let direct = visible_past_strands_around(b, around.towards, material.rim);
        let sent = scatter_around(direction, around, sky.eye, coat, direct, b, sky.rim);
        for (var tone = 0; tone < 3; tone++) {
            out.sky_once[tone] += light.whole * sent.once[tone];
            out.sky_often[tone] += light.irradiance * sent.often[tone];
        }
    }
    if !DARK_KEY {
        let light = normalize_or(light_ts, sky.eye);
        let above = above_rim(light.z, b.texel.w);
        let sent = scatter(direction, light, sky.eye, coat, above, visible_past_strands(b, light));
        out.key_once = sent.once;
        out.key_often = sent.often;
    }
    out.open = open_share(b);
    return out;
}

// Interpolates between values for the three tones, at a colour.
fn at_tone(color: vec3<f32>, dark: vec3<f32>, middle: vec3<f32>, bright: vec3<f32>) -> vec3<f32> {
    let from_dark = sqrt(clamp(color, vec3(0.0), vec3(1.0))) - ROOT_TONE;
    // Newton's form of the parabola through three points.
    let rise = (middle - dark) / TONE_STEP;
    let bend = ((bright - middle) / NEXT_STEP - rise) / (TONE_STEP + NEXT_STEP);
    return max(dark + from_dark * (rise + (from_dark - TONE_STEP) * bend), vec3(0.0));
}

// Returns the light that hair sends to the eye, not premultiplied. `color`: tinted colour of the hair; `around`: that
// of the hair below, divided by `deeper` of toned(); `open`: share of light that other strands let through to the
// point.
fn toned_light(t: Toned, color: vec3<f32>, around: vec3<f32>, open: f32, a: Arriving) -> vec3<f32> {
    let more = open / max(t.open, LEAST_OPEN_LAYER);
    let sky = more * at_tone(color, t.sky_once[0], t.sky_once[1], t.sky_once[2])
        + sqrt(more) * at_tone(color, t.sky_often[0], t.sky_often[1], t.sky_often[2]);
    if DARK_KEY {
        return sky;
    }
    // Where less of the key light arrives directly, about as much more arrives scattered forward.
    let key = more * at_tone(color, vec3(t.key_once.x), vec3(t.key_once.y), vec3(t.key_once.z))
        + at_tone(around, vec3(t.key_often.x), vec3(t.key_often.y), vec3(t.key_often.z));
    return sky + a.specular * a.past * key;
}
