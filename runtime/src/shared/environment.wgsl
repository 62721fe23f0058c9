// Spread light: its mean effect on a hair, and the coordinates at which tables and maps hold it.

// Returns the octahedral map coordinates of a direction, -1..=1 each.
fn octahedral(way: vec3<f32>) -> vec2<f32> {
    let flat = way.xz / max(abs(way.x) + abs(way.y) + abs(way.z), 1e-12);
    let folded = (1.0 - abs(flat.yx)) * select(vec2(-1.0), vec2(1.0), flat >= vec2(0.0));
    return select(folded, flat, way.y >= 0.0);
}

// Sine of the angle below its horizon at which light about a direction begins. LEAST_MEAN: mean cosine of light that is
// even above there.
const BELOW: f32 = 0.45;
const LEAST_MEAN: f32 = 0.275;

// Returns the mean squared cosine between a direction and light spread about an axis. mean: mean cosine of the light
// about its axis; cosine: between the direction and the axis.
fn mean_square(mean: f32, cosine: f32) -> f32 {
    let across = (1.0 - mean) * ((1.0 + 2.0 * mean) / 3.0 - (mean - LEAST_MEAN) * (0.525 - 0.501 * mean));
    return across + (1.0 - 3.0 * across) * cosine * cosine;
}

// Returns the coordinate of light with that mean cosine in the tables of broad light, 0..=1.
fn broad_coordinate(mean: f32) -> f32 {
    let rest = (1.0 - clamp(mean, LEAST_MEAN, 1.0)) / (1.0 - LEAST_MEAN);
    return clamp((1.0 - sqrt(rest)) / 0.83, 0.0, 1.0);
}

// Returns the angular variance of light with that mean cosine: 1 / kappa where it is narrow.
fn broad_variance(mean: f32) -> f32 {
    let m = clamp(mean, LEAST_MEAN, 1.0);
    return (1.0 - m) / m;
}

// Returns the mean cosine of a von Mises distribution with that concentration, I1 / I0, within 4 %.
fn mean_cosine_around(concentration: f32) -> f32 {
    return concentration / (0.5 + sqrt(concentration * concentration + 2.25));
}

// Share of all directions that most bodies leave open to the tips of their hair.
const USUALLY_OPEN: f32 = 0.725;

// Unpacks the openness of a vertex from two numbers, 0..=1. The result is a vector in the tile frame towards the middle
// of the open directions. Its length is the open share relative to that of most bodies.
fn unpack_openness(packed: vec2<f32>) -> vec3<f32> {
    // Unknown openness.
    if packed.x <= 0.0 {
        return vec3(0.0, 0.0, 1.0);
    }
    let byte = floor(packed.y * 255.0 + 0.5);
    let u = floor(byte / 16.0);
    let aside = (vec2(u, byte - 16.0 * u) - 7.0) / 7.0;
    let middle = vec3(aside, sqrt(max(1.0 - dot(aside, aside), 0.0)));
    return middle * (packed.x / USUALLY_OPEN * inverseSqrt(max(dot(middle, middle), 1.0)));
}

// Returns the share of environment light that reaches a point of a body of that colour, if the body hides the share
// `hidden` of it. The hiding surface is about as bright as the point itself, and lights it.
fn environment_share(color: vec3<f32>, hidden: f32) -> vec3<f32> {
    return (1.0 - hidden) / (1.0 - clamp(color, vec3(0.0), vec3(0.98)) * hidden);
}
