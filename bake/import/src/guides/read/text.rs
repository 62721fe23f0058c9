//! Strands as text, as written by `pelage export`.

use super::source::Source;
use crate::error::BakeError;
use crate::guides::Guides;
use glam::Vec3;

pub(super) fn read(source: Source<'_>) -> Result<Guides, BakeError> {
    let text = source.text()?;
    let mut guides = Guides::default();
    let (mut points, mut radii) = (Vec::new(), Vec::new());
    let mut columns = None;
    for (number, line) in (1..).zip(text.lines()) {
        if line.starts_with('#') {
            continue;
        }
        let words: Vec<&str> = line.split(is_between).filter(|word| !word.is_empty()).collect();
        if words.is_empty() {
            finish(&mut guides, &mut points, &mut radii);
            continue;
        }
        let fault = |reason: String| source.fault(format!("line {number}"), reason);
        let numbers: Vec<Option<f32>> = words.iter().map(|word| parse(word)).collect();
        if number == 1 && numbers.iter().all(Option::is_none) && words.len() > 2 {
            // Names of the columns.
            continue;
        }
        if let Some(i) = numbers.iter().position(Option::is_none) {
            return Err(fault(format!("{:?}, expected a number", words[i])));
        }
        let numbers: Vec<f32> = numbers.into_iter().flatten().collect();
        let found = numbers.len();
        if !(3..=4).contains(&found) || *columns.get_or_insert(found) != found {
            let expected = columns.map_or("x y z, or x y z radius".into(), |n| format!("{n}, as in the lines before"));
            return Err(fault(format!("{found} numbers, expected {expected}")));
        }
        points.push(Vec3::new(numbers[0], numbers[1], numbers[2]));
        radii.extend(numbers.get(3));
    }
    finish(&mut guides, &mut points, &mut radii);
    Ok(guides)
}

/// Returns whether a character separates numbers.
fn is_between(c: char) -> bool {
    c.is_whitespace() || c == ',' || c == ';'
}

/// Parses a number. C libraries of Windows print numbers that are not finite as `1.#QNAN`, `-nan(ind)` or similar.
fn parse(word: &str) -> Option<f32> {
    let bare = word.trim_start_matches(['-', '+']);
    let is_nan = bare.starts_with("1.#") || bare.get(..4).is_some_and(|start| start.eq_ignore_ascii_case("nan("));
    if is_nan { Some(f32::NAN) } else { word.parse().ok() }
}

fn finish(guides: &mut Guides, points: &mut Vec<Vec3>, radii: &mut Vec<f32>) {
    if !points.is_empty() {
        guides.push(points, radii, &[]);
        points.clear();
        radii.clear();
    }
}
