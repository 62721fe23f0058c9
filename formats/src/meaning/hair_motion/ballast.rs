//! Forces that keep unmoved hair as it was groomed.

use glam::{Mat3, Vec3};

/// Gravitational acceleration of the earth, m/s².
pub const GRAVITY: f32 = 9.81;

/// Returns the accelerations, one per point, that hold a guide's points in their groomed positions against gravity at
/// rest, besides the tension of its segments; in the frame of its triangle.
///
/// Segments only pull. From the tip on, each segment carries as much as it can, along itself, of the weight that hangs
/// from it. The rest, from hair that stands out or up, is carried by the hair's stiffness, which is the returned
/// acceleration.
///
/// * `points`: relative to the root, which is the first, in the frame of the root's triangle
/// * `frame`: from that frame to the axes of the world at rest, +y up
pub fn gravity_compensation(points: &[Vec3], frame: Mat3) -> Vec<Vec3> {
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
