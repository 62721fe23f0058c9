//! Mip levels: a hair covers the same texel in several layers. Averaging each layer's opacity separately therefore
//! makes distant fur too opaque. (Alpha-tested fur loses coverage and becomes too thin.)

use super::measures::{grow, mean, natural_hair, opacity, slice, transmittances};
use super::row::{Finding, Row};
use pelage_bake::recipe::{HairParams, Style};
use pelage_bake::stages::slice::ShellSet;
use pelage_import::BakeError;

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "mip levels",
    cliff: "thin fur closes or disappears with distance",
    naive: "average each layer by itself",
    safe: "keep each block's mean transmittance through all layers",
    drive,
};

/// Returns the mean transmittance at mip level `level` if the opacity of each layer is averaged separately.
fn averaged(set: &ShellSet, level: usize) -> f64 {
    let (whole, n, side) = (set.texels as usize, set.texels as usize >> level, 1_usize << level);
    let column = |texel: usize| {
        let average = |k| {
            let fine = (0..side * side).map(|i| (texel / n * side + i / side) * whole + texel % n * side + i % side);
            mean(&fine.map(|fine| opacity(set, k, 0, fine)).collect::<Vec<_>>())
        };
        (1..set.layers.len()).map(|k| 1.0 - average(k)).product::<f64>()
    };
    mean(&(0..n * n).map(column).collect::<Vec<_>>())
}

fn drive() -> Result<Vec<Finding>, BakeError> {
    let mut out = Vec::new();
    for (style, lean) in [(Style::Straight, 0.0), (Style::Straight, 0.6), (Style::Curly, 0.2), (Style::Messy, 0.5)] {
        let strands = grow(&HairParams { style, lean, density: 250, ..natural_hair()? }, 0.4)?;
        let set = slice(&strands, 16, 64)?;
        let truth = mean(&transmittances(&set, 0));
        let worst = |of: &dyn Fn(usize) -> f64| (1..=6).map(|l| (of(l) - truth).abs()).fold(0.0, f64::max);
        out.push(Finding {
            case: format!("{} hair, lean {lean}", style.word()),
            measure: "error of mean transmittance against level 0, worst of 6 levels",
            naive: worst(&|level| averaged(&set, level)),
            safe: worst(&|level| mean(&transmittances(&set, level))),
            bound: 0.02,
            fails_above: 0.04,
        });
    }
    Ok(out)
}
