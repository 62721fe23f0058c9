//! Transforms of prims.
//!
//! <https://openusd.org/release/api/class_usd_geom_xformable.html>

use glam::{DMat4, DQuat, DVec3, EulerRot};

/// Transform operations of a prim, and the order in which they apply.
#[derive(Default)]
pub(super) struct Xform<'a> {
    pub(super) operations: Vec<(&'a str, Vec<f64>)>,
    pub(super) order: Vec<&'a str>,
}

impl Xform<'_> {
    /// Returns the matrix from the prim's space to its parent's, and whether the transforms of the parents are ignored.
    /// An operation without a usable value is the identity; of two values, the later one counts.
    pub(super) fn matrix(&self) -> (DMat4, bool) {
        let mut matrix = DMat4::IDENTITY;
        let mut resets = false;
        for name in &self.order {
            if *name == "!resetXformStack!" {
                (matrix, resets) = (DMat4::IDENTITY, true);
                continue;
            }
            let plain = name.strip_prefix("!invert!");
            let named = |(known, _): &&(&str, Vec<f64>)| *known == plain.unwrap_or(name);
            let Some((name, values)) = self.operations.iter().rev().find(named) else { continue };
            let operation = operation(name.split(':').nth(1).unwrap_or_default(), values).unwrap_or(DMat4::IDENTITY);
            matrix *= if plain.is_some() { operation.inverse() } else { operation };
        }
        (matrix, resets)
    }
}

/// Returns the matrix of an operation such as `rotateXYZ`; `None` for an unknown one or another number of values.
fn operation(kind: &str, values: &[f64]) -> Option<DMat4> {
    if kind == "transform" {
        // USD multiplies row vectors by matrices, so its rows are the columns here.
        return Some(DMat4::from_cols_array(&<[f64; 16]>::try_from(values).ok()?));
    }
    if kind == "orient" {
        let [w, x, y, z] = <[f64; 4]>::try_from(values).ok()?;
        return Some(DMat4::from_quat(DQuat::from_xyzw(x, y, z, w).normalize()));
    }
    if let [degrees] = values {
        let turn = degrees.to_radians();
        return Some(match kind {
            "rotateX" => DMat4::from_rotation_x(turn),
            "rotateY" => DMat4::from_rotation_y(turn),
            "rotateZ" => DMat4::from_rotation_z(turn),
            _ => return None,
        });
    }
    let values = DVec3::from(<[f64; 3]>::try_from(values).ok()?);
    // In `rotateXYZ`, the rotation about x applies first, so it is the last factor.
    let order = match kind {
        "translate" => return Some(DMat4::from_translation(values)),
        "scale" => return Some(DMat4::from_scale(values)),
        "rotateXYZ" => EulerRot::ZYX,
        "rotateXZY" => EulerRot::YZX,
        "rotateYXZ" => EulerRot::ZXY,
        "rotateYZX" => EulerRot::XZY,
        "rotateZXY" => EulerRot::YXZ,
        "rotateZYX" => EulerRot::XYZ,
        _ => return None,
    };
    let [x, y, z] = values.to_array().map(f64::to_radians);
    let axis = |letter: u8| match letter {
        b'X' => x,
        b'Y' => y,
        _ => z,
    };
    let [first, second, third] = [6, 7, 8].map(|i| axis(kind.as_bytes()[i]));
    Some(DMat4::from_euler(order, third, second, first))
}
