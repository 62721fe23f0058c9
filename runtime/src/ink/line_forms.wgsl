// The forms that pelage draws lines with. A study of what Fang 2006 prints puts another file in the place of this one.

// Lines are no wider than the template.
const TEMPLATE: bool = true;
// Lines run a little into the paper, as wash does.
const SOFT: bool = true;
// Features are followed, and those that no line goes through are left out.
const FOLLOWED: bool = true;

// Strength of a feature; `dots`: of the pixel's normal with those of its neighbours.
fn form_of_features(strength: f32, dots: vec4<f32>) -> f32 {
    return strength;
}

// How far the line of a feature reaches: a weak one leaves the pixels beside it to its stronger neighbours. `w`: half of the line's width.
// With the square root, by which bands are drawn, two outlines and a fold that meet in a corner would run together.
fn form_of_reach(w: f32, strength: f32) -> f32 {
    return w * sqrt(sqrt(strength));
}

// Least for the feature whose line reaches farthest, at 0 or below where it reaches a pixel: `d` away, which its line does by `w`.
fn line_cost(d: vec2<f32>, w: f32) -> f32 {
    return dot(d, d) - w * w;
}

fn line_distance(d: vec2<f32>) -> f32 {
    return length(d);
}

// Opacity and grey of a line.
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
