// Default form of the line functions. A study of Fang 2006 in its published form replaces this file.

// Lines are at most as wide as the template.
const TEMPLATE: bool = true;
// Line edges are soft, because ink bleeds slightly into the paper, like wash.
const SOFT: bool = true;
// Features are traced; those that are not on a line are dropped.
const FOLLOWED: bool = true;

// Returns the strength of a feature. `dots`: dot products of the pixel's normal with its neighbours' normals.
fn form_of_features(strength: f32, dots: vec4<f32>) -> f32 {
    return strength;
}

// Returns the reach of a feature's line (formulas 5.2). `w`: half the width of the line. The line of a weak feature is
// narrower, which leaves the pixels beside it to stronger neighbours.
//
// A plain square root, as used for bands, would merge two outlines and a fold that meet in a corner.
fn form_of_reach(w: f32, strength: f32) -> f32 {
    return w * sqrt(sqrt(strength));
}

// Returns the cost of a feature at offset `d` from the pixel, whose line has reach `w`. The line that extends farthest
// beyond the pixel has the lowest cost. The cost is at most 0 if the line covers the pixel.
fn line_cost(d: vec2<f32>, w: f32) -> f32 {
    return dot(d, d) - w * w;
}

// Returns the distance of a pixel from a feature at offset `d`.
fn line_distance(d: vec2<f32>) -> f32 {
    return length(d);
}

// Returns the opacity and grey of a line.
fn form_of_line(
    brushed: vec2<f32>,
    even_grey: f32,
    in_reach: bool,
    distance: f32,
    half_width: f32,
    on_body: bool,
    stroke: f32,
) -> vec2<f32> {
    return brushed;
}
