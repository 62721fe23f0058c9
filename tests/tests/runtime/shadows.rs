//! Tests of light in fur: layer-wise shadow maps, soft shadows, lights without shadow, and casters of the application.

#![allow(clippy::unwrap_used, reason = "tests")]

use pelage_runtime::formats::Shading;
use pelage_runtime::glam::{Mat4, Vec3, Vec4};
use pelage_runtime::shared::layer_shadow::slanted_path;
use pelage_runtime::shared::soft_shadow::soft_shadow;
use pelage_runtime::{
    Camera, CasterPass, Casters, Frame, FrameParams, Hooks, Instance, Light, LightView, MAX_FILL_LIGHTS, PassId,
    PenumbraForm, Projection, Renderer, RendererOptions, RuntimeError, SelfShadow, ShadowMaps, ShadowParams, SlantForm,
    Sphere, Style, wgpu,
};
use pelage_stage::Gpu;
use pelage_tests::gpu::gpu;
use pelage_tests::pictures::{Picture, difference, draw, read_map};
use pelage_tests::plane::{PlaneGroom, groomed_plane};
use pelage_tests::support::sphere::{self, SphereParams};

const SIZE: (u32, u32) = (64, 64);
const LAYERS: u32 = 8;
const OPACITY: u8 = 51;

fn renderer(gpu: &Gpu) -> Renderer {
    Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap()
}

fn towards(direction: Vec3) -> Light {
    Light::Directional { towards_light: direction, color: Vec3::ONE }
}

/// Returns shadow parameters with the density of the drawn layers.
fn as_drawn() -> ShadowParams {
    ShadowParams::default().with(|s| s.density = 1.0)
}

/// Returns a view of the plane at z = 0 straight from above.
fn above() -> FrameParams {
    let projection = Projection::Orthographic { height_m: 0.2, aspect: 1.0, near_m: 0.0, far_m: 2.0 };
    let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, projection);
    FrameParams::new(camera, SIZE.into()).with(|p| (p.light, p.shadows) = (towards(Vec3::Z), as_drawn()))
}

/// Owner number of the plane.
const PLANE: u64 = 0;
/// Owner number of the ball.
const BALL: u64 = 1;

fn furry_plane(renderer: &Renderer, layers: u32, opacity: u8) -> Instance {
    // Upright hair would be black in light along it, so it is lit uniformly from all sides.
    let shading = Shading {
        ambient: [0.2; 3],
        diffuse: [0.8; 3],
        diffuse_exponent: 0.0,
        specular: [0.0; 3],
        ..Shading::default()
    };
    let package = groomed_plane(layers, opacity, shading, &PlaneGroom::default());
    Instance::new(PLANE, &renderer.load_bytes(&package).unwrap())
}

/// Prepares a frame and submits the recorded commands.
fn prepare(gpu: &Gpu, renderer: &mut Renderer, params: &FrameParams, instances: &[&Instance]) -> Frame {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let frame = renderer.prepare(&mut encoder, params, instances.iter().copied()).unwrap();
    gpu.queue.submit([encoder.finish()]);
    frame
}

fn texel(maps: &ShadowMaps, point: Vec3) -> ([u32; 2], Vec4) {
    let place = maps.view().map_from_world * point.extend(1.0);
    let size = maps.layers().or(maps.width()).unwrap().width() as f32;
    ([place.x, place.y].map(|x| (x / place.w * size) as u32), place)
}

/// Returns the transmittance above a point of the mesh surface, for each of the layer-wise maps.
fn transmittances(gpu: &Gpu, maps: &ShadowMaps, point: Vec3) -> Vec<f32> {
    let layers = maps.layers().unwrap();
    let ([x, y], _) = texel(maps, point);
    (0..layers.depth_or_array_layers())
        .map(|layer| read_map(gpu, layers, layer)[(y * layers.width() + x) as usize][0])
        .collect()
}

#[test]
fn layer_shadow_maps_hold_the_product_of_the_layers_above() {
    let Some(gpu) = gpu("layer_shadow_maps_hold_the_product_of_the_layers_above") else { return };
    let mut renderer = renderer(gpu);
    let plane = furry_plane(&renderer, LAYERS, OPACITY);
    let alpha = f32::from(OPACITY) / 255.0;
    // At larger angles, light would leave the plane before it leaves the fur.
    for degrees in [0.0f32, 40.0, 60.0, 70.0] {
        let angle = degrees.to_radians();
        for (slant, path) in [(SlantForm::Corrected, (1.0 / angle.cos()).min(4.0)), (SlantForm::Printed, 1.0)] {
            let light = towards(Vec3::new(angle.sin(), 0.0, angle.cos()));
            let params = above().with(|p| (p.light, p.study.light_slant) = (light, slant));
            let frame = prepare(gpu, &mut renderer, &params, &[&plane]);
            let found = transmittances(gpu, frame.shadows().unwrap(), Vec3::ZERO);
            assert_eq!(found.len(), LAYERS as usize);
            for (layer, t) in found.into_iter().enumerate() {
                let crossed = (LAYERS as usize - 1 - layer) as f32;
                let expected = (1.0 - alpha).powf(path * crossed);
                assert!(
                    (t - expected).abs() < 2e-3,
                    "{degrees} degrees, {slant:?}, layer {layer}: {t}, expected {expected}"
                );
            }
        }
    }
}

#[test]
fn density_scales_the_optical_depth() {
    let Some(gpu) = gpu("density_scales_the_optical_depth") else { return };
    let mut renderer = renderer(gpu);
    let plane = furry_plane(&renderer, LAYERS, OPACITY);
    let through = (1.0 - f32::from(OPACITY) / 255.0).powi(LAYERS as i32 - 1);
    let mut greens = Vec::new();
    for density in [0.0, 0.4, 1.0, 2.0] {
        let params = above().with(|p| p.shadows.density = density);
        let frame = prepare(gpu, &mut renderer, &params, &[&plane]);
        let found = transmittances(gpu, frame.shadows().unwrap(), Vec3::ZERO)[0];
        assert!((found - through.powf(density)).abs() < 3e-3, "density {density}: {found}");
        greens.push(draw(gpu, &mut renderer, &params, &[&plane]).mean(1));
    }
    assert!(greens.windows(2).all(|w| w[0] > w[1] + 1.0), "denser is darker: {greens:?}");
}

/// Checks that the light at the mesh surface is the same if the maps have fewer or more layers than are drawn.
#[test]
fn shadow_map_layer_count_keeps_the_density() {
    let Some(gpu) = gpu("shadow_map_layer_count_keeps_the_density") else { return };
    let mut renderer = renderer(gpu);
    let plane = furry_plane(&renderer, LAYERS, OPACITY);
    let expected = (1.0 - f32::from(OPACITY) / 255.0).powi(LAYERS as i32 - 1);
    for map_layers in [2, 3, 5, LAYERS, 15, 22] {
        let params = above().with(|p| p.shadows.map_layers = Some(map_layers));
        let frame = prepare(gpu, &mut renderer, &params, &[&plane]);
        let found = transmittances(gpu, frame.shadows().unwrap(), Vec3::ZERO);
        assert_eq!(found.len(), map_layers as usize);
        assert!((found[0] - expected).abs() < 4e-3, "{map_layers} map layers: {}, expected {expected}", found[0]);
        assert!(found.windows(2).all(|w| w[0] <= w[1]) && found.last() == Some(&1.0), "{found:?}");
    }
    // Coarser maps must give nearly the same picture.
    let fine = draw(gpu, &mut renderer, &above(), &[&plane]);
    let coarse = draw(gpu, &mut renderer, &above().with(|p| p.shadows.map_layers = Some(2)), &[&plane]);
    let found = difference(&fine, &coarse);
    assert!(found.mean > 0.0 && found.mean < 6.0, "{found:?}");
}

#[test]
fn shadow_map_texels_stay_within_0_and_1() {
    let Some(gpu) = gpu("shadow_map_texels_stay_within_0_and_1") else { return };
    let mut renderer = renderer(gpu);
    let params = SphereParams { quads: 8, texels: 16, strands: 200, ..SphereParams::default() };
    let ball = Instance::new(BALL, &renderer.load_bytes(&sphere::package(&params)).unwrap());
    let camera = Camera::framing(Vec3::ZERO, 0.13, Vec3::Z, 0.6, 1.0);
    let inside = Light::Point { position: Vec3::new(0.0, 0.02, 0.0), color: Vec3::ONE };
    let near = Light::Point { position: Vec3::new(0.2, 0.1, 0.0), color: Vec3::ONE };
    let lights = [towards(Vec3::Y), towards(Vec3::NEG_Z), towards(Vec3::new(1.0, 1e-4, 0.0)), near, inside];
    for light in lights {
        let shadows = as_drawn().with(|s| s.map_size = 128);
        let params = FrameParams::new(camera, SIZE.into()).with(|p| (p.light, p.shadows) = (light, shadows));
        let frame = prepare(gpu, &mut renderer, &params, &[&ball]);
        let maps = frame.shadows().unwrap();
        let layers = maps.layers().unwrap();
        let count = layers.depth_or_array_layers();
        let skin: Vec<f32> = read_map(gpu, layers, 0).iter().map(|t| t[0]).collect();
        for layer in 0..count {
            let map = read_map(gpu, layers, layer);
            assert!(map.iter().all(|t| (0.0..=1.0).contains(&t[0])), "{light:?}, layer {layer}");
        }
        let shaded = skin.iter().filter(|t| **t < 0.9).count();
        assert!(shaded > 500 || light == inside, "{light:?}: {shaded} texels in the shadow of hair");
        let width = read_map(gpu, maps.width().unwrap(), 0);
        assert!(width.iter().flatten().all(|v| (0.0..=1.0).contains(v)), "{light:?}");
    }
}

#[test]
fn self_shadow_darkens_hair_and_can_be_disabled() {
    let Some(gpu) = gpu("self_shadow_darkens_hair_and_can_be_disabled") else { return };
    let mut renderer = renderer(gpu);
    let plane = furry_plane(&renderer, LAYERS, OPACITY);
    let mut green = |change: &dyn Fn(&mut FrameParams)| {
        let mut params = above();
        change(&mut params);
        draw(gpu, &mut renderer, &params, &[&plane]).mean(1)
    };
    let no_self_shadow = |p: &mut FrameParams| *p = p.clone().with_fur(|f| f.self_shadow = SelfShadow::Off);
    let plain = green(&|p| {
        no_self_shadow(p);
        p.soft_shadow = false;
    });
    let soft = green(&no_self_shadow);
    assert!((plain - soft).abs() < 0.5, "a flat plane casts no shadow on itself: {plain} and {soft}");
    let shaded = green(&|_| ());
    assert!(shaded < 0.85 * plain, "{shaded} with shadows, {plain} without");
    let printed = green(&|p| {
        p.light = towards(Vec3::new(1.7, 0.0, 1.0));
        p.study.light_slant = SlantForm::Printed;
    });
    let corrected = green(&|p| p.light = towards(Vec3::new(1.7, 0.0, 1.0)));
    assert!(corrected < 0.97 * printed, "slanted light goes farther through hair: {corrected} and {printed}");
    let dark = |p: &mut FrameParams| p.light = Light::Directional { towards_light: Vec3::Z, color: Vec3::ZERO };
    assert_eq!(
        green(&dark),
        green(&|p| {
            dark(p);
            no_self_shadow(p);
        })
    );
}

#[test]
fn shadow_maps_are_redrawn_only_on_changes() {
    let Some(gpu) = gpu("shadow_maps_are_redrawn_only_on_changes") else { return };
    let mut renderer = renderer(gpu);
    let params = SphereParams { quads: 4, texels: 16, strands: 40, skeleton: true, ..SphereParams::default() };
    let mut ball = Instance::new(BALL, &renderer.load_bytes(&sphere::package(&params)).unwrap());
    let other = furry_plane(&renderer, LAYERS, OPACITY);
    let ran = |frame: &Frame| {
        let of = |id: PassId| frame.report().passes.iter().find(|p| p.name == id.name()).unwrap().ran;
        (of(PassId::LAYER_SHADOW), of(PassId::SHADOW_WIDTH))
    };
    let base = above();
    assert_eq!(ran(&prepare(gpu, &mut renderer, &base, &[&ball])), (true, true));
    let moved_camera = above().with(|p| p.ambient = Vec3::splat(0.5));
    assert_eq!(
        ran(&prepare(gpu, &mut renderer, &moved_camera, &[&ball])),
        (false, false),
        "camera and ambient do not matter"
    );
    let turned = above().with(|p| p.light = towards(Vec3::X));
    assert_eq!(ran(&prepare(gpu, &mut renderer, &turned, &[&ball])), (true, true), "light");
    ball.motion = pelage_runtime::Motion::Clip { clip: 0, time_s: 0.3 };
    assert_eq!(ran(&prepare(gpu, &mut renderer, &turned, &[&ball])), (true, true), "pose");
    ball.transform = Mat4::from_translation(Vec3::X);
    assert_eq!(ran(&prepare(gpu, &mut renderer, &turned, &[&ball])), (true, true), "place");
    assert_eq!(
        ran(&prepare(gpu, &mut renderer, &turned, &[&ball, &other])),
        (true, true),
        "another instance must redraw the maps"
    );
    assert_eq!(ran(&prepare(gpu, &mut renderer, &turned, &[&ball, &other])), (false, false));
    let fewer = turned.clone().with_fur(|f| f.layers = Some(4));
    assert_eq!(ran(&prepare(gpu, &mut renderer, &fewer, &[&ball, &other])), (true, true), "layers");
    renderer.invalidate();
    assert_eq!(ran(&prepare(gpu, &mut renderer, &fewer, &[&ball, &other])), (true, true), "invalidated");
    let off = above().with(|p| p.soft_shadow = false).with_fur(|f| f.self_shadow = SelfShadow::Off);
    let frame = prepare(gpu, &mut renderer, &off, &[&ball]);
    assert!(frame.shadows().is_none() && ran(&frame) == (false, false));
    let bare = above().with(|p| p.style = Style::Bare);
    assert_eq!(
        ran(&prepare(gpu, &mut renderer, &bare, &[&ball])),
        (false, true),
        "the bare surface must cast soft shadows"
    );
}

/// Checks that two frames with different lights in one submission have separate maps.
#[test]
fn frames_in_one_submission_have_separate_shadow_maps() {
    let Some(gpu) = gpu("frames_in_one_submission_have_separate_shadow_maps") else { return };
    let mut renderer = renderer(gpu);
    let plane = furry_plane(&renderer, LAYERS, OPACITY);
    let slanted = above().with(|p| p.light = towards(Vec3::new(1.0, 0.0, 0.4)));
    let first = prepare(gpu, &mut renderer, &above(), &[&plane]);
    let before = transmittances(gpu, first.shadows().unwrap(), Vec3::ZERO);
    let second = prepare(gpu, &mut renderer, &slanted, &[&plane]);
    assert_eq!(transmittances(gpu, first.shadows().unwrap(), Vec3::ZERO), before);
    assert_ne!(transmittances(gpu, second.shadows().unwrap(), Vec3::ZERO), before);
}

/// Returns the instances of a plane and of a sphere above it, for light from straight above.
fn ball_over_plane(renderer: &Renderer) -> [Instance; 2] {
    let params = SphereParams { quads: 12, texels: 16, strands: 40, height_m: 0.001, ..SphereParams::default() };
    let ball = Instance::new(BALL, &renderer.load_bytes(&sphere::package(&params)).unwrap());
    let above = Mat4::from_translation(Vec3::new(0.0, 0.0, 0.2)) * Mat4::from_scale(Vec3::splat(0.4));
    [furry_plane(renderer, 4, 0), ball.at(above)]
}

#[test]
fn objects_cast_soft_shadows_on_fur() {
    let Some(gpu) = gpu("objects_cast_soft_shadows_on_fur") else { return };
    let mut renderer = renderer(gpu);
    let [plane, ball] = ball_over_plane(&renderer);
    // The row of pixels crosses the middle of the shadow, and is viewed from below the ball.
    let mut row = |penumbra: f32, form: PenumbraForm, soft_shadow: bool| -> Vec<u8> {
        let projection = Projection::Orthographic { height_m: 0.2, aspect: 1.0, near_m: 0.0, far_m: 0.14 };
        let camera = Camera::look_at(Vec3::new(0.0, 0.0, 0.14), Vec3::ZERO, projection);
        // A wide penumbra requires a wide blur.
        let shadows = as_drawn().with(|s| (s.penumbra, s.map_size, s.shrink) = (penumbra, 256, 16));
        let params = above().with_fur(|f| f.self_shadow = SelfShadow::Off).with(|p| {
            (p.shadows, p.study.penumbra, p.soft_shadow, p.camera) = (shadows, form, soft_shadow, camera);
        });
        let picture = draw(gpu, &mut renderer, &params, &[&plane, &ball]);
        picture.rgba[32 * 64..33 * 64].iter().map(|p| p[1]).collect()
    };
    let lit = row(0.2, PenumbraForm::Centred, false)[32];
    for form in [PenumbraForm::Centred, PenumbraForm::Inner] {
        let (hard, soft) = (row(0.0, form, true), row(0.2, form, true));
        for row in [&hard, &soft] {
            assert!(row[32] < lit / 2 && row[2] + 2 > lit && row[61] + 2 > lit, "{form:?}: {row:?}, lit {lit}");
            let (left, right): (Vec<u8>, Vec<u8>) = (row[..32].to_vec(), row[32..].iter().rev().copied().collect());
            assert!(left.iter().zip(&right).all(|(a, b)| a.abs_diff(*b) < 24), "{form:?}: not symmetric: {row:?}");
        }
        let between = |row: &[u8]| row.iter().filter(|v| (row[32] + 12..lit - 12).contains(v)).count();
        assert!(between(&soft) > between(&hard) + 2, "{form:?}: soft {soft:?}, hard {hard:?}");
    }
    // The centred penumbra is half lit at the edge of the hard shadow. The inner penumbra darkens only farther inside.
    let area = |row: &[u8]| row.iter().map(|v| f64::from(lit.saturating_sub(*v))).sum::<f64>();
    let (hard, centred, inner) = (
        row(0.0, PenumbraForm::Centred, true),
        row(0.2, PenumbraForm::Centred, true),
        row(0.2, PenumbraForm::Inner, true),
    );
    assert!(area(&inner) < 0.95 * area(&centred), "inner {} of centred {}", area(&inner), area(&centred));
    assert!((area(&centred) / area(&hard) - 1.0).abs() < 0.25, "centred {} of hard {}", area(&centred), area(&hard));
}

/// Square of the application at a height above the plane; only its depth is drawn.
struct Square {
    pipelines: [wgpu::RenderPipeline; 2],
    uniform: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl Square {
    fn new(gpu: &Gpu) -> Self {
        let source = "
            @group(0) @binding(0) var<uniform> clip_from_world: mat4x4<f32>;
            @vertex fn main(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
                var corners = array(vec2(-1.0, -1.0), vec2(1.0, -1.0), vec2(1.0, 1.0), \
                    vec2(-1.0, -1.0), vec2(1.0, 1.0), vec2(-1.0, 1.0));
                return clip_from_world * vec4(corners[i] * 0.04, 0.1, 1.0);
            }";
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::VERTEX,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        let uniform = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }],
        });
        let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipelines = [CasterPass::Nearest, CasterPass::Farthest].map(|pass| {
            gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: None,
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: None,
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState { cull_mode: pass.cull_mode(), ..Default::default() },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: ShadowMaps::DEPTH_FORMAT,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(pass.compare()),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                fragment: None,
                multiview_mask: None,
                cache: None,
            })
        });
        Self { pipelines, uniform, group }
    }

    /// Prepares a frame in which the square casts shadows.
    fn prepare(
        &self,
        gpu: &Gpu,
        renderer: &mut Renderer,
        params: &FrameParams,
        instances: &[&Instance],
        revision: u64,
    ) -> (Frame, wgpu::CommandEncoder) {
        let mut draw = |pass: &mut wgpu::RenderPass<'_>, view: &LightView, kind: CasterPass| {
            gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&view.clip_from_world));
            pass.set_pipeline(&self.pipelines[usize::from(kind == CasterPass::Farthest)]);
            pass.set_bind_group(0, &self.group, &[]);
            pass.draw(0..6, 0..1);
        };
        let bounds = Some(Sphere { center: Vec3::new(0.0, 0.0, 0.1), radius: 0.06 });
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let hooks = Hooks::default().casters(Casters { bounds, revision, draw: &mut draw });
        let frame = renderer.prepare_with(&mut encoder, params, instances.iter().copied(), hooks).unwrap();
        (frame, encoder)
    }
}

#[test]
fn application_geometry_and_fur_cast_shadows_on_each_other() {
    let Some(gpu) = gpu("application_geometry_and_fur_cast_shadows_on_each_other") else { return };
    let mut renderer = renderer(gpu);
    let square = Square::new(gpu);
    let plane = furry_plane(&renderer, 4, 0);
    let projection = Projection::Orthographic { height_m: 0.2, aspect: 1.0, near_m: 0.0, far_m: 0.05 };
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 0.05), Vec3::ZERO, projection);
    let params = above().with(|p| p.camera = camera);
    let mut picture = |casters: bool| -> Picture {
        let options = renderer.options().clone();
        let (frame, mut encoder) = if casters {
            square.prepare(gpu, &mut renderer, &params, &[&plane], 1)
        } else {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            (renderer.prepare(&mut encoder, &params, [&plane]).unwrap(), encoder)
        };
        let targets = pelage_stage::Canvas::new(gpu, SIZE, &(&options).into());
        frame.draw(&mut targets.pass(&mut encoder, "application", Some(wgpu::Color::TRANSPARENT)));
        gpu.queue.submit([encoder.finish()]);
        Picture { size: SIZE, rgba: bytemuck::cast_slice(&targets.texels(gpu).unwrap()).to_vec() }
    };
    let (alone, shaded) = (picture(false), picture(true));
    let (middle, corner) = (32 * 64 + 32, 3 * 64 + 3);
    assert!(shaded.rgba[middle][1] < alone.rgba[middle][1] / 2, "{:?} {:?}", shaded.rgba[middle], alone.rgba[middle]);
    assert!(
        shaded.rgba[corner][1].abs_diff(alone.rgba[corner][1]) < 3,
        "{:?} {:?}",
        shaded.rgba[corner],
        alone.rgba[corner]
    );

    // With the same revision of the caster, the maps are kept. With another revision, they are redrawn.
    let ran = |frame: &Frame| frame.report().passes.iter().find(|p| p.name == "shadow_width").unwrap().ran;
    assert!(!ran(&square.prepare(gpu, &mut renderer, &params, &[&plane], 1).0));
    let (frame, encoder) = square.prepare(gpu, &mut renderer, &params, &[&plane], 2);
    assert!(ran(&frame));
    gpu.queue.submit([encoder.finish()]);

    // The expected value is that of an application's shader for its own ground at z = -0.01. It is computed from the
    // map with the shader function's twin.
    let maps = frame.shadows().unwrap();
    let width = read_map(gpu, maps.width().unwrap(), 0);
    let light_at = |point: Vec3| {
        let ([x, y], place) = texel(maps, point);
        let texel = Vec4::from(width[(y * maps.width().unwrap().width() + x) as usize]);
        (soft_shadow(texel, place.z, place.w, slanted_path(1.0), &maps.soft_shadow(), true), texel.w)
    };
    assert!(light_at(Vec3::new(0.0, 0.0, -0.01)).0 < 0.01);
    assert!(light_at(Vec3::new(0.075, 0.075, 0.0)).0 > 0.99);
    assert!(light_at(Vec3::new(0.0, 0.0, 0.1)).0 > 0.99, "the square itself is lit");
}

/// Checks that the shadow on the application's ground includes the hair's transmittance, the fourth channel of the
/// width map.
#[test]
fn fur_casts_shadows_on_the_ground_of_the_application() {
    let Some(gpu) = gpu("fur_casts_shadows_on_the_ground_of_the_application") else { return };
    let mut renderer = renderer(gpu);
    let plane = furry_plane(&renderer, LAYERS, OPACITY);
    let frame = prepare(gpu, &mut renderer, &above(), &[&plane]);
    let maps = frame.shadows().unwrap();
    let map = maps.width().unwrap();
    let ([x, y], _) = texel(maps, Vec3::ZERO);
    let under = read_map(gpu, map, 0)[(y * map.width() + x) as usize][3];
    let expected = (1.0 - f32::from(OPACITY) / 255.0).powi(LAYERS as i32 - 1);
    assert!((under - expected).abs() < 0.01, "{under}, expected {expected}");
    let beside = read_map(gpu, map, 0)[0][3];
    assert!((beside - 1.0).abs() < 1e-3, "{beside}");
}

#[test]
fn fill_light_equals_a_key_light_without_shadows() {
    let Some(gpu) = gpu("fill_light_equals_a_key_light_without_shadows") else { return };
    let mut renderer = renderer(gpu);
    let params = SphereParams { quads: 8, texels: 16, strands: 200, bare_band: true, ..SphereParams::default() };
    let ball = Instance::new(BALL, &renderer.load_bytes(&sphere::package(&params)).unwrap());
    let camera = Camera::framing(Vec3::ZERO, 0.13, Vec3::new(0.4, 0.3, 1.0), 0.6, 1.0);
    let plain = FrameParams::new(camera, SIZE.into())
        .with(|p| p.soft_shadow = false)
        .with_fur(|f| f.self_shadow = SelfShadow::Off);
    let color = Vec3::new(0.8, 0.5, 0.3);
    for light in [
        Light::Directional { towards_light: Vec3::new(1.0, 1.0, 0.5), color },
        Light::Point { position: Vec3::new(0.1, 0.3, 0.2), color },
    ] {
        let key = draw(gpu, &mut renderer, &plain.clone().with(|p| p.light = light), &[&ball]);
        let dark = Light::Directional { towards_light: Vec3::Y, color: Vec3::ZERO };
        let with = |fill_lights: Vec<Light>| plain.clone().with(|p| (p.light, p.fill_lights) = (dark, fill_lights));
        let fill = draw(gpu, &mut renderer, &with(vec![light]), &[&ball]);
        let found = difference(&key, &fill);
        // The difference is small: directions are interpolated for the key light, but computed per pixel for the
        // others.
        assert!(found.mean < 1.0, "{light:?}: {found:?}");
        let none = draw(gpu, &mut renderer, &with(vec![]), &[&ball]);
        assert!(difference(&key, &none).mean > 4.0, "the light must change the picture");
        let half = match light {
            Light::Directional { towards_light, color } => Light::Directional { towards_light, color: 0.5 * color },
            Light::Point { position, color } => Light::Point { position, color: 0.5 * color },
        };
        let twice = draw(gpu, &mut renderer, &with(vec![half, half]), &[&ball]);
        assert!(difference(&fill, &twice).mean < 0.1, "lights must add up");
    }
}

#[test]
fn out_of_range_shadow_parameters_are_named() {
    let Some(gpu) = gpu("out_of_range_shadow_parameters_are_named") else { return };
    let mut renderer = renderer(gpu);
    let plane = furry_plane(&renderer, 2, 0);
    let mut error = |change: &dyn Fn(&mut FrameParams)| -> RuntimeError {
        let mut params = above();
        change(&mut params);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        renderer.prepare(&mut encoder, &params, [&plane]).unwrap_err()
    };
    for (change, message) in [
        (
            &(|p: &mut FrameParams| p.shadows.map_size = 8) as &dyn Fn(&mut FrameParams),
            "map_size is 8, expected 16..=8192",
        ),
        (&|p| p.shadows.map_layers = Some(1), "map_layers is 1, expected 2..=256"),
        (&|p| p.shadows.density = 5.0, "density is 5, expected 0..=4"),
        (&|p| p.shadows.penumbra = f32::NAN, "penumbra is NaN, expected 0..=2"),
        (&|p| p.shadows.shrink = 64, "shrink is 64, expected 2..=32"),
        (&|p| p.fill_lights = vec![Light::default(); MAX_FILL_LIGHTS + 1], "33 lights, expected at most 32"),
        (&|p| p.fill_lights = vec![towards(Vec3::ZERO)], "a direction that is not zero"),
    ] {
        let found = error(change).to_string();
        assert!(found.contains(message), "{found}, expected {message}");
    }
}

/// Checks that the brightness changes smoothly while the light makes a full turn: per frame by only a small share of
/// the total range.
#[test]
fn a_turning_light_does_not_flicker() {
    let Some(gpu) = gpu("a_turning_light_does_not_flicker") else { return };
    let mut renderer = renderer(gpu);
    let params = SphereParams { quads: 12, texels: 32, strands: 300, ..SphereParams::default() };
    let ball = Instance::new(BALL, &renderer.load_bytes(&sphere::package(&params)).unwrap());
    let camera = Camera::framing(Vec3::ZERO, 0.13, Vec3::new(0.0, 0.3, 1.0), 0.6, 1.0);
    let frames = 48;
    let mut greens = Vec::new();
    for i in 0..frames {
        let angle = std::f32::consts::TAU * i as f32 / frames as f32;
        let light = towards(Vec3::new(angle.sin(), 0.6, angle.cos()));
        let params = FrameParams::new(camera, [96, 96]).with(|p| p.light = light);
        greens.push(draw(gpu, &mut renderer, &params, &[&ball]).mean(1));
    }
    let swing = greens.iter().copied().fold(f64::MIN, f64::max) - greens.iter().copied().fold(f64::MAX, f64::min);
    // Over one turn, a smooth curve changes between frames by at most pi / 48 of its range. Second differences reveal
    // jumps.
    let jump = (0..frames).map(|i| {
        let [a, b, c] = [0, 1, 2].map(|k| greens[(i + k) % frames]);
        (a - 2.0 * b + c).abs()
    });
    let jump = jump.fold(0.0, f64::max);
    println!("swing {swing:.2}, largest second difference {jump:.3}");
    assert!(swing > 5.0 && jump < 0.04 * swing, "swing {swing}, largest second difference {jump}: {greens:?}");
}
