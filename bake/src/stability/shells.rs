//! The outline: a look along the skin goes through each layer at another place, where the blur of each covers too much and the gaps between them show.

use super::{Drawer, DrawnDriver, Finding, Row, silhouette, surface};
use crate::BakeError;
use crate::recipe::Recipe;

/// The row of the table.
pub const ROW: Row<DrawnDriver> = Row {
    method: "shells",
    cliff: "grazing view: blur of layers, gaps between them, silhouettes of the wrong density",
    naive: "layers alone",
    safe: "fins of the same strands along the outline, and layers that leave them room",
    drive,
};

fn drive(draw: &mut Drawer<'_>) -> Result<Vec<Finding>, BakeError> {
    let mut out = Vec::new();
    for (case, model) in [("a torus", surface::torus()), ("a sphere", surface::sphere(24, 48))] {
        let packages = silhouette::Packages::bake(case, &model, &Recipe::default())?;
        let found = silhouette::measure(&packages, (160, 160), draw)?;
        out.push(Finding {
            case: format!("{case} in the default coat, against four times the layers and texels"),
            measure: "mean error of opacity within 6 pixels of the outline",
            naive: found.shells_alone,
            safe: found.with_fins,
            // At least halved.
            bound: 0.5 * found.shells_alone,
            fails_above: 0.02,
        });
    }
    Ok(out)
}
