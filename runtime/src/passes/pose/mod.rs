//! `pose`: skins the base mesh, once per changed pose; later passes read the posed vertices.
//!
//! Reads the rest vertices, the joint weights and the joint matrices; writes a vertex buffer of the same layout and size as the
//! rest vertices. Packages without a skeleton skip it and draw their rest vertices.

use crate::instance::Instance;
use crate::renderer::Pipelines;
use crate::{PassReport, RuntimeError};
use wgpu::util::DeviceExt;

/// The shader.
pub(crate) const WGSL: &str = concat!(
    include_str!("../../shared/skinning.wgsl"),
    include_str!("../../shared/tile_frame.wgsl"),
    include_str!("pose.wgsl"),
);

/// Vertices per workgroup, as in the shader.
pub(crate) const WORKGROUP: u32 = 64;

/// Records the pass for every instance whose pose changed.
pub(crate) fn record(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    pipelines: &mut Pipelines,
    instances: &mut [&mut Instance],
) -> Result<PassReport, RuntimeError> {
    let mut skinned = 0;
    let mut bind_groups = Vec::new();
    for instance in instances.iter_mut() {
        let model = instance.model().clone();
        let Some(skin) = model.skin().filter(|_| model.skeleton().is_some()) else { continue };
        skinned += 1;
        let Some(joints) = instance.changed_pose(device)? else { continue };
        // A buffer of its own for each pose: two frames in one submission do not overwrite each other's joints.
        let joints = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("pelage joints"),
            contents: bytemuck::cast_slice(joints),
            usage: wgpu::BufferUsages::STORAGE,
        });
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("pelage pose"),
            layout: &pipelines.pose(device).get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: joints.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: model.geometry().as_entire_binding() },
                wgpu::BindGroupEntry { binding: 2, resource: skin.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 3, resource: instance.geometry().as_entire_binding() },
            ],
        });
        let vertices = (model.geometry().size() / size_of::<pelage_formats::GeometryVertex>() as u64) as u32;
        bind_groups.push((bind_group, vertices.div_ceil(WORKGROUP)));
    }
    if bind_groups.is_empty() {
        let reason = if skinned == 0 { "no instance has a skeleton" } else { "no pose changed" };
        return Ok(PassReport::skipped("pose", reason));
    }
    let mut pass =
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("pelage pose"), timestamp_writes: None });
    pass.set_pipeline(pipelines.pose(device));
    for (bind_group, groups) in &bind_groups {
        // One dimension of a dispatch ends at 65 535 groups.
        let columns = (*groups).min(65_535);
        pass.set_bind_group(0, bind_group, &[]);
        pass.dispatch_workgroups(columns, groups.div_ceil(columns), 1);
    }
    Ok(PassReport::ran("pose", format!("{} of {skinned} skinned instances changed pose", bind_groups.len())))
}
