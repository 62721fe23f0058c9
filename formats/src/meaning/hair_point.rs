//! Position of a point of hair in fur of height H. At the share s of the height, it is s · H along the surface normal
//! and s² · l · H along the comb direction. The comb direction is the tile's bitangent, and l is the vertex's lean.

use glam::Vec3;
use std::ops::{Add, Mul};

/// Returns the lateral offset of a point of the fur volume in the comb direction, as a share of the volume's height.
/// `lean` is the lean beyond that of the tile's strands, 0..=1; `share` is the point's height as a share of the
/// volume's.
pub fn lean_offset<S: Copy + Mul<Output = S>>(lean: S, share: S) -> S {
    lean * share * share
}

/// Returns the derivative of [`lean_offset`] with respect to `share`.
pub fn lean_slope(lean: f32, share: f32) -> f32 {
    2.0 * lean * share
}

/// Returns the offset from the surface to a point of the hair that grows there, metres, in f32 or f64.
///
/// * `normal`, `bitangent` - of the tile's frame, unit length
/// * `lean` - of the vertex, 0..=1
/// * `share` - height of the point as a share of the fur's height: 0 on the surface, 1 at the outermost layer
/// * `height_m` - height of the outermost layer, metres
pub fn hair_offset<V, S>(normal: V, bitangent: V, lean: S, share: S, height_m: S) -> V
where
    V: Mul<S, Output = V> + Add<Output = V>,
    S: Copy + Mul<Output = S>,
{
    (normal * share + bitangent * lean_offset(lean, share)) * height_m
}

/// Transforms a segment of the tile's hair, in the tile frame, to fur that leans and is `share` times as high as the
/// tile's. The segment rises less but keeps its lateral extent, so it is flatter.
///
/// * `share` - the vertex's fur height divided by `FurInfo::height_m`
/// * `slope` - result of [`lean_slope`]
pub fn grown_tangent(direction: Vec3, share: f32, slope: f32) -> Vec3 {
    let rises = share * direction.z;
    Vec3::new(direction.x, direction.y + slope * rises, rises)
}

/// Returns the direction of [`grown_tangent`], scaled to the length of the tile's direction, at most 1.
pub fn hair_direction(direction: Vec3, share: f32, slope: f32) -> Vec3 {
    let grown = grown_tangent(direction, share, slope);
    grown * (direction.dot(direction) / grown.dot(grown).max(1e-30)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn hair_offset_is_linear_along_the_normal_and_quadratic_sideways() {
        for share in [0.0f32, 0.25, 0.5, 1.0] {
            let found = hair_offset(Vec3::Y, Vec3::Z, 0.5, share, 0.02);
            assert!(found.distance(Vec3::new(0.0, 0.02 * share, 0.01 * share * share)) < 1e-8, "{share}: {found}");
            let fine = hair_offset(DVec3::Y, DVec3::Z, 0.5, f64::from(share), 0.02);
            assert!(fine.as_vec3().distance(found) < 1e-8);
        }
    }

    #[test]
    fn directions_follow_the_bend_and_keep_their_length() {
        let (lean, share, step) = (0.8f32, 0.5f32, 1e-3f32);
        let at = |share| hair_offset(Vec3::Z, Vec3::Y, lean, share, 1.0);
        let along = (at(share + step) - at(share - step)).normalize();
        let found = hair_direction(Vec3::Z * 0.5, 1.0, lean_slope(lean, share));
        assert!((found.length() - 0.5).abs() < 1e-6 && (found / 0.5).distance(along) < 1e-3, "{found} along {along}");
        assert_eq!(hair_direction(Vec3::ZERO, 1.0, 1.0), Vec3::ZERO);
    }

    #[test]
    fn shorter_hair_lies_flatter() {
        // Two points of a strand, in units of the tile's height. They are placed on a vertex whose hair leans and is a
        // quarter as high as the tile's.
        let (low, high) = (Vec3::new(0.1, -0.05, 0.5), Vec3::new(0.103, -0.046, 0.504));
        let (lean, quarter) = (0.3, 0.25);
        let point = |p: Vec3| Vec3::new(p.x, p.y, 0.0) + hair_offset(Vec3::Z, Vec3::Y, lean, p.z, quarter);
        let along = (point(high) - point(low)).normalize();
        let found = hair_direction((high - low).normalize(), quarter, lean_slope(lean, 0.502));
        assert!(found.distance(along) < 1e-3, "{found} along {along}");
        assert!(hair_direction((high - low).normalize(), 1.0, 0.0).z > 2.0 * found.z);
        // Hair of height 0 lies flat.
        assert_eq!(hair_direction(Vec3::Z, 0.0, 0.5), Vec3::ZERO);
    }
}
