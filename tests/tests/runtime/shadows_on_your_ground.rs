//! Tests of shadows between the fur and an application's own geometry. They use the scene and the shader of the example
//! of the same name and of `forty_animals`.

#![allow(clippy::unwrap_used, reason = "tests")]

use pelage_runtime::glam::{Mat4, Vec3, Vec4};
use pelage_runtime::shared::receiver::{ShadowReceiver, light_at_place};
use pelage_runtime::{
    Camera, CasterPass, Casters, Frame, FrameParams, Hooks, Instance, Light, LightView, Projection, Renderer,
    RendererOptions, SelfShadow, Sphere, Style, wgpu,
};
use pelage_stage::{Canvas, Gpu};
use pelage_tests::gpu::gpu;
use pelage_tests::pictures::read_map;
use pelage_tests::support::ground::{Cuboid, Scene};
use pelage_tests::support::sphere::{SphereParams, package};

const SIZE: u32 = 256;
/// Radius of the bare sphere, metres.
const SKIN: f32 = 0.1;
/// Length of the sphere's fur, metres.
const FUR: f32 = 0.025;
/// Centre of the sphere, metres. The surface of the ground is at y = 0.
const CENTER: Vec3 = Vec3::new(0.0, 0.16, 0.0);
/// Width and height of a picture of the ground, metres.
const VIEW_M: f32 = 0.8;

struct Stage<'a> {
    gpu: &'a Gpu,
    options: RendererOptions,
    renderer: Renderer,
    ball: Instance,
    ground: Scene,
}

impl<'a> Stage<'a> {
    fn new(gpu: &'a Gpu) -> Self {
        // The format is linear, so that the values read back are linear light.
        let options = RendererOptions { color_format: wgpu::TextureFormat::Rgba8Unorm, ..RendererOptions::default() };
        let renderer = Renderer::new(&gpu.device, &gpu.queue, &options).unwrap();
        let sphere = package(&SphereParams { quads: 16, texels: 32, strands: 120, ..SphereParams::default() });
        let ball = Instance::new(0, &renderer.load_bytes(&sphere).unwrap()).at(Mat4::from_translation(CENTER));
        let ground = Scene::new(&gpu.device, &options, &[slab()]);
        Self { gpu, options, renderer, ball, ground }
    }

    /// Prepares a frame in which `casters` cast shadows, and draws the picture.
    fn draw(
        &mut self,
        params: &FrameParams,
        casters: &Scene,
        radius: Option<f32>,
        revision: u64,
        record: impl FnOnce(&Self, &mut wgpu::RenderPass<'_>, &Frame),
    ) -> (Frame, Vec<u8>) {
        let device = &self.gpu.device;
        let mut draw = |pass: &mut wgpu::RenderPass<'_>, view: &LightView, which: CasterPass| {
            casters.draw_depth(device, pass, view, which);
        };
        let bounds = radius.map(|radius| Sphere { center: Vec3::ZERO, radius });
        let mut encoder = device.create_command_encoder(&Default::default());
        let hooks = Hooks::default().casters(Casters { bounds, revision, draw: &mut draw });
        let frame = self.renderer.prepare_with(&mut encoder, params, [&self.ball], hooks).unwrap();
        let targets = Canvas::new(self.gpu, (SIZE, SIZE), &(&self.options).into());
        record(self, &mut targets.pass(&mut encoder, "application", Some(wgpu::Color::TRANSPARENT)), &frame);
        self.gpu.queue.submit([encoder.finish()]);
        (frame, targets.texels(self.gpu).unwrap())
    }

    /// Returns the share of light that reaches the ground, viewed from above. The fur is not drawn, because it would
    /// hide the ground.
    fn ground(
        &mut self,
        params: &FrameParams,
        casters: &Scene,
        radius: Option<f32>,
        revision: u64,
    ) -> (Frame, GroundLight) {
        let light_ws = match params.light {
            Light::Directional { towards_light, .. } => towards_light.extend(0.0),
            Light::Point { position, .. } => position.extend(1.0),
        };
        let (frame, rgba) = self.draw(params, casters, radius, revision, |stage, pass, frame| {
            let camera = params.camera;
            let clip_from_world = camera.projection.clip_from_view(false) * camera.view_from_world;
            stage.ground.draw(&stage.gpu.device, pass, clip_from_world, light_ws, frame);
        });
        (frame, GroundLight { rgba, light_ws })
    }
}

/// Picture of the white ground from above.
struct GroundLight {
    rgba: Vec<u8>,
    light_ws: Vec4,
}

impl GroundLight {
    /// Returns the share of light at a point of the ground, without the shader's constant terms.
    fn at(&self, x: f32, z: f32) -> f32 {
        let pixel = |v: f32| ((v / VIEW_M + 0.5) * SIZE as f32) as usize;
        let value = f32::from(self.rgba[4 * (pixel(z) * SIZE as usize + pixel(x))]) / 255.0;
        let towards = self.light_ws.truncate() - Vec3::new(x, 0.0, z) * self.light_ws.w;
        (value - 0.2) / (0.8 * towards.normalize().y)
    }

    /// Returns the mean of [`Self::at`] on a circle of `radius` metres around the origin.
    fn ring(&self, radius: f32) -> f32 {
        let points = (0..32).map(|i| std::f32::consts::TAU * i as f32 / 32.0);
        points.map(|a| self.at(radius * a.cos(), radius * a.sin())).sum::<f32>() / 32.0
    }
}

fn slab() -> Cuboid {
    Cuboid { low: Vec3::new(-0.6, -0.05, -0.6), high: Vec3::new(0.6, 0.0, 0.6), color: Vec3::ONE }
}

fn from_above(light: Light) -> FrameParams {
    let projection = Projection::Orthographic { height_m: VIEW_M, aspect: 1.0, near_m: 0.0, far_m: 2.0 };
    let camera = Camera::look_at(Vec3::Y, Vec3::ZERO, projection);
    FrameParams::new(camera, [SIZE; 2]).with(|p| (p.light, p.shadows.shrink) = (light, 8))
}

fn sun(towards_light: Vec3) -> Light {
    Light::Directional { towards_light, color: Vec3::ONE }
}

#[test]
fn fur_shadow_on_the_ground_is_soft_with_a_hair_fringe() {
    let Some(gpu) = gpu("fur_shadow_on_the_ground_is_soft_with_a_hair_fringe") else { return };
    let mut stage = Stage::new(gpu);
    let casters = Scene::new(&gpu.device, &stage.options, &[slab()]);
    let lamp = Vec3::new(0.0, 0.7, 0.0);
    // Radius, on the ground, of the lamp's cone that touches a sphere of radius `r`.
    let cone = |r: f32| {
        let sin = r / (lamp.y - CENTER.y);
        lamp.y * sin / (1.0 - sin * sin).sqrt()
    };
    let lights = [
        (sun(Vec3::Y), SKIN, SKIN + FUR),
        (Light::Point { position: lamp, color: Vec3::ONE }, cone(SKIN), cone(SKIN + FUR)),
    ];
    for (revision, (light, skin, fur)) in lights.into_iter().enumerate() {
        let revision = revision as u64;
        let params = from_above(light);
        let (_, furry) = stage.ground(&params, &casters, Some(0.35), revision);
        let (_, bare) = stage.ground(&params.clone().with(|p| p.style = Style::Bare), &casters, Some(0.35), revision);
        let profile = |p: &GroundLight| (0..=20).map(|i| p.ring(0.01 * i as f32)).collect::<Vec<_>>();
        println!("{light:?}\nfurry {:.2?}\nbare  {:.2?}", profile(&furry), profile(&bare));
        for (name, picture) in [("furry", &furry), ("bare", &bare)] {
            assert!(picture.at(0.0, 0.0) < 0.02, "{name}, {light:?}: the middle has {}", picture.at(0.0, 0.0));
            let beside = picture.ring(fur + 0.03);
            assert!((beside - 1.0).abs() < 0.02, "{name}, {light:?}: beside it there is {beside}");
            let rings: Vec<f32> = (0..60).map(|i| picture.ring(fur * i as f32 / 50.0)).collect();
            assert!(rings.windows(2).all(|w| w[1] > w[0] - 0.03), "{name}, {light:?}: not outwards lighter: {rings:?}");
        }
        // The shadow is soft: half lit at the edge of the bare sphere's shadow, with a slope to both sides.
        let edge = [-0.003, 0.0, 0.003].map(|d| bare.ring(skin + d));
        assert!((edge[1] - 0.5).abs() < 0.25, "{light:?}: at the edge {edge:?}");
        assert!(edge[0] > 0.02 && edge[2] < 0.98 && edge[2] > edge[0] + 0.1, "{light:?}: about the edge {edge:?}");
        // The circle is in the fringe of the fur's shadow.
        let between = 0.5 * (skin + fur);
        let fringe = [furry.ring(between), bare.ring(between)];
        assert!(fringe[0] < 0.5 * fringe[1] && fringe[1] > 0.85, "{light:?}: fur beside the skin {fringe:?}");
    }
    // Checks that a slanted light moves the shadow.
    let slanted = Vec3::new(-0.6, 0.8, 0.0);
    let aside = CENTER.y * 0.75;
    let (_, picture) = stage.ground(&from_above(sun(slanted)), &casters, Some(0.35), 9);
    assert!(picture.at(aside, 0.0) < 0.02 && picture.at(-aside, 0.0) > 0.98);
    // The shadow is an ellipse; its length is the sphere's diameter divided by the sine of the light's elevation.
    for (x, z) in [(aside + SKIN / 0.8, 0.0), (aside - SKIN / 0.8, 0.0), (aside, SKIN), (aside, -SKIN)] {
        let (inner, outer) = (0.85, 1.45);
        let at = |scale: f32| picture.at(aside + (x - aside) * scale, z * scale);
        assert!(at(inner) < 0.1 && at(outer) > 0.95, "towards {x} {z}: {} {}", at(inner), at(outer));
    }
}

/// Checks that the ground is lit when a kind of shadow is switched off.
#[test]
fn shadows_that_are_off_leave_the_ground_lit() {
    let Some(gpu) = gpu("shadows_that_are_off_leave_the_ground_lit") else { return };
    let mut stage = Stage::new(gpu);
    let casters = Scene::new(&gpu.device, &stage.options, &[slab()]);
    let on = from_above(sun(Vec3::Y));
    let between = SKIN + 0.5 * FUR;
    let mut ground = |params: FrameParams| {
        let (frame, picture) = stage.ground(&params, &casters, Some(0.35), 0);
        (frame.shadow_receiver(), picture.at(0.0, 0.0), picture.ring(between))
    };
    let both = ground(on.clone());
    assert!(both.1 < 0.02 && both.2 < 0.9, "{both:?}");
    let soft_alone = ground(on.clone().with_fur(|f| f.self_shadow = SelfShadow::Off));
    assert!(soft_alone.1 < 0.02 && soft_alone.2 > 0.95, "without maps of the hair there is no fringe: {soft_alone:?}");
    let dark = Light::Directional { towards_light: Vec3::Y, color: Vec3::ZERO };
    for off in [
        on.clone().with(|p| p.soft_shadow = false),
        on.clone().with(|p| p.soft_shadow = false).with_fur(|f| f.self_shadow = SelfShadow::Off),
        on.clone().with(|p| p.light = dark),
    ] {
        let (receiver, middle, fringe) = ground(off);
        assert_eq!(receiver, ShadowReceiver::default());
        assert!((middle - 1.0).abs() < 0.01 && (fringe - 1.0).abs() < 0.01, "{middle} {fringe}");
    }
}

/// Checks that the ground beyond a shadow map is lit, and that the last texel of the map is not repeated.
#[test]
fn ground_outside_the_shadow_maps_is_lit() {
    let Some(gpu) = gpu("ground_outside_the_shadow_maps_is_lit") else { return };
    let mut stage = Stage::new(gpu);
    let wall = Cuboid { low: Vec3::new(0.02, 0.05, -0.05), high: Vec3::new(0.39, 0.1, 0.05), color: Vec3::ONE };
    let casters = Scene::new(&gpu.device, &stage.options, &[slab(), wall]);
    let (frame, cut) = stage.ground(&from_above(sun(Vec3::Y)), &casters, Some(0.2), 0);
    let reach = 0.5 * frame.shadows().unwrap().view().extent;
    assert!((0.2..0.3).contains(&reach), "the maps reach {reach} m from the middle");
    assert!(cut.at(reach - 0.03, 0.0) < 0.02, "{}", cut.at(reach - 0.03, 0.0));
    assert!((cut.at(reach + 0.01, 0.0) - 1.0).abs() < 0.01, "{}", cut.at(reach + 0.01, 0.0));
    let (_, whole) = stage.ground(&from_above(sun(Vec3::Y)), &casters, Some(0.5), 0);
    assert!(whole.at(reach + 0.01, 0.0) < 0.02, "with larger bounds, the maps must include this point");
}

/// Checks that the shader function `light_received` agrees with its Rust twin, which is evaluated on the map read back.
#[test]
fn receiver_shader_matches_its_rust_twin() {
    let Some(gpu) = gpu("receiver_shader_matches_its_rust_twin") else { return };
    let mut stage = Stage::new(gpu);
    let casters = Scene::new(&gpu.device, &stage.options, &[slab()]);
    for (revision, light) in
        [sun(Vec3::new(-0.3, 0.9, 0.2)), Light::Point { position: Vec3::new(0.2, 0.6, 0.1), color: Vec3::ONE }]
            .into_iter()
            .enumerate()
    {
        let (frame, picture) = stage.ground(&from_above(light), &casters, Some(0.35), revision as u64);
        let map = frame.shadows().unwrap().width().unwrap();
        let (size, texels) = (map.width() as i32, read_map(gpu, map, 0));
        let receiver = frame.shadow_receiver();
        let twin = |point: Vec3| {
            let place = receiver.map_coordinates(point);
            let towards = picture.light_ws.truncate() - point * picture.light_ws.w;
            let texel =
                |x: i32, y: i32| Vec4::from(texels[(y.clamp(0, size - 1) * size + x.clamp(0, size - 1)) as usize]);
            let (u, v) = (place.x / place.w * size as f32 - 0.5, place.y / place.w * size as f32 - 0.5);
            let (x, y) = (u.floor() as i32, v.floor() as i32);
            let (a, b) = (u - u.floor(), v - v.floor());
            let row = |y| texel(x, y).lerp(texel(x + 1, y), a);
            light_at_place(row(y).lerp(row(y + 1), b), place, towards.normalize().y, &receiver)
        };
        let (mut worst, mut shaded) = (0.0f32, 0);
        // The points are pixel centres, so that shader and twin evaluate the same points.
        for i in (0..SIZE).step_by(3) {
            let middle = |i: u32| ((i as f32 + 0.5) / SIZE as f32 - 0.5) * VIEW_M;
            for j in (0..SIZE).step_by(3) {
                let (x, z) = (middle(i), middle(j));
                let (found, expected) = (picture.at(x, z), twin(Vec3::new(x, 0.0, z)));
                worst = worst.max((found - expected).abs());
                shaded += usize::from((0.05..0.95).contains(&expected));
            }
        }
        // The tolerance allows for 8 bits of the picture, and 8 bits of the linear filter's weights.
        assert!(shaded > 50 && worst < 0.03, "{light:?}: {shaded} points partly shaded, worst difference {worst}");
    }
}

/// Checks that hair behind an object, as seen from the light, does not darken the object although its shadow is
/// blurred.
#[test]
fn hair_behind_an_object_leaves_it_lit() {
    let Some(gpu) = gpu("hair_behind_an_object_leaves_it_lit") else { return };
    let mut stage = Stage::new(gpu);
    let top = CENTER.y + SKIN + FUR + 0.05;
    let plate =
        Cuboid { low: Vec3::new(-0.03, top - 0.005, -0.03), high: Vec3::new(0.03, top, 0.03), color: Vec3::ONE };
    let casters = Scene::new(&gpu.device, &stage.options, &[slab(), plate]);
    let (frame, _) = stage.ground(&from_above(sun(Vec3::Y)), &casters, Some(0.35), 0);
    let map = frame.shadows().unwrap().width().unwrap();
    let texels = read_map(gpu, map, 0);
    let receiver = frame.shadow_receiver();
    let light = |x: f32, z: f32, y: f32| {
        let place = receiver.map_coordinates(Vec3::new(x, y, z));
        let at = [place.y, place.x].map(|v| (v / place.w * map.width() as f32) as usize);
        light_at_place(Vec4::from(texels[at[0] * map.width() as usize + at[1]]), place, 1.0, &receiver)
    };
    for i in -9..=9 {
        let along = 0.003 * i as f32;
        for (x, z) in [(along, 0.0), (0.028, along), (along, -0.028)] {
            assert!(light(x, z, top) > 0.97, "on the plate at {x} {z}: {}", light(x, z, top));
        }
    }
    assert!(
        light(0.06, 0.0, CENTER.y + (SKIN * SKIN - 0.0036).sqrt()) < 0.3,
        "beside the plate, hair must shade the surface"
    );
}

#[test]
fn post_of_the_application_casts_a_shadow_on_the_fur() {
    let Some(gpu) = gpu("post_of_the_application_casts_a_shadow_on_the_fur") else { return };
    let mut stage = Stage::new(gpu);
    let post = Cuboid { low: Vec3::new(-0.22, 0.0, -0.02), high: Vec3::new(-0.18, 0.4, 0.02), color: Vec3::ONE };
    let scenes =
        [Scene::new(&gpu.device, &stage.options, &[slab()]), Scene::new(&gpu.device, &stage.options, &[slab(), post])];
    let towards_light = Vec3::new(-0.8, 0.6, 0.0);
    let camera = Camera::framing(CENTER, SKIN + FUR, Vec3::new(-1.0, 0.2, 0.6), 0.6, 1.0);
    let params = from_above(sun(towards_light)).with(|p| p.camera = camera);
    let clip_from_world = camera.projection.clip_from_view(false) * camera.view_from_world;
    // The points are at half the fur's length: one in the post's shadow, and one a post's width beside it.
    let brightness = |rgba: &[u8], direction: Vec3| {
        let clip = clip_from_world * (CENTER + direction.normalize() * (SKIN + 0.5 * FUR)).extend(1.0);
        let pixel = |v: f32| ((0.5 + 0.5 * v / clip.w) * SIZE as f32) as usize;
        let (x, y) = (pixel(clip.x), pixel(-clip.y));
        let around = (y - 3..=y + 3).flat_map(|y| (x - 3..=x + 3).map(move |x| 4 * (y * SIZE as usize + x)));
        around.map(|at| f32::from(rgba[at + 1])).sum::<f32>() / 49.0
    };
    let (in_shadow, beside) = (Vec3::new(-1.0, 0.1, 0.0), Vec3::new(-0.8, 0.1, 0.55));
    let mut revision = 0;
    let mut fur = |params: &FrameParams| {
        scenes.each_ref().map(|casters| {
            revision += 1;
            let (_, rgba) = stage.draw(params, casters, Some(0.45), revision, |_, pass, frame| frame.draw(pass));
            [in_shadow, beside].map(|direction| brightness(&rgba, direction))
        })
    };
    let [alone, shaded] = fur(&params);
    println!("alone {alone:.1?}, with the post {shaded:.1?}");
    assert!(shaded[0] < 0.7 * alone[0], "in the post's shadow {shaded:?}, without {alone:?}");
    assert!((shaded[1] / alone[1] - 1.0).abs() < 0.03, "beside its shadow {shaded:?}, without {alone:?}");
    let [alone, shaded] = fur(&params.with(|p| p.soft_shadow = false).with_fur(|f| f.self_shadow = SelfShadow::Off));
    assert_eq!(alone, shaded, "without shadows the post changes nothing");
}
