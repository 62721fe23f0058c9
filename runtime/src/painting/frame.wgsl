//! uses ink/distance
// Uniform block of a frame that is painted with strokes, and functions of it.

struct PaintingFrame {
    // Ink colour, sRGB-encoded, because ink and paper are mixed in that encoding.
    ink: vec3<f32>,
    // Pixels per 1/424 of the picture's height.
    unit_px: f32,
    paper: vec3<f32>,
    // Weight of the paper's relief and tone.
    paper_grain: f32,
    // Size of the picture, pixels.
    size: vec2<f32>,
    // Period of the paper, pixels.
    paper_period: f32,
    // Depth of the background.
    far_depth: f32,
    // Third and fourth rows of the projection matrix in its third and fourth columns.
    depth_rows: vec4<f32>,
    // Axes of the view in world space: right, up, and back towards the eye.
    right_ws: vec3<f32>,
    // Factor on the density of washes.
    wash: f32,
    up_ws: vec3<f32>,
    // Wetness of washes, 0..=1.
    wetness: f32,
    back_ws: vec3<f32>,
    // Dryness of the brush, 0..=1.
    dryness: f32,
    // Number of strokes, and of tufts.
    strokes: f32,
    tufts: f32,
    // Distances between which mist hides the painting; none if the first is not below the second.
    mist_from: f32,
    mist_to: f32,
    // Density of the wash on the ground.
    ground: f32,
    // Share of the painting that is done.
    progress: f32,
    // How far water spreads in the paper, relative to raw paper; visibility of its threads; its tint is between white
    // and silk by the same number.
    bleed: f32,
    weave: f32,
    reserved: vec3<f32>,
    // Variation of a stroke's width, 0..=1.
    pressure: f32,
}

// Returns the distance along the view direction of a depth in clip space.
fn eye_distance(painting: PaintingFrame, depth: f32) -> f32 {
    return distance_of_depth(painting.depth_rows, depth);
}

// Returns a hash of two whole numbers and a seed, 0..1.
fn hashed(i: i32, j: i32, seed: u32) -> f32 {
    var x = u32(i) * 374761393u + u32(j) * 668265263u + seed * 2246822519u;
    x = (x ^ (x >> 13u)) * 1274126177u;
    x = x ^ (x >> 16u);
    return f32(x & 0xffffffu) / 16777215.0;
}

// Returns smooth noise in the plane, 0..1, with one random value per unit.
fn plane_noise(p: vec2<f32>, seed: u32) -> f32 {
    let cell = floor(p);
    let f = p - cell;
    let s = f * f * (3.0 - 2.0 * f);
    let c = vec2<i32>(cell);
    let low = mix(hashed(c.x, c.y, seed), hashed(c.x + 1, c.y, seed), s.x);
    let high = mix(hashed(c.x, c.y + 1, seed), hashed(c.x + 1, c.y + 1, seed), s.x);
    return mix(low, high, s.y);
}
