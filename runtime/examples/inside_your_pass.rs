//! Draws fur inside an application's own render pass, with opaque objects of the application and a shared depth buffer.
//!
//! ```text
//! cargo run --release --example inside_your_pass -- [PACKAGE.pelage] [PICTURE.png]
//! ```
//!
//! Without a package it uses a small furry sphere. The picture shows the model twice. Fur and the application's ground
//! and post occlude each other.

#![allow(clippy::unwrap_used, reason = "an example stops at the first surprise")]

#[path = "support/mod.rs"]
mod support;

use pelage_runtime::glam::{Mat4, Quat, Vec3, Vec4};
use pelage_runtime::{Camera, FrameParams, Instance, Renderer, RendererOptions, wgpu};
use pelage_stage::{Canvas, Gpu};
use wgpu::util::DeviceExt;

const SIZE: (u32, u32) = (834, 424);

fn main() {
    let mut arguments = std::env::args().skip(1);
    let package = support::package_or_sphere(arguments.next());
    let picture = arguments.next().unwrap_or_else(|| "target/inside_your_pass.png".into());

    // Set up the application: a device, targets with a depth buffer, and a scene.
    let gpu = Gpu::with(wgpu::Features::TEXTURE_COMPRESSION_BC, Some(wgpu::Limits::default())).unwrap();
    let options = RendererOptions::default();
    let targets = Canvas::new(&gpu, SIZE, &(&options).into());

    // Set up pelage: a renderer for this kind of pass, a model, and two copies of it.
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options).unwrap();
    let model = renderer.load_bytes(&package).unwrap();
    let bounds = model.manifest().bounds;
    let radius = bounds.radius + model.manifest().fur.height_m;
    let side = Vec3::X * radius * 1.15;
    let centred = Mat4::from_translation(-Vec3::from(bounds.center));
    let turned = Mat4::from_scale_rotation_translation(Vec3::splat(0.9), Quat::from_rotation_y(2.0), side);
    let left = Instance::new(0, &model).at(Mat4::from_translation(-side) * centred);
    let right = Instance::new(1, &model).at(turned * centred);

    let aspect = SIZE.0 as f32 / SIZE.1 as f32;
    let camera = Camera::framing(Vec3::ZERO, radius * 1.7, Vec3::new(0.0, 0.35, 1.0), 0.6, aspect);
    let clip_from_world = camera.projection.clip_from_view(options.reversed_depth) * camera.view_from_world;
    let scene = Scene::new(&gpu, &options, clip_from_world, radius);

    // Draw a frame: prepare outside the pass, draw inside it.
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let params = FrameParams::new(camera, SIZE.into());
    let frame = renderer.prepare(&mut encoder, &params, [&left, &right]).unwrap();
    let mut pass = targets.pass(&mut encoder, "application", Some(wgpu::Color { r: 0.35, g: 0.45, b: 0.6, a: 1.0 }));
    scene.draw(&mut pass);
    frame.draw(&mut pass);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);

    image::save_buffer(&picture, &targets.texels(&gpu).unwrap(), SIZE.0, SIZE.1, image::ColorType::Rgba8).unwrap();
    println!("{picture}: drawn by {}", gpu.info.name);
    for pass in &frame.report().passes {
        println!("{}: {} ({})", pass.name, if pass.ran { "ran" } else { "did not run" }, pass.reason);
    }
}

/// Opaque objects of the application: a ground and a post, with the application's own pipeline.
struct Scene {
    pipeline: wgpu::RenderPipeline,
    vertices: wgpu::Buffer,
    count: u32,
}

const SCENE_WGSL: &str = "
struct Varying { @builtin(position) position: vec4<f32>, @location(0) color: vec4<f32> }
@vertex fn vertex(@location(0) position: vec4<f32>, @location(1) color: vec4<f32>) -> Varying {
    return Varying(position, color);
}
@fragment fn fragment(in: Varying) -> @location(0) vec4<f32> { return in.color; }
";

impl Scene {
    fn new(gpu: &Gpu, options: &RendererOptions, clip_from_world: Mat4, radius: f32) -> Self {
        // Builds a box from two corners; each side has its own shade.
        let cuboid = |low: Vec3, high: Vec3, color: Vec3| {
            let corner = |i: usize| Vec3::select(corner_mask(i), high, low);
            let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
            let shades = [0.6, 0.5, 0.3, 1.0, 0.4, 0.8];
            let mut out = Vec::new();
            for (side, shade) in sides.iter().zip(shades) {
                for i in [0, 1, 2, 0, 2, 3] {
                    out.push([clip_from_world * corner(side[i]).extend(1.0), (color * shade).extend(1.0)]);
                }
            }
            out
        };
        let r = radius;
        let ground =
            cuboid(Vec3::new(-4.0, -1.05, -2.0) * r, Vec3::new(4.0, -0.75, 2.0) * r, Vec3::new(0.2, 0.35, 0.12));
        let post = cuboid(Vec3::new(-0.75, -0.75, 0.6) * r, Vec3::new(-0.45, 0.9, 0.9) * r, Vec3::new(0.5, 0.12, 0.08));
        let vertices: Vec<[Vec4; 2]> = ground.into_iter().chain(post).collect();
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(SCENE_WGSL.into()),
        });
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("application"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[Some(wgpu::VertexBufferLayout {
                    array_stride: 32,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &wgpu::vertex_attr_array![0 => Float32x4, 1 => Float32x4],
                })],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: options.depth_format,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Less),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count: options.sample_count, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: Default::default(),
                targets: &[Some(options.color_format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let count = vertices.len() as u32;
        let floats: Vec<f32> = vertices.iter().flatten().flat_map(Vec4::to_array).collect();
        let bytes: Vec<u8> = floats.iter().flat_map(|v| v.to_ne_bytes()).collect();
        let vertices = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents: &bytes,
            usage: wgpu::BufferUsages::VERTEX,
        });
        Self { pipeline, vertices, count }
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.draw(0..self.count, 0..1);
    }
}

/// Returns which coordinates of a box's corner are the upper ones: bit 0 for x, bit 1 for y, bit 2 for z.
fn corner_mask(corner: usize) -> pelage_runtime::glam::BVec3 {
    pelage_runtime::glam::BVec3::new(corner & 1 != 0, corner & 2 != 0, corner & 4 != 0)
}
