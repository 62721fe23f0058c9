// Light that is spread about a direction: what of it meets a hair, and where a frame looks it up.

// Place of a direction in a square of all directions, -1..=1 each: an octahedron unfolded.
fn octahedral(way: vec3<f32>) -> vec2<f32> {
    let flat = way.xz / max(abs(way.x) + abs(way.y) + abs(way.z), 1e-12);
    let folded = (1.0 - abs(flat.yx)) * select(vec2(-1.0), vec2(1.0), flat >= vec2(0.0));
    return select(folded, flat, way.y >= 0.0);
}

// Mean of the squared cosine between a direction and light of that mean cosine about another, which lies at that cosine from it.
fn mean_square(mean: f32, cosine: f32) -> f32 {
    let across = (1.0 - mean * mean) / (3.0 - mean * mean);
    return across + (1.0 - 3.0 * across) * cosine * cosine;
}

// Where light of that mean cosine is on its axis of the tables of broad light, 0..=1.
fn broad_place(mean: f32) -> f32 {
    return clamp((1.0 - sqrt(1.0 - clamp(mean, 0.0, 1.0))) / 0.8, 0.0, 1.0);
}

// Variance of the angle of light of that mean cosine: 1 / kappa.
fn broad_variance(mean: f32) -> f32 {
    let m = clamp(mean, 1e-3, 0.9999);
    return (1.0 - m * m) / (m * (3.0 - m * m));
}
