//! Why hair that nothing moves stands as it was groomed.

use glam::{Mat3, Vec3};

/// Of the earth, metres a second squared.
pub const GRAVITY: f32 = 9.81;

/// What holds a guide's points in their groomed places against gravity at rest, beside the tension of its pieces: accelerations in the frame of its triangle,
/// one a point.
///
/// Pieces only pull. From the tip on, each bears along itself as much as it can of what hangs on it; the rest, hair that stands out or up, is borne by its
/// stiffness, which is this.
///
/// * `points`: relative to the root, which is the first, in the frame of the root's triangle
/// * `frame`: from there to the axes of the world at rest, +y up
pub fn ballast(points: &[Vec3], frame: Mat3) -> Vec<Vec3> {
    let down = Vec3::NEG_Y * GRAVITY;
    let to_frame = frame.inverse();
    let scale = libm::cbrtf(frame.determinant().abs());
    let mut out = vec![Vec3::ZERO; points.len()];
    let mut hangs = Vec3::ZERO;
    for k in (1..points.len()).rev() {
        let way = (frame * (points[k] - points[k - 1])).normalize_or_zero();
        let borne = way * (down + hangs).dot(way).max(0.0);
        let own = to_frame * (borne - hangs - down) * scale;
        out[k] = if own.is_finite() { own } else { Vec3::ZERO };
        hangs = borne;
    }
    out
}
