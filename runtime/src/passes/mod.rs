//! One pass is one folder: what it needs, its pipelines, and how it is recorded.

pub(crate) mod fins;
pub(crate) mod ink;
pub(crate) mod ink_composite;
pub(crate) mod ink_dilate;
pub(crate) mod ink_features;
pub(crate) mod ink_fur;
pub(crate) mod ink_normals;
pub(crate) mod ink_stroke;
pub(crate) mod key;
pub(crate) mod layer_shadow;
pub(crate) mod pose;
pub(crate) mod shadow_width;
pub(crate) mod shells;
pub(crate) mod skin;
pub(crate) mod surface;

use crate::model::Part;
use crate::shadow::CasterPass;
use std::ops::Range;

/// Draws a part's triangles, once for each of `layers`; groups 0 and 2 and the vertex buffers are set.
pub(crate) fn draw_part(
    pass: &mut wgpu::RenderPass<'_>,
    part: &Part,
    pipeline: &wgpu::RenderPipeline,
    layers: Range<u32>,
) {
    pass.set_pipeline(pipeline);
    pass.set_bind_group(1, &part.material, &[]);
    pass.draw_indexed(part.indices.clone(), 0, layers);
}

/// What a pass into the key light's maps draws to.
pub(crate) enum MapTarget<'a> {
    /// Texels, cleared to full light.
    Light(&'a wgpu::TextureView),
    /// Texels as they are, where nothing in the depth map is nearer.
    LightBefore { light: &'a wgpu::TextureView, nearest: &'a wgpu::TextureView },
    /// Depth, cleared to what the pass starts from.
    Depth(&'a wgpu::TextureView, CasterPass),
}

/// Begins a pass into the key light's maps.
pub(crate) fn begin_maps<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    label: &str,
    target: MapTarget<'_>,
) -> wgpu::RenderPass<'e> {
    let texels = |view, load| {
        let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
        [Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })]
    };
    // Without operations a depth buffer is only read.
    let depth = |view, depth_ops| wgpu::RenderPassDepthStencilAttachment { view, depth_ops, stencil_ops: None };
    let white = wgpu::LoadOp::Clear(wgpu::Color::WHITE);
    let (colors, depth) = match target {
        MapTarget::Light(view) => (Some(texels(view, white)), None),
        MapTarget::LightBefore { light, nearest } => {
            (Some(texels(light, wgpu::LoadOp::Load)), Some(depth(nearest, None)))
        }
        MapTarget::Depth(view, pass) => {
            let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(pass.clear()), store: wgpu::StoreOp::Store };
            (None, Some(depth(view, Some(ops))))
        }
    };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: colors.as_ref().map_or(&[], |c| &c[..]),
        depth_stencil_attachment: depth,
        ..Default::default()
    })
}

/// A pass of the frame, in the order in which they run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PassId {
    /// Compute: poses the vertices. Recorded by [`crate::Renderer::prepare`].
    Pose,
    /// Transmittance of the hair above each layer, seen from the key light. Recorded by [`crate::Renderer::prepare`].
    LayerShadow,
    /// Depth maps from the key light and the shadow-width map. Recorded by [`crate::Renderer::prepare`].
    ShadowWidth,
    /// The opaque base mesh and bare parts.
    Skin,
    /// Quads of hair on the edges of the skin, where they are seen face on.
    Fins,
    /// The layers of hair, inside to outside.
    Shells,
    /// Ink: the surfaces' normals, wash and stroke. Recorded by [`crate::Renderer::prepare`].
    InkNormals,
    /// Ink: the pixels that lines run through. Recorded by [`crate::Renderer::prepare`].
    InkFeatures,
    /// Ink: how far their lines reach along rows. Recorded by [`crate::Renderer::prepare`].
    InkDilate,
    /// Ink: the lines. Recorded by [`crate::Renderer::prepare`].
    InkStroke,
    /// Ink: paper, wash and lines.
    InkComposite,
    /// Ink: strokes of fur over them.
    InkFur,
}

impl PassId {
    /// All of them, in order.
    pub const ALL: [Self; 12] = [
        Self::Pose,
        Self::LayerShadow,
        Self::ShadowWidth,
        Self::InkNormals,
        Self::InkFeatures,
        Self::InkDilate,
        Self::InkStroke,
        Self::Skin,
        Self::Fins,
        Self::Shells,
        Self::InkComposite,
        Self::InkFur,
    ];

    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pose => "pose",
            Self::LayerShadow => "layer_shadow",
            Self::ShadowWidth => "shadow_width",
            Self::Skin => "skin",
            Self::Fins => "fins",
            Self::Shells => "shells",
            Self::InkNormals => "ink_normals",
            Self::InkFeatures => "ink_features",
            Self::InkDilate => "ink_dilate",
            Self::InkStroke => "ink_stroke",
            Self::InkComposite => "ink_composite",
            Self::InkFur => "ink_fur",
        }
    }
}
