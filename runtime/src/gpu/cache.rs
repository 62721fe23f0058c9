//! What is made when it is first asked for, and kept.

use super::bind_groups::BindGroups;
use super::layouts::Layouts;
use super::pipelines::Pipelines;
use super::shelf::Shelf;
use super::targets::TargetSet;

/// What is made when it is first asked for, and kept.
#[derive(Debug, Default)]
pub(crate) struct Cache {
    pub(crate) layouts: Layouts,
    pub(crate) pipelines: Pipelines,
    pub(crate) bind_groups: BindGroups,
    pub(crate) targets: Shelf<TargetSet>,
}
