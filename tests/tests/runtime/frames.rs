//! Tests of concurrent and consecutive frames: created resources, state per owner, encoders that are dropped, and
//! culling.

#![allow(clippy::unwrap_used, reason = "tests")]

use pelage_runtime::formats::{DetailLevel, FarLayerInfo, InkShading, Shading};
use pelage_runtime::glam::{Mat4, Vec3};
use pelage_runtime::{
    Camera, CasterPass, Casters, ClipLayer, CreatedObjects, Detail, Frame, FrameParams, FrameReport, HairGeometry,
    Hooks, InkBackground, InkParams, Instance, Light, LightView, LineWidth, Model, Motion, PassId, PassStage,
    Projection, Renderer, RendererOptions, SelfShadow, Sphere, Style, wgpu,
};
use pelage_stage::{Canvas, Gpu};
use pelage_tests::gpu::gpu;
use pelage_tests::packages::{straight_strands, with_fins, with_manifest, with_strands};
use pelage_tests::pictures::{Picture, PipelineStatistics, draw_with_statistics};
use pelage_tests::support::sphere::{SphereParams, package};

const SIZE: (u32, u32) = (96, 96);
const QUADS: u32 = 8;

fn sphere() -> SphereParams {
    SphereParams { quads: QUADS, texels: 16, strands: 60, ..SphereParams::default() }
}

/// Returns a furry sphere with a bendable skeleton, a bare band, and fins along the rows of quads of its first cube
/// face.
pub fn furry_package() -> Vec<u8> {
    let row = |j: u32| (0..QUADS).map(move |i| (j * (QUADS + 1) + i, j * (QUADS + 1) + i + 1));
    let edges: Vec<_> = (0..=QUADS).flat_map(row).collect();
    with_fins(&package(&SphereParams { skeleton: true, bare_band: true, ..sphere() }), &edges)
}

/// Returns a package with individual strands.
fn strand_package() -> Vec<u8> {
    let roots: Vec<_> = (0..16).map(|i| [(i % 4) as f32 / 4.0, (i / 4) as f32 / 4.0]).collect();
    with_strands(&furry_package(), &straight_strands(&roots, 0.0, &[[0.1, 0.2, 1.0]; 16], 0.01))
}

/// Returns a package with the ink style and fur strokes, and with a bendable skeleton.
fn ink_package() -> Vec<u8> {
    package(&SphereParams { skeleton: true, ink: true, ..sphere() })
}

/// Returns a package with levels of detail and a far layer, which is its outermost layer.
fn detail_package() -> Vec<u8> {
    with_manifest(&furry_package(), |manifest| {
        manifest.fur.layers -= 1;
        manifest.coat =
            Some(FarLayerInfo { height: 0.5, ambient_height: 0.5, light_straight: 0.5, light_slanted: 0.2 });
        let level = |step, full_px, gone_px, fins, density| DetailLevel { step, full_px, gone_px, fins, density };
        manifest.detail =
            vec![level(1, 8.0, 4.0, 1.0, 1.0), level(2, 3.0, 1.5, 0.5, 1.1), level(0, 0.0, 0.0, 0.0, 1.0)];
    })
}

fn bend(time_s: f32) -> Motion {
    Motion::Clip { clip: 0, time_s }
}

fn from(towards: Vec3) -> FrameParams {
    FrameParams::new(Camera::framing(Vec3::ZERO, 0.17, towards, 0.6, 1.0), SIZE.into())
}

/// Changes the style to ink with fur strokes, over the application's picture.
fn in_ink(params: FrameParams) -> FrameParams {
    params.with_ink(InkParams::default().with(|ink| {
        ink.background = InkBackground::Picture;
        ink.shading = Some(InkShading { fur: 1.0, ..InkShading::default() });
    }))
}

/// Changes the fur to individual strands.
fn in_strands(params: FrameParams) -> FrameParams {
    params.with_fur(|fur| fur.hair = HairGeometry::Strands)
}

fn lit_from(params: FrameParams, towards_light: Vec3) -> FrameParams {
    params.with(|p| p.light = Light::Directional { towards_light, color: Vec3::ONE })
}

fn shifted_along_x(x: f32) -> Mat4 {
    Mat4::from_translation(Vec3::X * x)
}

/// Application with a renderer and its own render targets.
struct Stage<'a> {
    gpu: &'a Gpu,
    renderer: Renderer,
    targets: Canvas,
}

impl<'a> Stage<'a> {
    fn new(gpu: &'a Gpu) -> Self {
        let options = RendererOptions::default();
        let renderer = Renderer::new(&gpu.device, &gpu.queue, &options).unwrap();
        Self { gpu, renderer, targets: Canvas::new(gpu, SIZE, &(&options).into()) }
    }

    fn load(&self, package: &[u8]) -> Model {
        self.renderer.load_bytes(package).unwrap()
    }

    fn prepare<I>(&mut self, params: &FrameParams, instances: I) -> (wgpu::CommandEncoder, Frame)
    where
        I: IntoIterator,
        I::Item: AsRef<Instance>,
    {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let frame = self.renderer.prepare(&mut encoder, params, instances).unwrap();
        (encoder, frame)
    }

    /// Draws a prepared frame, submits it, and waits for it as presentation does in an application.
    fn finish(&self, mut encoder: wgpu::CommandEncoder, frame: &Frame) {
        frame.draw(&mut self.targets.pass(&mut encoder, "application", Some(wgpu::Color::TRANSPARENT)));
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.wait().unwrap();
    }

    fn present<I>(&mut self, params: &FrameParams, instances: I) -> FrameReport
    where
        I: IntoIterator,
        I::Item: AsRef<Instance>,
    {
        let (encoder, frame) = self.prepare(params, instances);
        self.finish(encoder, &frame);
        frame.report().clone()
    }

    /// Reads the last picture from the targets.
    fn picture(&self) -> Picture {
        read(self.gpu, &self.targets)
    }
}

fn read(gpu: &Gpu, targets: &Canvas) -> Picture {
    let rgba = targets.texels(gpu).unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect();
    Picture { size: SIZE, rgba }
}

/// Draws a package with a new renderer; `place` sets up the instance.
fn draw_fresh(gpu: &Gpu, package: &[u8], params: &FrameParams, place: impl Fn(Instance) -> Instance) -> Picture {
    let mut stage = Stage::new(gpu);
    let model = stage.load(package);
    stage.present(params, [place(Instance::new(0, &model))]);
    stage.picture()
}

fn ran(report: &FrameReport, id: PassId) -> bool {
    report.passes.iter().find(|pass| pass.name == id.name()).unwrap().ran
}

fn reason(report: &FrameReport, id: PassId) -> &str {
    &report.passes.iter().find(|pass| pass.name == id.name()).unwrap().reason
}

/// Opens a separate device for the test. On a shared device, another test's poll could take over the completion of a
/// submission and delay it.
fn separate_device(features: wgpu::Features) -> Gpu {
    Gpu::with(features, Some(wgpu::Limits::default())).unwrap()
}

#[test]
fn steady_frames_create_no_gpu_resources() {
    if gpu("steady_frames_create_no_gpu_resources").is_none() {
        return;
    }
    let gpu = separate_device(wgpu::Features::empty());
    let front = from(Vec3::new(-0.3, 0.35, 1.0));
    for (name, package, params) in [
        ("fur", furry_package(), front.clone()),
        ("levels of detail", detail_package(), front.clone().with_fur(|f| f.detail = Detail::Auto { bias: 0.2 })),
        ("strands", strand_package(), in_strands(front.clone())),
        ("skin", furry_package(), front.clone().with(|p| p.style = Style::Bare)),
        ("ink", ink_package(), in_ink(front.clone())),
    ] {
        let mut stage = Stage::new(&gpu);
        let model = stage.load(&package);
        let still = [
            Instance::new(3, &model).at(shifted_along_x(-0.05)).moving(bend(0.3)),
            Instance::new(8, &model).at(shifted_along_x(0.05)),
        ];
        let reports: Vec<_> = (0..6).map(|_| stage.present(&params, &still)).collect();
        let CreatedObjects { buffers, textures, bind_groups, pipelines, .. } = reports[0].created;
        assert!(buffers > 0 && textures > 0 && bind_groups > 0 && pipelines > 0, "{name}: {:?}", reports[0].created);
        for (number, report) in reports.iter().enumerate().skip(2) {
            assert_eq!(report.created, CreatedObjects::default(), "{name}, frame {number}");
            // A frame in flight keeps its slot, so the first few frames allocate new slots.
            assert!(
                number < 5 || report.uploaded_bytes == 0,
                "{name}, frame {number}: {} bytes",
                report.uploaded_bytes
            );
        }
        assert!(!ran(&reports[5], PassId::POSE) && !ran(&reports[5], PassId::SHADOW_WIDTH), "{name}");

        // The camera orbits, the animation plays and the light turns. From the sixth frame on, all buffers must be
        // large enough.
        for number in 0..24 {
            let time_s = number as f32 / 24.0;
            let angle = std::f32::consts::TAU * time_s;
            let camera = from(Vec3::new(angle.sin(), 0.3, angle.cos())).camera;
            let params = lit_from(params.clone().with(|p| p.camera = camera), Vec3::new(angle.cos(), 1.0, angle.sin()));
            let moving =
                (0..2).map(|k| Instance::new(3 + 5 * k, &model).at(shifted_along_x(-0.05)).moving(bend(time_s)));
            let report = stage.present(&params, moving);
            assert!(ran(&report, PassId::POSE) && report.uploaded_bytes > 0, "{name}, moving frame {number}");
            if number >= 6 {
                assert_eq!(report.created, CreatedObjects::default(), "{name}, moving frame {number}");
            }
        }
    }
}

#[test]
fn frames_sharing_an_encoder_and_kept_frames_draw_as_alone() {
    let Some(gpu) = gpu("frames_sharing_an_encoder_and_kept_frames_draw_as_alone") else { return };
    // The frames have two cameras and, if there is lighting, two lights with different maps.
    let left = lit_from(from(Vec3::new(-0.3, 0.35, 1.0)), Vec3::new(-1.0, 1.0, 0.3));
    let right = lit_from(from(Vec3::new(1.0, 0.2, 0.1)), Vec3::new(0.2, 0.4, 1.0));
    for (name, package, views) in [
        ("fur", furry_package(), [left.clone(), right.clone()]),
        ("strands", strand_package(), [left.clone(), right.clone()].map(in_strands)),
        ("ink", ink_package(), [left, right].map(in_ink)),
    ] {
        let expected = views.each_ref().map(|view| draw_fresh(gpu, &package, view, |one| one.moving(bend(0.4))));
        assert_ne!(expected[0], expected[1], "{name}: both views must differ");

        let mut stage = Stage::new(gpu);
        let creature = Instance::new(0, &stage.load(&package)).moving(bend(0.4));
        let targets = [0, 1].map(|_| Canvas::new(gpu, SIZE, &stage.renderer.options().into()));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let frames = views.each_ref().map(|view| stage.renderer.prepare(&mut encoder, view, [&creature]).unwrap());
        for (frame, targets) in frames.iter().zip(&targets) {
            frame.draw(&mut targets.pass(&mut encoder, "application", Some(wgpu::Color::TRANSPARENT)));
        }
        gpu.queue.submit([encoder.finish()]);
        for (targets, expected) in targets.iter().zip(&expected) {
            assert!(read(gpu, targets) == *expected, "{name}: it shows the other frame of the encoder");
        }

        // The frames are kept while other frames are prepared and drawn, of the same size and of another one.
        let kept = frames;
        for turn in 1..4 {
            let towards = Vec3::new(turn as f32, 1.0, -1.0);
            let mut params = lit_from(views[0].clone(), towards);
            params.camera = from(towards).camera;
            stage.present(&params, [&creature]);
            let (encoder, small) = stage.prepare(&params.with(|p| p.viewport = [40, 30]), [&creature]);
            gpu.queue.submit([encoder.finish()]);
            drop(small);
        }
        for (frame, expected) in kept.iter().zip(&expected) {
            stage.finish(gpu.device.create_command_encoder(&Default::default()), frame);
            assert!(stage.picture() == *expected, "{name}: a kept frame has changed");
        }
    }
}

#[test]
fn dropped_encoder_is_followed_by_a_correct_frame() {
    let Some(gpu) = gpu("dropped_encoder_is_followed_by_a_correct_frame") else { return };
    let bytes = furry_package();
    let before = from(Vec3::new(-0.3, 0.35, 1.0));
    let after = lit_from(before.clone(), Vec3::new(1.0, 0.5, 0.2));
    let expected = draw_fresh(gpu, &bytes, &after, |one| one.moving(bend(0.5)));
    let passes = [PassId::POSE, PassId::LAYER_SHADOW, PassId::SHADOW_WIDTH];
    // The loops cover all combinations: first or later frame; dropped as an encoder or as commands that were never
    // submitted; dropped before or after the frame.
    for first in [true, false] {
        for finished in [true, false] {
            for frame_first in [true, false] {
                let said = format!("first {first}, finished {finished}, frame dropped first {frame_first}");
                let mut stage = Stage::new(gpu);
                let creature = Instance::new(0, &stage.load(&bytes));
                if !first {
                    stage.present(&before, [&creature]);
                }
                let creature = creature.moving(bend(0.5));
                let (encoder, frame) = stage.prepare(&after, [&creature]);
                assert!(passes.iter().all(|id| ran(frame.report(), *id)), "{said}");
                let held = (!frame_first).then_some(frame);
                if finished {
                    drop(encoder.finish());
                } else {
                    drop(encoder);
                }
                drop(held);

                let report = stage.present(&after, [&creature]);
                assert!(passes.iter().all(|id| ran(&report, *id)), "{said}: {:?}", report.passes);
                assert!(stage.picture() == expected, "{said}: the picture differs");
                let report = stage.present(&after, [&creature]);
                assert!(!passes.iter().any(|id| ran(&report, *id)), "{said}: again {:?}", report.passes);
                assert!(stage.picture() == expected, "{said}: the next frame differs");
            }
        }
    }
}

#[test]
fn culled_instances_still_cast_shadows() {
    if gpu("culled_instances_still_cast_shadows").is_none() {
        return;
    }
    let gpu = separate_device(wgpu::Features::PIPELINE_STATISTICS_QUERY);
    let mut stage = Stage::new(&gpu);
    let model = stage.load(&furry_package());
    // The instance is between the light and the visible instance.
    let towards_light = Vec3::new(-1.0, 0.05, 0.5).normalize();
    let between = Mat4::from_translation(0.6 * towards_light);
    let (seen, outside) = (Instance::new(0, &model), Instance::new(1, &model).at(between));
    let params = lit_from(from(Vec3::Z), towards_light);
    let count = |stage: &mut Stage<'_>, instances: &[&Instance]| -> (FrameReport, PipelineStatistics) {
        let (encoder, frame) = stage.prepare(&params, instances.iter().copied());
        (frame.report().clone(), draw_with_statistics(&gpu, &stage.targets, encoder, |pass| frame.draw(pass)))
    };
    let (report, one) = count(&mut stage, &[&seen]);
    assert!(report.instances[0].in_picture && one.vertices > 1000 && one.fragments > 1000, "{one:?}");
    let unshaded = stage.picture();
    let (report, both) = count(&mut stage, &[&seen, &outside]);
    assert_eq!(report.instances.iter().map(|i| i.in_picture).collect::<Vec<_>>(), [true, false]);
    assert!(reason(&report, PassId::SKIN).starts_with("1 instances"), "{}", reason(&report, PassId::SKIN));
    assert_eq!(both, one, "an instance outside the picture must not be drawn");
    let shaded = stage.picture();
    assert!(shaded.mean(1) < 0.9 * unshaded.mean(1), "{} shaded, {} not", shaded.mean(1), unshaded.mean(1));
    assert_eq!(shaded.covered(), unshaded.covered());

    let (report, none) = count(&mut stage, &[&outside]);
    assert_eq!(none, PipelineStatistics { vertices: 0, fragments: 0 });
    for id in [PassId::SKIN, PassId::FINS, PassId::SHELLS] {
        assert!(!ran(&report, id) && reason(&report, id) == "nothing is in the picture", "{id:?}: {report:?}");
    }
    assert!(ran(&report, PassId::LAYER_SHADOW) && ran(&report, PassId::SHADOW_WIDTH), "{report:?}");
    // Without shadows, an instance outside the picture has no effect.
    let dark = params.clone().with(|p| p.soft_shadow = false).with_fur(|f| f.self_shadow = SelfShadow::Off);
    stage.present(&dark, [&seen]);
    let one = stage.picture();
    stage.present(&dark, [&seen, &outside]);
    assert!(stage.picture() == one);
}

/// Checks that culling is not too early: an instance that leaves the picture must already be invisible when it is
/// culled.
#[test]
fn only_invisible_instances_are_culled() {
    let Some(gpu) = gpu("only_invisible_instances_are_culled") else { return };
    let target = Vec3::new(0.02, -0.01, 0.0);
    let aslant = Vec3::new(-0.2, 0.3, 1.0);
    let perspective = Projection::Perspective { fov_y_rad: 0.7, aspect: 1.0, near_m: 0.1, far_m: 2.0 };
    let parallel = Projection::Orthographic { height_m: 0.5, aspect: 1.0, near_m: 0.1, far_m: 2.0 };
    for (reversed_depth, projection, from, motion) in [
        (false, perspective, aslant, bend(0.45)),
        (true, perspective, aslant, bend(0.45)),
        // The view is along the sides of the bounding box, so the culling bounds are tight.
        (false, parallel, Vec3::Z, Motion::Rest),
    ] {
        let options = RendererOptions { reversed_depth, ..RendererOptions::default() };
        let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options).unwrap();
        let targets = Canvas::new(gpu, SIZE, &(&options).into());
        let camera = Camera::look_at(target + from, target, projection);
        let plain = FrameParams::new(camera, SIZE.into())
            .with(|p| p.soft_shadow = false)
            .with_fur(|f| f.self_shadow = SelfShadow::Off);
        for (package, params) in [(furry_package(), plain.clone()), (ink_package(), in_ink(plain))] {
            let model = renderer.load_bytes(&package).unwrap();
            let world_from_view = camera.view_from_world.inverse();
            for way in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
                let way_ws = world_from_view.transform_vector3(way);
                let mut at = |distance: f32| {
                    let place = Mat4::from_translation(target + way_ws * distance);
                    let instance = Instance::new(0, &model).at(place).moving(motion.clone());
                    let mut encoder = gpu.device.create_command_encoder(&Default::default());
                    let frame = renderer.prepare(&mut encoder, &params, [&instance]).unwrap();
                    frame.draw(&mut targets.pass(&mut encoder, "application", Some(wgpu::Color::TRANSPARENT)));
                    gpu.queue.submit([encoder.finish()]);
                    frame.report().instances[0].in_picture
                };
                let (mut inside, mut outside) = (0.0f32, 3.0f32);
                assert!(at(inside) && !at(outside), "{projection:?}, {way}");
                for _ in 0..14 {
                    let middle = 0.5 * (inside + outside);
                    if at(middle) { inside = middle } else { outside = middle }
                }
                assert!(at(inside));
                let left = read(gpu, &targets).covered();
                assert_eq!(left, 0, "{projection:?}, {way}: pixels visible at {inside} m, culled at {outside} m");
                // Checks that the instance is visible again when it is slightly closer to the picture.
                let seen = (1..300).map(|k| inside - 0.01 * k as f32).find(|distance| {
                    at(*distance);
                    read(gpu, &targets).covered() > 0
                });
                let last = seen.expect("the instance must have been visible");
                assert!(inside - last < 0.3, "{projection:?}, {way}: visible up to {last} m, culled at {outside} m");
            }
        }
    }
}

#[test]
fn owner_buffers_are_kept_and_released_with_their_instances() {
    let Some(gpu) = gpu("owner_buffers_are_kept_and_released_with_their_instances") else { return };
    let mut stage = Stage::new(gpu);
    let params = from(Vec3::new(-0.3, 0.35, 1.0));
    let (bending, plain) = (furry_package(), package(&SphereParams { quads: 11, stripes: true, ..sphere() }));
    let (bending_model, plain_model) = (stage.load(&bending), stage.load(&plain));

    // Checks that a duplicate owner number is an error and changes nothing.
    let twins = [Instance::new(7, &bending_model), Instance::new(7, &plain_model).at(shifted_along_x(0.1))];
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let error = stage.renderer.prepare(&mut encoder, &params, &twins).unwrap_err().to_string();
    assert!(error.contains("Instance::owner") && error.contains('7') && error.contains("twice"), "{error}");
    assert_eq!(stage.renderer.owners_gpu_bytes(), 0, "a frame that failed keeps nothing");

    // If an instance changes its model and changes back, the picture must not depend on the other model.
    let [bent, still] = [(&bending, bend(0.5)), (&plain, Motion::Rest)]
        .map(|(package, motion)| draw_fresh(gpu, package, &params, |one| one.moving(motion.clone())));
    assert_ne!(bent, still);
    for _ in 0..2 {
        stage.present(&params, [Instance::new(7, &bending_model).moving(bend(0.5))]);
        assert!(stage.picture() == bent, "the model that bends");
        assert!(stage.renderer.owners_gpu_bytes() > 0, "its posed vertices");
        stage.present(&params, [Instance::new(7, &plain_model)]);
        assert!(stage.picture() == still, "the model without skeleton");
        assert_eq!(stage.renderer.owners_gpu_bytes(), 0, "nothing is posed any more");
    }

    // Checks that instances may be passed as an iterator, a vector or references, and that the picture does not depend
    // on the owner numbers.
    let place =
        |k: u64| Instance::new(k, &bending_model).at(shifted_along_x(0.05 * k as f32)).moving(bend(0.2 * k as f32));
    stage.present(&params, (0..3).map(place));
    let three = stage.picture();
    let one_owner = stage.renderer.owners_gpu_bytes() / 3;
    assert!(one_owner > 0 && stage.renderer.owners_gpu_bytes() == 3 * one_owner);
    let kept: Vec<Instance> = (0..3).map(place).collect();
    let report = stage.present(&params, &kept);
    assert!(stage.picture() == three && !ran(&report, PassId::POSE), "{}", reason(&report, PassId::POSE));
    stage.present(&params, [&kept[0], &kept[1], &kept[2]]);
    assert!(stage.picture() == three);
    let others =
        kept.iter().cloned().map(|one| Instance::new(one.owner + 100, &one.model).at(one.transform).moving(one.motion));
    let report = stage.present(&params, others);
    assert!(stage.picture() == three && ran(&report, PassId::POSE));
    assert_eq!(stage.renderer.owners_gpu_bytes(), 6 * one_owner);

    // State is released on request, or after 256 frames without the owner.
    for owner in 0..3 {
        stage.renderer.forget(owner);
    }
    stage.renderer.forget(12_345);
    assert_eq!(stage.renderer.owners_gpu_bytes(), 3 * one_owner);
    stage.present(&params, (0..3).map(place));
    assert!(stage.picture() == three);
    for _ in 0..300 {
        stage.present(&params, [&kept[1]]);
    }
    assert_eq!(stage.renderer.owners_gpu_bytes(), one_owner);
}

/// Checks a crowd that exceeds a buffer of the renderer: one frame must equal eight frames with an eighth of the
/// instances each.
#[test]
fn crowd_equals_the_same_instances_in_smaller_frames() {
    let Some(gpu) = gpu("crowd_equals_the_same_instances_in_smaller_frames") else { return };
    let size = (400, 400);
    let parallel = Projection::Orthographic { height_m: 8.0, aspect: 1.0, near_m: 0.0, far_m: 10.0 };
    let camera = Camera::look_at(Vec3::Z * 5.0, Vec3::ZERO, parallel);
    let fur = FrameParams::new(camera, size.into())
        .with(|p| p.soft_shadow = false)
        .with_fur(|f| f.self_shadow = SelfShadow::Off);
    // The lines are thin, so that lines of different frames do not touch.
    let ink = in_ink(fur.clone()).with(|p| {
        if let Style::Ink(ink) = &mut p.style {
            ink.width = LineWidth::Pixels(2.0);
        }
    });
    for (name, params) in [("fur", fur), ("ink", ink)] {
        let pictures = [400, 50].map(|at_once: u64| {
            let mut stage = Stage::new(gpu);
            let model = stage.load(&ink_package());
            let place = |k: u64| {
                let [column, row] = [k % 20, k / 20].map(|n| 0.4 * (n as f32 - 9.5));
                let place = Mat4::from_translation(Vec3::new(column, row, 0.0));
                Instance::new(k, &model).at(place).moving(bend(k as f32 / 400.0))
            };
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            let mut some = |first| {
                let instances = (first..first + at_once).map(place);
                stage.renderer.prepare(&mut encoder, &params, instances).unwrap()
            };
            let frames: Vec<_> = (0..400).step_by(at_once as usize).map(&mut some).collect();
            let targets = Canvas::new(gpu, size, &stage.renderer.options().into());
            let mut pass = targets.pass(&mut encoder, "application", Some(wgpu::Color::TRANSPARENT));
            frames.iter().for_each(|frame| frame.draw(&mut pass));
            drop(pass);
            gpu.queue.submit([encoder.finish()]);
            targets.texels(gpu).unwrap()
        });
        let covered = pictures[0].chunks_exact(4).filter(|p| p[3] > 0).count();
        assert!((20_000..120_000).contains(&covered), "{name}: {covered} pixels of them");
        assert!(pictures[0] == pictures[1], "{name}: one frame differs from several smaller ones");
    }
}

#[test]
fn public_types_are_send_and_sync() {
    fn may<T: Send + Sync>() {}
    fn may_be_kept_twice<T: Clone + Send + Sync>() {}
    may::<Renderer>();
    may::<Frame>();
    may_be_kept_twice::<Model>();
    may_be_kept_twice::<Instance>();
    may_be_kept_twice::<FrameParams>();
}

#[test]
fn first_frame_needs_only_prepared_pipelines() {
    let Some(gpu) = gpu("first_frame_needs_only_prepared_pipelines") else { return };
    let front = from(Vec3::new(-0.3, 0.35, 1.0));
    let filled = front.clone().with(|p| p.fill_lights = vec![Light::default()]);
    for (name, package, params) in [
        ("fur", furry_package(), front.clone()),
        ("fur in two lights", furry_package(), filled),
        ("skin", furry_package(), front.clone().with(|p| p.style = Style::Bare)),
        ("ink", ink_package(), in_ink(front.clone())),
    ] {
        let mut stage = Stage::new(gpu);
        let creature = Instance::new(0, &stage.load(&package)).moving(bend(0.3));
        let unprepared = stage.present(&params, [&creature]);
        assert!(unprepared.created.pipelines > 0, "{name}");
        let expected = stage.picture();

        let mut stage = Stage::new(gpu);
        let creature = Instance::new(0, &stage.load(&package)).moving(bend(0.3));
        stage.renderer.prepare_pipelines(&creature.model, &params).unwrap();
        assert_eq!(stage.renderer.owners_gpu_bytes(), 0, "{name}: nothing was drawn yet");
        let report = stage.present(&params, [&creature]);
        assert_eq!(report.created.pipelines, 0, "{name}");
        assert!(stage.picture() == expected, "{name}");
    }

    // The loop draws every level of detail, alone and beside a near instance.
    let auto = front.clone().with_fur(|f| f.detail = Detail::Auto { bias: 1.0 });
    let mut stage = Stage::new(gpu);
    let model = stage.load(&detail_package());
    stage.renderer.prepare_pipelines(&model, &auto).unwrap();
    let (mut levels, mut faded) = ([false; 3], 0);
    for step in 0..60 {
        let away = Vec3::new(-0.3, 0.35, 1.0).normalize() * -0.1 * 1.09f32.powi(step);
        let far = Instance::new(1, &model).at(Mat4::from_translation(away)).moving(bend(0.3));
        let mut params = auto.clone();
        if let Projection::Perspective { far_m, .. } = &mut params.camera.projection {
            *far_m = 100.0;
        }
        for instances in [vec![&far], vec![&far, &Instance::new(0, &model)]] {
            let report = stage.present(&params, instances.iter().copied());
            assert_eq!(report.created.pipelines, 0, "{step} steps away: {:?}", report.instances);
            assert!(report.instances[0].in_picture, "{step} steps away");
            levels[report.instances[0].level as usize] = true;
            faded += u32::from(report.instances[0].fade > 0.0);
        }
    }
    assert!(levels == [true; 3] && faded > 4, "{levels:?}, {faded} fading");
}

#[test]
fn models_with_other_shading_share_gpu_resources() {
    let Some(gpu) = gpu("models_with_other_shading_share_gpu_resources") else { return };
    let shiny = Shading { specular: [0.9; 3], ..Shading::default() };
    let mut stage = Stage::new(gpu);
    let mut creature = Instance::new(0, &stage.load(&furry_package())).moving(bend(0.3));
    let plain = from(Vec3::new(-0.3, 0.35, 1.0));
    stage.present(&plain.clone().with(|p| p.shading = Some(shiny)), [&creature]);
    let asked = stage.picture();
    creature.model = creature.model.with_shading(shiny).unwrap();
    assert_eq!(creature.model.manifest().shading, shiny);
    let report = stage.present(&plain, [&creature]);
    assert!(stage.picture() == asked, "a model's own shading must look like the same shading in the parameters");
    assert_eq!((report.created.buffers, report.created.pipelines), (0, 0));
    assert!(!ran(&report, PassId::POSE), "the pose has not changed");
    let error = creature.model.with_shading(Shading { ambient_floor: 2.0, ..shiny }).unwrap_err().to_string();
    assert!(error.contains("Model::with_shading") && error.contains("ambient_floor"), "{error}");
}

#[test]
fn clip_layers_are_blended_and_invalid_ones_refused() {
    let Some(gpu) = gpu("clip_layers_are_blended_and_invalid_ones_refused") else { return };
    let mut stage = Stage::new(gpu);
    let creature = Instance::new(0, &stage.load(&furry_package()));
    let params = from(Vec3::new(-0.3, 0.35, 1.0));
    let layer = ClipLayer { clip: Some(0), time_s: 0.3, share: 1.0 };
    let mut drawn = |motion| {
        stage.present(&params, [&creature.clone().moving(motion)]);
        stage.picture()
    };
    let (rest, bent) = (drawn(Motion::Rest), drawn(bend(0.3)));
    assert!(rest != bent);
    assert!(drawn(Motion::Blend(vec![layer])) == bent && drawn(Motion::Blend(Vec::new())) == rest);
    let half = drawn(Motion::Blend(vec![ClipLayer { share: 0.5, ..layer }]));
    assert!(half != rest && half != bent);
    assert!(drawn(Motion::Blend(vec![layer, ClipLayer { clip: None, ..layer }])) == rest);
    for (layers, words) in [
        (vec![ClipLayer { clip: Some(9), ..layer }], "clip 9, expected less than the 1 clips"),
        (vec![layer, ClipLayer { share: 1.5, ..layer }], "a share of 1.5, expected 0 to 1"),
        (vec![ClipLayer { time_s: f32::NAN, ..layer }], "NaN seconds, expected a finite number"),
        (vec![layer; 17], "17 layers, expected at most 16"),
    ] {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let faulty = creature.clone().moving(Motion::Blend(layers));
        let error = stage.renderer.prepare(&mut encoder, &params, [&faulty]).unwrap_err().to_string();
        assert!(error.contains("Instance::motion") && error.contains(words), "{error}");
    }
}

#[test]
fn preparing_pipelines_does_not_affect_recorded_frames() {
    if gpu("preparing_pipelines_does_not_affect_recorded_frames").is_none() {
        return;
    }
    let gpu = separate_device(wgpu::Features::empty());
    let params = from(Vec3::new(-0.3, 0.35, 1.0));
    let mut stage = Stage::new(&gpu);
    let creature = Instance::new(0, &stage.load(&ink_package())).moving(bend(0.3));
    for _ in 0..3 {
        stage.present(&params, [&creature]);
    }
    let (picture, bytes) = (stage.picture(), stage.renderer.owners_gpu_bytes());
    stage.renderer.prepare_pipelines(&creature.model, &in_ink(params.clone())).unwrap();
    let report = stage.present(&params, [&creature]);
    assert_eq!(report.created, CreatedObjects::default());
    for id in [PassId::POSE, PassId::LAYER_SHADOW, PassId::SHADOW_WIDTH] {
        assert!(!ran(&report, id), "{id:?}: {}", reason(&report, id));
    }
    assert!(stage.picture() == picture && stage.renderer.owners_gpu_bytes() == bytes);
    assert_eq!(stage.present(&in_ink(params), [&creature]).created.pipelines, 0);
}

/// Checks that two cameras in one submission (two eyes or two windows) create no resources once the buffers are large
/// enough, as with a single camera.
#[test]
fn two_views_in_one_submission_create_no_gpu_resources() {
    if gpu("two_views_in_one_submission_create_no_gpu_resources").is_none() {
        return;
    }
    let gpu = separate_device(wgpu::Features::empty());
    let near = from(Vec3::new(-0.3, 0.35, 1.0));
    let far = |params: FrameParams| params.with(|p| p.camera = Camera::framing(Vec3::ZERO, 3.0, Vec3::X, 0.6, 1.0));
    let auto = near.clone().with_fur(|fur| fur.detail = Detail::Auto { bias: 0.3 });
    let small = |params: FrameParams| params.with(|p| p.viewport = [40, 30]);
    for (name, package, views) in [
        ("two lights", furry_package(), [near.clone(), lit_from(near.clone(), Vec3::new(-1.0, 1.0, 0.3))]),
        ("near and far", detail_package(), [auto.clone(), far(auto)]),
        ("strands near and far", strand_package(), [in_strands(near.clone()), in_strands(far(near.clone()))]),
        ("ink", ink_package(), [in_ink(near.clone()), in_ink(far(near.clone()))]),
        ("ink of two sizes", ink_package(), [in_ink(near.clone()), small(in_ink(near))]),
    ] {
        for kept in [true, false] {
            let mut stage = Stage::new(&gpu);
            let creature = Instance::new(0, &stage.load(&package)).moving(bend(0.4));
            for round in 0..12 {
                let mut encoder = gpu.device.create_command_encoder(&Default::default());
                let mut frames = Vec::new();
                for (number, view) in views.iter().enumerate() {
                    let frame = stage.renderer.prepare(&mut encoder, view, [&creature]).unwrap();
                    frame.draw(&mut stage.targets.pass(&mut encoder, "application", Some(wgpu::Color::TRANSPARENT)));
                    let created = frame.report().created;
                    assert!(
                        round < 6 || created == CreatedObjects::default(),
                        "{name} {kept} {round} {number}: {created:?}"
                    );
                    // With two lights, each frame overwrites the maps of the other, unless both frames are alive at the
                    // same time.
                    let maps = ran(frame.report(), PassId::SHADOW_WIDTH) && (kept || name != "two lights");
                    assert!(round < 6 || !maps, "{name} {kept} {round} {number}: maps are drawn again");
                    frames.extend(kept.then_some(frame));
                }
                gpu.queue.submit([encoder.finish()]);
                gpu.wait().unwrap();
            }
        }
    }
}

/// Checks that the callback after each pass may submit the recorded commands, as an application that times passes does.
#[test]
fn pass_callback_may_submit_the_encoder() {
    let Some(gpu) = gpu("pass_callback_may_submit_the_encoder") else { return };
    let front = from(Vec3::new(-0.3, 0.35, 1.0));
    for (name, package, params) in [
        ("fur", furry_package(), front.clone()),
        ("strands", strand_package(), in_strands(front.clone())),
        ("ink", ink_package(), in_ink(front)),
    ] {
        let expected = draw_fresh(gpu, &package, &params, |one| one.moving(bend(0.4)));
        let mut stage = Stage::new(gpu);
        let creature = Instance::new(0, &stage.load(&package)).moving(bend(0.4));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut marked = Vec::new();
        let mut mark = |encoder: &mut wgpu::CommandEncoder, id: PassId| {
            let next = gpu.device.create_command_encoder(&Default::default());
            gpu.queue.submit([std::mem::replace(encoder, next).finish()]);
            marked.push(id);
        };
        let hooks = Hooks::default().mark(&mut mark);
        let frame = stage.renderer.prepare_with(&mut encoder, &params, [&creature], hooks).unwrap();
        stage.finish(encoder, &frame);
        assert!(stage.picture() == expected, "{name}");
        let before: Vec<_> = PassId::all().filter(|id| id.stage() == PassStage::Before).collect();
        assert_eq!(marked, before, "{name}: expected every pass before the picture, in order");
    }
}

/// Checks that a number of instances that grows in every frame requires new buffers only occasionally.
#[test]
fn growing_instance_counts_create_few_buffers() {
    if gpu("growing_instance_counts_create_few_buffers").is_none() {
        return;
    }
    let gpu = separate_device(wgpu::Features::empty());
    let mut stage = Stage::new(&gpu);
    let model = stage.load(&package(&SphereParams { quads: 2, ..sphere() }));
    // The instances are outside the picture, because only their data matters here.
    let params = from(Vec3::Z).with(|p| p.soft_shadow = false).with_fur(|f| f.self_shadow = SelfShadow::Off);
    let far = |k: u64| Instance::new(k, &model).at(shifted_along_x(50.0 + k as f32));
    let mut buffers = 0;
    for count in (240..900).step_by(4) {
        buffers += stage.present(&params, (0..count).map(far)).created.buffers;
    }
    assert!((1..=24).contains(&buffers), "{buffers} buffers for 165 sizes");
}

#[test]
fn invalid_caster_bounds_are_refused() {
    let Some(gpu) = gpu("invalid_caster_bounds_are_refused") else { return };
    let mut stage = Stage::new(gpu);
    for (center, radius) in [(Vec3::NAN, 1.0), (Vec3::ZERO, -1.0), (Vec3::ZERO, f32::INFINITY)] {
        let mut draw = |_: &mut wgpu::RenderPass<'_>, _: &LightView, _: CasterPass| ();
        let casters = Casters { bounds: Some(Sphere { center, radius }), revision: 0, draw: &mut draw };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let hooks = Hooks::default().casters(casters);
        let prepared = stage.renderer.prepare_with(&mut encoder, &from(Vec3::Z), std::iter::empty::<Instance>(), hooks);
        assert!(prepared.unwrap_err().to_string().starts_with("Casters::bounds is"), "{center} {radius}");
    }
}
