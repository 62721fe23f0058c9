//! One pass is one folder: what it needs, its pipelines, and how it is recorded.

pub(crate) mod fins;
pub(crate) mod layer_shadow;
pub(crate) mod pose;
pub(crate) mod shadow_width;
pub(crate) mod shells;
pub(crate) mod skin;
pub(crate) mod surface;

use crate::shadow::CasterPass;

/// Begins a pass into the key light's maps: colour cleared to full light, depth to what `CasterPass` starts from.
pub(crate) fn begin_maps<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    label: &str,
    color: Option<&wgpu::TextureView>,
    depth: Option<(&wgpu::TextureView, CasterPass)>,
) -> wgpu::RenderPass<'e> {
    let color = color.map(|view| wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::WHITE), store: wgpu::StoreOp::Store },
    });
    let colors = [color];
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: if colors[0].is_some() { &colors } else { &[] },
        depth_stencil_attachment: depth.map(|(view, kind)| wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(kind.clear()), store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
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
}

impl PassId {
    /// All of them, in order.
    pub const ALL: [Self; 6] = [Self::Pose, Self::LayerShadow, Self::ShadowWidth, Self::Skin, Self::Fins, Self::Shells];

    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pose => "pose",
            Self::LayerShadow => "layer_shadow",
            Self::ShadowWidth => "shadow_width",
            Self::Skin => "skin",
            Self::Fins => "fins",
            Self::Shells => "shells",
        }
    }
}
