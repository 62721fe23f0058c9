//! What the skin, fins and shells passes share: bindings, vertex streams and the making of pipelines.

use super::key::{SurfaceKey, SurfaceShader};
use crate::RendererOptions;
use crate::params::MAX_FILL_LIGHTS;
use crate::shadow::ShadowMaps;
use crate::shared::frame;
use bytemuck::{Pod, Zeroable};
use pelage_formats::{AttributeVertex, Fin, GeometryVertex};
use std::mem::offset_of;
use std::num::NonZeroU64;
use wgpu::util::DeviceExt;

/// Source of the shared part, joined before each surface shader.
macro_rules! surface_wgsl {
    ($($pass:literal),+) => {
        concat!(
            include_str!("../../shared/detail.wgsl"),
            include_str!("../../shared/fins.wgsl"),
            include_str!("../../shared/frame.wgsl"),
            include_str!("../../shared/kajiya_kay.wgsl"),
            include_str!("../../shared/layer_shadow.wgsl"),
            include_str!("../../shared/opacity.wgsl"),
            include_str!("../../shared/skinning.wgsl"),
            include_str!("../../shared/soft_shadow.wgsl"),
            include_str!("../../shared/tile_frame.wgsl"),
            include_str!("../place.wgsl"),
            include_str!("../surface.wgsl"),
            $(include_str!($pass),)+
        )
    };
}
pub(crate) use surface_wgsl;

/// A material's constants.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct MaterialUniform {
    pub(crate) base_color: [f32; 4],
    pub(crate) alpha_cutoff: f32,
    pub(crate) reserved: [f32; 3],
}

pub(crate) const fn attribute(
    shader_location: u32,
    format: wgpu::VertexFormat,
    offset: usize,
) -> wgpu::VertexAttribute {
    wgpu::VertexAttribute { format, offset: offset as u64, shader_location }
}

/// A vertex buffer of `T`.
pub(crate) fn stream<T>(attributes: &[wgpu::VertexAttribute]) -> Option<wgpu::VertexBufferLayout<'_>> {
    let array_stride = size_of::<T>() as u64;
    Some(wgpu::VertexBufferLayout { array_stride, step_mode: wgpu::VertexStepMode::Vertex, attributes })
}

/// The streams that all passes over surfaces read, except fins, which find their vertices in storage buffers.
pub(crate) fn streams() -> [Option<wgpu::VertexBufferLayout<'static>>; 2] {
    [stream::<GeometryVertex>(&GEOMETRY_ATTRIBUTES), stream::<AttributeVertex>(&ATTRIBUTE_ATTRIBUTES)]
}

/// Which side of a surface is drawn. mirrored: of a copy that is.
pub(crate) fn primitive(mirrored: bool, double_sided: bool) -> wgpu::PrimitiveState {
    wgpu::PrimitiveState {
        front_face: if mirrored { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw },
        cull_mode: (!double_sided).then_some(wgpu::Face::Back),
        ..Default::default()
    }
}

/// The first stream, [`GeometryVertex`].
pub(crate) const GEOMETRY_ATTRIBUTES: [wgpu::VertexAttribute; 5] = [
    attribute(0, wgpu::VertexFormat::Float32x3, offset_of!(GeometryVertex, position)),
    attribute(1, wgpu::VertexFormat::Float32, offset_of!(GeometryVertex, fur_height)),
    attribute(2, wgpu::VertexFormat::Float32x3, offset_of!(GeometryVertex, normal)),
    attribute(3, wgpu::VertexFormat::Float32x4, offset_of!(GeometryVertex, tangent)),
    attribute(7, wgpu::VertexFormat::Float32, offset_of!(GeometryVertex, lean)),
];
/// The second stream, [`AttributeVertex`].
pub(crate) const ATTRIBUTE_ATTRIBUTES: [wgpu::VertexAttribute; 4] = [
    attribute(4, wgpu::VertexFormat::Float32x2, offset_of!(AttributeVertex, tile_uv)),
    attribute(5, wgpu::VertexFormat::Float32x2, offset_of!(AttributeVertex, base_uv)),
    attribute(6, wgpu::VertexFormat::Unorm8x4, offset_of!(AttributeVertex, color)),
    attribute(8, wgpu::VertexFormat::Unorm8x4, offset_of!(AttributeVertex, groom)),
];

/// Layouts of the bind groups, and what stands in for a texture that a material does not have.
#[derive(Debug)]
pub(crate) struct SurfaceLayouts {
    /// Group 0: frame, and the instance at a dynamic offset.
    pub(crate) frame: wgpu::BindGroupLayout,
    /// Group 1.
    pub(crate) material: wgpu::BindGroupLayout,
    /// Group 2.
    fur: wgpu::BindGroupLayout,
    /// Group 3, of the fins alone: posed vertices, attributes, fins. `None` where vertex shaders have no storage buffers.
    pub(crate) fins: Option<wgpu::BindGroupLayout>,
    pub(crate) white: wgpu::TextureView,
    pub(crate) white_array: wgpu::TextureView,
    pub(crate) map_sampler: wgpu::Sampler,
}

pub(crate) fn uniform<T>(binding: u32, has_dynamic_offset: bool) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset,
            min_binding_size: NonZeroU64::new(size_of::<T>() as u64),
        },
        count: None,
    }
}

/// An array of `T` that the vertex shader reads.
fn storage<T>(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: NonZeroU64::new(size_of::<T>() as u64),
        },
        count: None,
    }
}

pub(crate) fn texture(binding: u32, view_dimension: wgpu::TextureViewDimension) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension,
            multisampled: false,
        },
        count: None,
    }
}

/// Directions of hair: vertices look at them too, where light is computed there.
fn directions(binding: u32) -> wgpu::BindGroupLayoutEntry {
    let visibility = wgpu::ShaderStages::VERTEX_FRAGMENT;
    wgpu::BindGroupLayoutEntry { visibility, ..texture(binding, wgpu::TextureViewDimension::D2Array) }
}

pub(crate) fn sampler(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        count: None,
    }
}

pub(crate) fn layout(
    device: &wgpu::Device,
    label: &str,
    entries: &[wgpu::BindGroupLayoutEntry],
) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
}

impl SurfaceLayouts {
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        use wgpu::TextureViewDimension::{D2, D2Array};
        let white = device.create_texture_with_data(
            queue,
            &wgpu::TextureDescriptor {
                label: Some("pelage white"),
                size: wgpu::Extent3d::default(),
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba8Unorm,
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            },
            wgpu::util::TextureDataOrder::LayerMajor,
            &[255; 4],
        );
        Self {
            frame: layout(
                device,
                "pelage frame",
                &[
                    uniform::<frame::Frame>(0, false),
                    uniform::<frame::Instance>(1, true),
                    uniform::<[frame::FillLight; MAX_FILL_LIGHTS]>(2, false),
                    texture(3, D2Array),
                    texture(4, D2),
                    sampler(5),
                ],
            ),
            material: layout(
                device,
                "pelage material",
                &[uniform::<MaterialUniform>(0, false), texture(1, D2), sampler(2), texture(3, D2)],
            ),
            fur: layout(
                device,
                "pelage fur",
                &[texture(0, D2Array), directions(1), sampler(2), texture(3, D2Array), directions(4)],
            ),
            fins: (device.limits().max_storage_buffers_per_shader_stage >= 3).then(|| {
                let entries = [storage::<GeometryVertex>(0), storage::<AttributeVertex>(1), storage::<Fin>(2)];
                layout(device, "pelage fins", &entries)
            }),
            map_sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("pelage shadow maps"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
            white: white.create_view(&wgpu::TextureViewDescriptor::default()),
            white_array: white
                .create_view(&wgpu::TextureViewDescriptor { dimension: Some(D2Array), ..Default::default() }),
        }
    }

    /// Group 0. `maps`: the shadow maps that the frame reads.
    pub(crate) fn frame_bind_group(
        &self,
        device: &wgpu::Device,
        blocks: &wgpu::Buffer,
        fill_lights: &wgpu::Buffer,
        maps: Option<&ShadowMaps>,
    ) -> wgpu::BindGroup {
        let block = |binding, size| wgpu::BindGroupEntry {
            binding,
            resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer: blocks,
                offset: 0,
                size: NonZeroU64::new(size as u64),
            }),
        };
        let array =
            wgpu::TextureViewDescriptor { dimension: Some(wgpu::TextureViewDimension::D2Array), ..Default::default() };
        let layers = maps.and_then(ShadowMaps::layers).map(|t| t.create_view(&array));
        let width = maps.and_then(ShadowMaps::width).map(|t| t.create_view(&Default::default()));
        let view = |binding, view| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) };
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("pelage frame"),
            layout: &self.frame,
            entries: &[
                block(0, size_of::<frame::Frame>()),
                block(1, size_of::<frame::Instance>()),
                wgpu::BindGroupEntry { binding: 2, resource: fill_lights.as_entire_binding() },
                view(3, layers.as_ref().unwrap_or(&self.white_array)),
                view(4, width.as_ref().unwrap_or(&self.white)),
                wgpu::BindGroupEntry { binding: 5, resource: wgpu::BindingResource::Sampler(&self.map_sampler) },
            ],
        })
    }

    pub(crate) fn material_bind_group(
        &self,
        device: &wgpu::Device,
        constants: &MaterialUniform,
        base_color: &wgpu::TextureView,
        base_color_sampler: &wgpu::Sampler,
        groom: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        let buffer = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("pelage material"),
            contents: bytemuck::bytes_of(constants),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("pelage material"),
            layout: &self.material,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(base_color) },
                wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::Sampler(base_color_sampler) },
                wgpu::BindGroupEntry { binding: 3, resource: wgpu::BindingResource::TextureView(groom) },
            ],
        })
    }

    /// `wet`: colours and directions of wet hair, where there is any.
    pub(crate) fn fur_bind_group(
        &self,
        device: &wgpu::Device,
        [colors, directions]: [&wgpu::TextureView; 2],
        wet: Option<[&wgpu::TextureView; 2]>,
        shell_sampler: &wgpu::Sampler,
    ) -> wgpu::BindGroup {
        let [wet_colors, wet_directions] = wet.unwrap_or([&self.white_array; 2]);
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("pelage fur"),
            layout: &self.fur,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(colors) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(directions) },
                wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::Sampler(shell_sampler) },
                wgpu::BindGroupEntry { binding: 3, resource: wgpu::BindingResource::TextureView(wet_colors) },
                wgpu::BindGroupEntry { binding: 4, resource: wgpu::BindingResource::TextureView(wet_directions) },
            ],
        })
    }

    /// Makes a pipeline that fits into the application's pass.
    pub(crate) fn pipeline(
        &self,
        device: &wgpu::Device,
        module: &wgpu::ShaderModule,
        key: SurfaceKey,
        options: &RendererOptions,
    ) -> wgpu::RenderPipeline {
        let (vertex, fragment) = key.shader.entry_points(key.variant);
        let groups = [Some(&self.frame), Some(&self.material), Some(&self.fur)];
        let own = match key.shader {
            SurfaceShader::Fins => self.fins.as_ref(),
            _ => None,
        };
        let groups: Vec<_> = match key.shader {
            // A bare skin has no hair textures to bind.
            SurfaceShader::SkinBare | SurfaceShader::Caster(_) => groups[..2].to_vec(),
            _ => groups.into_iter().chain(own.map(Some)).collect(),
        };
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(fragment),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let constants = key.variant.constants();
        let compilation_options = wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
        let target = key.shader.target(options);
        // Depth alone needs no fragment shader, unless there are holes to cut.
        let has_fragment = target.color.is_some() || key.variant.cutout;
        let targets = [target.color];
        let streams = streams();
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(fragment),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some(vertex),
                compilation_options: compilation_options.clone(),
                buffers: if key.shader == SurfaceShader::Fins { &[] } else { &streams },
            },
            primitive: primitive(key.mirrored, key.double_sided),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: target.depth_format,
                depth_write_enabled: Some(target.depth_write),
                depth_compare: Some(target.depth_compare),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count: target.sample_count, ..Default::default() },
            fragment: has_fragment.then_some(wgpu::FragmentState {
                module,
                entry_point: Some(fragment),
                compilation_options,
                targets: if targets[0].is_some() { &targets } else { &[] },
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}
