//! The pipelines of the ink style, made when they are first drawn with.

use super::blocks::InkModel;
use super::targets::{DEPTH_FORMAT, InkTargets, NORMALS_FORMAT, PAIRS_FORMAT, SURFACES_FORMAT};
use crate::RendererOptions;
use crate::ink::{InkShow, SphereMapForm};
use crate::model_ink::ModelInk;
use crate::passes::key::depth_compare;
use crate::passes::surface::{self, SurfaceLayouts, attribute, stream};
use crate::passes::{ink_composite, ink_dilate, ink_features, ink_fur, ink_normals, ink_stroke};
use pelage_formats::{GeometryVertex, InkVertex};
use std::collections::HashMap;
use std::mem::offset_of;
use std::sync::Arc;
use wgpu::util::DeviceExt;

/// A pass over the whole picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Screen {
    Features { all_below: bool },
    Dilate { squares: bool },
    Stroke { printed: bool, template: bool },
    Composite { show: InkShow, picture: bool, soft: bool },
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
    pub(super) shader: InkShader,
    pub(super) base_color_texture: bool,
    pub(super) cutout: bool,
    pub(super) lean: bool,
    pub(super) double_sided: bool,
    pub(super) mirrored: bool,
    pub(super) fur: bool,
    pub(super) sphere_map: SphereMapForm,
    pub(super) on_screen: bool,
}

/// Layouts and pipelines of the ink style, made when it is first drawn.
#[derive(Debug)]
pub(crate) struct InkPipelines {
    /// Group 2 of the passes over surfaces.
    model: wgpu::BindGroupLayout,
    pub(super) tile_sampler: wgpu::Sampler,
    pub(super) clamp_sampler: wgpu::Sampler,
    normals_module: wgpu::ShaderModule,
    fur_module: wgpu::ShaderModule,
    screens: HashMap<Screen, wgpu::RenderPipeline>,
    surfaces: HashMap<InkKey, wgpu::RenderPipeline>,
    /// Of the last frame.
    targets: Option<Arc<InkTargets>>,
}

/// The third stream: [`GeometryVertex`] as stored.
pub(crate) const REST_ATTRIBUTES: [wgpu::VertexAttribute; 2] = [
    attribute(9, wgpu::VertexFormat::Float32x3, offset_of!(GeometryVertex, position)),
    attribute(10, wgpu::VertexFormat::Float32x3, offset_of!(GeometryVertex, normal)),
];
/// The fourth stream, [`InkVertex`].
pub(crate) const INK_ATTRIBUTES: [wgpu::VertexAttribute; 2] = [
    attribute(11, wgpu::VertexFormat::Snorm16x2, offset_of!(InkVertex, wash)),
    attribute(12, wgpu::VertexFormat::Unorm8x4, offset_of!(InkVertex, amount)),
];

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
    pub(super) fn targets(&mut self, device: &wgpu::Device, size: [u32; 2]) -> Arc<InkTargets> {
        let free = self.targets.take().filter(|t| t.size == size && Arc::strong_count(t) == 1);
        let targets = free.unwrap_or_else(|| Arc::new(InkTargets::new(device, size)));
        self.targets = Some(targets.clone());
        targets
    }

    pub(super) fn model_group(
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

    pub(super) fn surface(
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
        let mut streams = match key.shader {
            InkShader::Normals | InkShader::Shells => surface::streams().to_vec(),
            InkShader::Fins => Vec::new(),
        };
        if normals {
            streams.extend([stream::<GeometryVertex>(&REST_ATTRIBUTES), stream::<InkVertex>(&INK_ATTRIBUTES)]);
        }
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
                buffers: &streams,
            },
            primitive: surface::primitive(key.mirrored, key.double_sided),
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

    pub(super) fn screen(
        &mut self,
        device: &wgpu::Device,
        options: &RendererOptions,
        screen: Screen,
    ) -> wgpu::RenderPipeline {
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
        Screen::Composite { show, picture, soft } => {
            let constants =
                vec![("SHOW", f64::from(show as u8)), ("PICTURE", constant(picture)), ("SOFT", constant(soft))];
            ("pelage ink composite", ink_composite::WGSL, "fs_composite", constants)
        }
    };
    let composite = matches!(screen, Screen::Composite { .. });
    let format = match screen {
        Screen::Features { .. } => PAIRS_FORMAT,
        Screen::Dilate { .. } | Screen::Stroke { .. } => SURFACES_FORMAT,
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
pub(super) fn screen_group(
    device: &wgpu::Device,
    pipeline: &wgpu::RenderPipeline,
    constants: &wgpu::Buffer,
    views: &[(u32, &wgpu::TextureView)],
    samplers: &[(u32, &wgpu::Sampler)],
) -> wgpu::BindGroup {
    let mut entries = vec![wgpu::BindGroupEntry { binding: 0, resource: constants.as_entire_binding() }];
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
