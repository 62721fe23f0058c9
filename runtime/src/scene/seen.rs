//! An instance in a frame.

use crate::gpu::{Draw, Group};
use crate::hair::{Drawing, Look};
use crate::model::{Model, Part};
use crate::motion::Moved;
use std::ops::Range;

/// An instance in a frame.
#[derive(Debug)]
pub(crate) struct Seen {
    pub(crate) model: Model,
    pub(crate) moved: Moved,
    /// How much of its fur is drawn.
    pub(crate) drawing: Drawing,
    pub(crate) look: Look,
    /// Some of it may be in the picture.
    pub(crate) in_picture: bool,
    /// Where its blocks lie: as the eye sees it, and as the key light does.
    pub(super) view_offset: u64,
    pub(super) light_offset: u64,
}

impl Seen {
    /// A draw of one of its parts, once for each of `instances`. `frame`: group 0; `hair`: group 2.
    pub(crate) fn draw(
        &self,
        part: &Part,
        pipeline: wgpu::RenderPipeline,
        frame: Option<Group>,
        hair: Option<Group>,
        instances: Range<u32>,
    ) -> Draw {
        Draw {
            pipeline,
            groups: [frame, Group::of(&part.material), hair, None],
            vertices: [Some(self.moved.geometry.clone()), Some(self.model.attributes().clone()), None, None],
            indices: Some(self.model.indices().clone()),
            range: part.indices.clone(),
            instances,
        }
    }

    /// Group 2 of its shells; `None` for a model without fur.
    pub(crate) fn fur(&self) -> Option<Group> {
        self.model.fur().and_then(Group::of)
    }
}
