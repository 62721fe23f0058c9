//! Hair along the light: with rounding, sin² computed as 1 − (T·L)² is negative, and a power of it is NaN.

use super::measures::even_direction;
use super::row::{Finding, Row};
use glam::Vec3;
use pelage_import::BakeError;
use pelage_runtime::shared::kajiya_kay::{sin_power, sin_squared};

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "Kajiya-Kay",
    cliff: "hair along the light or the halfway vector",
    naive: "1 - (T.L)^2 to a power",
    safe: "clamp at zero first",
    drive,
};

/// Exponents of the lighting equation, covering the range that a recipe allows.
pub const EXPONENTS: [f32; 9] = [0.0, 0.5, 1.0, 2.0, 3.0, 30.0, 101.0, 1000.0, 10_000.0];

/// Returns test cases: unit vectors spread evenly over the sphere, each paired with a vector and an exponent. The
/// paired vector is the same one, its opposite, or the same one up to rounding.
pub fn cases() -> impl Iterator<Item = (Vec3, Vec3, f32)> {
    const COUNT: u32 = 100_000;
    (0..COUNT).map(|i| {
        let t = even_direction(i, COUNT).as_vec3().normalize();
        let l = [t, -t, (t * 1.000_000_1).normalize()][i as usize % 3];
        (t, l, EXPONENTS[i as usize % EXPONENTS.len()])
    })
}

fn drive() -> Result<Vec<Finding>, BakeError> {
    let (mut naive, mut safe) = (0, 0);
    for (t, l, exponent) in cases() {
        let sound = |value: f32| (0.0..=1.0).contains(&value);
        naive += usize::from(!sound((1.0 - t.dot(l) * t.dot(l)).powf(exponent / 2.0)));
        safe += usize::from(!sound(sin_power(sin_squared(t, l), 0.5 * exponent)));
    }
    Ok(vec![Finding {
        case: "100000 tangents along the light, exponents 0..=10000".into(),
        measure: "values outside 0..=1 or not a number",
        naive: naive as f64,
        safe: safe as f64,
        bound: 0.0,
        fails_above: 1000.0,
    }])
}
