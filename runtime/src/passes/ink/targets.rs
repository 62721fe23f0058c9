//! The textures that the ink passes hand on to each other.

use crate::passes::ink_normals;

/// Normals and 1 / clip w. Dots of normals are compared with thresholds up to 1: eight bits would be too few.
pub(crate) const NORMALS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Wash, stroke, width, dryness; what the search along rows found; and lines.
pub(crate) const SURFACES_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Features.
pub(crate) const PAIRS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg8Unorm;
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Labels and formats of all of them, in the order of [`InkTargets`]' fields.
const TARGETS: [(&str, wgpu::TextureFormat); 6] = [
    ("pelage ink normals", NORMALS_FORMAT),
    ("pelage ink surfaces", SURFACES_FORMAT),
    ("pelage ink features", PAIRS_FORMAT),
    ("pelage ink rows", SURFACES_FORMAT),
    ("pelage ink strokes", SURFACES_FORMAT),
    ("pelage ink depth", DEPTH_FORMAT),
];

/// Bytes of all of them for a picture of that size.
pub(crate) fn bytes_of(size: [u32; 2]) -> u64 {
    let of_pixel: u32 = TARGETS.iter().map(|(_, format)| format.block_copy_size(None).unwrap_or(4)).sum();
    u64::from(size[0]) * u64::from(size[1]) * u64::from(of_pixel)
}

/// What the passes hand on to each other. A frame keeps those that it draws from.
#[derive(Debug)]
pub(crate) struct InkTargets {
    pub(super) size: [u32; 2],
    pub(super) normals: wgpu::TextureView,
    pub(super) surfaces: wgpu::TextureView,
    pub(super) features: wgpu::TextureView,
    pub(super) rows: wgpu::TextureView,
    pub(super) strokes: wgpu::TextureView,
    pub(super) depth: wgpu::TextureView,
}

impl InkTargets {
    pub(super) fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        let target = |label, format| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        let [normals, surfaces, features, rows, strokes, depth] = TARGETS.map(|(label, format)| target(label, format));
        Self { size, normals, surfaces, features, rows, strokes, depth }
    }
}

impl InkTargets {
    pub(super) fn as_targets(&self) -> ink_normals::Targets<'_> {
        ink_normals::Targets { normals: &self.normals, surfaces: &self.surfaces, depth: &self.depth }
    }
}
