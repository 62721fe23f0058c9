//! Topic `cost`: how the time of a frame grows with covered pixels, layers, triangles, strands and copies.
//!
//! Each series varies one quantity. The time is compared with that of the first row of the series, which is drawn in
//! turn with it. If the time is proportional to a power of the quantity, the exponent is the same in all rows.

use super::{Cell, Panel};

/// Quantity that a series varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Size of the picture, drawn by layers at the level of detail that the runtime chooses; factor of its width.
    LayerPixels,
    /// Size of the picture, drawn by single strands; factor of its width.
    StrandPixels,
    /// Number of layers drawn.
    Layers,
    /// Triangles of a sphere of radius 1 m, drawn in full detail.
    Triangles,
    /// Density of single strands; factor of the recipe's.
    Strands,
    /// Copies of the model, framed together in a picture of the same size.
    Copies,
}

impl Quantity {
    /// All quantities, in the order of the table.
    pub const ALL: [Self; 6] =
        [Self::LayerPixels, Self::StrandPixels, Self::Layers, Self::Triangles, Self::Strands, Self::Copies];

    /// Returns the name of the series.
    pub fn word(self) -> &'static str {
        match self {
            Self::LayerPixels => "pixels of layers",
            Self::StrandPixels => "pixels of strands",
            Self::Layers => "layers",
            Self::Triangles => "triangles",
            Self::Strands => "strands",
            Self::Copies => "copies",
        }
    }

    /// Returns the settings to measure, smallest first.
    pub fn settings(self) -> &'static [f32] {
        match self {
            Self::LayerPixels | Self::StrandPixels => &[0.25, 0.5, 1.0, 2.0],
            Self::Layers => &[2.0, 4.0, 8.0, 15.0],
            Self::Triangles => &[1_000.0, 4_000.0, 16_000.0, 64_000.0],
            Self::Strands => &[0.25, 0.5, 1.0, 2.0],
            Self::Copies => &[1.0, 4.0, 25.0, 100.0],
        }
    }
}

/// Row of the chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CostConfiguration {
    /// Quantity that its series varies.
    pub quantity: Quantity,
    /// Value of the quantity.
    pub setting: f32,
}

/// Lists what to measure.
pub fn configurations() -> Vec<CostConfiguration> {
    let of = |quantity: Quantity| quantity.settings().iter().map(move |setting| (quantity, *setting));
    Quantity::ALL.into_iter().flat_map(of).map(|(quantity, setting)| CostConfiguration { quantity, setting }).collect()
}

/// Measured frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CostMeasures {
    /// Amount of the varied quantity.
    pub amount: f64,
    /// Pixels that the model covers at least partly.
    pub covered_px: u64,
    /// Fragments of the passes that draw the picture; `None` if the device cannot count them.
    pub fragments: Option<u64>,
    /// Time of a frame whose pose and shadow maps are made again, milliseconds.
    pub milliseconds: f64,
}

/// Columns of the table, after the series.
pub const COLUMNS: [&str; 9] = [
    "quantity",
    "width",
    "height",
    "amount",
    "covered_pixels",
    "fragments",
    "frame_milliseconds",
    "over_first",
    "exponent",
];

/// Returns a panel for each quantity: time over amount.
pub fn panels() -> Vec<Panel> {
    let label = |quantity: Quantity| match quantity {
        Quantity::LayerPixels => "covered pixels, drawn by layers",
        Quantity::StrandPixels => "covered pixels, drawn by strands",
        Quantity::Layers => "layers",
        Quantity::Triangles => "triangles of a sphere",
        Quantity::Strands => "strands in the tile",
        Quantity::Copies => "copies in the same picture",
    };
    let panel = |quantity: Quantity| Panel {
        cost: "amount",
        cost_label: label(quantity),
        error: "frame_milliseconds",
        error_label: "frame, milliseconds",
        only: Some(("quantity", quantity.word())),
    };
    Quantity::ALL.map(panel).to_vec()
}

/// Returns the cells of a row.
///
/// * `over_first`: time of the frame divided by that of the first row of the series
pub fn cells(
    configuration: &CostConfiguration,
    (width, height): (u32, u32),
    (first, here): (&CostMeasures, &CostMeasures),
    over_first: f64,
) -> Vec<Cell> {
    let more = here.amount / first.amount;
    let exponent = if more > 1.0 { Cell::Number(libm::log(over_first) / libm::log(more)) } else { Cell::Empty };
    vec![
        Cell::Text(configuration.quantity.word().into()),
        Cell::Number(width.into()),
        Cell::Number(height.into()),
        Cell::Number(here.amount),
        Cell::Number(here.covered_px as f64),
        here.fragments.map_or(Cell::Empty, |fragments| Cell::Number(fragments as f64)),
        Cell::Number(here.milliseconds),
        Cell::Number(over_first),
        exponent,
    ]
}

/// Returns a sphere of radius 1 m with about `triangles` triangles, as the text of an OBJ file.
pub fn sphere(triangles: f32) -> String {
    let rings = ((triangles / 4.0).sqrt().round() as u32).max(2);
    let columns = 2 * rings;
    let mut text = "v 0 1 0\n".to_owned();
    for i in 1..rings {
        let (sin, cos) = libm::sincos(std::f64::consts::PI * f64::from(i) / f64::from(rings));
        for k in 0..columns {
            let (across, along) = libm::sincos(std::f64::consts::TAU * f64::from(k) / f64::from(columns));
            text += &format!("v {:.6} {cos:.6} {:.6}\n", sin * along, -sin * across);
        }
    }
    text += "v 0 -1 0\n";
    let vertex = |i: u32, k: u32| 2 + (i - 1) * columns + k % columns;
    let last = 2 + (rings - 1) * columns;
    for k in 0..columns {
        text += &format!("f 1 {} {}\n", vertex(1, k), vertex(1, k + 1));
        for i in 1..rings - 1 {
            let [a, b, c, d] = [vertex(i, k), vertex(i + 1, k), vertex(i + 1, k + 1), vertex(i, k + 1)];
            text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
        }
        text += &format!("f {last} {} {}\n", vertex(rings - 1, k + 1), vertex(rings - 1, k));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponent_is_that_of_the_power() {
        let measures = |amount| CostMeasures { amount, ..CostMeasures::default() };
        let configuration = CostConfiguration { quantity: Quantity::Layers, setting: 8.0 };
        let exponent = |more: f64, over_first: f64| {
            let cells = cells(&configuration, (1, 1), (&measures(2.0), &measures(2.0 * more)), over_first);
            assert_eq!(cells.len(), COLUMNS.len());
            cells[8].number()
        };
        assert!((exponent(4.0, 8.0).unwrap_or(0.0) - 1.5).abs() < 1e-9);
        assert_eq!((exponent(1.0, 1.0), exponent(4.0, 1.0)), (None, Some(0.0)));
    }
}
