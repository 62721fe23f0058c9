//! Opposing tangents cancel: their mean is zero or rounding noise, and normalising it gives NaN or an arbitrary
//! direction.

use super::row::{Finding, Row};
use glam::Vec3;
use pelage_bake::recipe::SliceParams;
use pelage_bake::stages::simulate::Strands;
use pelage_bake::stages::slice::collect_layers;
use pelage_bake::stages::slice::direction::resolve;
use pelage_formats::{TextureFormat, decode_direction};
use pelage_import::BakeError;

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "direction textures",
    cliff: "filtered tangents of opposing hairs cancel",
    naive: "normalise the mean",
    safe: "keep the mean's length as a confidence, fall back to the surface normal",
    drive,
};

/// Returns two hairs that cross at one height in the middle of the tile. Their tangents are `angle_deg` to either side
/// of the surface normal.
fn crossing(angle_deg: f32) -> Strands {
    let (sin, cos) = (libm::sinf(angle_deg.to_radians()), libm::cosf(angle_deg.to_radians()));
    let middle = Vec3::new(0.5, 0.5, 0.5);
    let arm = |x: f32| Vec3::new(x * sin, 0.0, cos) * 0.4;
    Strands {
        points: vec![middle - arm(1.0), middle + arm(1.0), middle - arm(-1.0), middle + arm(-1.0)],
        radii: vec![0.02; 4],
        colors: vec![Vec3::ONE; 4],
        offsets: vec![0, 2, 4],
        height: 1.0,
        root_color: Vec3::ONE,
    }
}

/// Returns whether each stored texel is a valid direction or the marker for no direction.
fn stored_soundly(strands: &Strands, format: TextureFormat) -> Result<bool, BakeError> {
    let params = SliceParams { layers: 5, tile_texels: 32, ..SliceParams::default() };
    let set = collect_layers(strands, &params, format)?;
    let sound = |texel: &[u8]| {
        let mut values = [0.0, 0.0, 0.0, 1.0];
        values.iter_mut().zip(texel).for_each(|(v, b)| *v = f32::from(*b) / 255.0);
        let d = decode_direction(values, format);
        d.is_finite() && d.length() < 1.01
    };
    let levels = set.layers.iter().flat_map(|layer| &layer.direction);
    Ok(levels.flat_map(|level| level.chunks(format.components() as usize)).all(sound))
}

fn drive() -> Result<Vec<Finding>, BakeError> {
    let (mut naive_wrong, mut safe_wrong) = (0, 0);
    for angle in (0..=90_u8).map(f32::from) {
        let strands = crossing(angle);
        let mut right = true;
        for format in [TextureFormat::Rg8Unorm, TextureFormat::Rgba8Unorm] {
            right &= stored_soundly(&strands, format)?;
        }
        // For two hairs alone, the mean direction leans to neither side, and its length measures how well their
        // directions agree.
        let t = [strands.points[1] - strands.points[0], strands.points[3] - strands.points[2]].map(Vec3::normalize);
        let (unit, confidence) = resolve((t[0] + t[1]) * 0.5);
        right &= (unit - Vec3::Z).length() < 1e-3 && (confidence - libm::cosf(angle.to_radians())).abs() < 1e-3;
        // The tangents' components in the surface plane cancel completely. The result must still be a unit vector.
        let sum = t[0].with_z(0.0) + t[1].with_z(0.0);
        right &= resolve(sum * 0.5).0.is_normalized();
        safe_wrong += usize::from(!right);
        naive_wrong += usize::from(!(sum / sum.length()).is_finite());
    }
    Ok(vec![Finding {
        case: "two hairs crossing at 0..=90 degrees".into(),
        measure: "wrong directions, out of 91",
        naive: naive_wrong as f64,
        safe: safe_wrong as f64,
        bound: 0.0,
        fails_above: 45.0,
    }])
}
