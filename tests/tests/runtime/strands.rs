//! Tests of individual strands: coverage, effect of the groom, mutual shadows, and the transition from layers.
#![allow(clippy::unwrap_used, reason = "tests")]

use pelage_runtime::formats::{Shading, StrandsData};
use pelage_runtime::glam::{Mat4, Quat, Vec3};
use pelage_runtime::{
    Camera, Detail, FrameParams, FrameReport, HairGeometry, Instance, Light, PassId, Projection, Renderer,
    RendererOptions, SelfShadow, StrandEdges, wgpu,
};
use pelage_stage::{Canvas, CanvasOptions, Gpu};
use pelage_tests::binary::workspace;
use pelage_tests::gpu::gpu;
use pelage_tests::packages::straight_strands;
use pelage_tests::pictures::{Picture, difference, draw, draw_passes};
use pelage_tests::plane::{PlaneGroom, groomed_plane};
use pelage_tests::silhouette::bake_plain;
use pelage_truth::compare::compare;

const SIZE: u32 = 256;
/// Width of the visible square, metres; slightly more than the plane, which is 0.2 m wide.
const SEEN_M: f32 = 0.25;
const PX_PER_M: f32 = SIZE as f32 / SEEN_M;
/// Number of tiles along an edge of the plane.
const TILES: f32 = 8.0;
const TILE_M: f32 = 0.2 / TILES;
/// Number of strands per tile, in rows that do not touch.
const ROWS: usize = 8;

/// Returns light that is equally strong on everything that no hair hides.
fn even_light() -> Shading {
    Shading { ambient: [0.0; 3], diffuse: [1.0; 3], specular: [0.0; 3], ..Shading::default() }
}

/// Returns a view straight down, in white light.
fn above() -> FrameParams {
    let projection = Projection::Orthographic { height_m: SEEN_M, aspect: 1.0, near_m: 0.0, far_m: 2.0 };
    FrameParams::new(Camera::look_at(Vec3::Z, Vec3::ZERO, projection), [SIZE; 2]).with(|p| {
        p.light = Light::Directional { towards_light: Vec3::Z, color: Vec3::ONE };
        p.soft_shadow = false;
    })
}

fn in_strands(params: FrameParams) -> FrameParams {
    params.with_fur(|fur| fur.hair = HairGeometry::Strands)
}

fn renderer(gpu: &Gpu, samples: u32) -> Renderer {
    let options = RendererOptions { sample_count: samples, ..RendererOptions::default() };
    Renderer::new(&gpu.device, &gpu.queue, &options).unwrap()
}

/// Returns parallel horizontal strands above the mesh surface; their width is given in pixels, and their length is 0.6
/// tiles.
fn horizontal_strands(width_px: f32) -> StrandsData {
    let roots: Vec<_> = (0..ROWS).map(|i| [0.37 * i as f32 % 1.0, (i as f32 + 0.5) / ROWS as f32]).collect();
    // The strands are slightly tilted, so that they cover samples of all rows.
    straight_strands(&roots, 0.5, &[[0.6, 0.07, 0.5]; ROWS], 0.5 * width_px / PX_PER_M / TILE_M)
}

fn plane(strands: StrandsData, groom: PlaneGroom) -> Vec<u8> {
    groomed_plane(4, 128, even_light(), &PlaneGroom { strands: Some((strands, TILES)), ..groom })
}

/// Returns the summed opacity of a picture of the strands alone, pixels.
fn covered_px(gpu: &Gpu, package: &[u8], params: &FrameParams, samples: u32) -> f32 {
    let mut renderer = renderer(gpu, samples);
    let instance = Instance::new(0, &renderer.load_bytes(package).unwrap());
    let texels = draw_passes(gpu, &mut renderer, params, &[&instance], &[PassId::STRANDS, PassId::STRAND_BLEND]);
    texels.chunks_exact(4).map(|texel| f32::from(texel[3]) / 255.0).sum()
}

/// Returns the expected coverage of strands that do not overlap, pixels.
fn expected_px(width_px: f32) -> f32 {
    let length_px = 0.6f32.hypot(0.07) * TILE_M * PX_PER_M;
    TILES * TILES * ROWS as f32 * length_px * width_px
}

/// Checks that a ribbon an eighth of a pixel wide covers an eighth of what a ribbon one pixel wide covers. If it were
/// drawn at least one pixel wide, as lines are, it would cover eight times as much.
#[test]
fn strand_coverage_equals_strand_width() {
    let Some(gpu) = gpu("strand_coverage_equals_strand_width") else { return };
    for (edges, samples) in [(StrandEdges::Samples, 4), (StrandEdges::Blended, 1), (StrandEdges::Blended, 4)] {
        for width_px in [1.5, 0.5, 0.125] {
            let params = in_strands(above()).with_fur(|fur| fur.strand_edges = edges);
            let found = covered_px(gpu, &plane(horizontal_strands(width_px), PlaneGroom::default()), &params, samples);
            let expected = expected_px(width_px);
            println!("{edges:?}, {samples} samples, {width_px} px: {found:.1} pixels of {expected:.1}");
            assert!((found / expected - 1.0).abs() < 0.03, "{edges:?}, {width_px} px: {found}, expected {expected}");
        }
    }
}

/// Checks blended edges against ribbons drawn with many samples. The picture must depend neither on the order of
/// threads nor on whether depth is reversed.
#[test]
fn blended_strands_approach_many_samples() {
    let Some(gpu) = gpu("blended_strands_approach_many_samples") else { return };
    let model = workspace().join("assets/models/hare.glb");
    let bytes = bake_plain(&model, Some("assets/recipes/hare.toml"), &["strands.enabled=true"]);
    let drawn = |edges, samples: u32, reversed_depth, side: u32| {
        let options = RendererOptions { sample_count: samples, reversed_depth, ..RendererOptions::default() };
        let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options).unwrap();
        let instance = Instance::new(0, &renderer.load_bytes(&bytes).unwrap());
        let bounds = instance.model.manifest().bounds;
        let center = Vec3::from(bounds.center);
        let eye = center + Vec3::new(0.62, 0.28, 0.73).normalize() * bounds.radius * 3.5;
        let projection = Projection::Perspective { fov_y_rad: 0.5, aspect: 1.0, near_m: 0.01, far_m: 100.0 };
        let params = FrameParams::new(Camera::look_at(eye, center, projection), [side; 2])
            .with_fur(|fur| (fur.hair, fur.strand_edges, fur.detail) = (HairGeometry::Strands, edges, Detail::Full));
        draw(gpu, &mut renderer, &params, &[&instance])
    };
    let blended = drawn(StrandEdges::Blended, 1, false, 256);
    assert!(blended == drawn(StrandEdges::Blended, 1, false, 256), "it depends on the order of threads");
    let reversed = difference(&blended, &drawn(StrandEdges::Blended, 1, true, 256));
    assert!(reversed.mean < 0.05, "{reversed:?}");
    // Each pixel is the mean of sixteen pixels with four samples each.
    let fine = drawn(StrandEdges::Samples, 4, false, 1024).shrunk(4);
    let of = |edges, samples| difference(&drawn(edges, samples, false, 256), &fine).mean;
    let found = [of(StrandEdges::Blended, 1), of(StrandEdges::Samples, 4), of(StrandEdges::Samples, 1)];
    println!("mean difference to 64 samples: {found:.3?} blended, of 4 samples, of 1");
    assert!(found[0] < found[1] && found[1] < found[2], "{found:?}");
}

#[test]
fn bareness_thins_drawn_strands() {
    let Some(gpu) = gpu("bareness_thins_drawn_strands") else { return };
    let grown =
        |groom| covered_px(gpu, &plane(horizontal_strands(1.0), groom), &in_strands(above()), 4) / expected_px(1.0);
    let vertex = |bareness| grown(PlaneGroom { vertex: [bareness, 0], ..PlaneGroom::default() });
    for bareness in [0u8, 64, 191, 255] {
        let (found, expected) = (vertex(bareness), 1.0 - f32::from(bareness) / 255.0);
        assert!((found - expected).abs() < 0.05, "{bareness}: {found}, expected {expected}");
    }
    // The groom texture is bare in its left half.
    let texels = [[0u8, 0], [0, 0], [255, 0], [255, 0]].repeat(4);
    let half = grown(PlaneGroom { texture: Some((4, texels)), ..PlaneGroom::default() });
    assert!((half - 0.5).abs() < 0.05, "{half}");
}

/// Checks that strands are interpolated between wet and dry; here, wet strands are half as long as dry ones.
#[test]
fn wet_strands_are_mixed_with_dry_ones() {
    let Some(gpu) = gpu("wet_strands_are_mixed_with_dry_ones") else { return };
    let dry = horizontal_strands(1.0);
    let shorter = |p: &pelage_runtime::formats::StrandPoint| pelage_runtime::formats::StrandPoint {
        aside: p.aside.map(|x| 0.5 * x),
        ..*p
    };
    let wet = dry.points.iter().map(shorter);
    let both = StrandsData { points: dry.points.iter().copied().chain(wet).collect(), ..dry.clone() };
    for wetness in [0u8, 85, 255] {
        let groom = PlaneGroom { vertex: [0, wetness], wet_opacity: Some(128), ..PlaneGroom::default() };
        let found = covered_px(gpu, &plane(both.clone(), groom), &in_strands(above()), 4) / expected_px(1.0);
        let expected = 1.0 - 0.5 * f32::from(wetness) / 255.0;
        assert!((found - expected).abs() < 0.03, "{wetness}: {found}, expected {expected}");
    }
}

/// Returns the mean light of all strand pixels that are not black.
fn mean_light(gpu: &Gpu, package: &[u8], params: &FrameParams) -> f64 {
    let mut renderer = renderer(gpu, 1);
    let instance = Instance::new(0, &renderer.load_bytes(package).unwrap());
    let texels = draw_passes(gpu, &mut renderer, params, &[&instance], &[PassId::STRANDS]);
    let lit: Vec<f64> = texels
        .chunks_exact(4)
        .filter(|t| t[3] == 255 && t[0] > 0)
        .map(|t| f64::from(pelage_runtime::formats::meaning::srgb_to_linear(t[0])))
        .collect();
    assert!(lit.len() > 1000, "{} pixels", lit.len());
    lit.iter().sum::<f64>() / lit.len() as f64
}

/// Checks the shadow of many thin strands on a wide strand below them, viewed from below. The transmittance is exp(-c),
/// where c is the share of each map texel that the thin strands cover.
#[test]
fn strands_shadow_the_strands_below() {
    let Some(gpu) = gpu("strands_shadow_the_strands_below") else { return };
    // Number of thin strands; there are several per texel of the map.
    const ABOVE: usize = 128;
    for cover in [0.25f32, 1.0] {
        // The strands are as long as the tile, so that their coverage is uniform.
        let roots: Vec<_> = (0..ABOVE).map(|i| [0.0, (i as f32 + 0.5) / ABOVE as f32]).collect();
        let mut strands = straight_strands(&roots, 1.0, &[[1.0, 0.0, 1.0]; ABOVE], 0.5 * cover / ABOVE as f32);
        // The thin strands are black, so that the picture shows only the strand below them.
        strands.points.iter_mut().for_each(|point| point.color = [0; 3]);
        let below = straight_strands(&[[0.0, 0.51]], 0.0, &[[1.0, 0.0, 0.0]], 0.1);
        strands.roots.extend(below.roots);
        strands.points.extend(below.points);
        let package = plane(strands, PlaneGroom::default());
        // Strands have the same light for a camera on either side. The plane is not drawn.
        let projection = Projection::Orthographic { height_m: 0.15, aspect: 1.0, near_m: 0.0, far_m: 2.0 };
        let below = in_strands(above()).with(|p| {
            // The camera looks almost straight up. The surface then still faces it enough for its hair to be drawn.
            p.camera = Camera::look_at(Vec3::new(0.0, -1.0, -0.4), Vec3::ZERO, projection);
        });
        let [shaded, plain] = [SelfShadow::Auto, SelfShadow::Off]
            .map(|s| mean_light(gpu, &package, &below.clone().with_fur(|f| f.self_shadow = s)));
        println!("{cover}: {shaded:.4} of {plain:.4}, expected {:.4}", (-cover).exp());
        assert!((shaded / plain - f64::from((-cover).exp())).abs() < 0.06, "{cover}: {shaded} of {plain}");
    }
}

/// Checks that light at the edges and ends of a ribbon is never negative, in a float target. Light must not be
/// extrapolated to pixel centres that the ribbon does not cover.
#[test]
fn light_at_strand_ends_is_never_negative() {
    let Some(gpu) = gpu("light_at_strand_ends_is_never_negative") else { return };
    let mut strands = horizontal_strands(0.5);
    // The points are alternately black and white.
    let white = |point: usize| if point.is_multiple_of(2) { 0 } else { 255 };
    strands.points.iter_mut().enumerate().for_each(|(number, point)| point.color = [white(number); 3]);
    let options = CanvasOptions {
        color_format: wgpu::TextureFormat::Rgba16Float,
        sample_count: 4,
        reversed_depth: false,
        ..CanvasOptions::default()
    };
    let canvas = Canvas::new(gpu, (SIZE, SIZE), &options);
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options.renderer()).unwrap();
    let instance = Instance::new(0, &renderer.load_bytes(&plane(strands, PlaneGroom::default())).unwrap());
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let frame = renderer.prepare(&mut encoder, &in_strands(above()), [&instance]).unwrap();
    let mut pass = canvas.pass(&mut encoder, "strands", Some(wgpu::Color::TRANSPARENT));
    frame.draw_pass(PassId::STRANDS, &mut pass);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    let texels = canvas.texels(gpu).unwrap();
    // The highest bit of a half float is its sign.
    let numbers = texels.chunks_exact(2).map(|bytes| u16::from_le_bytes([bytes[0], bytes[1]]));
    let (lit, negative) = numbers.fold((0, 0), |(lit, negative), number| match number {
        0 | 0x8000 => (lit, negative),
        1..0x8000 => (lit + 1, negative),
        0x8001.. => (lit, negative + 1),
    });
    assert!(lit > 1000 && negative == 0, "{negative} numbers below 0 beside {lit} above");
}

/// Checks that strands look the same if they are scaled, rotated and mirrored together with camera and light.
#[test]
fn strands_follow_the_instance() {
    let Some(gpu) = gpu("strands_follow_the_instance") else { return };
    let package = plane(horizontal_strands(2.0), PlaneGroom::default());
    let mut renderer = renderer(gpu, 4);
    let model = renderer.load_bytes(&package).unwrap();
    // Shadow maps are off, because they depend on the position.
    let above = || in_strands(above()).with_fur(|fur| fur.self_shadow = SelfShadow::Off);
    let plain = draw(gpu, &mut renderer, &above(), &[&Instance::new(0, &model)]);
    let (scale, turn, away) = (3.0, Quat::from_rotation_x(0.7), Vec3::new(5.0, -2.0, 1.0));
    let place = Mat4::from_scale_rotation_translation(Vec3::splat(scale), turn, away);
    let projection =
        Projection::Orthographic { height_m: scale * SEEN_M, aspect: 1.0, near_m: 0.0, far_m: scale * 2.0 };
    let params = above().with(|p| {
        // The rotation is about x, so that the up direction stays in the picture plane.
        p.camera = Camera::look_at(place.transform_point3(Vec3::Z), away, projection);
        p.light = Light::Directional { towards_light: turn * Vec3::Z, color: Vec3::ONE };
    });
    let elsewhere = draw(gpu, &mut renderer, &params, &[&Instance::new(0, &model).at(place)]);
    assert!(plain.mean(0) > 10.0, "strands are seen: {}", plain.mean(0));
    assert!(difference(&plain, &elsewhere).mean < 0.6, "{:?}", difference(&plain, &elsewhere));
    let mirror = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    let mirrored = draw(gpu, &mut renderer, &above(), &[&Instance::new(0, &model).at(mirror)]);
    let rows = mirrored.rgba.chunks_exact(SIZE as usize);
    let back = Picture { rgba: rows.flat_map(|row| row.iter().rev().copied()).collect(), ..mirrored.clone() };
    // The sample positions within a pixel are not symmetric, so edges differ. Misplaced strands would differ far more.
    assert!(difference(&plain, &back).mean < 3.0, "{:?}", difference(&plain, &back));
    assert!(difference(&plain, &mirrored).mean > 10.0, "{:?}", difference(&plain, &mirrored));
}

fn report(gpu: &Gpu, renderer: &mut Renderer, params: &FrameParams, instance: &Instance) -> FrameReport {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let frame = renderer.prepare(&mut encoder, params, [instance]).unwrap();
    gpu.queue.submit([encoder.finish()]);
    frame.report().clone()
}

fn ran(report: &FrameReport, id: PassId) -> bool {
    report.passes.iter().any(|pass| pass.name == id.name() && pass.ran)
}

#[test]
fn wide_enough_strands_replace_layers() {
    let Some(gpu) = gpu("wide_enough_strands_replace_layers") else { return };
    let at = |samples, width_px, change: &dyn Fn(&mut pelage_runtime::FurParams)| {
        let mut renderer = renderer(gpu, samples);
        let instance = Instance::new(
            0,
            &renderer.load_bytes(&plane(horizontal_strands(width_px), PlaneGroom::default())).unwrap(),
        );
        report(gpu, &mut renderer, &above().with_fur(change), &instance)
    };
    let auto = |_: &mut pelage_runtime::FurParams| ();
    let full = |fur: &mut pelage_runtime::FurParams| fur.detail = Detail::Full;
    // Columns: share of the strands that is drawn, width in pixels, samples, expected share of strands in the
    // transition. At full detail, strands replace layers at a width of 0.9 pixels over the square root of the samples.
    // With four samples, a quarter of the strands, each four times as wide, replaces the layers at a quarter of that
    // width.
    for (quarter, width_px, samples, share) in
        [(0.7, 1, 0.0), (0.95, 1, 1.0), (0.35, 4, 0.0), (0.387, 4, 0.5), (0.43, 4, 1.0), (0.48, 4, 1.0)]
            .into_iter()
            .flat_map(|(px, samples, share)| [(1.0, px, samples, share), (0.25, 0.25 * px, samples, share)])
            .filter(|(quarter, _, samples, _)| *quarter == 1.0 || *samples == 4)
    {
        let report = at(samples, width_px, if quarter < 1.0 { &auto } else { &full });
        let width_px = width_px / quarter;
        let found = report.instances[0].strands;
        assert!((found - share).abs() < 0.1, "{width_px} px at {samples} samples: {found}, expected {share}");
        assert_eq!(ran(&report, PassId::STRANDS), share > 0.0);
        let layers = width_px < 0.9 / (samples as f32).sqrt();
        assert_eq!(ran(&report, PassId::SHELLS), layers);
        assert_eq!(report.instances[0].layers, if layers { 3 } else { 0 });
    }
    // Checks that an explicit choice of geometry, layers or level has priority over the automatic transition.
    assert!(!ran(&at(4, 2.0, &|fur| fur.hair = HairGeometry::Shells), PassId::STRANDS));
    assert!(!ran(&at(4, 2.0, &|fur| fur.layers = Some(4)), PassId::STRANDS));
    assert!(!ran(&at(4, 2.0, &|fur| fur.detail = Detail::Level(0.0)), PassId::STRANDS));
    assert!(ran(&at(1, 0.05, &|fur| fur.hair = HairGeometry::Strands), PassId::STRANDS));
    assert!(!ran(&at(1, 0.05, &|fur| fur.hair = HairGeometry::Strands), PassId::SHELLS));
}

/// Checks that a mane with blended edges is drawn over fur in layers.
#[test]
fn blended_hair_draws_over_layers() {
    let Some(gpu) = gpu("blended_hair_draws_over_layers") else { return };
    let model = workspace().join("assets/models/pony.glb");
    let bytes = bake_plain(&model, Some("assets/recipes/pony.toml"), &[]);
    let drawn = |edges, samples: u32, side: u32| {
        let mut renderer = renderer(gpu, samples);
        let instance = Instance::new(0, &renderer.load_bytes(&bytes).unwrap());
        let bounds = instance.model.manifest().bounds;
        let center = Vec3::from(bounds.center);
        let eye = center + Vec3::new(0.9, 0.2, 0.4).normalize() * bounds.radius * 3.5;
        let projection = Projection::Perspective { fov_y_rad: 0.5, aspect: 1.0, near_m: 0.01, far_m: 100.0 };
        let params = FrameParams::new(Camera::look_at(eye, center, projection), [side; 2])
            .with_fur(|fur| (fur.hair, fur.strand_edges, fur.detail) = (HairGeometry::Shells, edges, Detail::Full));
        draw(gpu, &mut renderer, &params, &[&instance])
    };
    let fine = drawn(StrandEdges::Samples, 4, 1024).shrunk(4);
    let of = |edges, samples| difference(&drawn(edges, samples, 256), &fine).mean;
    let found = [of(StrandEdges::Blended, 4), of(StrandEdges::Samples, 4)];
    println!("mean difference to 64 samples: {found:.3?} blended, in samples");
    assert!(found[0] < found[1], "{found:?}");
}

/// Checks that no pipeline is compiled when a model comes near, for any number of points per strand.
#[test]
fn strands_need_only_prepared_pipelines() {
    let Some(gpu) = gpu("strands_need_only_prepared_pipelines") else { return };
    for (edges, id) in [(StrandEdges::Samples, PassId::STRANDS), (StrandEdges::Blended, PassId::STRAND_BLEND)] {
        let mut renderer = renderer(gpu, 4);
        let instance =
            Instance::new(0, &renderer.load_bytes(&plane(horizontal_strands(2.0), PlaneGroom::default())).unwrap());
        let seen = |height_m| {
            let projection = Projection::Orthographic { height_m, aspect: 1.0, near_m: 0.0, far_m: 2.0 };
            let detail = Detail::Auto { bias: 1.0 };
            above()
                .with(|p| p.camera.projection = projection)
                .with_fur(|f| (f.strand_edges, f.detail) = (edges, detail))
        };
        renderer.prepare_pipelines(&instance.model, &seen(SEEN_M)).unwrap();
        for nearer in [1.0, 8.0, 64.0] {
            let report = report(gpu, &mut renderer, &seen(SEEN_M / nearer), &instance);
            assert!(ran(&report, id), "{edges:?}, {nearer} times as near: {report:?}");
            assert_eq!(report.created.pipelines, 0, "{edges:?}, {nearer} times as near");
        }
    }
}

/// Checks that strands are drawn with samples if the per-pixel lists exceed the device's maximum buffer size.
#[test]
fn blended_edges_fall_back_to_samples() {
    if gpu("blended_edges_fall_back_to_samples").is_none() {
        return;
    }
    // The buffer has space for only half of the picture.
    let bytes = u64::from(SIZE * SIZE) * 36 / 2;
    let limits = wgpu::Limits { max_storage_buffer_binding_size: bytes, ..wgpu::Limits::default() };
    let gpu = Gpu::with(wgpu::Features::empty(), Some(limits)).unwrap();
    let mut renderer = renderer(&gpu, 4);
    let instance =
        Instance::new(0, &renderer.load_bytes(&plane(horizontal_strands(2.0), PlaneGroom::default())).unwrap());
    let params = in_strands(above()).with_fur(|fur| fur.strand_edges = StrandEdges::Blended);
    let found = report(&gpu, &mut renderer, &params, &instance);
    assert!(ran(&found, PassId::STRANDS) && !ran(&found, PassId::STRAND_BLEND), "{found:?}");
    let reason = &found.passes.iter().find(|pass| pass.name == PassId::STRAND_GATHER.name()).unwrap().reason;
    assert!(reason.contains("buffers"), "{reason}");
    // A smaller picture fits into the buffer.
    let small = report(&gpu, &mut renderer, &params.with(|p| p.viewport = [SIZE / 2; 2]), &instance);
    assert!(ran(&small, PassId::STRAND_BLEND) && !ran(&small, PassId::STRANDS), "{small:?}");
}

/// Checks that layers are drawn on a device with too few storage buffers, and that the frame report says so.
#[test]
fn devices_with_few_storage_buffers_draw_layers() {
    if gpu("devices_with_few_storage_buffers_draw_layers").is_none() {
        return;
    }
    let limits = wgpu::Limits { max_storage_buffers_per_shader_stage: 4, ..wgpu::Limits::default() };
    let gpu = Gpu::with(wgpu::Features::empty(), Some(limits)).unwrap();
    let mut renderer = renderer(&gpu, 4);
    let instance =
        Instance::new(0, &renderer.load_bytes(&plane(horizontal_strands(2.0), PlaneGroom::default())).unwrap());
    let report = report(&gpu, &mut renderer, &in_strands(above()), &instance);
    assert!(ran(&report, PassId::SHELLS) && !ran(&report, PassId::STRANDS));
    let reason = &report.passes.iter().find(|pass| pass.name == PassId::STRANDS.name()).unwrap().reason;
    assert!(reason.contains("storage buffers"), "{reason}");
}

/// Checks that strands are the same if the model was drawn in layers first.
#[test]
fn strands_enabled_later_are_posed() {
    let Some(gpu) = gpu("strands_enabled_later_are_posed") else { return };
    let package = plane(horizontal_strands(2.0), PlaneGroom::default());
    let drawn = |first: &[HairGeometry]| {
        let mut renderer = renderer(gpu, 4);
        let instance = Instance::new(0, &renderer.load_bytes(&package).unwrap());
        for hair in first {
            draw(gpu, &mut renderer, &above().with_fur(|fur| fur.hair = *hair), &[&instance]);
        }
        draw(gpu, &mut renderer, &in_strands(above()), &[&instance])
    };
    let at_once = drawn(&[]);
    assert!(at_once.mean(0) > 10.0, "strands are seen: {}", at_once.mean(0));
    assert!(
        drawn(&[HairGeometry::Shells]) == at_once
            && drawn(&[HairGeometry::Shells, HairGeometry::Strands, HairGeometry::Shells]) == at_once
    );
}

/// Checks the hare's transition from layers to strands: consecutive frames must not change more than in either form
/// alone.
#[test]
fn transition_from_layers_to_strands_does_not_pop() {
    let Some(gpu) = gpu("transition_from_layers_to_strands_does_not_pop") else { return };
    let model = workspace().join("assets/models/hare.glb");
    let bytes = bake_plain(&model, Some("assets/recipes/hare.toml"), &["strands.enabled=true"]);
    let mut renderer = renderer(gpu, 4);
    let instance = Instance::new(0, &renderer.load_bytes(&bytes).unwrap());
    let bounds = instance.model.manifest().bounds;
    let seen_from = |distance: f32, hair| {
        let center = Vec3::from(bounds.center);
        let eye = center + Vec3::new(0.62, 0.28, 0.73).normalize() * bounds.radius * distance;
        let projection = Projection::Perspective { fov_y_rad: 0.5, aspect: 1.0, near_m: 0.01, far_m: 100.0 };
        FrameParams::new(Camera::look_at(eye, center, projection), [200; 2]).with_fur(|f| f.hair = hair)
    };
    // During the transition, strands fade in first, then layers fade out.
    let drawn = |renderer: &mut Renderer, distance| {
        let found = report(gpu, renderer, &seen_from(distance, HairGeometry::Auto), &instance).instances[0];
        found.strands + if found.layers > 0 { 0.0 } else { 1.0 }
    };
    // Finds by bisection the distances at which strands begin, strands are complete, and layers end.
    let mut find = |wanted: f32| {
        let (mut near, mut far) = (1.5f32, 100.0f32);
        for _ in 0..40 {
            let middle = (near * far).sqrt();
            if drawn(&mut renderer, middle) > wanted { near = middle } else { far = middle }
        }
        near
    };
    let (far, all, near) = (find(0.001), find(0.999), find(1.5));
    assert!(far > 1.1 * near, "layers and strands are mixed from {far} to {near}");
    let [layers, strands] = [HairGeometry::Shells, HairGeometry::Strands].map(|hair| {
        let picture = draw(gpu, &mut renderer, &seen_from(near, hair), &[&instance]);
        picture.rgba.iter().map(|p| f64::from(p[3])).sum::<f64>()
    });
    assert!((strands / layers - 1.0).abs() < 0.05, "strands cover {strands}, layers {layers}");
    let mut largest = |hair| {
        let mut found = 0.0f64;
        for at in [far, (all * far).sqrt(), all, (all * near).sqrt(), near] {
            let frames: Vec<_> = (-3..=3)
                .map(|i| {
                    let picture = draw(gpu, &mut renderer, &seen_from(at * 1.002f32.powi(i), hair), &[&instance]);
                    let texels = picture.rgba.iter().flat_map(|[r, g, b, _]| [*r, *g, *b, 255]).collect();
                    image::RgbaImage::from_raw(200, 200, texels).unwrap()
                })
                .collect();
            let flip = |pair: &[image::RgbaImage]| compare(&pair[0], &pair[1], [0; 3]).unwrap().0.flip.mean;
            let here: Vec<f64> = frames.windows(2).map(flip).collect();
            println!("{hair:?} from {at:.3}: {here:.5?}");
            found = here.into_iter().fold(found, f64::max);
        }
        found
    };
    let [mixed, layers, strands] = [HairGeometry::Auto, HairGeometry::Shells, HairGeometry::Strands].map(&mut largest);
    println!("largest FLIP between frames: {mixed:.5} mixed, {layers:.5} layers, {strands:.5} strands");
    assert!(mixed < 1.3 * layers.max(strands), "largest FLIP: {mixed} mixed, {layers} layers, {strands} strands");
}
