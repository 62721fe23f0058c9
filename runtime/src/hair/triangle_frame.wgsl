//! uses shared/skinning
// Returns a matrix with the columns: direction of the first edge, perpendicular to it in the plane, normal. A
// degenerate triangle gets zero, so that its hair has no length.
fn triangle_frame(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> mat3x3<f32> {
    let along = normalize_or(b - a, vec3(0.0));
    let normal = normalize_or(cross(b - a, c - a), vec3(0.0));
    if dot(along, along) == 0.0 || dot(normal, normal) == 0.0 {
        return mat3x3<f32>();
    }
    return mat3x3(along, cross(normal, along), normal);
}
