//! Vector pictures (SVG) of paintings: one path per stroke, in the order in which they are painted.

use pelage_runtime::{PictureStroke, StrokeLayer, StrokeMark};
use std::fmt::Write as _;

/// Identifiers of the groups, in order.
const GROUPS: [(&str, &[StrokeLayer]); 3] = [
    ("washes", &[StrokeLayer::Ground, StrokeLayer::Wash]),
    ("lines", &[StrokeLayer::Dark, StrokeLayer::Bone, StrokeLayer::Spot, StrokeLayer::Eye, StrokeLayer::Line]),
    ("fur", &[StrokeLayer::Tuft, StrokeLayer::Lock]),
];

/// Maximum distance between a path and its stroke, pixels.
const TOLERANCE: f32 = 0.2;

/// Returns the picture as SVG.
///
/// * `strokes`: in the order in which they are painted
/// * `size`: width and height, pixels
/// * `paper`, `ink`: colours, sRGB
pub fn svg(strokes: &[PictureStroke], (width, height): (u32, u32), paper: [u8; 3], ink: [u8; 3]) -> String {
    let color = |[r, g, b]: [u8; 3]| format!("#{r:02x}{g:02x}{b:02x}");
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\">\n<rect width=\"100%\" height=\"100%\" fill=\"{}\"/>\n",
        color(paper)
    );
    for (id, layers) in GROUPS {
        let _ = writeln!(out, "<g id=\"{id}\" fill=\"{}\">", color(ink));
        for stroke in strokes.iter().filter(|stroke| layers.contains(&stroke.layer)) {
            write_stroke(&mut out, stroke);
        }
        out.push_str("</g>\n");
    }
    out.push_str("</svg>\n");
    out
}

/// Writes the outline of a stroke. The attributes `data-*` hold its centre line with its width, density and dryness, so
/// that a program can paint it with a brush of its own.
fn write_stroke(out: &mut String, stroke: &PictureStroke) {
    let marks = simplified(&stroke.marks);
    let Some(outline) = outline(&marks) else { return };
    let density = marks.iter().map(|mark| mark.density).sum::<f32>() / marks.len() as f32;
    let opacity = 1.0 - libm::expf(-density);
    let layer = format!("{:?}", stroke.layer).to_lowercase();
    let _ = write!(
        out,
        "<path data-layer=\"{layer}\" data-number=\"{}.{}\" fill-opacity=\"{opacity:.3}\" d=\"M",
        stroke.instance, stroke.number
    );
    for [x, y] in outline {
        let _ = write!(out, "{x:.2} {y:.2} ");
    }
    out.push_str("Z\"");
    let mut list = |name: &str, value: &dyn Fn(&StrokeMark) -> String| {
        let values: Vec<String> = marks.iter().map(value).collect();
        let _ = write!(out, " data-{name}=\"{}\"", values.join(" "));
    };
    list("line", &|mark| format!("{:.2},{:.2}", mark.position[0], mark.position[1]));
    list("width", &|mark| format!("{:.2}", 2.0 * mark.half_width));
    list("density", &|mark| format!("{:.3}", mark.density));
    list("dryness", &|mark| format!("{:.3}", mark.dryness));
    out.push_str("/>\n");
}

/// Returns the points without those that lie between others (Ramer 1972, Douglas and Peucker 1973). Width counts as a
/// third coordinate.
fn simplified(marks: &[StrokeMark]) -> Vec<StrokeMark> {
    let place = |mark: &StrokeMark| glam::Vec3::new(mark.position[0], mark.position[1], mark.half_width);
    let mut keeps = vec![false; marks.len()];
    let mut open = Vec::new();
    if let Some(last) = marks.len().checked_sub(1) {
        (keeps[0], keeps[last]) = (true, true);
        open.push((0, last));
    }
    while let Some((from, to)) = open.pop() {
        let (a, b) = (place(&marks[from]), place(&marks[to]));
        let off = |k: usize| {
            let t = ((place(&marks[k]) - a).dot(b - a) / (b - a).length_squared().max(1e-9)).clamp(0.0, 1.0);
            place(&marks[k]).distance(a.lerp(b, t))
        };
        let farthest = (from + 1..to).map(|k| (off(k), k)).max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, k)) = farthest.filter(|(off, _)| *off > TOLERANCE) {
            keeps[k] = true;
            open.extend([(from, k), (k, to)]);
        }
    }
    marks.iter().zip(keeps).filter(|(_, keeps)| *keeps).map(|(mark, _)| *mark).collect()
}

/// Returns the outline of a stroke: one side, then the other side backwards. `None` for a stroke of a single point.
fn outline(marks: &[StrokeMark]) -> Option<Vec<[f32; 2]>> {
    let last = marks.len().checked_sub(1).filter(|last| *last > 0)?;
    let place = |k: usize| glam::Vec2::from(marks[k].position);
    let side = |k: usize, sign: f32| {
        let along = (place((k + 1).min(last)) - place(k.saturating_sub(1))).normalize_or_zero();
        (place(k) + along.perp() * sign * marks[k].half_width).to_array()
    };
    Some((0..=last).map(|k| side(k, 1.0)).chain((0..=last).rev().map(|k| side(k, -1.0))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mark(x: f32, y: f32, half_width: f32) -> StrokeMark {
        StrokeMark { position: [x, y], half_width, density: 1.0, dryness: 0.25 }
    }

    #[test]
    fn straight_parts_need_two_points_and_bends_and_swells_keep_theirs() {
        let line: Vec<StrokeMark> = (0..20).map(|k| mark(k as f32, 0.0, 2.0)).collect();
        assert_eq!(simplified(&line).len(), 2);
        let swollen: Vec<StrokeMark> =
            (0..21).map(|k| mark(k as f32, 0.0, 2.0 + if k == 10 { 3.0 } else { 0.0 })).collect();
        assert!(simplified(&swollen).iter().any(|m| m.half_width == 5.0));
        let bent = [mark(0.0, 0.0, 1.0), mark(5.0, 5.0, 1.0), mark(10.0, 0.0, 1.0)];
        assert_eq!(simplified(&bent).len(), 3);
        assert_eq!((simplified(&[]).len(), simplified(&bent[..1]).len()), (0, 1));
    }

    #[test]
    fn outlines_are_as_wide_as_the_stroke() {
        let found = outline(&[mark(0.0, 0.0, 1.0), mark(10.0, 0.0, 3.0)]).unwrap();
        assert_eq!(found, [[0.0, 1.0], [10.0, 3.0], [10.0, -3.0], [0.0, -1.0]]);
        assert_eq!(outline(&[mark(0.0, 0.0, 1.0)]), None);
    }

    #[test]
    fn groups_follow_the_order_of_painting() {
        let stroke = |layer, number| PictureStroke {
            instance: 0,
            layer,
            number,
            marks: vec![mark(0.0, 0.0, 1.0), mark(10.0, 0.0, 1.0)],
        };
        let strokes = [stroke(StrokeLayer::Wash, 1), stroke(StrokeLayer::Line, 2), stroke(StrokeLayer::Tuft, 3)];
        let text = svg(&strokes, (40, 30), [255; 3], [0; 3]);
        let at = |part: &str| text.find(part).unwrap_or_else(|| panic!("{part} is not in {text}"));
        assert!(at("id=\"washes\"") < at("data-number=\"0.1\"") && at("data-number=\"0.1\"") < at("id=\"lines\""));
        assert!(at("data-number=\"0.2\"") < at("id=\"fur\"") && at("id=\"fur\"") < at("data-number=\"0.3\""));
        assert!(text.contains("data-width=\"2.00 2.00\"") && text.contains("viewBox=\"0 0 40 30\""));
    }
}
