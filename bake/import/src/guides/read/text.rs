//! Strands as text, as written by `pelage export`.

use super::source::Source;
use crate::error::BakeError;
use crate::guides::Guides;
use glam::Vec3;

pub(super) fn read(source: Source<'_>) -> Result<Guides, BakeError> {
    let text = std::str::from_utf8(source.bytes)
        .map_err(|error| source.fault(format!("byte {}", error.valid_up_to()), "not text, expected UTF-8"))?;
    let mut guides = Guides::default();
    let (mut points, mut radii) = (Vec::new(), Vec::new());
    let mut columns = None;
    for (number, line) in (1..).zip(text.lines()) {
        if line.trim().is_empty() {
            finish(&mut guides, &mut points, &mut radii);
            continue;
        }
        let fault = |reason: String| source.fault(format!("line {number}"), reason);
        let mut numbers = Vec::new();
        for word in line.split_whitespace() {
            let number: f32 = word.parse().map_err(|_| fault(format!("{word:?}, expected a number")))?;
            if !number.is_finite() {
                return Err(fault(format!("{word}, expected a finite number")));
            }
            numbers.push(number);
        }
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

fn finish(guides: &mut Guides, points: &mut Vec<Vec3>, radii: &mut Vec<f32>) {
    if !points.is_empty() {
        guides.push(points, radii, &[]);
        points.clear();
        radii.clear();
    }
}
