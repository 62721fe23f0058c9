//! Scene of an application, with its own pipelines and shader. Its boxes are drawn into the shadow maps and receive
//! shadows.

use pelage_runtime::glam::{Mat4, Vec3, Vec4};
use pelage_runtime::shared::receiver;
use pelage_runtime::{CasterPass, Frame, LightView, RendererOptions, ShadowMaps, wgpu};
use wgpu::util::DeviceExt;

/// An axis-aligned box of one colour; corners in metres.
pub struct Cuboid {
    /// Corner with the lowest coordinates.
    pub low: Vec3,
    /// Corner with the highest coordinates.
    pub high: Vec3,
    /// Colour, linear RGB.
    pub color: Vec3,
}

/// Opaque objects and pipelines of the application.
pub struct Scene {
    vertices: wgpu::Buffer,
    count: u32,
    sampler: wgpu::Sampler,
    pipeline: wgpu::RenderPipeline,
    depth_pipelines: [wgpu::RenderPipeline; 2],
}

/// Shader of the application. `light_received` and `ShadowReceiver` come from pelage's shader source, which is
/// prepended.
const SCENE_WGSL: &str = "
struct View {
    clip_from_world: mat4x4<f32>,
    // Position of the light and 1, or the direction towards it and 0.
    light_ws: vec4<f32>,
}
@group(0) @binding(0) var<uniform> view: View;
@group(1) @binding(0) var<uniform> receiver: ShadowReceiver;
@group(1) @binding(1) var shadow_map: texture_2d<f32>;
@group(1) @binding(2) var shadow_sampler: sampler;

struct Varying {
    @builtin(position) position: vec4<f32>,
    @location(0) position_ws: vec3<f32>,
    @location(1) normal_ws: vec3<f32>,
    @location(2) color: vec3<f32>,
}
@vertex fn vertex(@location(0) position: vec3<f32>, @location(1) normal: vec3<f32>, \
    @location(2) color: vec3<f32>) -> Varying {
    return Varying(view.clip_from_world * vec4(position, 1.0), position, normal, color);
}
@fragment fn fragment(in: Varying) -> @location(0) vec4<f32> {
    let towards_light = normalize(view.light_ws.xyz - in.position_ws * view.light_ws.w);
    let n_dot_l = dot(normalize(in.normal_ws), towards_light);
    let light = max(n_dot_l, 0.0) * light_received(shadow_map, shadow_sampler, in.position_ws, n_dot_l, receiver);
    return vec4(in.color * (0.2 + 0.8 * light), 1.0);
}
@vertex fn vertex_depth(@location(0) position: vec3<f32>) -> @builtin(position) vec4<f32> {
    return view.clip_from_world * vec4(position, 1.0);
}
";

impl Scene {
    /// Uploads the boxes. Creates pipelines for passes as described by `options`, and for the shadow maps.
    pub fn new(device: &wgpu::Device, options: &RendererOptions, cuboids: &[Cuboid]) -> Self {
        let vertices: Vec<[Vec3; 3]> = cuboids.iter().flat_map(Cuboid::triangles).collect();
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("application"),
            source: wgpu::ShaderSource::Wgsl(format!("{}{SCENE_WGSL}", receiver::WGSL).into()),
        });
        // The first pipeline draws the picture. The other two draw only depth, in the formats that pelage requires.
        let pipeline = |caster: Option<CasterPass>| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("application"),
                layout: None,
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some(if caster.is_some() { "vertex_depth" } else { "vertex" }),
                    compilation_options: Default::default(),
                    buffers: &[Some(wgpu::VertexBufferLayout {
                        array_stride: 36,
                        step_mode: wgpu::VertexStepMode::Vertex,
                        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x3],
                    })],
                },
                primitive: wgpu::PrimitiveState {
                    cull_mode: caster.map_or(Some(wgpu::Face::Back), CasterPass::cull_mode),
                    ..Default::default()
                },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: caster.map_or(options.depth_format, |_| ShadowMaps::DEPTH_FORMAT),
                    depth_write_enabled: Some(true),
                    depth_compare: Some(caster.map_or(wgpu::CompareFunction::Less, CasterPass::compare)),
                    stencil: wgpu::StencilState::default(),
                    bias: wgpu::DepthBiasState::default(),
                }),
                multisample: wgpu::MultisampleState {
                    count: caster.map_or(options.sample_count, |_| 1),
                    ..Default::default()
                },
                fragment: caster.is_none().then_some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("fragment"),
                    compilation_options: Default::default(),
                    targets: &[Some(options.color_format.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        Self {
            count: vertices.len() as u32,
            vertices: device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("application"),
                contents: bytemuck::cast_slice(&vertices),
                usage: wgpu::BufferUsages::VERTEX,
            }),
            sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
            pipeline: pipeline(None),
            depth_pipelines: [CasterPass::Nearest, CasterPass::Farthest].map(|pass| pipeline(Some(pass))),
        }
    }

    /// Draws the objects into the application's pass, with the shadows of `frame` on them.
    ///
    /// * `light_ws`: position and 1 for a point light; direction towards the light and 0 for a distant one
    pub fn draw(
        &self,
        device: &wgpu::Device,
        pass: &mut wgpu::RenderPass<'_>,
        clip_from_world: Mat4,
        light_ws: Vec4,
        frame: &Frame,
    ) {
        let receiver = uniform(device, bytemuck::bytes_of(&frame.shadow_receiver()));
        let shadow = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("application: shadows"),
            layout: &self.pipeline.get_bind_group_layout(1),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: receiver.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(frame.shadow_map()) },
                wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::Sampler(&self.sampler) },
            ],
        });
        pass.set_bind_group(1, &shadow, &[]);
        self.record(device, pass, &self.pipeline, clip_from_world, light_ws);
    }

    /// Draws the depth of the objects into one of the shadow maps.
    pub fn draw_depth(
        &self,
        device: &wgpu::Device,
        pass: &mut wgpu::RenderPass<'_>,
        view: &LightView,
        which: CasterPass,
    ) {
        let pipeline = &self.depth_pipelines[usize::from(which == CasterPass::Farthest)];
        self.record(device, pass, pipeline, view.clip_from_world, Vec4::ZERO);
    }

    /// Records the draw with a new view buffer each time. Writing to the old buffer would change passes that were
    /// recorded before.
    fn record(
        &self,
        device: &wgpu::Device,
        pass: &mut wgpu::RenderPass<'_>,
        pipeline: &wgpu::RenderPipeline,
        clip_from_world: Mat4,
        light_ws: Vec4,
    ) {
        let mut view = clip_from_world.to_cols_array().to_vec();
        view.extend(light_ws.to_array());
        let view = uniform(device, bytemuck::cast_slice(&view));
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("application: view"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: view.as_entire_binding() }],
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.draw(0..self.count, 0..1);
    }
}

fn uniform(device: &wgpu::Device, contents: &[u8]) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::UNIFORM;
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
}

impl Cuboid {
    /// Returns position, normal and colour of the 36 triangle corners, counter-clockwise seen from outside.
    fn triangles(&self) -> Vec<[Vec3; 3]> {
        let half = 0.5 * (self.high - self.low);
        let mut out = Vec::new();
        for (k, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)] {
            let normal = Vec3::AXES[k] * sign;
            let (u, v) = (Vec3::AXES[(k + 1) % 3] * sign, Vec3::AXES[(k + 2) % 3]);
            for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                out.push([self.low + half + half * (normal + u * a + v * b), normal, self.color]);
            }
        }
        out
    }
}
