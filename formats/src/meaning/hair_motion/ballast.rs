//! Forces that hold hair at rest in its groomed shape.

use glam::{Mat3, Vec3};

/// Gravitational acceleration of the earth, m/s².
pub const GRAVITY: f32 = 9.81;

/// Returns the accelerations, one per point, that hold a guide in its groomed shape against gravity at rest, together
/// with the tension of its segments. They are in the frame of the root's triangle.
///
/// Segments can only pull. Starting at the tip, each segment carries as much as it can of the weight that hangs from
/// it, as a force along its direction. The rest, from hair that stands out or up, must be carried by the hair's
/// stiffness: this is the returned acceleration.
///
/// * `points`: points relative to the root, which is the first, in the frame of the root's triangle
/// * `frame`: matrix from that frame to world axes at rest, +y up
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
