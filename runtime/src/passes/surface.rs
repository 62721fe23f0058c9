//! What the skin, fins and shells passes share: bindings, vertex streams and the making of pipelines.

use crate::model::{Model, Part};
use crate::params::MAX_FILL_LIGHTS;
use crate::renderer::Pipelines;
use crate::shadow::{CasterPass, ShadowMaps};
use crate::shared::frame;
use crate::{Lighting, RendererOptions, Style};
use bytemuck::{Pod, Zeroable};
use pelage_formats::{AttributeVertex, Fin, GeometryVertex, Shading};
use std::mem::offset_of;
use std::num::NonZeroU64;
use wgpu::util::DeviceExt;

/// Source of the shared part, joined before each surface shader.
macro_rules! surface_wgsl {
    ($pass:literal) => {
        concat!(
            include_str!("../../shared/fins.wgsl"),
            include_str!("../../shared/frame.wgsl"),
            include_str!("../../shared/kajiya_kay.wgsl"),
            include_str!("../../shared/layer_shadow.wgsl"),
            include_str!("../../shared/opacity.wgsl"),
            include_str!("../../shared/skinning.wgsl"),
            include_str!("../../shared/soft_shadow.wgsl"),
            include_str!("../../shared/tile_frame.wgsl"),
            include_str!("../surface.wgsl"),
            include_str!($pass),
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

const fn attribute(shader_location: u32, format: wgpu::VertexFormat, offset: usize) -> wgpu::VertexAttribute {
    wgpu::VertexAttribute { format, offset: offset as u64, shader_location }
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

/// What distinguishes the pipelines of surfaces. A shader of which no package needs a variant is never compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct SurfaceKey {
    pub(crate) shader: SurfaceShader,
    pub(crate) variant: Variant,
    /// Back faces are drawn.
    pub(crate) double_sided: bool,
    /// The instance mirrors: its front faces wind clockwise.
    pub(crate) mirrored: bool,
}

/// Overrides of the shader: what a package or a frame does not need is compiled away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Variant {
    /// The material has a base-colour texture.
    pub(crate) base_color_texture: bool,
    /// The material cuts away transparent texels.
    pub(crate) cutout: bool,
    /// The direction texture has two components.
    pub(crate) planar_directions: bool,
    /// The diffuse exponent is 2.
    pub(crate) squared_diffuse: bool,
    /// There is a highlight.
    pub(crate) specular: bool,
    /// Other than the baked number of layers is drawn.
    pub(crate) resampled: bool,
    /// Some vertex leans more than the tile's strands.
    pub(crate) lean: bool,
    /// Some vertex is bare or wet.
    pub(crate) groom_vertices: bool,
    /// The material has a groom texture.
    pub(crate) groom_texture: bool,
    /// There is wet hair to mix in.
    pub(crate) wet: bool,
    /// Fins are drawn too.
    pub(crate) beside_fins: bool,
    /// How the key light's shadows fall.
    pub(crate) shadows: ShadowLook,
    /// There are lights without shadow.
    pub(crate) fill_lights: bool,
    /// The key light is computed at vertices.
    pub(crate) vertex_lighting: bool,
}

/// How the key light's shadows fall, as far as the choice of pipelines goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct ShadowLook {
    /// Hair shadows hair.
    pub(crate) self_shadow: bool,
    /// The light's way through a layer grows with its slant.
    pub(crate) slanted: bool,
    /// The layer-wise maps are of other layers than are drawn.
    pub(crate) maps_between: bool,
    /// Things throw soft shadows.
    pub(crate) soft_shadow: bool,
    /// The penumbra lies on both sides of the hard edge.
    pub(crate) centred: bool,
}

/// How a frame draws an instance, as far as the choice of pipelines goes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Look {
    pub(crate) style: Style,
    pub(crate) yardstick: bool,
    /// The instance mirrors.
    pub(crate) mirrored: bool,
    /// Other than the baked number of layers is drawn.
    pub(crate) resampled: bool,
    /// Fins are drawn.
    pub(crate) fins: bool,
    /// How the key light's shadows fall.
    pub(crate) shadows: ShadowLook,
    /// There are lights without shadow.
    pub(crate) fill_lights: bool,
    /// Where the key light is computed.
    pub(crate) lighting: Lighting,
    /// Constants of the lighting equation.
    pub(crate) shading: Shading,
}

impl Look {
    /// The pipeline of a part of a model.
    pub(crate) fn key(&self, shader: SurfaceShader, model: &Model, part: &Part) -> SurfaceKey {
        let variant = Variant {
            base_color_texture: part.has_texture,
            cutout: part.cutout,
            planar_directions: match shader {
                SurfaceShader::Fins => model.fins().is_some_and(|fins| fins.planar_directions),
                _ => model.planar_directions(),
            },
            squared_diffuse: self.shading.diffuse_exponent == 2.0,
            specular: self.shading.specular != [0.0; 3],
            resampled: self.resampled,
            lean: model.varies().lean,
            groom_vertices: model.varies().groom,
            groom_texture: part.has_groom_texture,
            wet: model.manifest().fur.wet.is_some(),
            beside_fins: self.fins,
            shadows: self.shadows,
            fill_lights: self.fill_lights,
            vertex_lighting: self.lighting == Lighting::Vertex,
        };
        let variant = shader.relevant(variant);
        // Fins are seen from both sides, and back faces throw shadows too.
        let both = matches!(shader, SurfaceShader::Fins | SurfaceShader::Caster(CasterPass::Nearest));
        SurfaceKey { shader, variant, double_sided: part.double_sided || both, mirrored: self.mirrored && !both }
    }
}

/// Numbers of the `wanted` parts of a model and the pipelines that draw them.
pub(crate) fn plan_parts(
    device: &wgpu::Device,
    pipelines: &mut Pipelines,
    model: &Model,
    look: &Look,
    shader: SurfaceShader,
    wanted: impl Fn(&Part) -> bool,
) -> Vec<(usize, wgpu::RenderPipeline)> {
    let parts = model.parts().iter().enumerate().filter(|(_, part)| wanted(part));
    parts.map(|(index, part)| (index, pipelines.surface(device, look.key(shader, model, part)))).collect()
}

impl Variant {
    /// Shells need more than the plain varyings.
    fn is_mapped(self) -> bool {
        let material = self.base_color_texture || self.cutout || self.groom_texture;
        material || self.lean || self.groom_vertices || self.wet || self.resampled || self.shadows.maps_between
    }

    /// Layers that the key light sees need more than the plain varyings.
    fn is_mapped_to_light(self) -> bool {
        self.cutout || self.groom_texture || self.groom_vertices || self.wet
    }

    fn constants(self) -> [(&'static str, f64); 18] {
        [
            ("BASE_COLOR_TEXTURE", self.base_color_texture),
            ("CUTOUT", self.cutout),
            ("PLANAR_DIRECTIONS", self.planar_directions),
            ("SQUARED_DIFFUSE", self.squared_diffuse),
            ("SPECULAR", self.specular),
            ("RESAMPLED", self.resampled),
            ("LEAN", self.lean),
            ("GROOM_VERTICES", self.groom_vertices),
            ("GROOM_TEXTURE", self.groom_texture),
            ("WET", self.wet),
            ("BESIDE_FINS", self.beside_fins),
            ("SELF_SHADOW", self.shadows.self_shadow),
            ("SLANTED", self.shadows.slanted),
            ("MAPS_BETWEEN", self.shadows.maps_between),
            ("SOFT_SHADOW", self.shadows.soft_shadow),
            ("CENTRED", self.shadows.centred),
            ("FILL_LIGHTS", self.fill_lights),
            ("VERTEX_LIGHTING", self.vertex_lighting),
        ]
        .map(|(name, value)| (name, f64::from(u8::from(value))))
    }
}

/// Shader of a surface pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum SurfaceShader {
    SkinBare,
    SkinFurred,
    Fins,
    Shells,
    Yardstick,
    /// A layer seen from the key light.
    LayerShadow,
    /// The skin seen from the key light.
    Caster(CasterPass),
}

/// What is there times what is drawn.
const MULTIPLIED: wgpu::BlendState = {
    let times = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::Zero,
        dst_factor: wgpu::BlendFactor::Src,
        operation: wgpu::BlendOperation::Add,
    };
    wgpu::BlendState { color: times, alpha: wgpu::BlendComponent { dst_factor: wgpu::BlendFactor::SrcAlpha, ..times } }
};

/// What a pipeline draws to.
struct Target {
    color: Option<wgpu::ColorTargetState>,
    depth_format: wgpu::TextureFormat,
    depth_write: bool,
    depth_compare: wgpu::CompareFunction,
    sample_count: u32,
}

impl SurfaceShader {
    /// The variant without what this shader does not look at, so that pipelines are shared.
    fn relevant(self, variant: Variant) -> Variant {
        // Light on a surface without layers of its own.
        let on_skin = ShadowLook { slanted: false, maps_between: false, ..variant.shadows };
        let surface =
            Variant { base_color_texture: variant.base_color_texture, cutout: variant.cutout, ..Variant::default() };
        // Of the colour only what is cut away matters.
        let holes = Variant { base_color_texture: variant.base_color_texture && variant.cutout, ..surface };
        match self {
            Self::SkinBare => Variant { shadows: on_skin, fill_lights: variant.fill_lights, ..surface },
            Self::SkinFurred => {
                Variant { resampled: false, lean: false, beside_fins: false, shadows: on_skin, ..variant }
            }
            Self::Fins => Variant { resampled: false, beside_fins: false, shadows: on_skin, ..variant },
            Self::Shells => variant,
            Self::Yardstick => Variant { lean: variant.lean, ..Variant::default() },
            Self::LayerShadow => Variant {
                resampled: variant.resampled,
                lean: variant.lean,
                groom_vertices: variant.groom_vertices,
                groom_texture: variant.groom_texture,
                wet: variant.wet,
                shadows: ShadowLook { slanted: variant.shadows.slanted, ..ShadowLook::default() },
                ..holes
            },
            Self::Caster(_) => holes,
        }
    }

    /// Vertex and fragment entry point.
    pub(crate) fn entry_points(self, variant: Variant) -> (&'static str, &'static str) {
        match self {
            Self::SkinBare => ("vs_bare", "fs_bare"),
            Self::SkinFurred => ("vs_furred", "fs_furred"),
            Self::Fins => ("vs_fins", "fs_fins"),
            Self::Shells if variant.fill_lights => ("vs_shells_filled", "fs_shells_filled"),
            Self::Shells if variant.is_mapped() => ("vs_shells_mapped", "fs_shells_mapped"),
            Self::Shells => ("vs_shells", "fs_shells"),
            Self::Yardstick => ("vs_yardstick", "fs_yardstick"),
            Self::LayerShadow if variant.is_mapped_to_light() => ("vs_layer_mapped", "fs_layer_mapped"),
            Self::LayerShadow => ("vs_layer", "fs_layer"),
            Self::Caster(_) => ("vs_caster", "fs_caster"),
        }
    }

    /// Hair over the skin: blended.
    fn is_blended(self) -> bool {
        matches!(self, Self::Fins | Self::Shells | Self::Yardstick)
    }

    fn target(self, options: &RendererOptions) -> Target {
        match self {
            Self::LayerShadow => Target {
                color: Some(wgpu::ColorTargetState {
                    format: ShadowMaps::LAYER_FORMAT,
                    blend: Some(MULTIPLIED),
                    write_mask: wgpu::ColorWrites::ALL,
                }),
                depth_format: ShadowMaps::DEPTH_FORMAT,
                depth_write: false,
                // Layers that coincide with the skin take no light.
                depth_compare: wgpu::CompareFunction::Less,
                sample_count: 1,
            },
            Self::Caster(pass) => Target {
                color: None,
                depth_format: ShadowMaps::DEPTH_FORMAT,
                depth_write: true,
                depth_compare: pass.compare(),
                sample_count: 1,
            },
            _ => Target {
                color: Some(wgpu::ColorTargetState {
                    format: options.color_format,
                    // The layers hold premultiplied colour.
                    blend: self.is_blended().then_some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                    write_mask: wgpu::ColorWrites::ALL,
                }),
                depth_format: options.depth_format,
                depth_write: self != Self::Fins,
                // Layers that coincide with the skin (fur of height 0) stay hidden: strictly nearer only.
                depth_compare: match (self.is_blended(), options.reversed_depth) {
                    (true, false) => wgpu::CompareFunction::Less,
                    (true, true) => wgpu::CompareFunction::Greater,
                    (false, false) => wgpu::CompareFunction::LessEqual,
                    (false, true) => wgpu::CompareFunction::GreaterEqual,
                },
                sample_count: options.sample_count,
            },
        }
    }
}

/// Layouts of the bind groups, and what stands in for a texture that a material does not have.
#[derive(Debug)]
pub(crate) struct SurfaceLayouts {
    /// Group 0: frame, and the instance at a dynamic offset.
    pub(crate) frame: wgpu::BindGroupLayout,
    /// Group 1.
    material: wgpu::BindGroupLayout,
    /// Group 2.
    fur: wgpu::BindGroupLayout,
    /// Group 3, of the fins alone: posed vertices, attributes, fins. `None` where vertex shaders have no storage buffers.
    pub(crate) fins: Option<wgpu::BindGroupLayout>,
    pub(crate) white: wgpu::TextureView,
    white_array: wgpu::TextureView,
    map_sampler: wgpu::Sampler,
}

fn uniform<T>(binding: u32, has_dynamic_offset: bool) -> wgpu::BindGroupLayoutEntry {
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

fn texture(binding: u32, view_dimension: wgpu::TextureViewDimension) -> wgpu::BindGroupLayoutEntry {
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

fn sampler(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        count: None,
    }
}

fn layout(device: &wgpu::Device, label: &str, entries: &[wgpu::BindGroupLayoutEntry]) -> wgpu::BindGroupLayout {
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
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(fragment),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some(vertex),
                compilation_options: compilation_options.clone(),
                // Fins read their vertices from storage buffers.
                buffers: if key.shader == SurfaceShader::Fins {
                    &[]
                } else {
                    &[
                        Some(wgpu::VertexBufferLayout {
                            array_stride: size_of::<GeometryVertex>() as u64,
                            step_mode: wgpu::VertexStepMode::Vertex,
                            attributes: &GEOMETRY_ATTRIBUTES,
                        }),
                        Some(wgpu::VertexBufferLayout {
                            array_stride: size_of::<AttributeVertex>() as u64,
                            step_mode: wgpu::VertexStepMode::Vertex,
                            attributes: &ATTRIBUTE_ATTRIBUTES,
                        }),
                    ]
                },
            },
            primitive: wgpu::PrimitiveState {
                front_face: if key.mirrored { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw },
                cull_mode: (!key.double_sided).then_some(wgpu::Face::Back),
                ..Default::default()
            },
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
