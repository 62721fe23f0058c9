// Light that is spread about a direction: what of it meets a hair, and where a frame looks it up.

// Place of a direction in a square of all directions, -1..=1 each: an octahedron unfolded.
fn octahedral(way: vec3<f32>) -> vec2<f32> {
    let flat = way.xz / max(abs(way.x) + abs(way.y) + abs(way.z), 1e-12);
    let folded = (1.0 - abs(flat.yx)) * select(vec2(-1.0), vec2(1.0), flat >= vec2(0.0));
    return select(folded, flat, way.y >= 0.0);
}

// Sine of how far below its horizon light about a direction begins, and the mean cosine of light that is even above there.
const BELOW: f32 = 0.45;
const LEAST_MEAN: f32 = 0.275;

// Mean of the squared cosine between a direction and light of that mean cosine about another, which lies at that cosine from it.
fn mean_square(mean: f32, cosine: f32) -> f32 {
    let across = (1.0 - mean) * ((1.0 + 2.0 * mean) / 3.0 - (mean - LEAST_MEAN) * (0.525 - 0.501 * mean));
    return across + (1.0 - 3.0 * across) * cosine * cosine;
}

// Where light of that mean cosine is on its axis of the tables of broad light, 0..=1.
fn broad_place(mean: f32) -> f32 {
    let rest = (1.0 - clamp(mean, LEAST_MEAN, 1.0)) / (1.0 - LEAST_MEAN);
    return clamp((1.0 - sqrt(rest)) / 0.83, 0.0, 1.0);
}

// Variance of the angle of light of that mean cosine: 1 / kappa where it is narrow.
fn broad_variance(mean: f32) -> f32 {
    let m = clamp(mean, LEAST_MEAN, 1.0);
    return (1.0 - m) / m;
}

// Mean cosine of a von Mises distribution of that concentration, I1 / I0, within 4 %.
fn mean_cosine_around(concentration: f32) -> f32 {
    return concentration / (0.5 + sqrt(concentration * concentration + 2.25));
}

// Share of all directions that most bodies leave open to the tips of their hair.
const USUALLY_OPEN: f32 = 0.725;

// What the body leaves open to the hair at a place, as vertices have it in two numbers, 0..=1: a vector in the tile frame towards the middle of what is open, as long
// as its share is over what most bodies leave open.
fn open_to_hair(packed: vec2<f32>) -> vec3<f32> {
    // Nothing is known.
    if packed.x <= 0.0 {
        return vec3(0.0, 0.0, 1.0);
    }
    let byte = floor(packed.y * 255.0 + 0.5);
    let u = floor(byte / 16.0);
    let aside = (vec2(u, byte - 16.0 * u) - 7.0) / 7.0;
    let middle = vec3(aside, sqrt(max(1.0 - dot(aside, aside), 0.0)));
    return middle * (packed.x / USUALLY_OPEN * inverseSqrt(max(dot(middle, middle), 1.0)));
}

// Of light from all around what reaches a place where a body of that colour hides that share of it: what hides it shines about as much as the place
// itself, and lights it.
fn left_open(color: vec3<f32>, hidden: f32) -> vec3<f32> {
    return (1.0 - hidden) / (1.0 - clamp(color, vec3(0.0), vec3(0.98)) * hidden);
}
