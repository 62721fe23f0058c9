//! Contour lines of simple bodies, read back from the GPU.

use crate::camera::Camera;
use crate::contours::{ContourNode, LineNode};
use crate::frame::Frame;
use crate::frame_tests::gpu;
use crate::instance::Instance;
use crate::params::{FrameParams, InkParams, RendererOptions};
use crate::renderer::Renderer;
use crate::swing_tests::read;
use glam::{Mat4, Vec2, Vec3};
use pelage_formats::{
    ContourFace, ContourMark, ContourMesh, Limits, MeshView, Package, PackageWriter, Tag,
};
use pelage_stage::Gpu;
use std::collections::{BTreeMap, BTreeSet, HashMap};

#[path = "../../../examples/support/mod.rs"]
#[expect(dead_code, reason = "only the sphere is used")]
mod support;

const NO_NODE: u32 = u32::MAX;

/// Returns the contour mesh of a mesh whose equal positions are one vertex.
fn contour_mesh(mesh: &MeshView<'_>) -> ContourMesh {
    let geometry: Vec<_> = mesh.geometry().collect();
    let mut first = HashMap::new();
    let key = |p: [f32; 3]| p.map(|x| (x * 1e5).round() as i32);
    let vertices: Vec<u32> =
        geometry.iter().zip(0..).map(|(v, i)| *first.entry(key(v.position)).or_insert(i)).collect();
    let mut made = ContourMesh { most_nodes: 2048, ..ContourMesh::default() };
    let mut known = HashMap::new();
    let indices: Vec<u32> = mesh.indices.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
    for triangle in indices.chunks_exact(3) {
        let corners: [u32; 3] = std::array::from_fn(|k| vertices[triangle[k] as usize]);
        let mut face = ContourFace::default();
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            face.edges[k] = *known.entry([a.min(b), a.max(b)]).or_insert_with_key(|edge| {
                made.edges.push(*edge);
                made.edges.len() as u32 - 1
            });
            face.flags |= u32::from(a > b) << k;
        }
        made.faces.push(face);
    }
    made.marks = vec![ContourMark { line: 255, ..ContourMark::default() }; geometry.len()];
    made
}

/// Returns a sphere of radius 0.1 m with the ink style and a contour mesh.
fn sphere(quads: u32) -> Vec<u8> {
    let params = support::sphere::SphereParams { quads, texels: 8, layers: 2, ink: true, ..Default::default() };
    let bytes = support::sphere::package(&params);
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    let mut writer = PackageWriter::new(package.manifest().clone());
    for (index, section) in package.sections().iter().enumerate().filter(|(_, s)| s.tag != Tag::MANIFEST) {
        writer = writer.section(section.tag, package.section_bytes(index).unwrap().to_vec());
    }
    writer.contours(&contour_mesh(&package.mesh().unwrap().unwrap())).finish().unwrap()
}

/// Lines of the first instance of a frame.
struct Lines {
    nodes: Vec<ContourNode>,
    drawn: Vec<LineNode>,
    /// Number of crossed edges.
    crossed: u32,
}

fn lines_of(gpu: &Gpu, frame: &Frame) -> Lines {
    let buffers = &frame.instances()[0].contours.as_ref().unwrap().buffers;
    let counts: Vec<u32> = read(gpu, &buffers.counts);
    let count = counts[4] as usize;
    let (nodes, drawn): (Vec<ContourNode>, Vec<LineNode>) = (read(gpu, &buffers.nodes), read(gpu, &buffers.lines));
    Lines { nodes: nodes[..count].to_vec(), drawn: drawn[..count].to_vec(), crossed: counts[5] }
}

fn draw(gpu: &Gpu, package: &[u8], camera: Camera, size: [u32; 2], at: Mat4) -> (Frame, Lines) {
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let model = renderer.load_bytes(package).unwrap();
    let params = FrameParams::new(camera, size).with_ink(InkParams::default());
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let frame = renderer.prepare(&mut encoder, &params, [&Instance::new(1, &model).at(at)]).unwrap();
    gpu.queue.submit([encoder.finish()]);
    let lines = lines_of(gpu, &frame);
    (frame, lines)
}

/// Returns the nodes of each line, from any node of a closed one.
fn chains(nodes: &[ContourNode]) -> Vec<(Vec<usize>, bool)> {
    let mut left: BTreeSet<usize> = (0..nodes.len()).collect();
    let mut chains = Vec::new();
    let starts = (0..nodes.len()).filter(|i| nodes[*i].previous == NO_NODE).chain(0..nodes.len());
    for start in starts {
        let (mut chain, mut at) = (Vec::new(), start);
        while left.remove(&at) {
            chain.push(at);
            at = nodes[at].next as usize;
        }
        if !chain.is_empty() {
            chains.push((chain, at == start));
        }
    }
    chains
}

const SIZE: [u32; 2] = [640, 424];

fn camera() -> Camera {
    Camera::framing(Vec3::ZERO, 0.12, Vec3::new(0.3, 0.4, 1.0), 0.6, SIZE[0] as f32 / SIZE[1] as f32)
}

#[test]
fn sphere_has_one_closed_contour_on_its_outline() {
    let Some(gpu) = gpu("sphere_has_one_closed_contour_on_its_outline") else { return };
    for (quads, tolerance) in [(8, 2.0), (30, 0.6)] {
        let (_, lines) = draw(&gpu, &sphere(quads), camera(), SIZE, Mat4::IDENTITY);
        assert_eq!(lines.crossed as usize, lines.nodes.len());
        let chains = chains(&lines.nodes);
        assert_eq!((chains.len(), chains[0].1, chains[0].0.len()), (1, true, lines.nodes.len()), "{quads} quads");
        // The outline of a sphere is a circle: its radius is that of the tangent cone.
        let camera = camera();
        let center = Vec2::from(SIZE.map(|n| n as f32)) / 2.0;
        let distance = camera.view_from_world.inverse().w_axis.truncate().length();
        let sine = 0.1 / distance;
        let radius = sine / (1.0 - sine * sine).sqrt() * 0.5 * SIZE[1] as f32 / (0.3f32).tan();
        let mut length = 0.0;
        for (node, drawn) in lines.nodes.iter().zip(&lines.drawn) {
            let (px, smooth) = (Vec2::from(node.px), Vec2::from(drawn.px));
            for (what, place, off) in [("raw", px, tolerance), ("smooth", smooth, tolerance)] {
                let found = place.distance(center);
                assert!((found - radius).abs() < off, "{quads} quads, {what}: {found}, expected {radius}");
            }
            assert!(Vec2::from(node.outward).dot((px - center) / radius) > 0.97, "{node:?}");
            assert!(node.weight > 0.99, "{node:?}");
            length += smooth.distance(lines.drawn[node.next as usize].px.into());
            assert_eq!(lines.nodes[node.next as usize].previous as usize, lines.nodes.iter().position(|n| std::ptr::eq(n, node)).unwrap());
        }
        let expected = std::f32::consts::TAU * radius;
        assert!((length / expected - 1.0).abs() < 0.02, "{quads} quads: length {length}, expected {expected}");
    }
}

/// Returns the distance to the end of a stroke by its definition: the least over all nodes in a direction.
fn distances(lines: &Lines, most: f32, forward: bool) -> Vec<f32> {
    let weight = |i: usize| most * lines.drawn[i].brush[3];
    let before = |i: usize| if forward { lines.nodes[i].previous } else { lines.nodes[i].next };
    let of = |start: usize| {
        let (mut at, mut way, mut least) = (start, 0.0, f32::INFINITY);
        for _ in 0..lines.nodes.len() {
            least = least.min(way + weight(at));
            let next = before(at);
            if next == NO_NODE {
                return least.min(way);
            }
            way += Vec2::from(lines.drawn[at].px).distance(lines.drawn[next as usize].px.into());
            at = next as usize;
        }
        least
    };
    (0..lines.nodes.len()).map(of).collect()
}

#[test]
fn ends_of_strokes_are_where_the_definition_puts_them() {
    let Some(gpu) = gpu("ends_of_strokes_are_where_the_definition_puts_them") else { return };
    // The noise of the surface leaves out a part of the lit side, so the outline has ends.
    let (frame, lines) = draw(&gpu, &sphere(20), camera(), SIZE, Mat4::IDENTITY);
    drop(frame);
    let largest = lines.drawn.iter().map(|n| n.ends[0].max(n.ends[1])).fold(0.0, f32::max);
    let weights: BTreeMap<u32, f32> = lines.drawn.iter().map(|n| (n.brush[3].to_bits(), n.brush[3])).collect();
    let most_weight = weights.values().copied().fold(0.0, f32::max);
    let most = largest.max(1.0) / most_weight.max(1e-3);
    assert!(most_weight > 0.9, "{most_weight}");
    for (forward, side) in [(true, 0), (false, 1)] {
        for (i, expected) in distances(&lines, most, forward).into_iter().enumerate() {
            let found = lines.drawn[i].ends[side];
            assert!((found - expected).abs() < 0.01 * most, "node {i}: {found}, expected {expected} of {most}");
        }
    }
}

#[test]
fn contours_are_the_same_each_time_and_do_not_depend_on_the_transform() {
    let Some(gpu) = gpu("contours_are_the_same_each_time_and_do_not_depend_on_the_transform") else { return };
    let package = sphere(12);
    let (_, first) = draw(&gpu, &package, camera(), SIZE, Mat4::IDENTITY);
    let (_, again) = draw(&gpu, &package, camera(), SIZE, Mat4::IDENTITY);
    assert!(bytemuck::cast_slice::<_, u8>(&first.drawn) == bytemuck::cast_slice::<_, u8>(&again.drawn));
    let (_, mirrored) = draw(&gpu, &package, camera(), SIZE, Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)));
    assert_eq!(chains(&mirrored.nodes).len(), 1);
    assert!(mirrored.nodes.iter().all(|node| node.weight > 0.99));
}

#[cfg(test)]
mod dev;
