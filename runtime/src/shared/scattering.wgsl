// Light scattering by fibres (Marschner 2003; d'Eon 2011; Chiang 2016; formulas 4.12, 4.13): coordinates in a package's
// tables, evaluation of their texels, and scattering between fibres.

// Table coordinates and cosines for a pair of light and eye directions, relative to a fibre.
struct FibreAngles {
    // Coordinates in the table of longitudinal scattering, 0..=1.
    along: vec2<f32>,
    // Coordinates in the table of azimuthal scattering, 0..=1.
    around: vec2<f32>,
    // Cosine of the light's inclination.
    cos_i: f32,
    // Cosine of the difference angle.
    cos_d: f32,
}

// Properties of a fibre that are not in its tables (FORMAT.md, "FIBR").
struct Fibre {
    // Values: 1 / eta^2, 1 / d, mean square offset of incidence, longitudinal variance of the reflected lobe.
    optics: vec4<f32>,
    on: array<vec4<f32>, 3>,
    back: array<vec4<f32>, 3>,
}

// Constant 0.3 of the table's axis for theta_h, sin theta_h / (0.3 + 0.7 |sin theta_h|) (formulas 4.12).
const DRAWN_OUT: f32 = 0.3;
// Minimum cosine of the difference angle, cos theta_d (formulas 4.12).
const LEAST_COS_D: f32 = 0.1;
const PI: f32 = 3.14159265;
// Longitudinal variances of the lobes R, TT, TRT and of the rest, relative to that of R: beta_TT = beta_R / 2 and
// beta_TRT = 2 beta_R (Marschner 2003).
const LOBE_VARIANCE: vec4<f32> = vec4(1.0, 0.25, 4.0, 4.0);

// Returns the table row for a cosine of the difference angle, as a coordinate 0..=1 (formulas 4.12).
fn fibre_row(cos_d: f32) -> f32 {
    return clamp((cos_d - LEAST_COS_D) / (1.0 - LEAST_COS_D), 0.0, 1.0);
}

// Returns the angles for three unit vectors (formulas 4.12): the fibre towards its tip, towards the light, towards the
// eye. A direction along the fibre has no azimuth, so an arbitrary one is used.
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
        vec2(0.5 + 0.5 * drawn_out, 0.5 + 0.5 * tilted), vec2(acos(cos_phi) / PI, fibre_row(cos_d)), cos_i, cos_d,
    );
}

// Returns the absorption per fibre radius at which deep fur has that colour. `per_depth`: 1 / d of FORMAT.md, "FIBR".
fn fibre_absorption(color: vec3<f32>, per_depth: f32) -> vec3<f32> {
    let root = log(clamp(color, vec3(1e-3), vec3(1.0))) * per_depth;
    return root * root;
}

// Returns the transmittance of one path through a fibre with that absorption per radius, sigma of formulas 4.12.
// `cos_d`: cosine of the difference angle.
fn fibre_transmittance(cos_d: f32, optics: vec4<f32>, absorbed: vec3<f32>) -> vec3<f32> {
    let c = max(cos_d, LEAST_COS_D);
    // Square of 1 / cos theta_t. The next line computes the square of the sine of the refraction angle in the
    // cross-section, at the mean square offset of incidence.
    let slant = 1.0 / (1.0 - (1.0 - c * c) * optics.x);
    let bent = optics.z * c * c * optics.x * slant;
    return exp(-2.0 * sqrt(slant * (1.0 - bent)) * absorbed);
}

// Combines the longitudinal and azimuthal texels of a fibre's tables (formulas 4.12). Returns the scattered light per
// steradian, divided by the irradiance and multiplied by the cosine of the light's inclination. `left`: from
// fibre_transmittance. TRT crosses the fibre twice, the remaining orders three times.
fn fibre_scatters(along: vec4<f32>, around: vec4<f32>, absorbed: vec3<f32>, left: vec3<f32>) -> vec3<f32> {
    let ways = along.xyz * around.xyz;
    return vec3(ways.x) + ways.y * exp(-absorbed * around.w) + left * left * (vec3(ways.z) + along.w * left);
}

// Returns the shares of light that a fibre without absorption scatters forward and backward (formulas 4.13). The four
// components of each are for R, TT, TRT and the remaining orders. `cos_theta`: cosine of the light's inclination.
fn fibre_shares(fibre: Fibre, cos_theta: f32) -> array<vec4<f32>, 2> {
    let u = 1.0 - max(cos_theta, LEAST_COS_D);
    let square = u * u;
    return array(
        fibre.on[0] + square * (fibre.on[1] + square * fibre.on[2]),
        fibre.back[0] + square * (fibre.back[1] + square * fibre.back[2]),
    );
}

// Returns the shares of light that an absorbing fibre scatters forward and backward: f and b of formulas 4.13.
fn absorbing_fibre_shares(fibre: Fibre, cos_theta: f32, left: vec3<f32>) -> array<vec3<f32>, 2> {
    let shares = fibre_shares(fibre, cos_theta);
    let on = shares[0];
    let back = shares[1];
    return array(
        vec3(on.x) + left * (vec3(on.y) + left * (vec3(on.z) + on.w * left)),
        vec3(back.x) + left * (vec3(back.y) + left * (vec3(back.z) + back.w * left)),
    );
}

// Light in deep fur, relative to the incident light.
struct DiffusedLight {
    // Light that other fibres have scattered only forward; its direction is close to that of the incident light.
    sent_on: vec3<f32>,
    // Other light that arrives from the light's side.
    from_light: vec3<f32>,
    // Light that returns from below.
    from_below: vec3<f32>,
}

// Minimum share of light whose depth is computed; the depth of 0 is infinite.
const LEAST_DIRECT: f32 = 1e-30;
// Minimum share of light from which the depth of a point in fur is computed (formulas 4.13). Baked visibility is fitted
// to 24 rays. If none of them reaches the light, the expected share is not 0, and at the roots of most coats near this.
const LEAST_BAKED: f32 = 0.01;

// Deep fur of fibres that scatter the shares `on` and `back` forward and backward (Kubelka and Munk 1931).
struct DeepFur {
    // Share that a fibre does not scatter forward.
    turned: vec3<f32>,
    // Exponent by which all light decreases per fibre.
    decrease: vec3<f32>,
    // Share of light that returns from below.
    given_back: vec3<f32>,
    // Square root of the share of light that a fibre absorbs.
    root_lost: vec3<f32>,
}

fn deep_fur(on: vec3<f32>, back: vec3<f32>) -> DeepFur {
    let lost = max(vec3(1.0) - on - back, vec3(1e-4));
    let root_lost = sqrt(lost);
    let decrease = root_lost * sqrt(lost + 2.0 * back);
    return DeepFur(vec3(1.0) - on, decrease, back / (lost + back + decrease), root_lost);
}

// Returns the light in deep fur at a point (formulas 4.13). `direct`: share of the light that reaches the point past
// all fibres. `least`: minimum of that share from which the point's depth is computed.
fn diffused_light(fur: DeepFur, direct: f32, least: f32) -> DiffusedLight {
    let depth = log2(clamp(direct, least, 1.0));
    let arrives = exp2(fur.decrease * depth);
    let sent_on = exp2(fur.turned * depth);
    let from_light = max(arrives - sent_on, vec3(0.0));
    return DiffusedLight(max(sent_on - direct, vec3(0.0)), from_light, fur.given_back * arrives);
}

// Returns the multiply scattered light under a light at an elevation with that sine, relative to a light at the zenith:
// F of formulas 4.13. Proportional to the excess of Hapke's H function over 1 (after Hapke 1981). `root_lost`: square
// root of the absorbed share.
fn multiple_scattering_by_height(root_lost: vec3<f32>, sine: f32) -> vec3<f32> {
    let root = 2.0 * root_lost;
    return sine * (1.0 + root) / (1.0 + sine * root);
}

// Share of forward-scattered light that turns back in a sheet of free hanging hair (formulas 4.13).
const TURNED_ON: f32 = 0.15;
// Share of backward-scattered light that turns back in a sheet of free hanging hair (formulas 4.13).
const TURNED_BACK: f32 = 0.8;
// Share of scattered light that leaves a sheet of hanging hair at its edges (formulas 4.13).
const LEAKS: f32 = 0.12;

// Returns the forward and backward shares of a sheet of hanging fibres, given those of one fibre (formulas 4.13).
fn hanging_sheet_shares(sides: array<vec3<f32>, 2>) -> array<vec3<f32>, 2> {
    let back = TURNED_ON * sides[0] + TURNED_BACK * sides[1];
    return array((1.0 - LEAKS) * (sides[0] + sides[1]) - back, back);
}

// Constants A, B, C and D of the fit (1 + 2 a + A a^2 / (a + B) - C a / (1 + D a^2))^(-1/2) of exp(-a) I0(a).
const I0E_FIT: vec4<f32> = vec4(4.2832, 0.9183, 0.6664, 0.3884);

// Returns the light scattered from one inclination to another, relative to a uniform distribution over all inclinations
// (formulas 4.13). `sin_i`, `sin_o`: sines of the inclinations of light and eye; `variance`: variance of the lobe
// (d'Eon 2011). The approximation of I0 has an error below 2 %.
fn along_cone(sin_i: f32, sin_o: f32, variance: f32) -> f32 {
    let k = 1.0 / clamp(variance, 1e-3, 1e3);
    let a = k * sqrt(max((1.0 - sin_i * sin_i) * (1.0 - sin_o * sin_o), 0.0));
    let i0e = inverseSqrt(
        1.0 + 2.0 * a + I0E_FIT.x * a * a / (a + I0E_FIT.y) - I0E_FIT.z * a / (1.0 + I0E_FIT.w * a * a),
    );
    return 2.0 * k * i0e * exp(a - k * (1.0 + sin_i * sin_o)) / (1.0 - exp(-2.0 * k));
}

// Returns along_cone in hair that hangs side by side (formulas 4.13): x for light that was only scattered forward, y
// for other light. Parallel fibres keep light near its cone of incidence, and each scattering widens the cone.
// `direct`: share of the light that passes all fibres; `left`: grey value from fibre_transmittance.
fn hanging_cones(fibre: Fibre, cos_i: f32, left: f32, direct: f32, sin_i: f32, sin_o: f32) -> vec2<f32> {
    let shares = fibre_shares(fibre, cos_i);
    let light = vec4(1.0, left, left * left, left * left * left);
    let wide = fibre.optics.w * LOBE_VARIANCE;
    // For opaque fibres, the fitted shares may be zero or negative.
    let on = max(dot(shares[0], light), 1e-4);
    let all = on + max(dot(shares[1], light), 0.0);
    let width = dot(shares[0] + shares[1], light * wide) / all;
    let depth = -log(clamp(direct, LEAST_DIRECT, 1.0));
    // Mean number of forward scatterings; `sent / (1 - exp(-sent))` is the mean given that there is at least one.
    let sent = max(on * depth, 1e-3);
    let sent_on = dot(shares[0], light * wide) / on * sent / (1.0 - exp(-sent));
    // Mean number of scatterings of light that returns from the sheet, derived from the decrease of that light with
    // growing absorption.
    let back = TURNED_ON * on + TURNED_BACK * (all - on);
    let lost = max(1.0 - (1.0 - LEAKS) * all, 1e-4);
    let met = back * inverseSqrt(lost * (lost + 2.0 * back));
    let times = 1.0 + depth * all + all / back * met * (1.0 + met / 1.5) / (1.0 + met);
    return vec2(along_cone(sin_i, sin_o, sent_on + width), along_cone(sin_i, sin_o, (times + 1.0) * width));
}
