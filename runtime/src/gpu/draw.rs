//! Draw calls as plain data: passes describe draws, and one function records them.

use std::ops::Range;

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DrawBindGroup {
    pub(crate) group: wgpu::BindGroup,
    pub(crate) offset: Option<u32>,
}

impl DrawBindGroup {
    pub(crate) fn of(group: &wgpu::BindGroup) -> Option<Self> {
        Some(Self { group: group.clone(), offset: None })
    }

    pub(crate) fn at(group: &wgpu::BindGroup, offset: u64) -> Option<Self> {
        Some(Self { group: group.clone(), offset: Some(offset as u32) })
    }
}

/// Draw call with all its state.
#[derive(Clone, Debug)]
pub(crate) struct Draw {
    pub(crate) pipeline: wgpu::RenderPipeline,
    pub(crate) groups: [Option<DrawBindGroup>; 4],
    /// Vertex buffers by slot.
    pub(crate) vertices: [Option<wgpu::Buffer>; 5],
    /// Index buffer of 32-bit indices; `None` for a non-indexed draw.
    pub(crate) indices: Option<wgpu::Buffer>,
    /// Range of indices, or of vertices for a non-indexed draw.
    pub(crate) range: Range<u32>,
    pub(crate) instances: Range<u32>,
    /// Buffer with indirect draw arguments at offset 0, written by the GPU; replaces the ranges.
    pub(crate) indirect: Option<wgpu::Buffer>,
}

impl Draw {
    /// Returns a draw of one triangle that covers the target, with bind group 0 only.
    pub(crate) fn screen(pipeline: wgpu::RenderPipeline, group: &wgpu::BindGroup) -> Self {
        Self {
            pipeline,
            groups: [DrawBindGroup::of(group), None, None, None],
            vertices: Default::default(),
            indices: None,
            range: 0..3,
            instances: 0..1,
            indirect: None,
        }
    }
}

/// Begins a render pass into one colour target, without depth.
pub(crate) fn begin_target<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    label: &str,
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPass<'e> {
    let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops,
        })],
        ..Default::default()
    })
}

/// Clears a colour target to no ink.
pub(crate) const CLEARED: wgpu::LoadOp<wgpu::Color> = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);

/// Records draws in order. State that consecutive draws share is bound once.
pub(crate) fn record<'d>(pass: &mut wgpu::RenderPass<'_>, draws: impl IntoIterator<Item = &'d Draw>) {
    let mut last: Option<&Draw> = None;
    for draw in draws {
        if last.is_none_or(|last| last.pipeline != draw.pipeline) {
            pass.set_pipeline(&draw.pipeline);
        }
        for (number, group) in draw.groups.iter().enumerate() {
            let Some(DrawBindGroup { group: bind_group, offset }) = group else { continue };
            if last.is_none_or(|last| last.groups[number] != *group) {
                pass.set_bind_group(number as u32, bind_group, offset.as_slice());
            }
        }
        for (slot, buffer) in draw.vertices.iter().enumerate() {
            let Some(vertices) = buffer else { continue };
            if last.is_none_or(|last| last.vertices[slot] != *buffer) {
                pass.set_vertex_buffer(slot as u32, vertices.slice(..));
            }
        }
        if let Some(indices) = &draw.indices
            && last.is_none_or(|last| last.indices.as_ref() != Some(indices))
        {
            pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
        }
        match (&draw.indirect, &draw.indices) {
            (Some(arguments), Some(_)) => pass.draw_indexed_indirect(arguments, 0),
            (Some(arguments), None) => pass.draw_indirect(arguments, 0),
            (None, Some(_)) => pass.draw_indexed(draw.range.clone(), 0, draw.instances.clone()),
            (None, None) => pass.draw(draw.range.clone(), draw.instances.clone()),
        }
        last = Some(draw);
    }
}
