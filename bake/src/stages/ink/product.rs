//! Product that determines the grey of the wash (Fang 2006, §3).

use glam::Vec3;

/// Distance from the centre, in radii of the bounding sphere, below which the direction from the centre to a vertex is
/// undefined.
const NEAR: f32 = 1e-6;

/// Returns the wash product at a surface point V (`place`) with unit normal N (`normal`), for the centre CP (`center`),
/// in two forms:
///
/// * (V − CP)·N divided by the bounding sphere's radius, −2..=2 for centres within the model
/// * ((V − CP)/|V − CP|)·N, as in the abstract of the paper, −1..=1, and 0 at the centre
///
/// The published product (V − CP)·N is in the units of the model. Because it is divided by the radius, the same shading
/// constants suit models of any size.
pub(super) fn wash_product(place: Vec3, normal: Vec3, center: Vec3, radius: f32) -> [f32; 2] {
    let from = (place - center) / radius.max(f32::MIN_POSITIVE);
    let along = from.dot(normal);
    let far = from.length();
    let finite = |x: f32| if x.is_finite() { x } else { 0.0 };
    [finite(along), if far < NEAR { 0.0 } else { finite(along / far).clamp(-1.0, 1.0) }]
}
