//! The `STRO` section: strokes of a painted model, attached to its surface. Layout in `FORMAT.md`, "STRO".

use super::kind::Kind;
use crate::encoding::{decode_section, encode_section};
use crate::error::FormatError;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

impl Tag {
    /// Strokes of a painted model, since version 3. At most one.
    pub const STROKES: Self = Self(*b"STRO");
}

pub(crate) const KIND: Kind =
    Kind::optional(Tag::STROKES, 3, "[strokes of a painting](#stro-strokes-of-a-painting)", |package, _| {
        package.stroke_pool().map(drop)
    });

/// Strokes with which a model is painted, attached to its surface. They cover the whole surface; a frame draws some of
/// those that face the eye.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StrokePool {
    /// Diagonal of the model's bounding box at rest, metres, above 0.
    pub size_m: f32,
    /// Strokes, at most [`Self::MOST`].
    pub strokes: Vec<PaintStroke>,
}

/// Stroke attached to the surface of a model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PaintStroke {
    /// Role of the stroke.
    pub kind: StrokeKind,
    /// Rank among the strokes of its kind, 0..=1: the most important stroke has rank 0.
    pub rank: f32,
    /// Seed of the stroke's irregularities.
    pub seed: u32,
    /// Colour of the pigment, linear RGB, 0..=1 each; `None` for ink.
    pub pigment: Option<[f32; 3]>,
    /// Points from the beginning to the end of the stroke; [`Self::POINTS`] of them.
    pub points: Vec<StrokePoint>,
}

/// Role of a stroke in a painting.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum StrokeKind {
    /// Broad pale stroke of the first wash.
    #[default]
    Pale,
    /// Stroke of the second wash, laid where the tone is darker.
    Middle,
    /// Narrow stroke of dark ink, laid where the tone is darkest.
    Dark,
    /// Thin part, painted with a single stroke along its axis.
    Bone,
    /// Small dark spot, such as a nose or a hoof, or a line of the face: nostril or mouth.
    Spot,
    /// Eye.
    Eye,
    /// Tuft of fur.
    Tuft,
    /// Lock of guided hair.
    Lock,
}

/// Point of a stroke.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StrokePoint {
    /// Two points of the surface; the stroke's point is midway between them. They are equal for a stroke on the
    /// surface, and opposite to each other for a stroke along the axis of a limb.
    pub sides: [StrokeAnchor; 2],
    /// Position relative to the first of these points, in the frame of its triangle
    /// ([`crate::meaning::hair_groups::triangle_frame`]), metres; `None` for a point midway between the two.
    pub offset_m: Option<[f32; 3]>,
    /// Half width of the stroke, metres, at least 0.
    pub half_width_m: f32,
    /// Darkness of the surface's colour, 0 for white to 1 for black; for spots and eyes, amount of ink.
    pub darkness: f32,
}

/// Point on a triangle of the mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StrokeAnchor {
    /// Vertices of the triangle.
    pub vertices: [u32; 3],
    /// Barycentric weights of the second and third vertex, in units of 1/65535; their sum is at most 65535.
    pub weights: [u16; 2],
}

impl StrokePool {
    /// Maximum number of strokes.
    pub const MOST: usize = 4096;

    fn fault(&self, vertices: u32) -> Option<String> {
        if !(self.size_m > 0.0 && self.size_m.is_finite()) {
            return Some(format!("size_m is {}, expected a finite number above 0", self.size_m));
        }
        if self.strokes.len() > Self::MOST {
            return Some(format!("{} strokes, expected at most {}", self.strokes.len(), Self::MOST));
        }
        self.strokes.iter().enumerate().find_map(|(i, s)| Some(format!("strokes[{i}]: {}", s.fault(vertices)?)))
    }
}

impl PaintStroke {
    /// Number of points of every stroke.
    pub const POINTS: usize = 24;

    fn fault(&self, vertices: u32) -> Option<String> {
        if !(0.0..=1.0).contains(&self.rank) {
            return Some(format!("rank is {}, expected 0 to 1", self.rank));
        }
        if let Some(found) = self.pigment.iter().flatten().find(|c| !(0.0..=1.0).contains(*c)) {
            return Some(format!("pigment has the component {found}, expected 0 to 1"));
        }
        if self.points.len() != Self::POINTS {
            return Some(format!("{} points, expected {}", self.points.len(), Self::POINTS));
        }
        self.points.iter().enumerate().find_map(|(i, p)| Some(format!("points[{i}]: {}", p.fault(vertices)?)))
    }
}

impl StrokePoint {
    fn fault(&self, vertices: u32) -> Option<String> {
        if !(self.half_width_m >= 0.0 && self.half_width_m.is_finite()) {
            return Some(format!("half_width_m is {}, expected a finite number of at least 0", self.half_width_m));
        }
        if !(0.0..=1.0).contains(&self.darkness) {
            return Some(format!("darkness is {}, expected 0 to 1", self.darkness));
        }
        if let Some(found) = self.offset_m.iter().flatten().find(|x| !x.is_finite()) {
            return Some(format!("offset_m has the component {found}, expected finite numbers"));
        }
        for StrokeAnchor { vertices: of, weights: [b, c] } in self.sides {
            if let Some(found) = of.iter().find(|v| **v >= vertices) {
                return Some(format!("vertex {found}, expected less than the {vertices} of the mesh"));
            }
            if u32::from(b) + u32::from(c) > 65535 {
                return Some(format!("weights {b} and {c}, expected a sum of at most 65535"));
            }
        }
        None
    }
}

impl Package<'_> {
    /// Returns the strokes with which the model is painted; `None` if the package has no such section.
    ///
    /// Fails if the section is damaged, or refers to a vertex that the mesh does not have.
    pub fn stroke_pool(&self) -> Result<Option<Arc<StrokePool>>, FormatError> {
        let Some((index, section)) = self.find(Tag::STROKES, 0) else { return Ok(None) };
        let pool = self.cached(index, || {
            let pool: StrokePool = decode_section(Tag::STROKES, section.offset, self.section_bytes(index)?)?;
            match pool.fault(self.mesh()?.map_or(0, |mesh| mesh.vertex_count)) {
                Some(reason) => Err(FormatError::Content { tag: Tag::STROKES, offset: section.offset, reason }),
                None => Ok(Arc::new(pool)),
            }
        })?;
        Ok(Some(pool))
    }
}

impl PackageWriter<'_> {
    /// Adds the strokes with which the model is painted.
    pub fn stroke_pool(self, pool: &StrokePool) -> Self {
        self.encoded(Tag::STROKES, encode_section(Tag::STROKES, pool))
    }
}
