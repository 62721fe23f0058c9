//! Labels beside marks. A label that would overlap another label or a mark is omitted; its value is still in the table.

/// Box in pixels: left, top, right, bottom.
type Rect = [i32; 4];

fn overlap(a: &Rect, b: &Rect) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// Largest distance between marks that count as one group, pixels.
const SAME_POSITION_PX: i32 = 3;

/// Label with a position.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlacedLabel {
    /// Index of the mark.
    pub mark: usize,
    /// Centre of the label, pixels.
    pub at: (i32, i32),
}

/// Places labels.
///
/// * `marks`: position of each mark in pixels, radius and label, most important first; of marks at about the same
///   position, only one is labelled
/// * `obstacles`: other points that no label may cover, such as those of a line
/// * `frame`: left, top, right and bottom bounds for labels
/// * `font`: height of a letter; its mean width is 0.54 times that
pub fn place_labels(
    marks: &[((i32, i32), i32, &str)],
    obstacles: &[(i32, i32)],
    frame: [i32; 4],
    font: i32,
) -> Vec<PlacedLabel> {
    let around = |(x, y): (i32, i32), r: i32| [x - r, y - r, x + r, y + r];
    let mut taken: Vec<Rect> = marks.iter().map(|(at, radius, _)| around(*at, *radius)).collect();
    taken.extend(obstacles.iter().map(|at| around(*at, 1)));
    let mut out: Vec<PlacedLabel> = Vec::new();
    for (mark, ((x, y), radius, text)) in marks.iter().enumerate().filter(|(_, (.., text))| !text.is_empty()) {
        let apart = |(at, ..): &((i32, i32), i32, &str)| (at.0 - x).abs().max((at.1 - y).abs());
        if out.iter().any(|other| apart(&marks[other.mark]) <= SAME_POSITION_PX) {
            continue;
        }
        let here = marks.iter().filter(|other| apart(other) <= SAME_POSITION_PX);
        let radius = here.fold(*radius, |most, other| most.max(other.1 + apart(other)));
        let width = (text.chars().count() as f32 * font as f32 * 0.54).ceil() as i32 + 2;
        let (right, left, above, below) =
            (x + radius + 3, x - radius - 3 - width, y - radius - font / 2 - 1, y + radius + font / 2 + 1);
        let middle = x - width / 2;
        let tries = [
            (right, *y),
            (left, *y),
            (middle, above),
            (middle, below),
            (right - 2, above + 3),
            (right - 2, below - 3),
            (left + 2, above + 3),
            (left + 2, below - 3),
        ];
        let free = tries.into_iter().find_map(|(left, middle)| {
            let rect = [left, middle - font / 2 - 1, left + width, middle + font / 2 + 1];
            let inside = rect[0] > frame[0] && rect[1] > frame[1] && rect[2] < frame[2] && rect[3] < frame[3];
            (inside && !taken.iter().any(|other| overlap(&rect, other))).then_some((rect, (left + width / 2, middle)))
        });
        if let Some((rect, at)) = free {
            taken.push(rect);
            out.push(PlacedLabel { mark, at });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: [i32; 4] = [0, 0, 200, 100];

    #[test]
    fn labels_overlap_neither_marks_nor_labels() {
        // The marks are so close together on a line that not all labels fit.
        let marks: Vec<_> = (0..30).map(|i| ((20 + 5 * i, 50), 5, "256²")).collect();
        let placed = place_labels(&marks, &[], FRAME, 11);
        assert!(placed.len() >= 4 && placed.len() < marks.len(), "{placed:?}");
        let rect = |p: &PlacedLabel| [p.at.0 - 12, p.at.1 - 6, p.at.0 + 12, p.at.1 + 6];
        for (i, a) in placed.iter().enumerate() {
            assert!(placed[..i].iter().all(|b| !overlap(&rect(a), &rect(b))), "{placed:?}");
            assert!(marks.iter().all(|((x, y), ..)| !overlap(&rect(a), &[x - 5, y - 5, x + 5, y + 5])), "{placed:?}");
        }
    }

    #[test]
    fn chart_labels_stay_within_the_frame() {
        let right = place_labels(&[((195, 50), 5, "a long word")], &[], FRAME, 11);
        assert!(right[0].at.0 < 160 && right[0].at.0 > 0);
        assert_eq!(place_labels(&[((100, 50), 5, &"x".repeat(60))], &[], FRAME, 11), []);
        // Marks at one position get one label: that of the first mark that has one.
        let spot = [((50, 50), 10, ""), ((50, 51), 5, "a"), ((51, 50), 5, "b")];
        assert_eq!(place_labels(&spot, &[], FRAME, 11).iter().map(|p| p.mark).collect::<Vec<_>>(), [1]);
        // A label is to the right of its mark, unless that position is occupied.
        assert_eq!(place_labels(&[((50, 50), 5, "a")], &[], FRAME, 11)[0].at, (62, 50));
        assert_ne!(place_labels(&[((50, 50), 5, "a")], &[(60, 50)], FRAME, 11)[0].at, (62, 50));
    }
}
