//! Contours of the smooth surface that a mesh approximates: the zeros of N·E with interpolated normals (Hertzmann and
//! Zorin 2000, §4).

use super::visible::{Family, MeshLine};
use pelage_truth::{SurfaceView, SurfaceVisibility};

/// Returns the zeros of N·E in all triangles, whether hidden or not.
pub(super) fn contours(sight: &SurfaceVisibility, look: &SurfaceView<'_>) -> Vec<MeshLine> {
    let skin = sight.skin();
    let in_triangle = |triangle: usize| {
        let corners = skin.corners(triangle);
        let at = corners.map(|c| c.position_ws);
        let towards = corners.map(|c| -c.normal_ws.dot(look.direction_to(c.position_ws)));
        let crossing = |k: usize| {
            let (i, j) = (k, (k + 1) % 3);
            ((towards[i] > 0.0) != (towards[j] > 0.0))
                .then(|| at[i].lerp(at[j], towards[i] / (towards[i] - towards[j])))
        };
        let mut ends = (0..3).filter_map(crossing);
        let (from, to) = (ends.next()?, ends.next()?);
        let front = (0..3).max_by(|i, j| towards[*i].total_cmp(&towards[*j]))?;
        let longest = (0..3).map(|k| at[k].distance(at[(k + 1) % 3])).fold(0.0, f64::max);
        Some(MeshLine { from, to, family: Family::Contour, inside: at[front], slack_m: longest })
    };
    (0..skin.triangles.len()).filter_map(in_triangle).collect()
}
