//! Topic `detail`: number of layers, triangles and texels that a model needs at several sizes on screen. The reference
//! is a picture of the true strands.
//!
//! Fur that is few pixels high cannot show many layers, and small triangles add nothing there. The same view is
//! therefore drawn in four sizes, each compared with its own reference image. Each size is drawn with the runtime's
//! choice, in full detail, and with one of layers, triangles and texels changed at a time.

use super::{Cell, Panel};
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::detail::{has_far_layer, levels};
use pelage_bake::stages::slice::FarFurStats;
use pelage_import::BakeError;
use pelage_stage::LookDetail;
use pelage_tool::shell_judge::SettingMeasurements;

/// Picture size relative to the recipe's `[judge]` size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Name of the size in the table.
    pub word: &'static str,
    /// Factor and divisor applied to the recipe's width and height.
    ratio: (u32, u32),
}

impl Size {
    /// All sizes, largest first; each has half the width, height and fur height of the previous one, in pixels.
    pub const ALL: [Self; 4] = [
        Self { word: "double", ratio: (2, 1) },
        Self { word: "whole", ratio: (1, 1) },
        Self { word: "half", ratio: (1, 2) },
        Self { word: "quarter", ratio: (1, 4) },
    ];

    /// Returns width and height of the picture, pixels, at least 1.
    pub fn pixels(self, recipe: &Recipe) -> (u32, u32) {
        let (times, over) = self.ratio;
        let of = |pixels: u32| (pixels * times / over).max(1);
        (of(recipe.judge.width), of(recipe.judge.height))
    }
}

/// Tile sizes that are drawn in full detail, texels. The smallest suffices for a small picture, the largest for a
/// close-up.
pub const TILES: [u32; 4] = [32, 64, 128, 256];

/// Parameters of one measurement: content and picture size.
#[derive(Clone, Debug, PartialEq)]
pub struct DetailConfiguration {
    /// Name of the varied setting.
    pub series: &'static str,
    /// Value of the varied setting, shown beside its mark in the plot.
    pub label: String,
    /// Index into [`Size::ALL`].
    pub size: usize,
    /// Level of detail at which the package is drawn.
    pub detail: LookDetail,
    /// Recipe with the changes of this configuration.
    pub recipe: Recipe,
    /// Whether this is the default: the unchanged recipe at the automatic level of detail.
    pub default: bool,
}

/// Columns of the chart.
pub const COLUMNS: [&str; 18] = [
    "label",
    "size",
    "width",
    "height",
    "fur_px",
    "samples",
    "layers",
    "triangles",
    "slice.tile_texels",
    "flip",
    "flip_covered",
    "rmse",
    "coverage_error",
    "fragments",
    "frame_milliseconds",
    "gpu_bytes",
    "package_bytes",
    "timing",
];

/// Returns the panels of the chart, one per size. The cost is the number of fragments, or milliseconds if the adapter
/// does not count fragments.
pub fn panels(counted: bool) -> Vec<Panel> {
    let (cost, cost_label) = match counted {
        true => ("fragments", "fragments per frame"),
        false => ("frame_milliseconds", "frame, milliseconds"),
    };
    let error_labels = [
        "mean FLIP at twice the size in [judge]",
        "mean FLIP at the size in [judge]",
        "mean FLIP at half the size in [judge]",
        "mean FLIP at a quarter of the size in [judge]",
    ];
    let panel = |(size, error_label): (Size, _)| Panel {
        cost,
        cost_label,
        error: "flip",
        error_label,
        only: Some(("size", size.word)),
    };
    Size::ALL.into_iter().zip(error_labels).map(panel).collect()
}

/// Lists what to measure. Each size is drawn with:
///
/// * the runtime's choice
/// * full detail, with all layers and triangles of the recipe
/// * the recipe's levels of detail in quarter steps, as long as they have layers
/// * full detail with each of the tile sizes [`TILES`]
/// * the runtime's choice without simplified triangle lists
///
/// # Errors
///
/// Same as [`Recipe::set`]; cannot occur with a valid base.
pub fn configurations(base: &Recipe) -> Result<Vec<DetailConfiguration>, BakeError> {
    let mut unsimplified = base.clone();
    unsimplified.set("detail.simplified=false")?;
    let coat = has_far_layer(base).then(FarFurStats::default);
    let chain = levels(&base.detail, base.slice.layers, coat.as_ref());
    // At step 0, the transition to the far layer, all layers vanish at once; that level is therefore excluded.
    let last = chain.iter().filter(|level| level.step > 0).count().saturating_sub(1);
    let mut out: Vec<DetailConfiguration> = Vec::new();
    for size in 0..Size::ALL.len() {
        let mut add = |series, label: String, detail, recipe: &Recipe| {
            if out.iter().all(|c| (c.size, c.detail, &c.recipe) != (size, detail, recipe)) {
                let default = detail == LookDetail::Auto && recipe == base;
                out.push(DetailConfiguration { series, label, size, detail, recipe: recipe.clone(), default });
            }
        };
        add("auto: as much as the picture shows", "auto".into(), LookDetail::Auto, base);
        add("full: all layers and triangles", "full".into(), LookDetail::Full, base);
        for quarters in 1..=4 * last {
            let level = quarters as f32 / 4.0;
            add("level of detail, all triangles", level.to_string(), LookDetail::Level(level), base);
        }
        for tile_texels in TILES {
            let mut recipe = base.clone();
            recipe.slice.tile_texels = tile_texels;
            add("full, tile of other size", format!("{tile_texels}²"), LookDetail::Full, &recipe);
        }
        add("auto, all triangles", "unsimplified".into(), LookDetail::Auto, &unsimplified);
    }
    Ok(out)
}

/// Values shared by all rows of a size.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DetailSizeFacts {
    /// Width and height of the picture, pixels.
    pub pixels: (u32, u32),
    /// Height of the fur at the nearest point of the model, pixels; `None` without fur or levels of detail.
    pub fur_px: Option<f32>,
    /// Rays per pixel of the reference image.
    pub samples: u32,
}

/// Returns the cells of a row, in the order of [`COLUMNS`]. `timing` is the source of the milliseconds.
pub fn cells(
    configuration: &DetailConfiguration,
    seen: &DetailSizeFacts,
    m: &SettingMeasurements,
    timing: &str,
) -> Vec<Cell> {
    let number = |x: f64| Cell::Number(x);
    vec![
        Cell::Text(configuration.label.clone()),
        Cell::Text(Size::ALL[configuration.size].word.into()),
        number(seen.pixels.0.into()),
        number(seen.pixels.1.into()),
        seen.fur_px.map_or(Cell::Empty, |px| number(px.into())),
        number(seen.samples.into()),
        number(m.layers.into()),
        number(m.triangles.into()),
        number(configuration.recipe.slice.tile_texels.into()),
        number(m.flip),
        number(m.flip_covered),
        number(m.rmse),
        number(m.coverage_error),
        m.fragments.map_or(Cell::Empty, |n| number(n as f64)),
        number(m.frame_ms),
        number(m.gpu_bytes as f64),
        number(m.package_bytes as f64),
        Cell::Text(timing.into()),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::{Chart, Row};

    fn all(base: &Recipe) -> Vec<DetailConfiguration> {
        configurations(base).expect("a valid base")
    }

    #[test]
    fn every_size_has_the_same_rows_each_once() {
        let base = Recipe::default();
        let all = all(&base);
        let of = |size: usize| -> Vec<_> { all.iter().filter(|c| c.size == size).collect() };
        for size in 0..Size::ALL.len() {
            let rows = of(size);
            assert_eq!(rows.len(), all.len() / Size::ALL.len());
            assert!(rows[0].default && rows[0].detail == LookDetail::Auto && rows[0].recipe == base);
            assert_eq!(rows.iter().filter(|c| c.default).count(), 1);
            let drawn = |detail, tile: u32, lists: bool| {
                let alike = |c: &&&DetailConfiguration| {
                    (c.detail, c.recipe.slice.tile_texels, c.recipe.detail.simplified) == (detail, tile, lists)
                };
                rows.iter().filter(alike).count()
            };
            for tile in TILES {
                assert_eq!(drawn(LookDetail::Full, tile, true), 1, "a tile of {tile}");
            }
            // Sixteen layers have three levels, each divided into quarter steps, followed by the far layer.
            for level in [0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0] {
                assert_eq!(drawn(LookDetail::Level(level), base.slice.tile_texels, true), 1, "level {level}");
            }
            assert_eq!(drawn(LookDetail::Auto, base.slice.tile_texels, false), 1);
            assert_eq!(rows.len(), 2 + 8 + (TILES.len() - 1) + 1);
        }
        for c in &all {
            c.recipe.validate().expect("a valid recipe");
        }
    }

    #[test]
    fn level_rows_end_at_the_last_level() {
        let count = |sets: &str| {
            let mut recipe = Recipe::default();
            sets.split(' ').for_each(|set| recipe.set(set).expect("a valid change"));
            let all = all(&recipe);
            all.iter().filter(|c| c.size == 0 && matches!(c.detail, LookDetail::Level(_))).count()
        };
        let recipes = ["slice.layers=32", "slice.layers=32 detail.coat_px=0", "slice.layers=8", "detail.enabled=false"];
        assert_eq!(recipes.map(count), [12, 12, 4, 0]);
    }

    #[test]
    fn each_size_is_half_of_the_previous_one() {
        let mut recipe = Recipe::default();
        let pixels = |recipe: &Recipe| Size::ALL.map(|size| size.pixels(recipe));
        assert_eq!(pixels(&recipe), [(1668, 848), (834, 424), (417, 212), (208, 106)]);
        (recipe.judge.width, recipe.judge.height) = (16, 3);
        assert_eq!(pixels(&recipe)[3], (4, 1));
    }

    #[test]
    fn each_row_has_all_columns_and_belongs_to_one_panel() {
        let measured =
            SettingMeasurements { flip: 0.5, fragments: Some(9), frame_ms: 1.0, ..SettingMeasurements::default() };
        let base = Recipe::default();
        let row = |c: &DetailConfiguration| {
            let cells = cells(c, &DetailSizeFacts::default(), &measured, "timestamp-query");
            assert_eq!(cells.len(), COLUMNS.len());
            let cell = |name| &cells[COLUMNS.iter().position(|column| *column == name).expect("a column")];
            assert_eq!((cell("flip"), cell("fragments")), (&Cell::Number(0.5), &Cell::Number(9.0)));
            assert_eq!((cell("fur_px"), cell("timing")), (&Cell::Empty, &Cell::Text("timestamp-query".into())));
            Row { series: c.series.into(), label: c.label.clone(), cells, default: c.default, command: String::new() }
        };
        for counted in [true, false] {
            let chart = Chart {
                topic: "detail",
                title: String::new(),
                adapter: String::new(),
                columns: COLUMNS.to_vec(),
                rows: all(&base).iter().map(row).collect(),
                panels: panels(counted),
            };
            let drawn: Vec<_> = chart.panels.iter().map(|panel| chart.points(panel)).collect();
            for i in 0..chart.rows.len() {
                assert_eq!(drawn.iter().filter(|points| points[i].is_some()).count(), 1, "row {i}");
            }
            assert_eq!(chart.fronts().len(), 1, "a column for all sizes");
        }
    }
}
