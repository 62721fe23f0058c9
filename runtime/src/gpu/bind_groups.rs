//! Cache of bind groups, keyed by their resources. A frame with no new resources creates no bind group.

use super::binding_resource::BindingResource;
use super::device::Gpu;
use std::collections::HashMap;

/// Number of frames after which an unused bind group is dropped, so that its resources can be freed.
const DROPPED_AFTER: u64 = 64;

type Key = (wgpu::BindGroupLayout, Vec<(u32, BindingResource)>);

#[derive(Debug, Default)]
pub(crate) struct BindGroups {
    /// Bind groups, each with the last frame that bound it.
    made: HashMap<Key, (wgpu::BindGroup, u64)>,
    frame: u64,
}

impl BindGroups {
    /// Returns the bind group for these resources, each given with its binding number.
    pub(crate) fn get(
        &mut self,
        gpu: &Gpu,
        label: &str,
        layout: &wgpu::BindGroupLayout,
        entries: Vec<(u32, BindingResource)>,
    ) -> wgpu::BindGroup {
        let key = (layout.clone(), entries);
        if let Some((group, last)) = self.made.get_mut(&key) {
            *last = self.frame;
            return group.clone();
        }
        let group = gpu.bind_group(label, layout, &key.1);
        self.made.insert(key, (group.clone(), self.frame));
        group
    }

    /// Drops all bind groups, which releases their resources.
    pub(crate) fn clear(&mut self) {
        self.made.clear();
    }

    /// Drops bind groups that have not been bound for long, so that their resources can be freed.
    pub(crate) fn next_frame(&mut self) {
        self.frame += 1;
        let oldest = self.frame.saturating_sub(DROPPED_AFTER);
        self.made.retain(|_, (_, last)| *last >= oldest);
    }
}
