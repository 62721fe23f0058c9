//! Fur shorter than the tile's, made by scaling the heights of the same strands. The stored directions of full-height
//! hair are then too upright.

use super::measures::{grow, natural_hair, opacity, slice, texels};
use super::row::{Finding, Row};
use glam::Vec3;
use pelage_bake::recipe::HairParams;
use pelage_bake::stages::simulate::Strands;
use pelage_bake::stages::slice::ShellSet;
use pelage_formats::meaning::hair_direction;
use pelage_formats::{TextureFormat, decode_direction};
use pelage_import::BakeError;

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "short fur",
    cliff: "hair a quarter or a tenth as long as the tile's",
    naive: "directions of the full-length hair",
    safe: "z of directions scaled by the relative hair length",
    drive,
};

/// Returns the strands with their heights scaled by `share`; horizontal positions are unchanged.
fn pressed(strands: &Strands, share: f32) -> Strands {
    let points = strands.points.iter().map(|p| p.with_z(share * p.z)).collect();
    Strands { points, height: share * strands.height, ..strands.clone() }
}

/// Returns the direction of the hair in a texel of the finest level.
fn direction(set: &ShellSet, layer: usize, texel: usize) -> Vec3 {
    let bytes = &set.layers[layer].direction[0][4 * texel..][..4];
    let values: [f32; 4] = std::array::from_fn(|i| f32::from(bytes[i]) / 255.0);
    decode_direction(values, TextureFormat::Rgba8Unorm).normalize_or(Vec3::Z)
}

/// Returns the mean angle between the directions of `short` and the directions that `form` computes from those of
/// `full`, degrees. Texels are weighted by their opacity.
fn angle_deg(full: &ShellSet, short: &ShellSet, form: impl Fn(Vec3) -> Vec3) -> f64 {
    let (mut sum, mut weight) = (0.0, 0.0);
    for layer in 1..full.layers.len() {
        for texel in 0..texels(full, 0) {
            let alpha = opacity(short, layer, 0, texel);
            let cosine = form(direction(full, layer, texel)).dot(direction(short, layer, texel)).clamp(-1.0, 1.0);
            sum += alpha * f64::from(cosine).acos().to_degrees();
            weight += alpha;
        }
    }
    sum / weight
}

fn drive() -> Result<Vec<Finding>, BakeError> {
    let strands = grow(&HairParams { density: 300, ..natural_hair()? }, 0.2)?;
    let full = slice(&strands, 16, 64)?;
    let mut out = Vec::new();
    for (share, bound, fails_above) in [(0.25, 2.0, 20.0), (0.1, 2.0, 35.0)] {
        let short = slice(&pressed(&strands, share), 16, 64)?;
        out.push(Finding {
            case: format!("hair {share} times as long as the tile's"),
            measure: "mean angle to the strands, degrees",
            naive: angle_deg(&full, &short, |d| d),
            safe: angle_deg(&full, &short, |d| hair_direction(d, share, 0.0)),
            bound,
            fails_above,
        });
    }
    Ok(out)
}
