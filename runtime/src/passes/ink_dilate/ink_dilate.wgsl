// Along rows: the feature whose line reaches a pixel farthest. With the search along columns that `ink_stroke` does this is exact: a line is the union of
// discs about its features, and whether a disc of radius w holds a point at (x, y) from its centre, x² + y² <= w², parts into rows and columns.
// (Three dilations by 3 x 3 pixels are the same with squares of half width 3 for discs.)

@group(0) @binding(1) var features: texture_2d<f32>;

// Offset along the row, (x + 128) / 255, and how far its line reaches over WIDEST_HALF, 0 for none; how much of the row within reach is features, the
// near ones more.
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
