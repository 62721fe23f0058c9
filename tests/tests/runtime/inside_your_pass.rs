//! Tests that opaque objects of the application and the fur can share one pass and one depth buffer.

#![allow(clippy::unwrap_used, reason = "tests")]

use pelage_runtime::glam::Vec3;
use pelage_runtime::{Camera, FrameParams, Instance, Renderer, RendererOptions, wgpu};
use pelage_stage::{Canvas, Gpu};
use pelage_tests::gpu::gpu;
use pelage_tests::support::sphere::{SphereParams, package};

const SIZE: u32 = 96;

/// Returns the pipeline of a red wall that covers the left half of the picture; its depth is in clip space.
fn wall(gpu: &Gpu, options: &RendererOptions) -> wgpu::RenderPipeline {
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(
            "@vertex fn vertex(@builtin(vertex_index) i: u32, @builtin(instance_index) depth: u32) \
                -> @builtin(position) vec4<f32> {
                let corner = vec2(f32(i & 1u), f32(i >> 1u));
                return vec4(corner.x - 1.0, 2.0 * corner.y - 1.0, f32(depth) / 100.0, 1.0);
            }
            @fragment fn fragment() -> @location(0) vec4<f32> { return vec4(1.0, 0.0, 0.0, 1.0); }"
                .into(),
        ),
    });
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("wall"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState { topology: wgpu::PrimitiveTopology::TriangleStrip, ..Default::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: options.depth_format,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &[Some(options.color_format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

#[test]
fn fur_and_application_objects_occlude_each_other() {
    let Some(gpu) = gpu("fur_and_application_objects_occlude_each_other") else { return };
    let options = RendererOptions::default();
    let targets = Canvas::new(gpu, (SIZE, SIZE), &(&options).into());
    let wall = wall(gpu, &options);
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options).unwrap();
    let sphere = package(&SphereParams { quads: 8, texels: 16, strands: 40, ..SphereParams::default() });
    let instance = Instance::new(0, &renderer.load_bytes(&sphere).unwrap());
    let params = FrameParams::new(Camera::framing(Vec3::ZERO, 0.13, Vec3::Z, 0.6, 1.0), [SIZE; 2]);
    let at =
        |texels: &[u8], x: u32, y: u32| -> [u8; 4] { texels[((y * SIZE + x) * 4) as usize..][..4].try_into().unwrap() };
    // Columns: depth in per cent of the clip range; whether the wall is drawn before the fur; whether the wall is in
    // front of the fur.
    for (depth, first, wall_in_front) in [(1, true, true), (1, false, true), (99, true, false), (99, false, false)] {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let frame = renderer.prepare(&mut encoder, &params, [&instance]).unwrap();
        let mut pass = targets.pass(&mut encoder, "application", Some(wgpu::Color::TRANSPARENT));
        let draw_wall = |pass: &mut wgpu::RenderPass<'_>| {
            pass.set_pipeline(&wall);
            pass.draw(0..4, depth..depth + 1);
        };
        if first {
            draw_wall(&mut pass);
        }
        frame.draw(&mut pass);
        if !first {
            draw_wall(&mut pass);
        }
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        let texels = targets.texels(gpu).unwrap();
        let (left, right, corner) = (at(&texels, 30, 48), at(&texels, 66, 48), at(&texels, 1, 1));
        let red = [255, 0, 0, 255];
        assert_eq!(left == red, wall_in_front, "wall at {depth} %, first {first}: {left:?}");
        assert!(right != red && right[3] == 255, "beside the wall there is fur: {right:?}");
        assert_eq!(corner, red, "around the fur there is wall");
    }
}

#[test]
fn frames_in_one_submission_are_independent() {
    let Some(gpu) = gpu("frames_in_one_submission_are_independent") else { return };
    let options = RendererOptions::default();
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options).unwrap();
    let sphere =
        package(&SphereParams { quads: 8, texels: 16, strands: 40, skeleton: true, ..SphereParams::default() });
    let mut instance = Instance::new(0, &renderer.load_bytes(&sphere).unwrap());
    let views =
        [Vec3::Z, Vec3::X].map(|from| FrameParams::new(Camera::framing(Vec3::ZERO, 0.13, from, 0.6, 1.0), [SIZE; 2]));
    let motions = [0.1, 0.5].map(|time_s| pelage_runtime::Motion::Clip { clip: 0, time_s });
    let targets = [0, 1].map(|_| Canvas::new(gpu, (SIZE, SIZE), &(&options).into()));
    let mut draw = |together: bool| {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for k in 0..2 {
            instance.motion = motions[k].clone();
            let frame = renderer.prepare(&mut encoder, &views[k], [&instance]).unwrap();
            frame.draw(&mut targets[k].pass(&mut encoder, "application", Some(wgpu::Color::TRANSPARENT)));
            if !together {
                let full = std::mem::replace(&mut encoder, gpu.device.create_command_encoder(&Default::default()));
                gpu.queue.submit([full.finish()]);
            }
        }
        gpu.queue.submit([encoder.finish()]);
        targets.each_ref().map(|t| t.texels(gpu).unwrap())
    };
    let apart = draw(false);
    assert_ne!(apart[0], apart[1], "the two views must differ");
    assert_eq!(draw(true), apart);
}
