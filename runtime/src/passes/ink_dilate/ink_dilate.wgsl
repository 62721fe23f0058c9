//! uses ink/line_forms, ink/screen
// Row search of the dilation (formulas 5.2): finds the feature whose line reaches farthest over a pixel. Together with
// the column search of `ink_stroke`, the result is exact. A line is the union of discs around its features, and the
// disc test x² + y² <= w² separates into rows and columns. Three dilations by 3 x 3 pixels would be similar, but would
// draw squares of half width 3 instead of discs.

@group(0) @binding(1) var features: texture_2d<f32>;

// Returns the result of the row search:
// * x: offset along the row, stored as (x + 128) / 255
// * y: reach of the line divided by WIDEST_HALF, 0 for none
// * z: number of features within reach in the row, weighted by nearness and divided by `ink.reach` + 1
@fragment
fn fs_dilate(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let p = vec2<i32>(position.xy);
    let first = max(p.x - ink.reach, 0);
    let last = min(p.x + ink.reach, i32(ink.size.x) - 1);
    var best = 1e9;
    var found = vec2(0.0);
    var features_near = 0.0;
    for (var x = first; x <= last; x++) {
        let feature = textureLoad(features, vec2(x, p.y), 0);
        let w = form_of_reach(feature.r * WIDEST_HALF, feature.g);
        let dx = f32(x - p.x);
        let cost = line_cost(vec2(dx, 0.0), w);
        if w > 0.0 {
            features_near += nearness(dx);
        }
        if w > 0.0 && cost < best {
            best = cost;
            found = vec2((dx + 128.0) / 255.0, w / WIDEST_HALF);
        }
    }
    return vec4(found, features_near / f32(ink.reach + 1), 1.0);
}
