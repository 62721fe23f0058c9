//! Tests of swinging guided hair: when it swings, and that it comes to rest.

#![allow(clippy::unwrap_used, reason = "tests")]

use pelage_runtime::formats::{GroupMotion, HairGroup, HairMotion, Limits, Package, PackageWriter};
use pelage_runtime::glam::{Mat4, Vec3};
use pelage_runtime::{
    Camera, Capsule, FrameParams, HairMotionParams, Instance, PassId, Renderer, RendererOptions, RuntimeError,
    SelfShadow,
};
use pelage_tests::gpu::gpu;
use pelage_tests::pictures::{difference, draw};
use pelage_tests::support::sphere::{SphereParams, package};

const POINTS: usize = 8;
const LENGTH_M: f32 = 0.12;
const GUIDES: u32 = 24;
const MOTION: GroupMotion =
    GroupMotion { held: 0.0, free: 0.4, drag_per_s: 1.5, shape_hz: 0.8, bend_hz: 1.5, friction: 0.3 };

fn sphere() -> Vec<u8> {
    package(&SphereParams { quads: 12, texels: 32, strands: 90, tiles: 4, ..SphereParams::default() })
}

/// Returns the positions and triangles of a package.
fn positions_and_triangles(bytes: &[u8]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let opened = Package::open(bytes, &Limits::default()).unwrap();
    let mesh = opened.mesh().unwrap().unwrap().to_data();
    let triangles = mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    (mesh.geometry.iter().map(|v| v.position.into()).collect(), triangles)
}

/// Returns a group of thick, protruding hairs. `points` returns the points of a guide in the frame of its triangle.
fn group(triangles: u32, points: impl Fn(u32) -> Vec<Vec3>) -> HairGroup {
    let roots = (0..GUIDES).map(|guide| guide * triangles / GUIDES);
    let guides: Vec<_> = roots
        .enumerate()
        .map(|(number, triangle)| {
            let root = pelage_runtime::formats::TrianglePoint { triangle, weights: [0.5, 0.25, 0.25] };
            (root, points(number as u32)[1..].to_vec())
        })
        .collect();
    let mut group = HairGroup {
        name: "mop".into(),
        points: POINTS as u32,
        lock_hairs: 1,
        root_radius_m: 0.004,
        tip_radius_m: 0.002,
        root_color: [200, 60, 30],
        tip_color: [240, 220, 60],
        ..HairGroup::default()
    };
    group.set_guides(&guides);
    group
}

fn straight(_: u32) -> Vec<Vec3> {
    (0..POINTS).map(|k| Vec3::new(0.0, 0.2, 1.0) * (LENGTH_M * k as f32 / (POINTS - 1) as f32)).collect()
}

fn with_hair(bytes: &[u8], group: HairGroup, motion: Option<HairMotion>) -> Vec<u8> {
    let package = Package::open(bytes, &Limits::default()).unwrap();
    let mesh = package.mesh().unwrap().unwrap().to_data();
    let mut writer = PackageWriter::new(package.manifest().clone()).mesh(&mesh).hair_groups(&[group]);
    if let Some(motion) = motion {
        writer = writer.hair_motion(&motion);
    }
    let textures = 0..package.manifest().textures.len() as u32;
    textures.fold(writer, |writer, i| writer.texture(package.texture(i).unwrap().ktx2)).finish().unwrap()
}

fn params() -> FrameParams {
    let camera = Camera::framing(Vec3::ZERO, 0.3, Vec3::new(-0.3, 0.35, 1.0), 0.6, 1.0);
    let params = FrameParams::new(camera, [128, 128]);
    params.with(|p| p.soft_shadow = false).with_fur(|fur| fur.self_shadow = SelfShadow::Off)
}

/// Returns a collider supplied by the application.
fn ball() -> Capsule {
    let place = Vec3::new(0.35, 0.1, 0.05);
    Capsule { from: place, to: place, radius_m: 0.08 }
}

#[test]
fn hair_at_rest_skips_simulation_and_keeps_its_groom() {
    let Some(gpu) = gpu("hair_at_rest_skips_simulation_and_keeps_its_groom") else { return };
    let bytes = sphere();
    let count = positions_and_triangles(&bytes).1.len() as u32;
    let motion = HairMotion { groups: vec![MOTION], freedom: vec![Vec::new()], colliders: Vec::new() };
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let model = renderer.load_bytes(&with_hair(&bytes, group(count, straight), Some(motion))).unwrap();
    let mut time_s = 0.0;
    let mut frame = |instance: &Instance, seconds: f64, wind: Vec3| {
        time_s += seconds;
        let moved = HairMotionParams::default().with(|p| p.wind.velocity = wind);
        let live = params().with(|p| (p.time_s, p.hair_motion) = (time_s, Some(moved)));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let frame = renderer.prepare(&mut encoder, &live, [instance]).unwrap();
        gpu.queue.submit([encoder.finish()]);
        let ran = |pass: PassId| frame.report().passes.iter().find(|p| p.name == pass.name()).unwrap().ran;
        let picture = draw(gpu, &mut renderer, &live, &[instance]);
        (ran(PassId::HAIR_MOTION), ran(PassId::HAIR_POSE), picture)
    };
    let still = Instance::new(1, &model);
    let (ran, posed, groomed) = frame(&still, 1.0 / 60.0, Vec3::ZERO);
    assert!(ran && posed);
    // The wind blows for one second, then stops.
    let (_, _, blown) = (0..30).map(|_| frame(&still, 1.0 / 30.0, Vec3::X * 4.0)).last().unwrap();
    let swing = difference(&blown, &groomed).mean;
    assert!(swing > 2.0, "{swing}");
    let mut rested = None;
    for number in 0..400 {
        let (ran, _, picture) = frame(&still, 1.0 / 30.0, Vec3::ZERO);
        if !ran {
            rested = Some((number, picture));
            break;
        }
    }
    let (frames, picture) = rested.unwrap();
    assert!((30..300).contains(&frames), "at rest after {frames} frames");
    // A thousandth of the swing remains, which changes pixels at the edges of hairs.
    let off = difference(&picture, &groomed).mean;
    assert!(off < 0.04 * swing, "off by {off}, swung by {swing}");
    // Without elapsed time nothing moves. After a cut, the motion restarts from the groomed shape.
    assert!(!frame(&still, 0.0, Vec3::ZERO).0);
    assert!(frame(&still.clone().at(Mat4::from_translation(Vec3::X * 0.01)), 1.0 / 60.0, Vec3::ZERO).0);
    let mut put = still.clone();
    put.hair_revision = 1;
    let (ran, _, anew) = frame(&put, 1.0 / 60.0, Vec3::ZERO);
    assert!(ran && difference(&anew, &groomed).mean == 0.0, "{:?}", difference(&anew, &groomed));
}

#[test]
fn invalid_hair_motion_parameters_are_refused() {
    let Some(gpu) = gpu("invalid_hair_motion_parameters_are_refused") else { return };
    let bytes = sphere();
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let model = renderer.load_bytes(&bytes).unwrap();
    let mut refused = |params: &FrameParams, instance: &Instance| {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        match renderer.prepare(&mut encoder, params, [instance]) {
            Err(RuntimeError::Params { field, .. }) => field,
            other => panic!("{other:?}"),
        }
    };
    let instance = Instance::new(1, &model);
    let moved = |change: fn(&mut HairMotionParams)| {
        params().with(|p| p.hair_motion = Some(HairMotionParams::default().with(change)))
    };
    assert_eq!(refused(&moved(|p| p.gravity.x = f32::NAN), &instance), "HairMotionParams::gravity");
    assert_eq!(refused(&moved(|p| p.wind.gust_s = 0.0), &instance), "HairMotionParams::wind");
    let mut crowded = instance.clone();
    crowded.colliders = vec![ball(); Instance::MAX_COLLIDERS + 1];
    assert_eq!(refused(&params(), &crowded), "Instance::colliders");
    let mut broken = instance;
    broken.colliders = vec![Capsule { radius_m: -1.0, ..ball() }];
    assert_eq!(refused(&params(), &broken), "Instance::colliders");
}
