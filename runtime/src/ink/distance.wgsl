// Distance of a depth, shared by the passes that hide strokes and lines.

// Returns the distance along the view direction of a depth in clip space. `rows`: elements of the projection, by which
// depth and w in clip space are linear in the z coordinate of the view.
fn distance_of_depth(rows: vec4<f32>, depth: f32) -> f32 {
    let below = depth * rows.z - rows.x;
    // The background of an infinite projection has no distance.
    return select((depth * rows.w - rows.y) / below, 1e9, abs(below) < 1e-9);
}
