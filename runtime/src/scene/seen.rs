//! An instance in a frame.

use super::ribbons::Ribbons;
use crate::gpu::Group;
use crate::hair::{Drawing, Look};
use crate::model::Model;
use crate::motion::Moved;
use std::sync::Arc;

/// An instance in a frame.
#[derive(Debug)]
pub(crate) struct Seen {
    pub(crate) model: Model,
    pub(crate) moved: Moved,
    /// How much of its fur is drawn.
    pub(crate) drawing: Drawing,
    pub(crate) look: Look,
    /// What its strands are drawn from, where they are in the picture.
    pub(crate) ribbons: Option<Arc<Ribbons>>,
    /// Where its blocks lie: as the eye sees it, and as the key light does.
    pub(super) view_offset: u64,
    pub(super) light_offset: u64,
}

impl Seen {
    /// Whether any of it may be in the picture.
    pub(crate) fn in_picture(&self) -> bool {
        self.drawing.detail.in_picture
    }

    /// Group 2 of its shells; `None` for a model without fur.
    pub(crate) fn fur(&self) -> Option<Group> {
        self.model.fur().and_then(Group::of)
    }
}
