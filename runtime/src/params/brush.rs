//! Parameters of painted ink strokes.

use crate::error::RuntimeError;
use std::ops::RangeInclusive;

/// Sheet that a painting is on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum BrushSheet {
    /// Raw paper: water spreads, and edges feather.
    #[default]
    Raw,
    /// Paper sized with alum: water stays where the brush left it, and pigment gathers at the edges.
    Sized,
    /// Silk: a warm tone, with threads that show through.
    Silk,
}

/// Parameters of the strokes in [`crate::InkLines::Strokes`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct BrushParams {
    /// Approximate number of brush strokes on an animal, without tufts of fur, 4..=200 (default 60). Few strokes leave
    /// more paper.
    pub strokes: f32,
    /// Factor on the density of the washes, 0..=2 (default 1). With 0, only lines, spots and tufts are painted.
    pub wash: f32,
    /// Wetness of the washes, 0..=1 (default 0.6): how far pigment spreads within them, and how much of it gathers at
    /// their edges.
    pub wetness: f32,
    /// Dryness of the brush, 0..=1 (default 0.5): how early a stroke breaks up into the marks of single bristles.
    pub dryness: f32,
    /// Number of tufts of fur on an animal, 0..=200 (default 45). Below 10, locks of guided hair shorten; with 0, they
    /// are not painted.
    pub tufts: f32,
    /// Factor on the width of lines, 0..=4 (default 1).
    pub line_width: f32,
    /// Share of the contour that is left out where the washes already show it, 0..=1 (default 1). With 0, the contour
    /// is complete.
    pub omission: f32,
    /// Density of the wash on the ground below an animal, 0..=1 (default 0.5).
    pub ground: f32,
    /// Sheet that the painting is on (default raw paper).
    pub sheet: BrushSheet,
    /// Share of the painting that is done, 0..=1 (default 1): strokes appear one after the other, from the washes to
    /// the fur.
    pub progress: f32,
}

impl Default for BrushParams {
    fn default() -> Self {
        Self {
            strokes: 60.0,
            wash: 1.0,
            wetness: 0.6,
            dryness: 0.5,
            tufts: 45.0,
            line_width: 1.0,
            omission: 1.0,
            ground: 0.5,
            sheet: BrushSheet::Raw,
            progress: 1.0,
        }
    }
}

impl BrushParams {
    /// Returns the parameters with changes: `BrushParams::default().with(|b| b.strokes = 30.0)`.
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }

    pub(super) fn check(&self) -> Result<(), RuntimeError> {
        let ranges: [(&str, f32, RangeInclusive<f32>); 9] = [
            ("BrushParams::strokes", self.strokes, 4.0..=200.0),
            ("BrushParams::wash", self.wash, 0.0..=2.0),
            ("BrushParams::wetness", self.wetness, 0.0..=1.0),
            ("BrushParams::dryness", self.dryness, 0.0..=1.0),
            ("BrushParams::tufts", self.tufts, 0.0..=200.0),
            ("BrushParams::line_width", self.line_width, 0.0..=4.0),
            ("BrushParams::omission", self.omission, 0.0..=1.0),
            ("BrushParams::ground", self.ground, 0.0..=1.0),
            ("BrushParams::progress", self.progress, 0.0..=1.0),
        ];
        // NaN is in no range.
        match ranges.into_iter().find(|(_, value, range)| !range.contains(value)) {
            Some((field, value, range)) => Err(RuntimeError::Params {
                field,
                found: value.to_string(),
                expected: format!("{}..={}", range.start(), range.end()),
            }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::InkParams;

    type Field = fn(&mut BrushParams) -> &mut f32;

    const FIELDS: [(&str, Field, [f32; 2]); 9] = [
        ("BrushParams::strokes", |b| &mut b.strokes, [4.0, 200.0]),
        ("BrushParams::wash", |b| &mut b.wash, [0.0, 2.0]),
        ("BrushParams::wetness", |b| &mut b.wetness, [0.0, 1.0]),
        ("BrushParams::dryness", |b| &mut b.dryness, [0.0, 1.0]),
        ("BrushParams::tufts", |b| &mut b.tufts, [0.0, 200.0]),
        ("BrushParams::line_width", |b| &mut b.line_width, [0.0, 4.0]),
        ("BrushParams::omission", |b| &mut b.omission, [0.0, 1.0]),
        ("BrushParams::ground", |b| &mut b.ground, [0.0, 1.0]),
        ("BrushParams::progress", |b| &mut b.progress, [0.0, 1.0]),
    ];

    #[test]
    fn every_value_is_checked() {
        assert!(InkParams::default().check().is_ok());
        for (name, field, [low, high]) in FIELDS {
            let ink = |value| InkParams::default().with(|ink| *field(&mut ink.brush) = value);
            for value in [low, high] {
                assert!(ink(value).check().is_ok(), "{name} = {value}");
            }
            for value in [low - 0.01, high + 0.01, f32::NAN, f32::INFINITY] {
                let Err(RuntimeError::Params { field, found, expected }) = ink(value).check() else {
                    panic!("{name} = {value} is accepted")
                };
                assert_eq!((field, found, expected), (name, value.to_string(), format!("{low}..={high}")));
            }
        }
    }
}
