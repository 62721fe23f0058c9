// How a fibre scatters light (Marschner 2003; d'Eon 2011; Chiang 2016): where a package's tables are looked up, and what is made of their texels; and
// what becomes of light that goes from fibre to fibre.

// Two directions about a fibre.
struct FibreAngles {
    // Places in the tables, 0..=1: of what happens along the fibre, and around it.
    along: vec2<f32>,
    around: vec2<f32>,
    // Cosine of the light's angle from the plane across the fibre.
    cos_i: f32,
}

// Share of the axis of sin theta_h that is as it was, and the least cosine of the difference angle.
const DRAWN_OUT: f32 = 0.3;
const LEAST_COS_D: f32 = 0.1;
const PI: f32 = 3.14159265;

// Row of a table for a cosine of the difference angle, 0..=1.
fn fibre_row(cos_d: f32) -> f32 {
    return clamp((cos_d - LEAST_COS_D) / (1.0 - LEAST_COS_D), 0.0, 1.0);
}

// Of unit vectors: the fibre towards its tip, towards the light, towards the eye. A direction along the fibre has no azimuth: any is taken.
fn fibre_angles(tip: vec3<f32>, light: vec3<f32>, eye: vec3<f32>) -> FibreAngles {
    let sin_i = clamp(dot(tip, light), -1.0, 1.0);
    let sin_o = clamp(dot(tip, eye), -1.0, 1.0);
    let cos_i = sqrt(1.0 - sin_i * sin_i);
    let cos_o = sqrt(1.0 - sin_o * sin_o);
    let cos_d = sqrt(clamp(0.5 * (1.0 + cos_i * cos_o + sin_i * sin_o), 0.0, 1.0));
    let sin_h = clamp(0.5 * (sin_i + sin_o) / max(cos_d, 1e-4), -1.0, 1.0);
    let half_d = sqrt(max(1.0 - cos_d * cos_d, 0.0)) / (1.0 + cos_d);
    let tilted = select(-half_d, half_d, sin_o >= sin_i);
    let drawn_out = sin_h / (DRAWN_OUT + (1.0 - DRAWN_OUT) * abs(sin_h));
    let cos_phi = clamp((dot(light, eye) - sin_i * sin_o) / max(cos_i * cos_o, 1e-6), -1.0, 1.0);
    return FibreAngles(
        vec2(0.5 + 0.5 * drawn_out, 0.5 + 0.5 * tilted), vec2(acos(cos_phi) / PI, fibre_row(cos_d)), cos_i,
    );
}

// What fibres absorb a radius of which a deep coat has that colour. per_depth: 1 / d of FORMAT.md, "FIBR".
fn fibre_absorption(color: vec3<f32>, per_depth: f32) -> vec3<f32> {
    let root = log(clamp(color, vec3(1e-3), vec3(1.0))) * per_depth;
    return root * root;
}

// What the tables' texels along and around a fibre come to, times the cosine of the light's angle: light a steradian, over its irradiance.
fn fibre_scatters(along: vec4<f32>, around: vec4<f32>, lengths: vec4<f32>, absorbed: vec3<f32>) -> vec3<f32> {
    let ways = along * around;
    return vec3(ways.x) + ways.y * exp(-absorbed * lengths.x) + ways.z * exp(-absorbed * lengths.y) + ways.w * exp(-absorbed * lengths.z);
}

// Light in a coat of fibres of which each sends the shares `on` and `back` of it to either side (Kubelka and Munk 1931).
struct Diffused {
    // Over what falls on the coat: what other fibres have sent on, and never back; what comes from the light's side besides; what comes from below.
    sent_on: vec3<f32>,
    from_light: vec3<f32>,
    from_below: vec3<f32>,
}

// Where the share `direct` of the light comes past all fibres.
fn diffused(on: vec3<f32>, back: vec3<f32>, direct: f32) -> Diffused {
    let lost = max(vec3(1.0) - on - back, vec3(1e-4));
    let less = sqrt(lost * (lost + 2.0 * back));
    let given_back = back / (lost + back + less);
    let depth = -log(clamp(direct, 1e-6, 1.0));
    let arrives = exp(-less * depth);
    let sent_on = exp(-(vec3(1.0) - on) * depth);
    return Diffused(max(sent_on - direct, vec3(0.0)), max(arrives - sent_on, vec3(0.0)), given_back * arrives);
}
