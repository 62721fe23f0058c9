//! A chart as a picture: cost across, error up, the front joined, the default ringed.

use super::{Chart, Panel};
use crate::BakeError;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

/// Width and height of a panel, pixels, and the height of what stands above and below all of them.
const PANEL: (u32, u32) = (620, 470);
const TITLE_HEIGHT: u32 = 40;
const LEGEND_ROW: u32 = 22;
const LEGEND_COLUMNS: u32 = 4;

/// Colours that the common kinds of colour blindness can tell apart (Okabe and Ito 2008).
const COLORS: [RGBColor; 8] = [
    RGBColor(60, 60, 60),
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(213, 94, 0),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(150, 135, 0),
];

fn fault(error: impl std::fmt::Display) -> BakeError {
    BakeError::Internal(format!("drawing a chart: {error}"))
}

/// The whole chart as SVG text.
///
/// # Errors
///
/// [`BakeError::Internal`] should plotters refuse.
pub fn svg(chart: &Chart) -> Result<String, BakeError> {
    let series = series(chart);
    let legend_rows = (series.len() as u32 + 2).div_ceil(LEGEND_COLUMNS);
    let legend_height = legend_rows * LEGEND_ROW + 12;
    let size = (PANEL.0 * chart.panels.len().max(1) as u32, PANEL.1 + TITLE_HEIGHT + legend_height);
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        root.fill(&WHITE).map_err(fault)?;
        let (title, rest) = root.split_vertically(TITLE_HEIGHT);
        let heading = ("sans-serif", 17).into_font().color(&BLACK).pos(Pos::new(HPos::Center, VPos::Center));
        title
            .draw(&Text::new(chart.title.clone(), (size.0 as i32 / 2, TITLE_HEIGHT as i32 / 2), heading))
            .map_err(fault)?;
        let (panels, legend) = rest.split_vertically(PANEL.1);
        for (area, panel) in panels.split_evenly((1, chart.panels.len().max(1))).iter().zip(&chart.panels) {
            draw_panel(area, chart, panel, &series)?;
        }
        draw_legend(&legend, &series)?;
        root.present().map_err(fault)?;
    }
    Ok(text)
}

/// The series in the order of first appearance.
fn series(chart: &Chart) -> Vec<&str> {
    let mut out: Vec<&str> = Vec::new();
    for row in &chart.rows {
        if !out.contains(&row.series.as_str()) {
            out.push(&row.series);
        }
    }
    out
}

fn color(index: usize) -> RGBColor {
    COLORS[index % COLORS.len()]
}

/// The range of an axis: decades where the values span more than one, else linear from zero.
struct Scale {
    log: bool,
    range: Range<f64>,
}

fn scale(values: impl Iterator<Item = f64>) -> Scale {
    let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
    for value in values {
        low = low.min(value);
        high = high.max(value);
    }
    if low > 0.0 && high > 10.0 * low && high.is_finite() {
        return Scale { log: true, range: low / 1.3..high * 1.3 };
    }
    Scale { log: false, range: 0.0..if high > 0.0 { 1.08 * high } else { 1.0 } }
}

impl Scale {
    /// Where a value stands along the axis, 0..=1.
    fn place(&self, value: f64) -> f64 {
        let (a, b) = (self.range.start, self.range.end);
        if self.log { (value / a).ln() / (b / a).ln() } else { (value - a) / (b - a) }
    }

    /// Where to write numbers: 1, 2 and 5 of each decade, or round steps.
    fn ticks(&self) -> Vec<f64> {
        let (a, b) = (self.range.start, self.range.end);
        if self.log {
            let decades = a.log10().floor() as i32..=b.log10().ceil() as i32;
            let wide = b > 300.0 * a;
            let digits: &[f64] = if wide { &[1.0] } else { &[1.0, 2.0, 5.0] };
            let all = decades.flat_map(|d| digits.iter().map(move |m| m * 10_f64.powi(d)));
            return all.filter(|x| (a..=b).contains(x)).collect();
        }
        let raw = (b - a) / 6.0;
        let decade = 10_f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * decade).into_iter().find(|s| *s >= raw).unwrap_or(raw);
        (0..=(b / step) as u32).map(|i| f64::from(i) * step).collect()
    }
}

fn label(value: f64) -> String {
    format!("{value:.2e}").parse::<f64>().unwrap_or(value).to_string()
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Distances from the panel's edges to the frame: left, right, top, bottom.
const MARGIN: [i32; 4] = [78, 18, 8, 56];

fn draw_panel(area: &Area<'_>, chart: &Chart, panel: &Panel, series: &[&str]) -> Result<(), BakeError> {
    let points = chart.points(panel);
    let (x_scale, y_scale) = (scale(points.iter().flatten().map(|p| p.0)), scale(points.iter().flatten().map(|p| p.1)));
    let (width, height) = area.dim_in_pixel();
    let [left, right, top, bottom] = MARGIN;
    let (frame_w, frame_h) = (width as i32 - left - right, height as i32 - top - bottom);
    let place = |(x, y): (f64, f64)| {
        let (u, v) = (x_scale.place(x), y_scale.place(y));
        (left + (u * f64::from(frame_w)).round() as i32, top + ((1.0 - v) * f64::from(frame_h)).round() as i32)
    };
    let grey = RGBColor(225, 225, 225);
    let small = |h, v| ("sans-serif", 12).into_font().color(&RGBColor(60, 60, 60)).pos(Pos::new(h, v));
    for tick in x_scale.ticks() {
        let (x, _) = place((tick, y_scale.range.start));
        area.draw(&PathElement::new([(x, top), (x, top + frame_h)], grey)).map_err(fault)?;
        let style = small(HPos::Center, VPos::Top);
        area.draw(&Text::new(label(tick), (x, top + frame_h + 6), style)).map_err(fault)?;
    }
    for tick in y_scale.ticks() {
        let (_, y) = place((x_scale.range.start, tick));
        area.draw(&PathElement::new([(left, y), (left + frame_w, y)], grey)).map_err(fault)?;
        area.draw(&Text::new(label(tick), (left - 7, y), small(HPos::Right, VPos::Center))).map_err(fault)?;
    }
    let frame = [(left, top), (left + frame_w, top + frame_h)];
    area.draw(&Rectangle::new(frame, RGBColor(120, 120, 120))).map_err(fault)?;
    let name = |h| ("sans-serif", 14).into_font().color(&BLACK).pos(Pos::new(h, VPos::Center));
    let across = (left + frame_w / 2, height as i32 - 18);
    area.draw(&Text::new(panel.cost_label, across, name(HPos::Center))).map_err(fault)?;
    let up = name(HPos::Center).transform(FontTransform::Rotate270);
    area.draw(&Text::new(panel.error_label, (16, top + frame_h / 2), up)).map_err(fault)?;

    let mut line: Vec<(f64, f64)> =
        points.iter().zip(chart.on_front(panel)).filter(|(_, on)| *on).filter_map(|(p, _)| *p).collect();
    line.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    let line: Vec<(i32, i32)> = line.into_iter().map(place).collect();
    area.draw(&PathElement::new(line, BLACK.mix(0.55).stroke_width(2))).map_err(fault)?;
    for (row, point) in chart.rows.iter().zip(&points) {
        let Some(at) = point.map(place) else { continue };
        let index = series.iter().position(|s| *s == row.series).unwrap_or_default();
        mark(area, at, color(index), row.default)?;
    }
    Ok(())
}

fn mark(area: &Area<'_>, at: (i32, i32), color: RGBColor, default: bool) -> Result<(), BakeError> {
    area.draw(&Circle::new(at, 5, color.filled())).map_err(fault)?;
    area.draw(&Circle::new(at, 5, WHITE.stroke_width(1))).map_err(fault)?;
    if default {
        area.draw(&Circle::new(at, 10, BLACK.stroke_width(2))).map_err(fault)?;
    }
    Ok(())
}

fn draw_legend(area: &Area<'_>, series: &[&str]) -> Result<(), BakeError> {
    let (width, _) = area.dim_in_pixel();
    let column = (width / LEGEND_COLUMNS) as i32;
    let style = ("sans-serif", 13).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
    let mut place = (0..).map(|i: i32| {
        let columns = LEGEND_COLUMNS as i32;
        (24 + (i % columns) * column, 10 + (i / columns) * LEGEND_ROW as i32)
    });
    for (index, name) in series.iter().enumerate() {
        let (x, y) = place.next().unwrap_or_default();
        mark(area, (x, y), color(index), false)?;
        area.draw(&Text::new(*name, (x + 14, y), style.clone())).map_err(fault)?;
    }
    let (x, y) = place.next().unwrap_or_default();
    area.draw(&Circle::new((x, y), 8, BLACK.stroke_width(2))).map_err(fault)?;
    area.draw(&Text::new("default", (x + 14, y), style.clone())).map_err(fault)?;
    let (x, y) = place.next().unwrap_or_default();
    area.draw(&PathElement::new([(x - 9, y), (x + 9, y)], BLACK.mix(0.55).stroke_width(2))).map_err(fault)?;
    area.draw(&Text::new("front: nothing is better in both", (x + 14, y), style)).map_err(fault)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::{Cell, Row};

    #[test]
    fn scales_hold_their_values_and_ticks() {
        for values in [&[0.0, 3.0][..], &[1.0, 2.0, 5.0], &[0.001, 0.5], &[1e-9, 1e6], &[0.0], &[]] {
            let scale = scale(values.iter().copied());
            assert!(values.iter().all(|v| (-1e-9..=1.0).contains(&scale.place(*v))), "{values:?}");
            let ticks = scale.ticks();
            assert!((2..=20).contains(&ticks.len()), "{values:?}: {ticks:?}");
            assert!(ticks.iter().all(|t| (-1e-9..=1.0 + 1e-9).contains(&scale.place(*t))), "{values:?}: {ticks:?}");
        }
    }

    #[test]
    fn every_row_with_figures_is_a_mark() {
        let row = |x: f64, default| Row {
            series: "<a & b>".into(),
            cells: vec![Cell::Number(x), Cell::Number(2.0 * x)],
            default,
            command: String::new(),
        };
        let panel = Panel { cost: "x", cost_label: "seconds", error: "y", error_label: "error, degrees" };
        let chart = Chart {
            topic: "t",
            title: "t".into(),
            adapter: String::new(),
            columns: vec!["x", "y"],
            rows: vec![row(1.0, true), row(2.0, false), row(f64::NAN, false)],
            panels: vec![panel],
        };
        let text = svg(&chart).unwrap_or_default();
        assert!(text.starts_with("<svg ") && text.trim_end().ends_with("</svg>"));
        // Two circles a mark: two rows and one in the legend; a ring for the default, and one in the legend.
        assert_eq!(text.matches("<circle").count(), 2 * 3 + 2);
        assert!(text.contains("seconds") && text.contains("error, degrees") && text.contains("&lt;a &amp; b&gt;"));
    }
}
