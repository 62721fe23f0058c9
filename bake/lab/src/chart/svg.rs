//! Drawing of a chart: cost on the horizontal axis, error on the vertical. Points of the Pareto front are joined, and
//! the default is ringed.

use super::axis::{self, Scale};
use super::{Chart, Panel, Row, labels};
use pelage_import::BakeError;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Width and height of a panel, pixels.
const PANEL: (u32, u32) = (620, 470);
/// Height of the title, pixels.
const TITLE_HEIGHT: u32 = 54;
/// Height of a row of the legend, pixels.
const LEGEND_ROW: u32 = 22;

/// Colours that are distinguishable with the common kinds of colour blindness (Okabe and Ito 2008).
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

/// Returns the whole chart as SVG text, two panels per row.
///
/// # Errors
///
/// [`BakeError::Internal`] if plotters fails.
pub fn svg(chart: &Chart) -> Result<String, BakeError> {
    let series = series(chart);
    let across = chart.panels.len().clamp(1, 2);
    let down = chart.panels.len().max(1).div_ceil(across);
    let width = PANEL.0 * across as u32;
    let legend_height = (series.len() as u32 + 2).div_ceil(legend_columns(width)) * LEGEND_ROW + 12;
    let size = (width, PANEL.1 * down as u32 + TITLE_HEIGHT + legend_height);
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        root.fill(&WHITE).map_err(fault)?;
        let (title, rest) = root.split_vertically(TITLE_HEIGHT);
        let heading = |size, color: RGBColor| {
            ("sans-serif", size).into_font().color(&color).pos(Pos::new(HPos::Center, VPos::Center))
        };
        let middle = size.0 as i32 / 2;
        title.draw(&Text::new(chart.title.clone(), (middle, 18), heading(17, BLACK))).map_err(fault)?;
        let adapter = format!("measured on {}", chart.adapter);
        title.draw(&Text::new(adapter, (middle, 38), heading(12, RGBColor(90, 90, 90)))).map_err(fault)?;
        let (panels, legend) = rest.split_vertically(PANEL.1 * down as u32);
        for (area, panel) in panels.split_evenly((down, across)).iter().zip(&chart.panels) {
            draw_panel(area, chart, panel, &series)?;
        }
        draw_legend(&legend, &series)?;
        root.present().map_err(fault)?;
    }
    Ok(text)
}

fn legend_columns(width: u32) -> u32 {
    width / 310
}

/// Returns the series in the order of first appearance.
fn series(chart: &Chart) -> Vec<&str> {
    let mut out: Vec<&str> = Vec::new();
    for row in &chart.rows {
        if !out.contains(&row.series.as_str()) {
            out.push(&row.series);
        }
    }
    out
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Distances from the panel's edges to the frame: left, right, top, bottom.
const MARGIN: [i32; 4] = [78, 18, 8, 60];

/// Radius of a mark, pixels.
const MARK: i32 = 5;
/// Radius of the ring around the default, pixels.
const RING: i32 = 10;
/// Height of a letter beside a mark, pixels.
const LABEL: i32 = 11;

fn draw_panel(area: &Area<'_>, chart: &Chart, panel: &Panel, series: &[&str]) -> Result<(), BakeError> {
    let points = chart.points(panel);
    let (x_scale, y_scale) =
        (Scale::of(points.iter().flatten().map(|p| p.0)), Scale::of(points.iter().flatten().map(|p| p.1)));
    let (width, height) = area.dim_in_pixel();
    let [left, right, top, bottom] = MARGIN;
    let (frame_w, frame_h) = (width as i32 - left - right, height as i32 - top - bottom);
    let place = |(x, y): (f64, f64)| {
        let (u, v) = (x_scale.position(x), y_scale.position(y));
        (left + (u * f64::from(frame_w)).round() as i32, top + ((1.0 - v) * f64::from(frame_h)).round() as i32)
    };
    let (x_ticks, y_ticks) = (x_scale.ticks(), y_scale.ticks());
    let across = |value: f64| place((value, y_scale.range.start)).0;
    let up = |value: f64| place((x_scale.range.start, value)).1;
    let vertical = |value: f64| [(across(value), top), (across(value), top + frame_h)];
    let level = |value: f64| [(left, up(value)), (left + frame_w, up(value))];
    for (lines, grey) in [(&x_ticks.minor, 242), (&x_ticks.major, 222)] {
        for value in lines {
            area.draw(&PathElement::new(vertical(*value), RGBColor(grey, grey, grey))).map_err(fault)?;
        }
    }
    for (lines, grey) in [(&y_ticks.minor, 242), (&y_ticks.major, 222)] {
        for value in lines {
            area.draw(&PathElement::new(level(*value), RGBColor(grey, grey, grey))).map_err(fault)?;
        }
    }
    let small = |h, v| ("sans-serif", 12).into_font().color(&RGBColor(60, 60, 60)).pos(Pos::new(h, v));
    for value in &x_ticks.major {
        let at = (across(*value), top + frame_h + 6);
        area.draw(&Text::new(axis::label(*value), at, small(HPos::Center, VPos::Top))).map_err(fault)?;
    }
    for value in &y_ticks.major {
        let at = (left - 7, up(*value));
        area.draw(&Text::new(axis::label(*value), at, small(HPos::Right, VPos::Center))).map_err(fault)?;
    }
    let frame = [(left, top), (left + frame_w, top + frame_h)];
    area.draw(&Rectangle::new(frame, RGBColor(120, 120, 120))).map_err(fault)?;
    let name = |h| ("sans-serif", 14).into_font().color(&BLACK).pos(Pos::new(h, VPos::Center));
    let at = (left + frame_w / 2, height as i32 - 22);
    area.draw(&Text::new(panel.cost_label, at, name(HPos::Center))).map_err(fault)?;
    let upwards = name(HPos::Center).transform(FontTransform::Rotate270);
    area.draw(&Text::new(panel.error_label, (16, top + frame_h / 2), upwards)).map_err(fault)?;

    let on_front = chart.on_front(panel);
    let line = stairs(&points, &on_front, place, (left + frame_w, top));
    area.draw(&PathElement::new(line.clone(), BLACK.mix(0.5).stroke_width(2))).map_err(fault)?;
    // Draws rows of the Pareto front after the others, and the default last. Labels are placed in the opposite order.
    let mut order: Vec<usize> = (0..chart.rows.len()).filter(|i| points[*i].is_some()).collect();
    order.sort_by_key(|i| (chart.rows[*i].default, on_front[*i]));
    let at = |i: usize| points[i].map(place).unwrap_or_default();
    for i in &order {
        let row = &chart.rows[*i];
        let index = series.iter().position(|s| *s == row.series).unwrap_or_default();
        mark(area, at(*i), index, row.default)?;
    }
    order.reverse();
    let radius = |row: &Row| if row.default { RING + 1 } else { MARK + 1 };
    let marks: Vec<_> =
        order.iter().map(|i| (at(*i), radius(&chart.rows[*i]), chart.rows[*i].label.as_str())).collect();
    let style =
        ("sans-serif", LABEL).into_font().color(&RGBColor(90, 90, 90)).pos(Pos::new(HPos::Center, VPos::Center));
    let frame = [left, top, left + frame_w, top + frame_h];
    for label in labels::place_labels(&marks, &along(&line), frame, LABEL) {
        area.draw(&Text::new(marks[label.mark].2, label.at, style.clone())).map_err(fault)?;
    }
    Ok(())
}

/// Returns the Pareto front as steps from least cost to least error. At each cost, a step shows the least error
/// available for at most that cost. The line begins at the top of the frame and ends at its right edge; `end` is the
/// upper right corner of the frame.
fn stairs(
    points: &[Option<(f64, f64)>],
    on_front: &[bool],
    place: impl Fn((f64, f64)) -> (i32, i32),
    end: (i32, i32),
) -> Vec<(i32, i32)> {
    let mut front: Vec<(f64, f64)> =
        points.iter().zip(on_front).filter(|(_, on)| **on).filter_map(|(p, _)| *p).collect();
    front.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    let mut line: Vec<(i32, i32)> = Vec::new();
    for (x, y) in front.into_iter().map(place) {
        let from = line.last().map_or(end.1, |last| last.1);
        line.extend([(x, from), (x, y)]);
    }
    line.extend(line.last().map(|last| (end.0, last.1)));
    line
}

/// Returns points on a line of horizontal and vertical pieces, spaced so densely that no label fits between them.
fn along(line: &[(i32, i32)]) -> Vec<(i32, i32)> {
    let piece = |ends: &[(i32, i32)]| {
        let (a, b) = (ends[0], ends[1]);
        let steps = (b.0 - a.0).abs().max((b.1 - a.1).abs()) / 4 + 1;
        (0..=steps).map(move |i| (a.0 + (b.0 - a.0) * i / steps, a.1 + (b.1 - a.1) * i / steps)).collect::<Vec<_>>()
    };
    line.windows(2).flat_map(piece).collect()
}

/// Corners of the mark shapes; the first shape has none, because it is a circle. Each series has a colour and a shape,
/// so that the chart is readable without colour.
const SHAPES: [&[(i32, i32)]; 7] = [
    &[],
    &[(-5, -5), (5, -5), (5, 5), (-5, 5)],
    &[(0, -6), (6, 5), (-6, 5)],
    &[(0, -7), (7, 0), (0, 7), (-7, 0)],
    &[(0, 6), (6, -5), (-6, -5)],
    &[(-2, -6), (2, -6), (2, -2), (6, -2), (6, 2), (2, 2), (2, 6), (-2, 6), (-2, 2), (-6, 2), (-6, -2), (-2, -2)],
    &[(-6, -3), (0, -6), (6, -3), (6, 3), (0, 6), (-6, 3)],
];

fn mark(area: &Area<'_>, at: (i32, i32), index: usize, default: bool) -> Result<(), BakeError> {
    let color = COLORS[index % COLORS.len()];
    let shape = SHAPES[index % SHAPES.len()];
    if shape.is_empty() {
        area.draw(&Circle::new(at, MARK, color.filled())).map_err(fault)?;
        area.draw(&Circle::new(at, MARK, WHITE.stroke_width(1))).map_err(fault)?;
    } else {
        let corners: Vec<_> = shape.iter().map(|(x, y)| (at.0 + x, at.1 + y)).collect();
        area.draw(&Polygon::new(corners.clone(), color.filled())).map_err(fault)?;
        let outline = corners.iter().chain(&corners[..1]).copied().collect::<Vec<_>>();
        area.draw(&PathElement::new(outline, WHITE.stroke_width(1))).map_err(fault)?;
    }
    if default {
        area.draw(&Circle::new(at, RING, BLACK.stroke_width(2))).map_err(fault)?;
    }
    Ok(())
}

fn draw_legend(area: &Area<'_>, series: &[&str]) -> Result<(), BakeError> {
    let (width, _) = area.dim_in_pixel();
    let columns = legend_columns(width) as i32;
    let column = width as i32 / columns;
    let style = ("sans-serif", 13).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
    let mut place = (0..).map(|i: i32| (24 + (i % columns) * column, 10 + (i / columns) * LEGEND_ROW as i32));
    for (index, name) in series.iter().enumerate() {
        let (x, y) = place.next().unwrap_or_default();
        mark(area, (x, y), index, false)?;
        area.draw(&Text::new(*name, (x + 14, y), style.clone())).map_err(fault)?;
    }
    let (x, y) = place.next().unwrap_or_default();
    area.draw(&Circle::new((x, y), RING - 2, BLACK.stroke_width(2))).map_err(fault)?;
    area.draw(&Text::new("ringed: the default", (x + 14, y), style.clone())).map_err(fault)?;
    let (x, y) = place.next().unwrap_or_default();
    area.draw(&PathElement::new([(x - 9, y), (x + 9, y)], BLACK.mix(0.5).stroke_width(2))).map_err(fault)?;
    area.draw(&Text::new("Pareto front", (x + 14, y), style)).map_err(fault)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::Cell;

    #[test]
    fn every_row_with_finite_figures_has_a_mark() {
        let row = |x: f64, default| Row {
            series: "<a & b>".into(),
            label: format!("at {x}"),
            cells: vec![Cell::Number(x), Cell::Number(2.0 * x)],
            default,
            command: String::new(),
        };
        let panel = Panel { cost: "x", cost_label: "seconds", error: "y", error_label: "error, degrees", only: None };
        let chart = Chart {
            topic: "t",
            title: "t".into(),
            adapter: "a quick one".into(),
            columns: vec!["x", "y"],
            rows: vec![row(1.0, true), row(2.0, false), row(f64::NAN, false)],
            panels: vec![panel],
        };
        let text = svg(&chart).unwrap_or_default();
        assert!(text.starts_with("<svg ") && text.trim_end().ends_with("</svg>"));
        // Each mark consists of two circles; two rows and the legend have a mark each. The ring of the default and its
        // legend entry add two circles.
        assert_eq!(text.matches("<circle").count(), 2 * 3 + 2);
        assert!(text.contains("at 2") && text.contains("a quick one") && !text.contains("at NaN"), "{text}");
        assert!(text.contains("seconds") && text.contains("error, degrees") && text.contains("&lt;a &amp; b&gt;"));
    }
}
