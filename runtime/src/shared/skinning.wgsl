// Linear blend skinning of positions, normals and tangents.

// Returns a joint matrix times its weight. A joint of weight 0 is ignored, even if its matrix is not finite.
fn weighted(m: mat4x4<f32>, weight: f32) -> mat4x4<f32> {
    if weight > 0.0 {
        return m * weight;
    }
    return mat4x4<f32>();
}

// Returns the weighted sum of four joint matrices (formulas 2.2); the identity if no weight is positive.
fn blend(m0: mat4x4<f32>, m1: mat4x4<f32>, m2: mat4x4<f32>, m3: mat4x4<f32>, weights: vec4<f32>) -> mat4x4<f32> {
    if !any(weights > vec4(0.0)) {
        return mat4x4(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    }
    return weighted(m0, weights.x) + weighted(m1, weights.y) + weighted(m2, weights.z) + weighted(m3, weights.w);
}

// Returns v / |v|, or `fallback` if v is too short, too long or not finite. The vector is scaled first, because a
// squared length may exceed the range of f32.
fn normalize_or(v: vec3<f32>, fallback: vec3<f32>) -> vec3<f32> {
    let largest = max(abs(v.x), max(abs(v.y), abs(v.z)));
    // The negated form makes NaN and infinity also return the fallback.
    if !(largest > 1e-30 && largest < 1e30) {
        return fallback;
    }
    return normalize(v / largest);
}

// Transforms a unit normal by a matrix that may scale non-uniformly, mirror or be singular (formulas 2.3). The result
// always has unit length, and an outward normal stays outward. The cofactor matrix, the inverse transpose times the
// determinant, needs no division. The sign of the determinant is removed again.
fn transform_normal(m: mat3x3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let c0 = cross(m[1], m[2]);
    let n = c0 * normal.x + cross(m[2], m[0]) * normal.y + cross(m[0], m[1]) * normal.z;
    return normalize_or(select(n, -n, dot(m[0], c0) < 0.0), normal);
}

// Returns -1 if the matrix m mirrors, otherwise 1.
fn handedness_of(m: mat3x3<f32>) -> f32 {
    return select(1.0, -1.0, dot(m[0], cross(m[1], m[2])) < 0.0);
}
