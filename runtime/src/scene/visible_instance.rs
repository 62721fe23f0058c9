//! Instances of a frame with everything that passes need to draw them.

use super::ribbons::Ribbons;
use crate::contours::ContourBuffers;
use crate::gpu::{DrawBindGroup, UniformRange};
use crate::hair::{InstanceDrawing, StrandSetDrawing, Variant};
use crate::model::{Model, ModelContours, ModelPainting, Part, StrandSet};
use crate::motion::{PosedInstance, PosedStrands};
use crate::painting::PaintedStrokes;
use crate::report::InstanceDetail;
use std::ops::Range;
use std::sync::Arc;

/// Instance of a frame with everything that passes need to draw it.
#[derive(Debug)]
pub(crate) struct VisibleInstance {
    pub(crate) model: Model,
    pub(crate) moved: PosedInstance,
    /// Level of detail of the fur.
    pub(crate) drawing: InstanceDrawing,
    pub(crate) look: Variant,
    pub(crate) sets: Vec<VisibleStrandSet>,
    /// Posed strokes, if the instance is painted with strokes and may be in the picture.
    pub(crate) painted: Option<VisiblePainting>,
    /// Contour lines, if they are drawn.
    pub(crate) contours: Option<VisibleContours>,
    /// Offset of the instance's uniform block for the eye.
    pub(super) view_offset: u64,
    /// Offset of the instance's uniform block for the key light.
    pub(super) light_offset: u64,
}

/// Posed strokes of an instance.
#[derive(Debug)]
pub(crate) struct VisiblePainting {
    pub(crate) strokes: Arc<PaintedStrokes>,
    /// Location of the [`crate::painting::PaintedModel`] block.
    pub(crate) block: UniformRange,
}

/// Contour lines of an instance.
#[derive(Debug)]
pub(crate) struct VisibleContours {
    pub(crate) buffers: Arc<ContourBuffers>,
    /// Location of the [`crate::contours::ContourBlock`].
    pub(crate) block: UniformRange,
}

#[derive(Debug)]
pub(crate) struct VisibleStrandSet {
    pub(crate) drawn: StrandSetDrawing,
    pub(crate) posed: PosedStrands,
    /// Ribbons of the strands, if the instance may be in the picture.
    pub(crate) ribbons: Option<Arc<Ribbons>>,
}

/// Strand set with all data that passes read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StrandsToDraw<'a> {
    pub(crate) drawn: &'a StrandSetDrawing,
    pub(crate) strands: &'a StrandSet,
    pub(crate) posed: &'a PosedStrands,
    pub(crate) ribbons: Option<&'a Arc<Ribbons>>,
}

impl StrandsToDraw<'_> {
    /// Returns the parts on which the set grows, each with the range of its strands that `share` selects.
    pub(crate) fn parts<'p>(&self, parts: &'p [Part], share: f32) -> impl Iterator<Item = (&'p Part, Range<u32>)> {
        let (set, strands) = (self.drawn.set, self.strands);
        let of_part = move |part: &'p Part| (part, strands.prefix_below(&part.strands[set], share));
        parts.iter().map(of_part).filter(|(_, strands)| !strands.is_empty())
    }
}

impl VisibleInstance {
    /// Returns the strand sets that are drawn.
    pub(crate) fn strands(&self) -> impl Iterator<Item = StrandsToDraw<'_>> {
        self.sets.iter().map(|set| StrandsToDraw {
            drawn: &set.drawn,
            strands: &self.model.strands()[set.drawn.set],
            posed: &set.posed,
            ribbons: set.ribbons.as_ref(),
        })
    }

    /// Returns the instance with its contour mesh and lines; `None` if no contour lines are drawn.
    pub(crate) fn contour_lines(&self) -> Option<(&Self, &ModelContours, &VisibleContours)> {
        Some((self, self.model.contours()?, self.contours.as_ref()?))
    }

    /// Returns the instance with the strokes of its model and its posed strokes; `None` if no strokes are painted.
    pub(crate) fn painting(&self) -> Option<(&Self, &ModelPainting, &VisiblePainting)> {
        Some((self, self.model.painting()?, self.painted.as_ref()?))
    }

    /// Returns the level of detail as reported to the application.
    pub(crate) fn detail_report(&self) -> InstanceDetail {
        let detail = self.drawing.reported();
        match self.sets.first() {
            Some(VisibleStrandSet { drawn, .. }) if self.model.fur_strands().is_none() => {
                let strand_pieces = self.model.strands()[drawn.set].segments(drawn.step);
                InstanceDetail { strands: drawn.share, strand_pieces, ..detail }
            }
            _ => detail,
        }
    }

    /// Returns whether hair or fur is still moving, so that the next frame differs even if the input is unchanged.
    pub(crate) fn is_animating(&self) -> bool {
        let swings = self.moved.swing.as_ref().is_some_and(|swing| !swing.is_at_rest);
        swings
            && self.in_picture()
            && (self.moved.lean.is_some() || self.sets.iter().any(|set| set.posed.particles.is_some()))
    }

    /// Returns whether any part of the instance may be in the picture.
    pub(crate) fn in_picture(&self) -> bool {
        self.drawing.detail.in_picture
    }

    /// Returns bind group 2 with the hair textures of the shells; `None` for a model without fur.
    pub(crate) fn fur(&self) -> Option<DrawBindGroup> {
        self.model.fur().and_then(DrawBindGroup::of)
    }
}
