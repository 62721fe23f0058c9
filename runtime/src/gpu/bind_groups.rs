//! Bind groups by what they bind: a frame in which nothing is new makes none.

use super::bound::Bound;
use super::device::Gpu;
use std::collections::HashMap;

/// Frames after which what none of them bound is forgotten, and what it binds can be freed.
const FORGOTTEN_AFTER: u64 = 64;

/// Layout and entries by their numbers.
type Key = (wgpu::BindGroupLayout, Vec<(u32, Bound)>);

#[derive(Debug, Default)]
pub(crate) struct BindGroups {
    /// Each with the last frame that bound it.
    made: HashMap<Key, (wgpu::BindGroup, u64)>,
    frame: u64,
}

impl BindGroups {
    /// The group of these entries by their numbers.
    pub(crate) fn get(
        &mut self,
        gpu: &Gpu,
        label: &str,
        layout: &wgpu::BindGroupLayout,
        entries: Vec<(u32, Bound)>,
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

    /// Forgets all, with what they bind.
    pub(crate) fn clear(&mut self) {
        self.made.clear();
    }

    /// Forgets what has not been bound for long, so that what it refers to can be freed.
    pub(crate) fn next_frame(&mut self) {
        self.frame += 1;
        let oldest = self.frame.saturating_sub(FORGOTTEN_AFTER);
        self.made.retain(|_, (_, last)| *last >= oldest);
    }
}
