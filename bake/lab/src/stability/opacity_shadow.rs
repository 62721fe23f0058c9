//! Opacity shadow maps: their planes divide the whole depth of a scene, so all fur is between two of them.

use super::measures::{grow, natural_hair};
use super::row::{Finding, Row};
use crate::chart::opacity_shadow::{PLANES, column, columns_of, light_in_column};
use pelage_bake::recipe::HairParams;
use pelage_bake::stages::simulate::Strands;
use pelage_import::BakeError;
use pelage_runtime::{OpacityForm, ShadowParams};

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "opacity shadow maps",
    cliff: "fur of 2 cm on a body 1 m deep",
    naive: "16 planes over the whole depth; as published, with the last plane before the end of the depth range",
    safe: "4 slabs behind the first hair of each texel",
    drive,
};

/// Depth of the body along the light, metres.
const BODY_M: f32 = 1.0;
/// Height of the fur, metres.
const FUR_HEIGHT_M: f32 = 0.02;
/// Depth below the fur's surface at which light is measured, metres.
const BELOW_M: f32 = 0.005;

/// Returns all strand pieces of a tile under light from straight above. For each piece, the result has its depth below
/// the fur's surface in metres, and the fraction of the tile that it covers.
fn covered(strands: &Strands) -> Vec<(f32, f32)> {
    let metres = FUR_HEIGHT_M / strands.height;
    let mut out = Vec::new();
    for strand in 0..strands.len() {
        let range = strands.range(strand);
        for i in range.start..range.end.saturating_sub(1) {
            let (a, b) = (strands.points[i], strands.points[i + 1]);
            let area = (strands.radii[i] + strands.radii[i + 1]) * (b - a).truncate().length();
            out.push((metres * (strands.height - 0.5 * (a.z + b.z)), area));
        }
    }
    out
}

fn drive() -> Result<Vec<Finding>, BakeError> {
    let strands = grow(&HairParams { density: 1400, length_variation: 0.0, lean: 0.6, ..natural_hair()? }, 0.2)?;
    let hair = covered(&strands);
    let surface = hair.iter().map(|(depth, _)| *depth).fold(f32::INFINITY, f32::min);
    // True transmittance: all hair between the light and a point shadows it.
    let truth: f32 =
        (-hair.iter().filter(|(depth, _)| depth - surface < BELOW_M).map(|(_, area)| area).sum::<f32>()).exp();
    // Returns the largest error of the transmittance t. `bodies` are the depths along the light at which the fur's
    // surface is placed, metres.
    let error = |form, slabs, bodies: &mut dyn Iterator<Item = f32>| {
        let opacity = columns_of(form, &ShadowParams::default().with(|s| s.slabs = slabs), BODY_M, FUR_HEIGHT_M);
        let of = |at_m: f32| {
            let place = |depth: f32| (at_m + depth - surface) / BODY_M;
            let (first, slabs) = column(form, &opacity, hair.iter().map(|(depth, area)| (place(*depth), *area)));
            let t = light_in_column(form, &opacity, first, &slabs, place(surface + BELOW_M));
            f64::from((t - truth).abs())
        };
        bodies.map(of).fold(0.0, f64::max)
    };
    let anywhere = || (0..64).map(|k| (BODY_M - FUR_HEIGHT_M) * k as f32 / 64.0);
    let behind = || (0..16).map(|k| BODY_M - FUR_HEIGHT_M - 0.02 * k as f32 / 16.0);
    let slabs = ShadowParams::default().slabs;
    let finding = |case: &str, naive, safe| Finding {
        case: format!("{case}; {truth:.2} of the light arrives 5 mm below the surface of the fur"),
        measure: "largest error of t at that depth",
        naive,
        safe,
        bound: 0.15,
        fails_above: 0.2,
    };
    Ok(vec![
        finding(
            "fur anywhere on the body",
            error(OpacityForm::WholeDepth, PLANES, &mut anywhere()),
            error(OpacityForm::Deep, slabs, &mut anywhere()),
        ),
        finding(
            "fur at the far end of the body",
            error(OpacityForm::Printed, PLANES, &mut behind()),
            error(OpacityForm::Deep, slabs, &mut behind()),
        ),
    ])
}
