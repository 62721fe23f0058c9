//! Tests that the hair motion computed on the GPU matches its Rust counterpart in `pelage-formats`, particle for
//! particle.

use crate::camera::Camera;
use crate::frame_tests::gpu;
use crate::instance::Instance;
use crate::params::{FrameParams, HairMotionParams, RendererOptions, SelfShadow};
use crate::renderer::Renderer;
use glam::{Mat3, Mat4, Quat, Vec3};
use pelage_formats::meaning::hair_groups::{smoothed, triangle_frame};
use pelage_formats::meaning::hair_motion::{
    Capsule, Frame, GRAVITY, GroomedGuide, Particle, RootFrame, Springs, Wind, advance_frame, gravity_compensation,
    steps,
};
use pelage_formats::{
    AttributeVertex, BodyCollider, GeometryVertex, GroupMotion, HairGroup, HairMotion, Manifest, Material, MeshData,
    PackageWriter, Part, TrianglePoint,
};
use pelage_stage::Gpu;

const POINTS: usize = 9;
const MOTION: GroupMotion =
    GroupMotion { held: 0.1, free: 0.5, drag_per_s: 1.5, shape_hz: 0.8, bend_hz: 1.5, friction: 0.3 };
/// Freedom of movement of each guide, 0..=255; the first one follows the surface.
const FREEDOM: [u8; 8] = [0, 128, 250, 255, 255, 255, 255, 255];
const WIND: Wind = Wind { velocity: Vec3::new(2.0, 0.0, -1.0), gust: 0.5, gust_s: 0.7, turbulence: 0.4, eddy_m: 0.3 };

/// Returns the contents of a GPU buffer.
pub fn read<T: bytemuck::Pod>(gpu: &Gpu, buffer: &wgpu::Buffer) -> Vec<T> {
    let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
    let copy = wgpu::BufferDescriptor { label: None, size: buffer.size(), usage, mapped_at_creation: false };
    let copy = gpu.device.create_buffer(&copy);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
    gpu.queue.submit([encoder.finish()]);
    bytemuck::pod_collect_to_vec(&gpu.read_buffer(&copy).unwrap())
}

/// Returns the texels of a texture with one layer; `T` has the size of a texel.
pub fn read_texels<T: bytemuck::Pod>(gpu: &Gpu, texture: &wgpu::Texture) -> Vec<T> {
    let (size, texel) = (texture.size(), size_of::<T>() as u32);
    let row = (texel * size.width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
    let bytes = u64::from(row * size.height);
    let copy = wgpu::BufferDescriptor { label: None, size: bytes, usage, mapped_at_creation: false };
    let copy = gpu.device.create_buffer(&copy);
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: Some(size.height) };
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let to = wgpu::TexelCopyBufferInfo { buffer: &copy, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, size);
    gpu.queue.submit([encoder.finish()]);
    let bytes = gpu.read_buffer(&copy).unwrap();
    let rows = bytes.chunks_exact(row as usize).map(|line| &line[..(texel * size.width) as usize]);
    rows.flat_map(bytemuck::pod_collect_to_vec::<u8, T>).collect()
}

/// Returns a white material without hair.
pub fn white_skin() -> Material {
    Material {
        name: "skin".into(),
        base_color: [1.0; 4],
        base_color_texture: None,
        groom_texture: None,
        alpha_cutoff: None,
        furred: false,
        double_sided: false,
    }
}

/// Octahedron with one guide on each side.
struct Scene {
    corners: Vec<[Vec3; 3]>,
    points: Vec<Vec<Vec3>>,
    package: Vec<u8>,
}

impl Scene {
    fn new(colliders: Vec<BodyCollider>) -> Self {
        let tips = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z].map(|tip| tip * 0.1);
        let sides = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
        let corners: Vec<[Vec3; 3]> = sides.iter().map(|side| side.map(|v: usize| tips[v])).collect();
        let vertex = |tip: &Vec3| GeometryVertex {
            position: tip.to_array(),
            normal: tip.normalize().to_array(),
            tangent: [1.0, 0.0, 0.0, 1.0],
            ..GeometryVertex::default()
        };
        let mesh = MeshData {
            geometry: tips.iter().map(vertex).collect(),
            attributes: vec![AttributeVertex::default(); 6],
            indices: sides.iter().flatten().map(|v| *v as u32).collect(),
            ..MeshData::default()
        };
        let groomed = |side: usize| {
            let bent = 0.03 * side as f32;
            let point = |k: usize| {
                let t = k as f32 / (POINTS - 1) as f32;
                Vec3::new(bent * t * t, 0.02 * (4.0 * t).sin(), 0.12 * t)
            };
            (0..POINTS).map(point).collect::<Vec<_>>()
        };
        let root = |side: usize| TrianglePoint { triangle: side as u32, weights: [0.5, 0.25, 0.25] };
        let guides: Vec<_> = (0..8).map(|side| (root(side), groomed(side)[1..].to_vec())).collect();
        let mut group = HairGroup {
            name: "mop".into(),
            points: POINTS as u32,
            lock_hairs: 1,
            root_radius_m: 0.004,
            ..HairGroup::default()
        };
        group.set_guides(&guides);
        // The guides are quantised and resampled, as in the package.
        let points = (0..8).map(|side| smoothed(&group.guide(side), POINTS)).collect();
        let manifest = Manifest {
            materials: vec![white_skin()],
            parts: vec![Part { material: 0, first_index: 0, index_count: 24 }],
            ..Manifest::default()
        };
        let motion = HairMotion { groups: vec![MOTION], freedom: vec![FREEDOM.to_vec()], colliders };
        let writer = PackageWriter::new(manifest).mesh(&mesh).hair_groups(&[group]).hair_motion(&motion);
        Self { corners, points, package: writer.finish().unwrap() }
    }

    fn rooted(&self, side: usize, transform: Mat4) -> RootFrame {
        let corners = self.corners[side];
        let root = corners[0] * 0.5 + (corners[1] + corners[2]) * 0.25;
        let frame = Mat3::from_mat4(transform) * triangle_frame(corners);
        RootFrame { root: transform.transform_point3(root), frame }
    }

    /// Returns the final points of each guide as computed by the Rust counterpart, in model space, relative to the
    /// guide's root.
    fn expected_points(
        &self,
        frames: u32,
        fps: f32,
        at: &dyn Fn(u32) -> (Mat4, Vec<Capsule>),
        wind: Wind,
    ) -> Vec<Vec3> {
        let GroupMotion { drag_per_s, shape_hz, bend_hz, friction, .. } = MOTION;
        let springs = Springs { drag_per_s, shape_hz, bend_hz, friction };
        let mut all = Vec::new();
        for (side, points) in self.points.iter().enumerate() {
            let ballast = gravity_compensation(points, triangle_frame(self.corners[side]));
            let of_guide = f32::from(FREEDOM[side]) / 255.0;
            let free: Vec<f32> =
                (0..POINTS).map(|k| of_guide * MOTION.freedom(k as f32 / (POINTS - 1) as f32)).collect();
            let groomed = GroomedGuide { points, ballast: &ballast, free: &free };
            let mut particles: Vec<Particle> = self.rooted(side, at(0).0).groomed(points);
            for frame in 1..frames {
                let colliders: Vec<_> = at(frame - 1).1.into_iter().zip(at(frame).1).map(|(a, b)| [a, b]).collect();
                let moment = Frame {
                    seconds: 1.0 / fps,
                    before_s: steps(1.0 / fps).1,
                    gravity: Vec3::NEG_Y * GRAVITY,
                    wind,
                    time_s: frame as f32 / fps,
                    colliders: &colliders,
                };
                let [before, now] = [frame - 1, frame].map(|frame| self.rooted(side, at(frame).0));
                advance_frame(&mut particles, &groomed, &springs, &moment, before, now);
            }
            let back = Mat3::from_mat4(at(frames - 1).0).inverse();
            all.extend(particles.iter().map(|particle| back * particle.place));
        }
        all
    }

    fn points_on_gpu(
        &self,
        gpu: &Gpu,
        frames: u32,
        fps: f32,
        at: &dyn Fn(u32) -> (Mat4, Vec<Capsule>),
        wind: Wind,
    ) -> Vec<Vec3> {
        let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
        let model = renderer.load_bytes(&self.package).unwrap();
        let camera = Camera::framing(Vec3::ZERO, 0.3, Vec3::Z, 0.6, 1.0);
        for frame in 0..frames {
            let (transform, colliders) = at(frame);
            let mut instance = Instance::new(1, &model).at(transform);
            // The first collider belongs to the body itself.
            instance.colliders = colliders[1..].to_vec();
            let blown = HairMotionParams::default().with(|p| p.wind = wind);
            let time_s = f64::from(frame) / f64::from(fps);
            let params = FrameParams::new(camera, [64, 64]).with(|p| (p.time_s, p.hair_motion) = (time_s, Some(blown)));
            let params = params.with(|p| p.soft_shadow = false).with_fur(|fur| fur.self_shadow = SelfShadow::Off);
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            renderer.prepare(&mut encoder, &params, [&instance]).unwrap();
            gpu.queue.submit([encoder.finish()]);
        }
        let guides = renderer.posed_guides(1, 0).unwrap();
        let numbers: Vec<[f32; 4]> = read(gpu, guides);
        numbers.iter().map(|[x, y, z, _]| Vec3::new(*x, *y, *z)).collect()
    }
}

#[test]
fn gpu_hair_motion_matches_the_cpu() {
    let Some(gpu) = gpu("gpu_hair_motion_matches_the_cpu") else { return };
    let body = BodyCollider { joint: 0, from: [0.0; 3], to: [0.0, 0.03, 0.0], radius: 0.06 };
    let scene = Scene::new(vec![body]);
    // The body moves, turns and grows, among colliders that come from the side.
    let at = |frame: u32| {
        let t = frame as f32 / 60.0;
        let turn = Quat::from_rotation_z(0.8 * (3.0 * t).sin());
        let place = Vec3::new(0.08 * (7.0 * t).sin(), 0.02, 40.0);
        let transform = Mat4::from_scale_rotation_translation(Vec3::splat(1.2), turn, place);
        let [from, to] = [Vec3::ZERO, Vec3::Y * 0.03].map(|end| transform.transform_point3(end));
        let ball = Vec3::new(0.4 - 0.006 * frame as f32, 0.1, 40.05);
        (transform, vec![Capsule { from, to, radius_m: 0.072 }, Capsule { from: ball, to: ball, radius_m: 0.08 }])
    };
    for (fps, frames) in [(60.0, 30), (30.0, 15), (144.0, 60)] {
        let (found, expected) =
            (scene.points_on_gpu(&gpu, frames, fps, &at, WIND), scene.expected_points(frames, fps, &at, WIND));
        let off = found.iter().zip(&expected).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        let groomed = scene.points.iter().enumerate().flat_map(|(side, points)| {
            let frame = triangle_frame(scene.corners[side]);
            points.iter().map(move |p| frame * *p)
        });
        let swung = found.iter().zip(groomed).map(|(a, b)| a.distance(b)).fold(0.0, f32::max);
        println!("{fps} frames a second: off by {off:.1e} m, swung by {swung:.3} m");
        assert_eq!(found.len(), expected.len());
        assert!(off < 1e-3 && swung > 0.03, "off by {off} m, swung by {swung} m");
    }
}

/// Checks that hair blown aside returns to its groomed shape, and that further steps do not move it.
#[test]
fn hair_comes_to_rest_in_its_groomed_shape() {
    let Some(gpu) = gpu("hair_comes_to_rest_in_its_groomed_shape") else { return };
    let scene = Scene::new(Vec::new());
    let still = |_: u32| (Mat4::IDENTITY, vec![Capsule::default()]);
    let calm = Wind { velocity: Vec3::ZERO, ..WIND };
    let found = scene.points_on_gpu(&gpu, 120, 60.0, &still, calm);
    let expected = scene.expected_points(1, 60.0, &still, calm);
    let off = found.iter().zip(&expected).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(off < 2e-5, "off by {off} m");
}
