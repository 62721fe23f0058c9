//! What the ink passes share: layouts, the making of pipelines, the textures they hand on, and the order they are recorded in.

use super::fins::{self, FinDraws};
use super::ink_composite::ScreenShow;
use super::key::depth_compare;
use super::surface::{self, ATTRIBUTE_ATTRIBUTES, GEOMETRY_ATTRIBUTES, SurfaceLayouts};
use super::{PassId, ink_composite, ink_dilate, ink_features, ink_fur, ink_normals, ink_stroke};
use crate::frame::Drawn;
use crate::ink::{Anchoring, FeatureRule, InkBackground, InkParams, LineWidth, SphereMapForm};
use crate::model::{Model, Part};
use crate::model_ink::ModelInk;
use crate::shared::{skinning, srgb::encoded};
use crate::{FrameParams, Instance, RendererOptions};
use bytemuck::{Pod, Zeroable};
use glam::{Mat3, Mat4};
use pelage_formats::{AttributeVertex, GeometryVertex, InkVertex};
use std::collections::HashMap;
use std::mem::offset_of;
use std::sync::Arc;
use wgpu::util::DeviceExt;

/// Source of what the passes over a model's surface share, joined before each.
macro_rules! ink_surface_wgsl {
    ($($file:literal),+) => {
        concat!(
            include_str!("../../shared/fins.wgsl"),
            include_str!("../../shared/frame.wgsl"),
            include_str!("../../shared/ink.wgsl"),
            include_str!("../../shared/skinning.wgsl"),
            include_str!("../../shared/tile_frame.wgsl"),
            include_str!("../place.wgsl"),
            include_str!("../ink_model.wgsl"),
            $(include_str!($file),)+
        )
    };
}
pub(crate) use ink_surface_wgsl;

/// Source of what the passes over the picture share, joined before each.
macro_rules! ink_screen_wgsl {
    ($file:literal) => {
        concat!(
            include_str!("../../shared/ink.wgsl"),
            include_str!("../../shared/srgb.wgsl"),
            include_str!("../ink_screen.wgsl"),
            include_str!($file)
        )
    };
}
pub(crate) use ink_screen_wgsl;

/// Normals and 1 / clip w. Dots of normals are compared with thresholds up to 1: eight bits would be too few.
pub(crate) const NORMALS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Wash, stroke, width, dryness; and lines.
pub(crate) const SURFACES_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Features, and what the search along rows found.
pub(crate) const PAIRS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg8Unorm;
const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The constants of a frame, as the shaders read them.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct InkFrame {
    pub(crate) ink: [f32; 3],
    pub(crate) roughness: f32,
    pub(crate) paper: [f32; 3],
    pub(crate) paper_grain: f32,
    pub(crate) size: [f32; 2],
    pub(crate) t1: f32,
    pub(crate) t2: f32,
    pub(crate) step: i32,
    pub(crate) reach: i32,
    pub(crate) half_width: f32,
    pub(crate) half_width_scaled: f32,
    pub(crate) tone: f32,
    pub(crate) lightness: f32,
    pub(crate) dryness: f32,
    pub(crate) paper_period: f32,
    pub(crate) mist_from: f32,
    pub(crate) mist_to: f32,
    pub(crate) depth_step: f32,
    pub(crate) reserved: f32,
}

/// The constants of an instance, as the shaders read them.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct InkModel {
    pub(crate) right_ws: [f32; 3],
    pub(crate) wash_speed: f32,
    pub(crate) up_ws: [f32; 3],
    pub(crate) wash_range: f32,
    pub(crate) periods: f32,
    pub(crate) normalised: f32,
    pub(crate) grain: f32,
    pub(crate) tone: f32,
    pub(crate) fur: f32,
    pub(crate) line: f32,
    pub(crate) pressure: f32,
    pub(crate) swell: f32,
    pub(crate) ink: [f32; 3],
    pub(crate) paper_period: f32,
    pub(crate) stroke_px: f32,
    pub(crate) px_per_unit: f32,
    pub(crate) reserved: [f32; 2],
}

impl InkFrame {
    fn new(params: &InkParams, clip_from_view: Mat4) -> Self {
        let [width, height] = params.target_px.map(|n| n as f32);
        let (half_width, half_width_scaled) = match params.width {
            LineWidth::Pixels(px) => (0.5 * px, 0.0),
            LineWidth::Metres(m) => (0.0, 0.5 * m * px_per_unit(clip_from_view, params)),
        };
        let [mist_from, mist_to] = params.mist_m.unwrap_or_default();
        Self {
            ink: encoded(params.ink).to_array(),
            roughness: params.roughness_px,
            paper: encoded(params.paper).to_array(),
            paper_grain: params.paper_grain,
            size: [width, height],
            t1: params.threshold,
            t2: params.threshold - params.weak_difference,
            step: params.step_px as i32,
            reach: params.reach_px() as i32,
            half_width,
            half_width_scaled,
            tone: params.tone,
            lightness: params.weak_lightness,
            dryness: params.dryness,
            paper_period: params.paper_period_px,
            mist_from,
            mist_to,
            depth_step: params.depth_step,
            reserved: 0.0,
        }
    }
}

impl InkModel {
    fn new(ink: &ModelInk, params: &InkParams, view_from_world: Mat4, clip_from_view: Mat4) -> Self {
        let shading = params.shading.unwrap_or(ink.info.shading);
        let rotation = Mat3::from_mat4(view_from_world);
        Self {
            right_ws: rotation.row(0).to_array(),
            wash_speed: shading.wash_speed,
            up_ws: rotation.row(1).to_array(),
            wash_range: shading.wash_range,
            periods: ink.periods,
            normalised: f32::from(u8::from(shading.normalised)),
            grain: shading.grain,
            tone: shading.tone,
            fur: shading.fur,
            line: shading.line,
            pressure: params.pressure,
            swell: params.swell,
            ink: encoded(params.ink).to_array(),
            paper_period: params.paper_period_px,
            stroke_px: (0.17 * InkParams::default_width_px(params.target_px[1])).max(1.2),
            px_per_unit: px_per_unit(clip_from_view, params),
            reserved: [0.0; 2],
        }
    }
}

/// How many pixels high a metre is at clip w 1.
fn px_per_unit(clip_from_view: Mat4, params: &InkParams) -> f32 {
    clip_from_view.y_axis.y.abs() * 0.5 * params.target_px[1] as f32
}

/// What the passes hand on to each other. A frame keeps those that it draws from.
#[derive(Debug)]
pub(crate) struct InkTargets {
    size: [u32; 2],
    normals: wgpu::TextureView,
    surfaces: wgpu::TextureView,
    features: wgpu::TextureView,
    rows: wgpu::TextureView,
    strokes: wgpu::TextureView,
    depth: wgpu::TextureView,
}

impl InkTargets {
    fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
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
        Self {
            size,
            normals: target("pelage ink normals", NORMALS_FORMAT),
            surfaces: target("pelage ink surfaces", SURFACES_FORMAT),
            features: target("pelage ink features", PAIRS_FORMAT),
            rows: target("pelage ink rows", PAIRS_FORMAT),
            strokes: target("pelage ink strokes", SURFACES_FORMAT),
            depth: target("pelage ink depth", DEPTH_FORMAT),
        }
    }
}

/// A pass over the whole picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Screen {
    Features { all_below: bool },
    Dilate { squares: bool },
    Stroke { printed: bool, template: bool },
    Composite { show: ScreenShow, picture: bool },
}

/// A pass over a model's surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum InkShader {
    Normals,
    Fins,
    Shells,
}

/// What distinguishes the pipelines of surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct InkKey {
    shader: InkShader,
    base_color_texture: bool,
    cutout: bool,
    lean: bool,
    double_sided: bool,
    mirrored: bool,
    fur: bool,
    sphere_map: SphereMapForm,
    on_screen: bool,
}

/// Layouts and pipelines of the ink style, made when it is first drawn.
#[derive(Debug)]
pub(crate) struct InkPipelines {
    /// Group 2 of the passes over surfaces.
    model: wgpu::BindGroupLayout,
    tile_sampler: wgpu::Sampler,
    clamp_sampler: wgpu::Sampler,
    normals_module: wgpu::ShaderModule,
    fur_module: wgpu::ShaderModule,
    screens: HashMap<Screen, wgpu::RenderPipeline>,
    surfaces: HashMap<InkKey, wgpu::RenderPipeline>,
    /// Of the last frame.
    targets: Option<Arc<InkTargets>>,
}

/// What an instance draws in ink.
#[derive(Debug)]
pub(crate) struct InkDraws {
    group: wgpu::BindGroup,
    normals: Vec<(usize, wgpu::RenderPipeline)>,
    shells: Vec<(usize, wgpu::RenderPipeline)>,
    fins: Option<FinDraws>,
}

/// What a frame needs to paint the sheet.
#[derive(Debug)]
pub(crate) struct Sheet {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    /// Another frame must not draw to them while this one lives.
    _targets: Arc<InkTargets>,
}

const fn location(shader_location: u32, format: wgpu::VertexFormat, offset: usize) -> wgpu::VertexAttribute {
    wgpu::VertexAttribute { format, offset: offset as u64, shader_location }
}

/// The third stream: [`GeometryVertex`] as stored.
pub(crate) const REST_ATTRIBUTES: [wgpu::VertexAttribute; 2] = [
    location(9, wgpu::VertexFormat::Float32x3, offset_of!(GeometryVertex, position)),
    location(10, wgpu::VertexFormat::Float32x3, offset_of!(GeometryVertex, normal)),
];
/// The fourth stream, [`InkVertex`].
pub(crate) const INK_ATTRIBUTES: [wgpu::VertexAttribute; 2] = [
    location(11, wgpu::VertexFormat::Snorm16x2, offset_of!(InkVertex, wash)),
    location(12, wgpu::VertexFormat::Unorm8x4, offset_of!(InkVertex, amount)),
];

fn stream<T>(attributes: &[wgpu::VertexAttribute]) -> Option<wgpu::VertexBufferLayout<'_>> {
    let array_stride = size_of::<T>() as u64;
    Some(wgpu::VertexBufferLayout { array_stride, step_mode: wgpu::VertexStepMode::Vertex, attributes })
}

fn constant(value: bool) -> f64 {
    f64::from(u8::from(value))
}

impl InkPipelines {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        use wgpu::TextureViewDimension::{D2, D2Array};
        let sampler = |label, mode| {
            device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some(label),
                address_mode_u: mode,
                address_mode_v: mode,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..Default::default()
            })
        };
        let module = |label, wgsl: &'static str| {
            let source = wgpu::ShaderSource::Wgsl(wgsl.into());
            device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(label), source })
        };
        Self {
            model: surface::layout(
                device,
                "pelage ink model",
                &[
                    surface::uniform::<InkModel>(0, false),
                    surface::texture(1, D2),
                    surface::texture(2, D2),
                    surface::texture(3, D2Array),
                    surface::texture(4, D2),
                    surface::sampler(5),
                    surface::sampler(6),
                ],
            ),
            tile_sampler: sampler("pelage ink tiles", wgpu::AddressMode::Repeat),
            clamp_sampler: sampler("pelage ink stroke", wgpu::AddressMode::ClampToEdge),
            normals_module: module("pelage ink normals", ink_normals::WGSL),
            fur_module: module("pelage ink fur", ink_fur::WGSL),
            screens: HashMap::new(),
            surfaces: HashMap::new(),
            targets: None,
        }
    }

    /// The textures for a picture of this size, unless a living frame still draws from those of the last.
    fn targets(&mut self, device: &wgpu::Device, size: [u32; 2]) -> Arc<InkTargets> {
        let free = self.targets.take().filter(|t| t.size == size && Arc::strong_count(t) == 1);
        let targets = free.unwrap_or_else(|| Arc::new(InkTargets::new(device, size)));
        self.targets = Some(targets.clone());
        targets
    }

    fn model_group(
        &self,
        device: &wgpu::Device,
        layouts: &SurfaceLayouts,
        ink: &ModelInk,
        constants: &InkModel,
    ) -> wgpu::BindGroup {
        let buffer = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("pelage ink model"),
            contents: bytemuck::bytes_of(constants),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let view = |binding, view| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) };
        let sampler = |binding, s| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::Sampler(s) };
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("pelage ink model"),
            layout: &self.model,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() },
                view(1, &ink.stroke),
                view(2, &ink.wash),
                view(3, ink.fur.as_ref().unwrap_or(&layouts.white_array)),
                view(4, &ink.paper),
                sampler(5, &self.tile_sampler),
                sampler(6, &self.clamp_sampler),
            ],
        })
    }

    fn surface(
        &mut self,
        device: &wgpu::Device,
        layouts: &SurfaceLayouts,
        options: &RendererOptions,
        key: InkKey,
    ) -> wgpu::RenderPipeline {
        if let Some(made) = self.surfaces.get(&key) {
            return made.clone();
        }
        let (module, vertex, fragment) = match key.shader {
            InkShader::Normals => (&self.normals_module, "vs_ink", "fs_ink"),
            InkShader::Fins => (&self.fur_module, "vs_ink_fins", "fs_ink_fins"),
            InkShader::Shells => (&self.fur_module, "vs_ink_shells", "fs_ink_shells"),
        };
        let mut groups = vec![Some(&layouts.frame), Some(&layouts.material), Some(&self.model)];
        groups.extend(layouts.fins.as_ref().filter(|_| key.shader == InkShader::Fins).map(Some));
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(fragment),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let mut constants = vec![
            ("BASE_COLOR_TEXTURE", constant(key.base_color_texture)),
            ("CUTOUT", constant(key.cutout)),
            ("LEAN", constant(key.lean)),
        ];
        let normals = key.shader == InkShader::Normals;
        if normals {
            constants.push(("SPHERE_MAP", f64::from(key.sphere_map as u8)));
            constants.push(("ON_SCREEN", constant(key.on_screen)));
            constants.push(("FUR_STROKES", constant(key.fur)));
        }
        let compilation_options = wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
        let both = [stream::<GeometryVertex>(&GEOMETRY_ATTRIBUTES), stream::<AttributeVertex>(&ATTRIBUTE_ATTRIBUTES)];
        let ink = [stream::<GeometryVertex>(&REST_ATTRIBUTES), stream::<InkVertex>(&INK_ATTRIBUTES)];
        let four = [both[0].clone(), both[1].clone(), ink[0].clone(), ink[1].clone()];
        let color = |format, blend| Some(wgpu::ColorTargetState { format, blend, write_mask: wgpu::ColorWrites::ALL });
        let over = Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING);
        let targets = if normals {
            vec![color(NORMALS_FORMAT, None), color(SURFACES_FORMAT, None)]
        } else {
            vec![color(options.color_format, over)]
        };
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(fragment),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some(vertex),
                compilation_options: compilation_options.clone(),
                buffers: match key.shader {
                    InkShader::Normals => &four,
                    InkShader::Shells => &both,
                    // Fins read their vertices from storage buffers.
                    InkShader::Fins => &[],
                },
            },
            primitive: wgpu::PrimitiveState {
                front_face: if key.mirrored { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw },
                cull_mode: (!key.double_sided).then_some(wgpu::Face::Back),
                ..Default::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: if normals { DEPTH_FORMAT } else { options.depth_format },
                depth_write_enabled: Some(normals),
                depth_compare: Some(depth_compare(!normals, options.reversed_depth)),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState {
                count: if normals { 1 } else { options.sample_count },
                ..Default::default()
            },
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some(fragment),
                compilation_options,
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        });
        self.surfaces.entry(key).or_insert(pipeline).clone()
    }

    fn screen(&mut self, device: &wgpu::Device, options: &RendererOptions, screen: Screen) -> wgpu::RenderPipeline {
        let make = || screen_pipeline(device, options, screen);
        self.screens.entry(screen).or_insert_with(make).clone()
    }
}

fn screen_pipeline(device: &wgpu::Device, options: &RendererOptions, screen: Screen) -> wgpu::RenderPipeline {
    let (label, wgsl, fragment, constants) = match screen {
        Screen::Features { all_below } => {
            ("pelage ink features", ink_features::WGSL, "fs_features", vec![("ALL_BELOW", constant(all_below))])
        }
        Screen::Dilate { squares } => {
            ("pelage ink dilate", ink_dilate::WGSL, "fs_dilate", vec![("SQUARES", constant(squares))])
        }
        Screen::Stroke { printed, template } => {
            let constants =
                [("SQUARES", printed), ("HARD", printed), ("TEMPLATE", template)].map(|(name, v)| (name, constant(v)));
            ("pelage ink stroke", ink_stroke::WGSL, "fs_stroke", constants.to_vec())
        }
        Screen::Composite { show, picture } => {
            let constants = vec![("SHOW", f64::from(show as u8)), ("PICTURE", constant(picture))];
            ("pelage ink composite", ink_composite::WGSL, "fs_composite", constants)
        }
    };
    let composite = matches!(screen, Screen::Composite { .. });
    let format = match screen {
        Screen::Features { .. } | Screen::Dilate { .. } => PAIRS_FORMAT,
        Screen::Stroke { .. } => SURFACES_FORMAT,
        Screen::Composite { .. } => options.color_format,
    };
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(wgsl.into()),
    });
    let compilation_options = wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(label),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vs_screen"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: composite.then(|| wgpu::DepthStencilState {
            format: options.depth_format,
            depth_write_enabled: Some(true),
            depth_compare: Some(depth_compare(false, options.reversed_depth)),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState {
            count: if composite { options.sample_count } else { 1 },
            ..Default::default()
        },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(fragment),
            compilation_options,
            targets: &[Some(wgpu::ColorTargetState {
                format,
                blend: composite.then_some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Binds textures and samplers by their numbers in the shader; 0 is the frame's constants.
fn screen_group(
    device: &wgpu::Device,
    pipeline: &wgpu::RenderPipeline,
    constants: Option<&wgpu::Buffer>,
    views: &[(u32, &wgpu::TextureView)],
    samplers: &[(u32, &wgpu::Sampler)],
) -> wgpu::BindGroup {
    let buffer = constants.map(|b| wgpu::BindGroupEntry { binding: 0, resource: b.as_entire_binding() });
    let view = |(binding, view): &(u32, &'_ wgpu::TextureView)| (*binding, wgpu::TextureView::clone(view));
    let views: Vec<_> = views.iter().map(view).collect();
    let mut entries: Vec<_> = buffer.into_iter().collect();
    entries.extend(views.iter().map(|(binding, view)| wgpu::BindGroupEntry {
        binding: *binding,
        resource: wgpu::BindingResource::TextureView(view),
    }));
    entries.extend(samplers.iter().map(|(binding, sampler)| wgpu::BindGroupEntry {
        binding: *binding,
        resource: wgpu::BindingResource::Sampler(sampler),
    }));
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    })
}

/// What pipelines and bind groups are made with.
#[derive(Clone, Copy)]
pub(crate) struct Making<'a> {
    pub(crate) device: &'a wgpu::Device,
    pub(crate) layouts: &'a SurfaceLayouts,
    pub(crate) options: &'a RendererOptions,
    pub(crate) clip_from_view: Mat4,
}

/// What an instance draws in this frame. `ink`: of its model.
pub(crate) fn plan(
    making: Making<'_>,
    pipelines: &mut InkPipelines,
    params: &FrameParams,
    ink_params: &InkParams,
    instance: &Instance,
    ink: &ModelInk,
) -> InkDraws {
    let Making { device, layouts, options, .. } = making;
    let model = instance.model();
    let constants = InkModel::new(ink, ink_params, params.camera.view_from_world, making.clip_from_view);
    let has_strokes = ink.fur.is_some() && constants.fur > 0.0;
    let mirrored = skinning::handedness_of(Mat3::from_mat4(instance.transform)) < 0.0;
    let mut pipeline = |shader, part: &Part| {
        let fins = shader == InkShader::Fins;
        let key = InkKey {
            shader,
            base_color_texture: part.has_texture,
            cutout: part.cutout,
            lean: shader != InkShader::Normals && model.varies().lean,
            double_sided: part.double_sided || fins,
            mirrored: mirrored && !fins,
            fur: shader == InkShader::Normals && has_strokes && part.furred,
            sphere_map: if shader == InkShader::Normals { ink_params.sphere_map } else { SphereMapForm::default() },
            on_screen: shader == InkShader::Normals && ink_params.anchoring == Anchoring::Screen,
        };
        pipelines.surface(device, layouts, options, key)
    };
    let mut of = |shader, wanted: &dyn Fn(&Part) -> bool| -> Vec<_> {
        let parts = model.parts().iter().enumerate().filter(|(_, part)| wanted(part));
        parts.map(|(index, part)| (index, pipeline(shader, part))).collect()
    };
    let normals = of(InkShader::Normals, &|_| true);
    // Strokes are of the painting alone.
    let painted = has_strokes && ink_params.show == crate::ink::InkShow::Painting;
    let shells = if painted { of(InkShader::Shells, &|part| part.furred) } else { Vec::new() };
    let fins = (painted && params.fins && model.fins().is_some() && layouts.fins.is_some())
        .then(|| of(InkShader::Fins, &|part| !part.fins.is_empty()));
    let fins = fins.and_then(|parts| fins::bind(device, layouts, instance, parts));
    InkDraws { group: pipelines.model_group(device, layouts, ink, &constants), normals, shells, fins }
}

/// Compiles what a model needs in ink.
pub(crate) fn compile(
    making: Making<'_>,
    pipelines: &mut InkPipelines,
    params: &FrameParams,
    ink_params: &InkParams,
    model: &Model,
) {
    if let Some(ink) = model.ink() {
        plan(making, pipelines, params, ink_params, &Instance::new(model), ink);
    }
    for screen in screens(ink_params) {
        pipelines.screen(making.device, making.options, screen);
    }
}

/// The passes over the picture, in their order.
fn screens(params: &InkParams) -> [Screen; 4] {
    let printed = params.printed_lines;
    [
        Screen::Features { all_below: params.features == FeatureRule::AllBelow },
        Screen::Dilate { squares: printed },
        Screen::Stroke { printed, template: params.template },
        Screen::Composite { show: ScreenShow::from(params.show), picture: params.background == InkBackground::Picture },
    ]
}

/// What is needed to record the passes before the application's.
pub(crate) struct Recording<'a> {
    pub(crate) making: Making<'a>,
    pub(crate) params: &'a InkParams,
    /// Left, top, width and height of the part of the picture that there is something in.
    pub(crate) rect: [u32; 4],
    /// Group 0 of the passes over surfaces.
    pub(crate) frame: &'a wgpu::BindGroup,
    pub(crate) instances: &'a [Drawn],
}

/// Records all passes but those in the application's own, and returns what paints the sheet there.
pub(crate) fn record(
    pipelines: &mut InkPipelines,
    encoder: &mut wgpu::CommandEncoder,
    recording: &Recording<'_>,
    mark: &mut dyn FnMut(&mut wgpu::CommandEncoder, PassId),
) -> Sheet {
    let Recording { making: Making { device, options, layouts, clip_from_view }, params, .. } = *recording;
    let targets = pipelines.targets(device, params.target_px);
    ink_normals::record(encoder, &targets.as_targets(), recording, options.reversed_depth);
    mark(encoder, PassId::InkNormals);

    let constants = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("pelage ink frame"),
        contents: bytemuck::bytes_of(&InkFrame::new(params, clip_from_view)),
        usage: wgpu::BufferUsages::UNIFORM,
    });
    // One sheet for all: that of the first who is on it.
    let paper = recording.instances.iter().find_map(|i| i.model.ink()).map_or(&layouts.white, |ink| &ink.paper);
    let [features, dilate, stroke, composite] = screens(params).map(|s| pipelines.screen(device, options, s));
    let t = &*targets;
    let tile = &pipelines.tile_sampler;
    let group = |pipeline: &wgpu::RenderPipeline, views: &[_], samplers: &[_]| {
        screen_group(device, pipeline, Some(&constants), views, samplers)
    };
    let seen = group(&features, &[(1, &t.normals), (2, &t.surfaces)], &[]);
    fill(encoder, recording, "pelage ink features", &t.features, &features, &seen);
    mark(encoder, PassId::InkFeatures);
    let seen = group(&dilate, &[(1, &t.features)], &[]);
    fill(encoder, recording, "pelage ink dilate", &t.rows, &dilate, &seen);
    mark(encoder, PassId::InkDilate);
    let views = [(1, &t.normals), (2, &t.surfaces), (3, &t.features), (4, &t.rows), (5, paper)];
    let seen = group(&stroke, &views, &[(6, tile)]);
    fill(encoder, recording, "pelage ink stroke", &t.strokes, &stroke, &seen);
    mark(encoder, PassId::InkStroke);
    let shown = if params.show == crate::ink::InkShow::Features { &t.features } else { &t.strokes };
    let views = [(1, &t.normals), (2, &t.surfaces), (3, shown), (4, &t.depth), (5, paper)];
    let seen = group(&composite, &views, &[(6, tile), (7, &pipelines.clamp_sampler)]);
    Sheet { pipeline: composite, group: seen, _targets: targets }
}

impl InkTargets {
    fn as_targets(&self) -> ink_normals::Targets<'_> {
        ink_normals::Targets { normals: &self.normals, surfaces: &self.surfaces, depth: &self.depth }
    }
}

/// Records a pass that fills the painted part of a texture.
fn fill(
    encoder: &mut wgpu::CommandEncoder,
    recording: &Recording<'_>,
    label: &str,
    view: &wgpu::TextureView,
    pipeline: &wgpu::RenderPipeline,
    group: &wgpu::BindGroup,
) {
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store };
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops,
        })],
        ..Default::default()
    });
    let [left, top, width, height] = recording.rect;
    if width > 0 && height > 0 {
        pass.set_scissor_rect(left, top, width, height);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.draw(0..3, 0..1);
    }
}

impl Sheet {
    /// Paints it into the application's pass.
    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.draw(0..3, 0..1);
    }
}

impl InkDraws {
    /// Whether it has no strokes of fur.
    pub(crate) fn is_bald(&self) -> bool {
        self.shells.is_empty() && self.fins.is_none()
    }

    /// Parts and pipelines of `ink_normals`.
    pub(crate) fn normals(&self) -> &[(usize, wgpu::RenderPipeline)] {
        &self.normals
    }

    /// Group 2 of the passes over surfaces.
    pub(crate) fn group(&self) -> &wgpu::BindGroup {
        &self.group
    }

    /// Parts and pipelines of the strokes on shells.
    pub(crate) fn shells(&self) -> &[(usize, wgpu::RenderPipeline)] {
        &self.shells
    }

    /// What is drawn of the fins.
    pub(crate) fn fins(&self) -> Option<&FinDraws> {
        self.fins.as_ref()
    }
}
