//! Compute dispatches as plain data: passes describe them, and one function records them.

use crate::gpu::{DrawBindGroup, WORKGROUP, workgroups};

/// Compute dispatch with its pipeline and bind groups.
#[derive(Debug)]
pub(crate) struct Dispatch {
    pub(crate) pipeline: wgpu::ComputePipeline,
    pub(crate) groups: Vec<Option<DrawBindGroup>>,
    /// Total number of threads, dispatched in workgroups of 64.
    pub(crate) threads: u32,
}

/// Records dispatches in order; each one sees the writes of those before it.
pub(crate) fn record_dispatches(encoder: &mut wgpu::CommandEncoder, label: &str, dispatches: &[Dispatch]) {
    let descriptor = wgpu::ComputePassDescriptor { label: Some(label), timestamp_writes: None };
    let mut pass = encoder.begin_compute_pass(&descriptor);
    for Dispatch { pipeline, groups, threads } in dispatches {
        pass.set_pipeline(pipeline);
        for (number, group) in groups.iter().enumerate() {
            let Some(DrawBindGroup { group, offset }) = group else { continue };
            pass.set_bind_group(number as u32, group, offset.as_slice());
        }
        let [columns, rows] = workgroups(threads.div_ceil(WORKGROUP));
        pass.dispatch_workgroups(columns, rows, 1);
    }
}
