//! Topic `surface`: trade-off between seams and distortion of texture coordinates, and the seconds needed to compute
//! them.

use super::{Cell, Panel};
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::surface::Measures;
use pelage_import::mesh::Model;

/// Recipe to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceConfiguration {
    /// Name of the varied setting.
    pub series: &'static str,
    /// Short value of the varied setting.
    pub label: String,
    /// Changes to the base recipe, as arguments of `--set`.
    pub sets: Vec<String>,
    /// Recipe with the changes.
    pub recipe: Recipe,
}

/// Columns of the chart.
pub const COLUMNS: [&str; 14] = [
    "surface.source",
    "surface.comb",
    "surface.comb_weight",
    "surface.patch_size",
    "surface.patch_turn_deg",
    "surface.patch_stretch",
    "angle_distortion",
    "area_distortion",
    "stretch_l2",
    "comb_misalignment_deg",
    "flipped_triangles",
    "seam_length_ratio",
    "patches",
    "seconds",
];

/// Panels of the chart.
pub const PANELS: [Panel; 2] = [
    Panel {
        cost: "seam_length_ratio",
        cost_label: "seam length / square root of skin area",
        error: "angle_distortion",
        error_label: "angle distortion (0: none)",
        only: None,
    },
    Panel {
        cost: "seconds",
        cost_label: "surface stage, seconds",
        error: "angle_distortion",
        error_label: "angle distortion (0: none)",
        only: None,
    },
];

/// Lists what to measure, the base recipe first. The model's own texture coordinates are included if all parts have
/// them.
///
/// # Errors
///
/// Same as [`Recipe::set`]; cannot occur with a valid base.
pub fn configurations(base: &Recipe, model: &Model) -> Result<Vec<SurfaceConfiguration>, pelage_import::BakeError> {
    let with = |series: &'static str, label: String, sets: &[String]| -> Result<_, pelage_import::BakeError> {
        let mut recipe = base.clone();
        sets.iter().try_for_each(|set| recipe.set(set))?;
        Ok(SurfaceConfiguration { series, label, sets: sets.to_vec(), recipe })
    };
    let mut out = vec![with("as the recipe says", String::new(), &[])?];
    let patches = "surface.source=patches".to_owned();
    let size = |size: f32| format!("surface.patch_size={size:?}");
    for value in [0.25, 0.5, 0.75, 1.0, 1.5, 3.0, 4.0, 8.0] {
        out.push(with("patch size", value.to_string(), &[patches.clone(), size(value)])?);
    }
    // From some size on, the limits on turn and stretch stop the growth of patches. They are relaxed here, so that only
    // the size decides.
    for value in [0.5, 1.0, 2.0, 4.0, 8.0, 16.0] {
        let wide = ["surface.patch_turn_deg=60.0".to_owned(), "surface.patch_stretch=4.0".to_owned()];
        out.push(with(
            "patch size, limits wide open",
            value.to_string(),
            &[&[patches.clone(), size(value)][..], &wide].concat(),
        )?);
    }
    for value in [5.0, 10.0, 15.0, 35.0, 45.0, 60.0] {
        out.push(with(
            "patch turn",
            format!("{value}°"),
            &[patches.clone(), format!("surface.patch_turn_deg={value:?}")],
        )?);
    }
    for value in [1.05, 1.1, 1.25, 2.0, 3.0, 4.0] {
        out.push(with(
            "patch stretch",
            value.to_string(),
            &[patches.clone(), format!("surface.patch_stretch={value:?}")],
        )?);
    }
    for value in [0.75, 0.5, 0.25, 0.0] {
        out.push(with("comb weight", value.to_string(), &[patches.clone(), format!("surface.comb_weight={value:?}")])?);
    }
    for value in [0.5, 1.0, 2.0, 4.0, 8.0] {
        out.push(with(
            "isotropic (no comb)",
            value.to_string(),
            &[patches.clone(), "surface.comb=none".into(), size(value)],
        )?);
    }
    if model.mesh.parts.iter().all(|part| part.has_uvs) {
        out.push(with("the model's own coordinates", String::new(), &["surface.source=model".into()])?);
    }
    Ok(out)
}

/// Returns the cells of a row, in the order of [`COLUMNS`].
pub fn cells(recipe: &Recipe, measures: &Measures, seconds: f64) -> Vec<Cell> {
    let (s, m) = (&recipe.surface, measures);
    vec![
        Cell::Text(s.source.word().into()),
        Cell::Text(s.comb.word().into()),
        Cell::Number(s.comb_weight.into()),
        Cell::Number(s.patch_size.into()),
        Cell::Number(s.patch_turn_deg.into()),
        Cell::Number(s.patch_stretch.into()),
        Cell::Number(m.angle_distortion),
        Cell::Number(m.area_distortion),
        Cell::Number(m.stretch_l2),
        m.comb_misalignment_deg.map_or(Cell::Empty, Cell::Number),
        Cell::Number(m.flipped_triangles.into()),
        Cell::Number(m.seam_length_ratio),
        Cell::Number(m.patches.into()),
        Cell::Number(seconds),
    ]
}
