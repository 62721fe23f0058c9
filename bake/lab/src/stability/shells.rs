//! Silhouette: a grazing view has a long path through each layer, which layers rendered as sheets ignore.

use super::row::{DrawCallback, DrawnRowTest, Finding, Row};
use super::{silhouette, surface};
use pelage_bake::recipe::{Coat, Recipe};
use pelage_import::BakeError;

/// Row of the stability table.
pub const ROW: Row<DrawnRowTest> = Row {
    method: "shells",
    cliff: "grazing view: gaps between layers, silhouettes too transparent",
    naive: "layers as sheets, equally opaque at every angle",
    safe: "layers as slabs: 1 - (1 - opacity)^(1 / |N.E|); and fins of the same strands along the outline",
    drive,
};

fn drive(draw: &mut DrawCallback<'_>) -> Result<Vec<Finding>, BakeError> {
    let mut out = Vec::new();
    for (case, model) in [("a torus", surface::torus()), ("a sphere", surface::sphere(24, 48))] {
        let package = silhouette::bake(case, &model, &Recipe::of_coat(Coat::Natural)?)?;
        let found = silhouette::measure(&package, (160, 160), draw)?;
        out.push(Finding {
            case: format!("{case} in the default coat, against its true strands"),
            measure: "mean error of opacity within 6 pixels of the outline",
            naive: found.sheets,
            safe: found.ours,
            // The error must be at most half that of the sheets.
            bound: 0.5 * found.sheets,
            fails_above: 0.02,
        });
    }
    Ok(out)
}
