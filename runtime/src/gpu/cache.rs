//! Cache of GPU objects that are created on first use.

use super::bind_groups::BindGroups;
use super::layouts::Layouts;
use super::pipelines::Pipelines;
use super::pool::Pool;
use super::targets::TargetSet;

/// Cache of GPU objects that are created on first use.
#[derive(Debug, Default)]
pub(crate) struct Cache {
    pub(crate) layouts: Layouts,
    pub(crate) pipelines: Pipelines,
    pub(crate) bind_groups: BindGroups,
    pub(crate) targets: Pool<TargetSet>,
}
