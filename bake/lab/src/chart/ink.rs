//! Topic `ink`: lines of the ink style, compared with the lines of the mesh, and their cost. For lines found in a
//! picture of normals, threshold, width, picture size and rule are varied; for painted strokes, their number, the share
//! of the contour that is left out, and the picture size.
//!
//! The truth is `crate::truth::TrueLines`. Precision, recall and their harmonic mean measure whether lines are where
//! they should be. The widest stroke measures whether lines stay thin; the sphere map alone blackens surfaces seen edge
//! on (Fang 2006, Fig. 3). Flicker measures whether wash and lines keep their position on the model while the camera
//! slowly circles it. Width and flicker are measured on blank paper ([`on_blank_paper`]). `flicker_lines` of the two
//! kinds cannot be compared: it covers dense ink of strokes, and all ink of lines in pixels.

use super::{Cell, Panel};
use crate::compare_lines::LineMeasures;
use crate::measure_painting::PaintingMeasures;
use pelage_runtime::{Anchoring, FeatureRule, InkLines, InkParams, LineWidth, SphereMapForm, Study};

/// Ink settings to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct InkConfiguration {
    /// Name of the varied setting.
    pub series: &'static str,
    /// Value of the varied setting, shown beside its mark in the plot.
    pub label: String,
    /// Ink settings of the drawing.
    pub look: InkSettings,
    /// Whether this is the default configuration.
    pub default: bool,
}

/// Ink parameters, algorithm variants and picture size.
#[derive(Clone, Debug, PartialEq)]
pub struct InkSettings {
    /// Width and height, pixels.
    pub size: (u32, u32),
    /// Ink parameters.
    pub ink: InkParams,
    /// Variants of the algorithms.
    pub study: Study,
}

impl Default for InkSettings {
    fn default() -> Self {
        let ink = InkParams::default().with(|ink| ink.lines = InkLines::Pixels);
        Self { size: SIZE, ink, study: Study::default() }
    }
}

impl InkSettings {
    /// Returns the settings of painted strokes.
    fn strokes(change: impl FnOnce(&mut InkParams)) -> Self {
        Self { ink: InkParams::default().with(|ink| ink.lines = InkLines::Strokes).with(change), ..Self::default() }
    }

    fn with(mut self, change: impl FnOnce(&mut InkParams, &mut Study)) -> Self {
        change(&mut self.ink, &mut self.study);
        self
    }
}

/// Columns of the chart.
pub const COLUMNS: [&str; 30] = [
    "width",
    "height",
    "lines",
    "brush_strokes",
    "omission",
    "threshold",
    "depth_step",
    "step_px",
    "line_px",
    "rule",
    "sphere_map",
    "template",
    "anchoring",
    "precision",
    "recall",
    "recall_silhouette",
    "recall_contour",
    "recall_crease",
    "line_error",
    "widest_stroke_px",
    "template_px",
    "widest_over_template",
    "flicker",
    "flicker_wash",
    "flicker_lines",
    "strokes",
    "tufts",
    "unpainted",
    "dark_outline",
    "frame_milliseconds",
];

/// Panels of the chart.
pub const PANELS: [Panel; 2] = [
    Panel {
        cost: "frame_milliseconds",
        cost_label: "frame, milliseconds",
        error: "line_error",
        error_label: "1 - F1 score of lines, tolerance 2 pixels",
        only: None,
    },
    Panel {
        cost: "frame_milliseconds",
        cost_label: "frame, milliseconds",
        error: "widest_over_template",
        error_label: "widest stroke / template width",
        only: None,
    },
];

/// Size of the pictures in Fang 2006, pixels.
pub const SIZE: (u32, u32) = (834, 424);
/// Thresholds T1.
const THRESHOLDS: [f32; 8] = [0.2, 0.4, 0.5, 0.64, 0.7, 0.8, 0.9, 0.97];
/// Relative depth steps that count as an edge. With 0, only normals are used to find edges.
const DEPTH_STEPS: [f32; 5] = [0.0, 0.005, 0.01, 0.02, 0.05];
/// Maximum line widths, pixels.
const WIDTHS: [f32; 5] = [3.0, 5.0, 7.0, 12.0, 16.0];
/// Numbers of painted strokes.
const STROKES: [f32; 3] = [20.0, 110.0, 200.0];
/// Picture sizes, pixels.
const SIZES: [(u32, u32); 4] = [(417, 212), SIZE, (1251, 636), (1668, 848)];

/// Lists what to measure: lines found in pixels, first at their defaults, then painted strokes, first at theirs. Each
/// other configuration differs from the defaults of its kind only in the setting that its series names.
pub fn configurations() -> Vec<InkConfiguration> {
    let default = InkSettings::default();
    let shown = InkSettings { ink: InkParams::default(), ..InkSettings::default() };
    let mut out: Vec<InkConfiguration> = Vec::new();
    let mut add = |series, label: String, look: InkSettings| {
        if out.iter().all(|c| c.look != look) {
            out.push(InkConfiguration { series, label, default: look == shown, look });
        }
    };
    let of = |change: &dyn Fn(&mut InkParams, &mut Study)| InkSettings::default().with(|ink, study| change(ink, study));
    add("pixels", String::new(), default.clone());
    for threshold in THRESHOLDS {
        add("threshold T1", threshold.to_string(), of(&|ink, _| ink.threshold = threshold));
    }
    for depth_step in DEPTH_STEPS {
        add("step of depth", depth_step.to_string(), of(&|ink, _| ink.depth_step = depth_step));
    }
    for width in WIDTHS {
        add("line width, pixels", width.to_string(), of(&|ink, _| ink.width = LineWidth::Pixels(width)));
    }
    for size in SIZES {
        add("size of the picture", format!("{}x{}", size.0, size.1), InkSettings { size, ..default.clone() });
    }
    for step_px in [1, 2, 3] {
        add("neighbours, pixels away", step_px.to_string(), of(&|ink, _| ink.step_px = step_px));
    }
    let printed = of(&|ink, study| {
        study.features = FeatureRule::AllBelow;
        study.sphere_map = SphereMapForm::Reflection;
        study.printed_lines = true;
        ink.depth_step = 0.0;
    });
    for threshold in [default.ink.threshold, 0.97] {
        let label = format!("T1 {threshold}");
        add("as published", label, printed.clone().with(|ink, _| ink.threshold = threshold));
    }
    let any = printed.with(|_, study| study.features = FeatureRule::AnyBelow);
    add("as published, any neighbour", String::new(), any.clone());
    add("sphere map alone", "reflection".into(), any.with(|_, study| study.template = false));
    add("sphere map alone", "ours".into(), of(&|_, study| study.template = false));
    add("tied to the screen", String::new(), of(&|_, study| study.anchoring = Anchoring::Screen));
    add("painted strokes", String::new(), InkSettings::strokes(|_| ()));
    for strokes in STROKES {
        let look = InkSettings::strokes(|ink| ink.brush.strokes = strokes);
        add("number of painted strokes", strokes.to_string(), look);
    }
    for omission in [0.0, 0.5] {
        add("share left out", omission.to_string(), InkSettings::strokes(|ink| ink.brush.omission = omission));
    }
    for size in SIZES {
        let look = InkSettings { size, ..InkSettings::strokes(|_| ()) };
        add("size of the picture, strokes", format!("{}x{}", size.0, size.1), look);
    }
    out
}

/// Returns the maximum line width in a picture of `height` rows, pixels. All configurations specify it in pixels.
pub fn line_px(ink: &InkParams, height: u32) -> f64 {
    match ink.width {
        LineWidth::Auto => InkParams::default_width_px(height).into(),
        LineWidth::Pixels(px) => px.into(),
        LineWidth::Metres(_) => f64::NAN,
    }
}

/// Returns the width of the template, pixels. It is the maximum line width plus one, because an edge gives features on
/// both of its sides. (Three dilations of Fang 2006, §2, turn one pixel into seven and two into eight.) Lines closer
/// than that merge.
pub fn template_px(ink: &InkParams, height: u32) -> f64 {
    line_px(ink, height) + 1.0
}

/// Returns the same ink on paper without relief, with smooth line edges and no dry brush. Paper does not move with the
/// model, so relief and dry brush would change the picture on the model although nothing is wrong. A black patch must
/// also be measured without holes in it.
#[must_use]
pub fn on_blank_paper(ink: &InkParams) -> InkParams {
    ink.clone().with(|ink| (ink.paper_grain, ink.roughness_px, ink.dryness) = (0.0, 0.0, 0.0))
}

/// Returns the same ink without washes and tufts, with which the strokes leave only their lines and spots.
#[must_use]
pub fn lines_alone(ink: &InkParams) -> InkParams {
    ink.clone().with(|ink| (ink.brush.wash, ink.brush.tufts, ink.brush.ground) = (0.0, 0.0, 0.0))
}

/// Results of a configuration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InkMeasures {
    /// Line measures of each view.
    pub views: Vec<LineMeasures>,
    /// Mean difference between consecutive frames, grey levels 0..=1: over the mesh surface, over pixels that are lines
    /// in neither frame, and over pixels that are lines in both.
    pub flicker: [Option<f64>; 3],
    /// Measures of the paintings of each view. Lines found in pixels have no strokes.
    pub paintings: Vec<PaintingMeasures>,
    /// Fastest frame of the slowest view, milliseconds.
    pub frame_ms: f64,
}

/// Returns the cells of a row, in the order of [`COLUMNS`].
pub fn cells(look: &InkSettings, measured: &InkMeasures) -> Vec<Cell> {
    let InkSettings { size: (width, height), ink, study } = look;
    let share = |of: &dyn Fn(&LineMeasures) -> Option<f64>| {
        let known: Vec<f64> = measured.views.iter().filter_map(of).collect();
        if known.is_empty() { Cell::Empty } else { Cell::Number(known.iter().sum::<f64>() / known.len() as f64) }
    };
    let number = |x: f64| Cell::Number(x);
    let is_painted = ink.lines == InkLines::Strokes;
    let of_kind = |wanted: bool, cell: Cell| if is_painted == wanted { cell } else { Cell::Empty };
    let mean = |of: fn(&PaintingMeasures) -> f64| match measured.paintings.len() {
        0 => Cell::Empty,
        count => Cell::Number(measured.paintings.iter().map(of).sum::<f64>() / count as f64),
    };
    let (stroke, template) =
        (measured.views.iter().map(|m| m.stroke.width_px).fold(0.0, f64::max), template_px(ink, *height));
    let word = |text: &str| Cell::Text(text.into());
    let mut cells = vec![
        number((*width).into()),
        number((*height).into()),
        word(if is_painted { "strokes" } else { "pixels" }),
        of_kind(true, number(ink.brush.strokes.into())),
        of_kind(true, number(ink.brush.omission.into())),
        of_kind(false, number(ink.threshold.into())),
        of_kind(false, number(ink.depth_step.into())),
        of_kind(false, number(ink.step_px.into())),
        of_kind(false, number(line_px(ink, *height))),
        of_kind(
            false,
            word(match study.features {
                FeatureRule::AnyBelow => "any",
                FeatureRule::AllBelow => "all",
            }),
        ),
        of_kind(
            false,
            word(match study.sphere_map {
                SphereMapForm::Perpendicular => "perpendicular",
                SphereMapForm::Reflection => "reflection",
                SphereMapForm::Printed => "printed",
            }),
        ),
        of_kind(false, word(if study.template { "on" } else { "off" })),
        of_kind(
            false,
            word(match study.anchoring {
                Anchoring::Surface => "surface",
                Anchoring::Screen => "screen",
            }),
        ),
        share(&|m| m.lines.precision),
        share(&|m| m.lines.recall),
    ];
    cells.extend([0, 1, 2].map(|kind| share(&|m| m.recall[kind])));
    cells.push(share(&|m| Some(1.0 - m.lines.f1())));
    // The widest painted stroke is a spot or an eye.
    cells.extend([stroke, template, stroke / template].map(|width| of_kind(false, number(width))));
    cells.extend(measured.flicker.map(|f| f.map_or(Cell::Empty, number)));
    cells.extend([mean(|m| m.strokes as f64), mean(|m| m.tufts as f64)].map(|cell| of_kind(true, cell)));
    cells.extend([mean(|m| m.unpainted), mean(|m| m.dark_outline)]);
    cells.push(number(measured.frame_ms));
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ink_configurations_are_listed_once() {
        let all = configurations();
        let defaults: Vec<_> = all.iter().filter(|c| c.default).map(|c| c.series).collect();
        assert_eq!((all[0].series, &defaults[..]), ("pixels", &["painted strokes"][..]));
        for (i, c) in all.iter().enumerate() {
            assert!(all[i + 1..].iter().all(|other| other.look != c.look), "{} {}", c.series, c.label);
        }
        for series in ["threshold T1", "step of depth", "as published", "sphere map alone", "share left out"] {
            assert!(all.iter().any(|c| c.series == series), "{series}");
        }
    }

    #[test]
    fn ink_rows_have_all_columns() {
        let look =
            InkSettings { size: (64, 32), ..InkSettings::default() }.with(|ink, _| ink.width = LineWidth::Pixels(8.0));
        let mut measured = InkMeasures { views: vec![LineMeasures::default(); 2], ..InkMeasures::default() };
        let found = |measured: &InkMeasures, name| {
            let cells = cells(&look, measured);
            assert_eq!(cells.len(), COLUMNS.len());
            cells[COLUMNS.iter().position(|c| *c == name).expect("a column")].clone()
        };
        assert_eq!(found(&measured, "precision"), Cell::Empty);
        measured.views[0].lines.precision = Some(0.5);
        measured.views[1].stroke.width_px = 4.5;
        assert_eq!(found(&measured, "precision"), Cell::Number(0.5));
        assert_eq!(found(&measured, "widest_stroke_px"), Cell::Number(4.5));
        assert_eq!(found(&measured, "widest_over_template"), Cell::Number(0.5));
        assert_eq!(found(&measured, "height"), Cell::Number(32.0));
        assert_eq!((found(&measured, "strokes"), found(&measured, "unpainted")), (Cell::Empty, Cell::Empty));
        measured.paintings.push(PaintingMeasures { unpainted: 0.25, strokes: 7, ..PaintingMeasures::default() });
        assert_eq!((found(&measured, "strokes"), found(&measured, "unpainted")), (Cell::Empty, Cell::Number(0.25)));
        let painted = InkSettings::strokes(|_| ());
        let cells = cells(&painted, &measured);
        let at = |name| &cells[COLUMNS.iter().position(|c| *c == name).expect("a column")];
        assert_eq!((at("strokes"), at("threshold")), (&Cell::Number(7.0), &Cell::Empty));
        assert_eq!((at("rule"), at("widest_stroke_px")), (&Cell::Empty, &Cell::Empty));
    }
}
