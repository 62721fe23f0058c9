//! Tests that the fur lean computed on the GPU matches its Rust counterpart in `pelage-formats`, vertex for vertex.

use crate::camera::Camera;
use crate::frame_tests::gpu;
use crate::instance::Instance;
use crate::params::{FrameParams, HairMotionParams, RendererOptions, SelfShadow, Wind};
use crate::renderer::Renderer;
use crate::swing_tests::{read, white_skin};
use glam::{Mat3, Mat4, Quat, Vec3};
use pelage_formats::meaning::fur_motion::{
    Frame, Tip, advance, freedom, initial_tip, lean, leaning_direction, tip_offset,
};
use pelage_formats::{AttributeVertex, FurInfo, GeometryVertex, Manifest, MeshData, PackageWriter, Part};
use pelage_stage::Gpu;

const HEIGHTS_M: [f32; 6] = [0.03, 0.06, 0.004, 0.03, 0.03, 0.0];
const LEANS: [f32; 6] = [0.0, 0.0, 0.0, 0.6, 0.0, 0.0];
const WETNESS: [u8; 6] = [0, 0, 0, 0, 200, 0];
const TIPS: [Vec3; 6] = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];
const WIND: Wind = Wind { velocity: Vec3::new(3.0, 0.0, -1.0), gust: 0.5, gust_s: 0.7, turbulence: 0.4, eddy_m: 0.3 };

/// Returns a package of an octahedron with several kinds of hair.
fn package() -> Vec<u8> {
    let sides = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    let vertex = |i: usize| GeometryVertex {
        position: (TIPS[i] * 0.1).to_array(),
        fur_height: HEIGHTS_M[i],
        normal: TIPS[i].to_array(),
        lean: LEANS[i],
        tangent: TIPS[(i + 1) % 3].extend(1.0).to_array(),
    };
    let mesh = MeshData {
        geometry: (0..6).map(vertex).collect(),
        attributes: WETNESS.map(|wet| AttributeVertex { groom: [0, wet, 0, 0], ..AttributeVertex::default() }).to_vec(),
        indices: sides.iter().flatten().copied().collect(),
        ..MeshData::default()
    };
    let manifest = Manifest {
        materials: vec![white_skin()],
        parts: vec![Part { material: 0, first_index: 0, index_count: 24 }],
        fur: FurInfo { height_m: 0.06, ..FurInfo::default() },
        ..Manifest::default()
    };
    PackageWriter::new(manifest).mesh(&mesh).finish().unwrap()
}

/// Returns a rotated, scaled and moving transform at a time.
fn at(time_s: f32) -> Mat4 {
    let turn = Quat::from_rotation_z(0.8 * (3.0 * time_s).sin());
    let place = Vec3::new(0.08 * (7.0 * time_s).sin(), 0.02, 40.0 + 2.0 * time_s);
    Mat4::from_scale_rotation_translation(Vec3::splat(1.2), turn, place)
}

/// Draws `frames` frames and returns the leaned vertices.
fn leaned_on_gpu(
    gpu: &Gpu,
    frames: u32,
    fps: f32,
    at: &dyn Fn(f32) -> Mat4,
    wind: Wind,
) -> Option<Vec<GeometryVertex>> {
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let model = renderer.load_bytes(&package()).unwrap();
    for frame in 0..frames {
        let instance = Instance::new(1, &model).at(at(frame as f32 / fps));
        let near = Camera::framing(instance.transform.w_axis.truncate(), 0.3, Vec3::Z, 0.6, 1.0);
        let params = FrameParams::new(near, [64, 64]).with(|p| {
            p.time_s = f64::from(frame) / f64::from(fps);
            p.hair_motion = Some(HairMotionParams::default().with(|p| p.wind = wind));
            p.soft_shadow = false;
        });
        let params = params.with_fur(|fur| fur.self_shadow = SelfShadow::Off);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        renderer.prepare(&mut encoder, &params, [&instance]).unwrap();
        gpu.queue.submit([encoder.finish()]);
    }
    renderer.leaned(1).map(|buffer| read(gpu, buffer))
}

/// Returns the world-space normal of each vertex as computed by the Rust counterpart.
fn expected_normals(frames: u32, fps: f32) -> Vec<Vec3> {
    let axis = |i: usize| {
        let (size, place) = (HEIGHTS_M[i] * 1.2, |t: f32| at(t).transform_point3(TIPS[i] * 0.1));
        let normal = (Mat3::from_mat4(at((frames - 1) as f32 / fps)) * TIPS[i]).normalize();
        if size == 0.0 {
            return normal;
        }
        let mut tip: Tip = initial_tip(size, place(0.0), &WIND, 0.0);
        for number in 1..frames {
            let [from, to] = [number - 1, number].map(|n| n as f32 / fps);
            let frame = Frame { seconds: to - from, before_s: 1.0 / fps, wind: &WIND, time_s: to };
            tip = advance(tip, size, place(to), place(to) - place(from), &frame);
        }
        let freedom = freedom(LEANS[i], f32::from(WETNESS[i]) / 255.0);
        let aside = tip_offset(&tip, size, 1.0 / fps);
        lean(aside, normal, size, freedom).map_or(normal, |(angle, along)| leaning_direction(normal, angle, along))
    };
    (0..6).map(axis).collect()
}

#[test]
fn gpu_fur_motion_matches_the_cpu() {
    let Some(gpu) = gpu("gpu_fur_motion_matches_the_cpu") else { return };
    for (fps, frames) in [(60.0, 40), (30.0, 20), (144.0, 90)] {
        let end = Mat3::from_mat4(at((frames - 1) as f32 / fps));
        let found = leaned_on_gpu(&gpu, frames, fps, &at, WIND).unwrap();
        let (mut off, mut leant) = (0.0f32, 0.0f32);
        for (i, (vertex, expected)) in found.iter().zip(expected_normals(frames, fps)).enumerate() {
            let normal = (end * Vec3::from(vertex.normal)).normalize();
            let tangent = Vec3::from_slice(&vertex.tangent);
            off = off.max(normal.distance(expected));
            leant = leant.max(normal.distance((end * TIPS[i]).normalize()));
            assert_eq!(Vec3::from(vertex.position), TIPS[i] * 0.1);
            assert!((tangent.length() - 1.0).abs() < 1e-5 && tangent.dot(vertex.normal.into()).abs() < 1e-5);
        }
        println!("{fps} frames a second: off by {off:.1e}, leant by {leant:.2}");
        assert!(off < 2e-3 && leant > 0.1, "{fps} frames a second: off by {off}, leant by {leant}");
    }
}

#[test]
fn fur_at_rest_keeps_its_groomed_shape() {
    let Some(gpu) = gpu("fur_at_rest_keeps_its_groomed_shape") else { return };
    let calm = Wind { velocity: Vec3::ZERO, ..WIND };
    let still = |_: f32| Mat4::from_scale_rotation_translation(Vec3::splat(1.2), Quat::from_rotation_x(0.4), Vec3::X);
    let found = leaned_on_gpu(&gpu, 10, 60.0, &still, calm).unwrap();
    assert!((0..6).all(|i| found[i].normal == TIPS[i].to_array() && found[i].lean == LEANS[i]), "{found:?}");
    // The model is so small on screen that the lean would be invisible.
    let far = |_: f32| Mat4::from_scale(Vec3::splat(1e-3));
    assert!(leaned_on_gpu(&gpu, 3, 60.0, &far, WIND).is_none());
}
