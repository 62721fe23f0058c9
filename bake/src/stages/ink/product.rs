//! The product that the wash's grey follows from (Fang 2006, §3).

use glam::Vec3;

/// A vertex as near to the centre as this, in radii, has no direction from it.
const NEAR: f32 = 1e-6;

/// The wash's product at a place with that unit normal: (V − CP)·N over the bounding sphere's radius, −2..=2 for centres within the model, and as the
/// abstract has it, ((V − CP)/|V − CP|)·N, −1..=1, which is 0 at the centre itself.
///
/// Printed is (V − CP)·N in the model's units; over the radius, one a and b suit a model of any size.
pub(super) fn product(place: Vec3, normal: Vec3, center: Vec3, radius: f32) -> [f32; 2] {
    let from = (place - center) / radius.max(f32::MIN_POSITIVE);
    let along = from.dot(normal);
    let far = from.length();
    let finite = |x: f32| if x.is_finite() { x } else { 0.0 };
    [finite(along), if far < NEAR { 0.0 } else { finite(along / far).clamp(-1.0, 1.0) }]
}
