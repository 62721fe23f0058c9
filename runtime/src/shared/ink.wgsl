// Formulas of the ink style, shared by the ink passes (Fang 2006). Greys range from 0 for black to 1 for white, in
// display encoding.

// Returns the sphere map coordinates (§2; formulas 5.1): position in the stroke texture. `normal`: in the frame
// perpendicular to the view (x right, y up, z towards the eye). The outline maps to the rim of the unit disc under any
// perspective, and no division is needed. `swell`: factor on the width of the rim.
fn ink_sphere_uv(normal: vec3<f32>, swell: f32) -> vec2<f32> {
    let r = min(length(normal.xy), 1.0);
    // Inside the disc, distances from the rim shrink as the rim swells.
    let wanted = max(1.0 - (1.0 - r) / max(swell, 1e-3), 0.0);
    let p = normal.xy * (wanted / max(r, 1e-6));
    return vec2(0.5 + 0.5 * p.x, 0.5 - 0.5 * p.y);
}

// Returns the sphere map coordinates by reflection of the eye, which the published equations intend (formulas 5.1): R =
// 2 (N.E) N - E. E points from the surface to the eye; both vectors are in view space. The mapping is undefined at R =
// (0, 0, -1), where the middle of the texture is returned.
fn ink_sphere_uv_reflected(normal: vec3<f32>, eye: vec3<f32>) -> vec2<f32> {
    let r = 2.0 * dot(normal, eye) * normal - eye;
    let m = max(length(r + vec3(0.0, 0.0, 1.0)), 1e-4);
    return vec2(0.5 + 0.5 * r.x / m, 0.5 - 0.5 * r.y / m);
}

// Returns the sphere map coordinates in the published form (formulas 5.1): R = (N.E)(N.E) E - E, with E from the eye to
// the surface. R is parallel to E, so that all normals map to one point.
fn ink_sphere_uv_printed(normal: vec3<f32>, eye: vec3<f32>) -> vec2<f32> {
    let e = -eye;
    let alpha = dot(normal, e);
    let r = alpha * dot(normal, e) * e - e;
    let m = sqrt(r.x * r.x + r.y * r.y + (r.z + 1.0) * (r.z + 1.0));
    return vec2(r.x / (2.0 * m) + 0.5, 0.5 - r.y / (2.0 * m));
}

// Returns the strength of a feature (formulas 5.2): 0 if `least` is at T1 or above, 1 at T2 and below. `least`: least
// of the four dot products of a pixel's normal with its diagonal neighbours' normals. The published thresholds are the
// two ends of this ramp.
fn ink_feature_strength(least: f32, t1: f32, t2: f32) -> f32 {
    if least > t1 {
        return 0.0;
    }
    return clamp((t1 - least) / max(t1 - t2, 1e-6), 0.0, 1.0);
}

// Returns D of Fang 2006, §2 (formulas 5.2): the grey of a line, k (0.5 N.E + 0.5), darkest at the outline. Weak lines
// are lightened towards `lightness`.
fn ink_line_grey(n_dot_e: f32, k: f32, lightness: f32, strength: f32) -> f32 {
    let d = k * (0.5 * clamp(n_dot_e, 0.0, 1.0) + 0.5);
    return mix(lightness + (1.0 - lightness) * d, d, strength);
}

// Returns W of Fang 2006, §3 (formulas 5.3): the grey of the wash for the product ((V - CP).N) / rho, or for the
// normalised product.
fn ink_wash_grey(product: f32, speed: f32, range: f32) -> f32 {
    return clamp(product * speed + range, 0.0, 1.0);
}

// Compresses a negative product to the range above -1/2 (formulas 5.3). Where a surface turns back towards the centre
// of the wash, as between legs, the product is unbounded below.
fn ink_wash_product(product: f32) -> f32 {
    return select(product / (1.0 - 2.0 * product), product, product >= 0.0);
}

// Returns the ink at a density between 0 (none) and 1 (all strokes) (formulas 5.5). The four components of `texel`
// store four nested densities.
fn ink_nested(texel: vec4<f32>, density: f32) -> f32 {
    let x = clamp(density, 0.0, 1.0) * 4.0;
    var ink = texel.r * clamp(x, 0.0, 1.0);
    ink = mix(ink, texel.g, clamp(x - 1.0, 0.0, 1.0));
    ink = mix(ink, texel.b, clamp(x - 2.0, 0.0, 1.0));
    return mix(ink, texel.a, clamp(x - 3.0, 0.0, 1.0));
}
