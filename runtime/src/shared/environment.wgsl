// Light that is spread about a direction: its mean effect on a hair, and its coordinates in tables and maps (formulas
// 4.15).

// Returns the octahedral map coordinates of a direction, -1..=1 each (formulas 4.15).
fn octahedral(way: vec3<f32>) -> vec2<f32> {
    let flat = way.xz / max(abs(way.x) + abs(way.y) + abs(way.z), 1e-12);
    let folded = (1.0 - abs(flat.yx)) * select(vec2(-1.0), vec2(1.0), flat >= vec2(0.0));
    return select(folded, flat, way.y >= 0.0);
}

// Sine c of the angle below the horizon down to which light spread about a direction extends (formulas 4.15). The
// horizon is perpendicular to that direction.
const BELOW: f32 = 0.45;
// Mean cosine (1 - c) / 2 of light that is uniform above the angle of BELOW (formulas 4.15).
const LEAST_MEAN: f32 = 0.275;
// Fit of the mean squared cosine perpendicular to the axis of spread light, for c = BELOW (formulas 4.15).
const ACROSS_FIT: vec2<f32> = vec2(0.525, 0.501);
// Last mean cosine in the broad-light tables; narrower light is clamped to it (formulas 4.15).
const LAST_MEAN: f32 = 0.83;

// Returns the mean squared cosine between a direction and light that is spread about an axis (formulas 4.15). `mean`:
// mean cosine between the light and its axis; `cosine`: cosine between the direction and the axis.
fn mean_square(mean: f32, cosine: f32) -> f32 {
    let fit = (mean - LEAST_MEAN) * (ACROSS_FIT.x - ACROSS_FIT.y * mean);
    let across = (1.0 - mean) * ((1.0 + 2.0 * mean) / 3.0 - fit);
    return across + (1.0 - 3.0 * across) * cosine * cosine;
}

// Returns the coordinate 0..=1 in the broad-light tables of light with this mean cosine (formulas 4.15).
fn broad_coordinate(mean: f32) -> f32 {
    let rest = (1.0 - clamp(mean, LEAST_MEAN, 1.0)) / (1.0 - LEAST_MEAN);
    return clamp((1.0 - sqrt(rest)) / LAST_MEAN, 0.0, 1.0);
}

// Returns the angular variance of light with this mean cosine: 1 / kappa for narrow light (formulas 4.15).
fn broad_variance(mean: f32) -> f32 {
    let m = clamp(mean, LEAST_MEAN, 1.0);
    return (1.0 - m) / m;
}

// Constants a and b of the fit x / (a + sqrt(x^2 + b)) of I1(x) / I0(x).
const BESSEL_RATIO_FIT: vec2<f32> = vec2(0.5, 2.25);

// Returns the mean cosine of a von Mises distribution with this concentration, with an error below 4 %: A = I1 / I0 of
// formulas 4.15.
fn mean_cosine_around(concentration: f32) -> f32 {
    return concentration / (BESSEL_RATIO_FIT.x + sqrt(concentration * concentration + BESSEL_RATIO_FIT.y));
}

// Share of all directions that are open to the hair tips of most bodies (formulas 4.15).
const USUALLY_OPEN: f32 = 0.725;
// Half the range of a four-bit component of openness.
const OPENNESS_HALF: f32 = 7.0;
// Number of values of a four-bit component of openness.
const OPENNESS_VALUES: f32 = 16.0;
// Maximum colour of a surface for which the sum of reflected light is evaluated.
const BRIGHTEST: f32 = 0.98;

// Unpacks the openness of a vertex from two numbers, 0..=1. Returns a vector in the tile frame towards the middle of
// the open directions. Its length is the open share, relative to that of most bodies.
fn unpack_openness(packed: vec2<f32>) -> vec3<f32> {
    // The openness is unknown.
    if packed.x <= 0.0 {
        return vec3(0.0, 0.0, 1.0);
    }
    let byte = floor(packed.y * 255.0 + 0.5);
    let u = floor(byte / OPENNESS_VALUES);
    let aside = (vec2(u, byte - OPENNESS_VALUES * u) - OPENNESS_HALF) / OPENNESS_HALF;
    let middle = vec3(aside, sqrt(max(1.0 - dot(aside, aside), 0.0)));
    return middle * (packed.x / USUALLY_OPEN * inverseSqrt(max(dot(middle, middle), 1.0)));
}

// Returns the share of environment light that reaches a point on a body of that colour (formulas 4.15). `hidden`: share
// of this light that the body hides from the point. The hiding surface is assumed to be as bright as the point, and
// lights it.
fn environment_share(color: vec3<f32>, hidden: f32) -> vec3<f32> {
    return (1.0 - hidden) / (1.0 - clamp(color, vec3(0.0), vec3(BRIGHTEST)) * hidden);
}
