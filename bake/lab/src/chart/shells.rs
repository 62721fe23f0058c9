//! Topic `shells`: error of pictures of shells and fins, compared with the true strands, and their cost. Layers, tile,
//! filter and formats are varied.
//!
//! The truth is the same strands, traced as curves (`pelage_truth`). It is rendered once, because it does not depend on
//! slicing. The charts plot mean FLIP. The tables also contain RMSE and coverage, because each measure ignores
//! something: FLIP ignores errors that the eye tolerates, RMSE the position of an error, coverage the colour.

use super::{Cell, Panel};
use pelage_bake::recipe::Recipe;
use pelage_import::BakeError;
use pelage_tool::shell_judge::SettingMeasurements;
use pelage_truth::decide::{LAYERS, Setting, TILES};

/// Slicing parameters to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct ShellsConfiguration {
    /// Name of the varied setting.
    pub series: String,
    /// Value of the varied setting, shown beside its mark in the plot.
    pub label: String,
    /// Recipe with the changes.
    pub recipe: Recipe,
    /// Whether the recipe is unchanged.
    pub default: bool,
}

/// Columns of the chart.
pub const COLUMNS: [&str; 16] = [
    "slice.layers",
    "slice.tile_texels",
    "slice.filter_width",
    "fins.enabled",
    "pack.shell_format",
    "pack.direction_format",
    "flip",
    "flip_covered",
    "rmse",
    "coverage_error",
    "frame_milliseconds",
    "fragments",
    "package_bytes",
    "gpu_bytes",
    "bake_seconds",
    "timing",
];

/// Panels of the chart.
pub const PANELS: [Panel; 2] = [
    Panel {
        cost: "frame_milliseconds",
        cost_label: "frame, milliseconds",
        error: "flip",
        error_label: "mean FLIP against the true strands",
        only: None,
    },
    Panel {
        cost: "package_bytes",
        cost_label: "package, bytes",
        error: "flip",
        error_label: "mean FLIP against the true strands",
        only: None,
    },
];

/// The layers, tile and fins of Yang 2006.
const YANG_2006: Setting = Setting { layers: 16, tile_texels: 64, fins: false };

/// Lists what to measure, the unchanged recipe first:
///
/// * all combinations of [`LAYERS`] and [`TILES`]
/// * filter widths and formats, with the recipe's other settings
/// * the layers without fins, or with fins if the recipe has none
///
/// # Errors
///
/// Same as [`Recipe::set`]; cannot occur with a valid base.
pub fn configurations(base: &Recipe) -> Result<Vec<ShellsConfiguration>, BakeError> {
    let mut out: Vec<ShellsConfiguration> = Vec::new();
    let mut add = |series: &str, label: String, recipe: Recipe| {
        if out.iter().all(|c| c.recipe != recipe) {
            out.push(ShellsConfiguration { series: series.into(), label, default: recipe == *base, recipe });
        }
    };
    let own = Setting::of(base);
    add("as the recipe says", String::new(), base.clone());
    add("as in Yang 2006: 16 layers of 64², no fins", String::new(), YANG_2006.applied_to(base));
    for tile_texels in TILES {
        for layers in LAYERS {
            let setting = Setting { layers, tile_texels, ..own };
            add(&format!("tile of {tile_texels}²"), layers.to_string(), setting.applied_to(base));
        }
    }
    let series = if own.fins { "without fins" } else { "with fins" };
    for layers in LAYERS {
        add(series, layers.to_string(), Setting { layers, fins: !own.fins, ..own }.applied_to(base));
    }
    for (series, sets) in [
        ("filter width", &["slice.filter_width=0.25", "slice.filter_width=1.0", "slice.filter_width=2.0"][..]),
        ("plain texels", &["pack.shell_format=rgba8 pack.direction_format=rg8"]),
    ] {
        for set in sets {
            let mut recipe = base.clone();
            set.split(' ').try_for_each(|set| recipe.set(set))?;
            let label = set.strip_prefix("slice.filter_width=").unwrap_or_default();
            add(series, label.into(), recipe);
        }
    }
    Ok(out)
}

/// Returns the cells of a row, in the order of [`COLUMNS`]. `timing` is the source of the milliseconds.
pub fn cells(recipe: &Recipe, m: &SettingMeasurements, timing: &str) -> Vec<Cell> {
    let number = |x: f64| Cell::Number(x);
    vec![
        number(recipe.slice.layers.into()),
        number(recipe.slice.tile_texels.into()),
        number(recipe.slice.filter_width.into()),
        Cell::Text(recipe.fins.enabled.to_string()),
        Cell::Text(recipe.pack.shell_format.word().into()),
        Cell::Text(recipe.pack.direction_format.word().into()),
        number(m.flip),
        number(m.flip_covered),
        number(m.rmse),
        number(m.coverage_error),
        number(m.frame_ms),
        m.fragments.map_or(Cell::Empty, |n| number(n as f64)),
        number(m.package_bytes as f64),
        number(m.gpu_bytes as f64),
        number(m.bake_s),
        Cell::Text(timing.into()),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shell_configurations_are_listed_once() {
        let base = Recipe::default();
        let all = configurations(&base).expect("a valid base");
        assert!(all[0].default && all[0].recipe == base);
        assert_eq!(all.iter().filter(|c| c.default).count(), 1);
        for (i, c) in all.iter().enumerate() {
            assert!(all[i + 1..].iter().all(|other| other.recipe != c.recipe), "{}", c.series);
            c.recipe.validate().expect("a valid recipe");
        }
        // The grid must be complete: each combination occurs in some series.
        for tile_texels in TILES {
            for layers in LAYERS {
                let setting = Setting { layers, tile_texels, ..Setting::of(&base) };
                assert!(all.iter().any(|c| c.recipe == setting.applied_to(&base)), "{setting}");
            }
        }
        let paper = all.iter().find(|c| c.series.contains("Yang 2006")).expect("the paper's setting");
        assert_eq!(Setting::of(&paper.recipe), YANG_2006);
    }

    #[test]
    fn shell_rows_have_all_columns() {
        let cells = cells(&Recipe::default(), &SettingMeasurements::default(), "timestamp-query");
        assert_eq!(cells.len(), COLUMNS.len());
        assert_eq!(cells[COLUMNS.iter().position(|c| *c == "fragments").expect("a column")], Cell::Empty);
    }
}
