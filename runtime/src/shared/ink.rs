//! Formulas of the ink style (Fang 2006); Rust counterpart of `ink.wgsl`. Greys range from 0 for black to 1 for white,
//! in display encoding.

use glam::{Vec2, Vec3, Vec4};

/// WGSL source of this topic.
pub const WGSL: &str = include_str!("ink.wgsl");

/// Returns the sphere map coordinates (Fang 2006, §2): position in the stroke texture, 0..=1 each. `normal`: unit
/// vector in the frame perpendicular to the view (x right, y up, z towards the eye). The outline maps to the rim of the
/// disc. `swell`: factor on the width of the rim, above 0.
pub fn ink_sphere_uv(normal: Vec3, swell: f32) -> Vec2 {
    let xy = normal.truncate();
    let r = xy.length().min(1.0);
    let wanted = (1.0 - (1.0 - r) / swell.max(1e-3)).max(0.0);
    let p = xy * (wanted / r.max(1e-6));
    Vec2::new(0.5 + 0.5 * p.x, 0.5 - 0.5 * p.y)
}

/// Returns the sphere map coordinates by reflection of the eye, which the published equations intend: R = 2 (N·E) N −
/// E. Both vectors are in view space; `eye` points from the surface to the eye.
pub fn ink_sphere_uv_reflected(normal: Vec3, eye: Vec3) -> Vec2 {
    let r = 2.0 * normal.dot(eye) * normal - eye;
    let m = (r + Vec3::Z).length().max(1e-4);
    Vec2::new(0.5 + 0.5 * r.x / m, 0.5 - 0.5 * r.y / m)
}

/// Returns the sphere map coordinates in the published form. R = (N·E)(N·E) E − E is parallel to E, so that all normals
/// map to one point. NaN where m is 0.
pub fn ink_sphere_uv_printed(normal: Vec3, eye: Vec3) -> Vec2 {
    let e = -eye;
    let alpha = normal.dot(e);
    let r = alpha * normal.dot(e) * e - e;
    let m = (r.x * r.x + r.y * r.y + (r.z + 1.0) * (r.z + 1.0)).sqrt();
    Vec2::new(r.x / (2.0 * m) + 0.5, 0.5 - r.y / (2.0 * m))
}

/// Returns the strength of a feature: 0 if `least` is above `t1`, 1 if it is at most `t2`, linear in between. `least`:
/// least of the four dot products of a pixel's normal with its diagonal neighbours' normals.
pub fn ink_feature_strength(least: f32, t1: f32, t2: f32) -> f32 {
    if least > t1 { 0.0 } else { ((t1 - least) / (t1 - t2).max(1e-6)).clamp(0.0, 1.0) }
}

/// Returns D of Fang 2006, §2: the grey of a line, k (0.5 N·E + 0.5). Lines of low `strength` are lightened towards
/// `lightness`.
pub fn ink_line_grey(n_dot_e: f32, k: f32, lightness: f32, strength: f32) -> f32 {
    let d = k * (0.5 * n_dot_e.clamp(0.0, 1.0) + 0.5);
    let weak = lightness + (1.0 - lightness) * d;
    weak + (d - weak) * strength
}

/// Returns W of Fang 2006, §3: the grey of the wash for the product ((V − CP)·N)/ρ, or for the normalised product.
pub fn ink_wash_grey(product: f32, speed: f32, range: f32) -> f32 {
    (product * speed + range).clamp(0.0, 1.0)
}

/// Compresses a negative product to the range above −1/2. Where a surface turns back towards the centre of the wash, as
/// between legs, the product is unbounded below.
pub fn ink_wash_product(product: f32) -> f32 {
    if product >= 0.0 { product } else { product / (1.0 - 2.0 * product) }
}

/// Returns the ink at a density between 0 (none) and 1 (all strokes). The four components of `texel` store four nested
/// densities.
pub fn ink_nested(texel: Vec4, density: f32) -> f32 {
    let x = density.clamp(0.0, 1.0) * 4.0;
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t.clamp(0.0, 1.0);
    let mut ink = texel.x * x.clamp(0.0, 1.0);
    ink = mix(ink, texel.y, x - 1.0);
    ink = mix(ink, texel.z, x - 2.0);
    mix(ink, texel.w, x - 3.0)
}
