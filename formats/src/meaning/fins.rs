//! Fins: positions of a quad's corners, and opacity (Lengyel 2001).

use super::skinning::normalize_or;
use glam::Vec3;

/// Number of vertices of a fin's quad, which is drawn as two triangles.
pub const FIN_CORNERS: u32 = 6;
/// Number of stacked quads of a fin where hair leans, so that the fin can bend.
pub const LEANING_ROWS: u32 = 3;

/// Returns the number of stacked quads of a fin; 1 if the hair does not lean. Together they are as high as the hair.
pub fn fin_rows(leans: bool) -> u32 {
    if leans { LEANING_ROWS } else { 1 }
}

/// Returns the heights of the lower and upper corners of a row of quads, as shares of the hair's height.
pub fn row_heights(row: u32, rows: u32) -> [f32; 2] {
    [row, row + 1].map(|r| r as f32 / rows as f32)
}

/// Returns the unit normal of a fin's plane, computed from the edge `a` to `b` and the surface normals at its ends.
/// Zero if they do not define a plane.
pub fn fin_face(a: Vec3, b: Vec3, normal_a: Vec3, normal_b: Vec3) -> Vec3 {
    normalize_or((b - a).cross(normal_a + normal_b), Vec3::ZERO)
}

/// Returns the opacity of a fin: 1 if it is seen face-on, 0 if it is turned by 60° or more. `p` is the cosine of the
/// angle between its normal and the direction to the eye.
pub fn fin_opacity(p: f32) -> f32 {
    (2.0 * p.abs() - 1.0).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fins_are_opaque_only_when_seen_face_on() {
        for (degrees, expected) in [(0.0f32, 1.0), (60.0, 0.0), (75.0, 0.0), (120.0, 0.0), (180.0, 1.0)] {
            assert!((fin_opacity(degrees.to_radians().cos()) - expected).abs() < 1e-6, "{degrees}°");
        }
        assert_eq!(fin_face(Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Y), Vec3::Z);
        assert_eq!(fin_face(Vec3::ZERO, Vec3::ZERO, Vec3::Y, Vec3::Y), Vec3::ZERO, "an edge without length");
    }

    #[test]
    fn fin_rows_are_contiguous_in_height() {
        for leans in [false, true] {
            let rows = fin_rows(leans);
            let heights: Vec<[f32; 2]> = (0..rows).map(|row| row_heights(row, rows)).collect();
            assert!(heights.windows(2).all(|pair| pair[0][1] == pair[1][0]));
            assert_eq!((heights[0][0], heights[heights.len() - 1][1]), (0.0, 1.0));
        }
    }
}
