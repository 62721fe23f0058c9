//! Layer count: the same fur must be equally dense with 8 and with 64 layers.

use super::measures::{grow, mean, natural_hair, opacity, slice, texels, transmittances};
use super::row::{Finding, Row};
use pelage_bake::recipe::{HairParams, Style};
use pelage_import::BakeError;

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "opacity and layer count",
    cliff: "the same fur at 8 and at 64 layers",
    naive: "the same opacity per layer",
    safe: "opacity from the length of hair within a layer",
    drive,
};

fn drive() -> Result<Vec<Finding>, BakeError> {
    let coats =
        [(Style::Straight, 150, 0.0), (Style::Straight, 700, 0.5), (Style::Curly, 300, 0.2), (Style::Messy, 500, 0.9)];
    let mut out = Vec::new();
    for (style, density, lean) in coats {
        let strands = grow(&HairParams { style, density, lean, ..natural_hair()? }, 0.4)?;
        let eight = slice(&strands, 8, 64)?;
        let few = transmittances(&eight, 0);
        let covered = |t: &[f64]| t.iter().filter(|t| **t < 0.5).count() as f64 / t.len() as f64;
        let mut safe = 0.0_f64;
        for layers in [16, 64] {
            let many = transmittances(&slice(&strands, layers, 64)?, 0);
            safe = safe.max((mean(&few) - mean(&many)).abs()).max((covered(&few) - covered(&many)).abs());
        }
        // The naive form draws 64 layers with the opacities of 8 layers.
        let naive: Vec<f64> = (0..texels(&eight, 0))
            .map(|texel| (1..64).map(|k| 1.0 - opacity(&eight, (k * 7_usize).div_ceil(63), 0, texel)).product())
            .collect();
        out.push(Finding {
            case: format!("{} hair, {density} strands, lean {lean}", style.word()),
            measure: "difference in mean transmittance or coverage",
            naive: (mean(&few) - mean(&naive)).abs(),
            safe,
            bound: 0.02,
            fails_above: 0.04,
        });
    }
    Ok(out)
}
