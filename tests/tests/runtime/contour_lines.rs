//! Compares contour lines, extracted on the GPU, with the lines of the mesh that rays find.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::{Vec3, vec3};
use pelage_bake::strands::PosedMesh;
use pelage_lab::mask::Mask;
use pelage_lab::truth::{LineKind, LineParams, TrueLines};
use pelage_runtime::formats::{Limits, Package};
use pelage_runtime::{Camera, FrameParams, InkLines, InkParams, Instance, Renderer, RendererOptions, wgpu};
use pelage_stage::Gpu;
use pelage_tests::binary::workspace;
use pelage_tests::gpu::gpu;
use pelage_tests::silhouette::bake_plain;
use pelage_truth::{Lens, TrueCamera};

const QUICK: [&str; 4] = ["slice.layers=4", "slice.tile_texels=64", "fins.enabled=false", "hair.density=50"];
const SIZE: [u32; 2] = [834, 424];
const FOV_Y_RAD: f32 = 0.5;
/// Distance up to which a line is on another, pixels.
const NEAR_PX: f64 = 2.0;
/// Visibility from which a node counts as visible.
const SHOWN: f32 = 0.5;

fn read(gpu: &Gpu, buffer: &wgpu::Buffer) -> Vec<u8> {
    let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
    let size = buffer.size();
    let copy =
        gpu.device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, size);
    gpu.queue.submit([encoder.finish()]);
    gpu.read_buffer(&copy).unwrap()
}

/// Returns the pixel positions of the visible contour nodes of an instance at rest.
fn visible_nodes(gpu: &Gpu, package: &[u8], camera: Camera) -> Vec<[f32; 2]> {
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let instance = Instance::new(0, &renderer.load_bytes(package).unwrap());
    let params =
        FrameParams::new(camera, SIZE).with_ink(InkParams::default().with(|ink| ink.lines = InkLines::Strokes));
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let frame = renderer.prepare(&mut encoder, &params, [&instance]).unwrap();
    gpu.queue.submit([encoder.finish()]);
    let [counts, nodes] = frame.contour_buffers().next().unwrap().map(|buffer| read(gpu, buffer));
    let word = |bytes: &[u8], k: usize| u32::from_le_bytes(bytes[4 * k..4 * k + 4].try_into().unwrap());
    let number = |node: &[u8], k| f32::from_bits(word(node, k));
    let contours = nodes.chunks_exact(64).take(word(&counts, 4) as usize).filter(|node| word(node, 6) >> 24 == 0);
    contours.filter(|node| number(node, 3) > SHOWN).map(|node| [number(node, 0), number(node, 1)]).collect()
}

/// Returns the share of the points in the picture that are near a mask.
fn share_near(points: &[[f32; 2]], mask: &Mask) -> f64 {
    let distances = mask.distances();
    let at = |[x, y]: &[f32; 2]| {
        let inside = (0.0..SIZE[0] as f32).contains(x) && (0.0..SIZE[1] as f32).contains(y);
        inside.then(|| distances[*y as usize * SIZE[0] as usize + *x as usize])
    };
    let found: Vec<f64> = points.iter().filter_map(at).collect();
    found.iter().filter(|distance| **distance <= NEAR_PX).count() as f64 / found.len() as f64
}

#[test]
fn contour_nodes_are_on_the_lines_of_the_mesh() {
    let Some(gpu) = gpu("contour_nodes_are_on_the_lines_of_the_mesh") else { return };
    for name in ["hare", "ox"] {
        let model = workspace().join(format!("assets/models/{name}.glb"));
        let package = bake_plain(&model, Some(&format!("assets/recipes/{name}.toml")), &QUICK);
        let opened = Package::open(&package, &Limits::default()).unwrap();
        let bounds = opened.manifest().bounds;
        let truth = TrueLines::new(PosedMesh::posed(name, &opened, &[]).unwrap()).unwrap();
        for from in [vec3(0.9, 0.25, 0.5), vec3(0.3, 0.1, 1.0), vec3(-0.8, 0.5, -0.4)] {
            let aspect = SIZE[0] as f32 / SIZE[1] as f32;
            let camera = Camera::framing(Vec3::from(bounds.center), bounds.radius, from, FOV_Y_RAD, aspect);
            let lens = Lens::Perspective { fov_y_rad: FOV_Y_RAD };
            let true_camera = TrueCamera::from_view(camera.view_from_world, lens);
            let lines = truth.visible_from(&true_camera, SIZE.into(), &LineParams::default()).unwrap();
            let nodes = visible_nodes(gpu, &package, camera);
            let precision = share_near(&nodes, &lines.mask(&LineKind::ALL));
            println!("{name} from {from}: {} nodes, precision {precision:.3}", nodes.len());
            assert!(nodes.len() > 300 && precision >= 0.95, "{name} from {from}: precision {precision}");
        }
    }
}
