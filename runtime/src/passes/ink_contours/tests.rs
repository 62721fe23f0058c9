//! Contour lines of simple bodies, read back from the GPU.

use crate::camera::Camera;
use crate::contours::{ContourNode, LineNode};
use crate::frame::Frame;
use crate::frame_tests::gpu;
use crate::instance::Instance;
use crate::params::{FrameParams, InkLines, InkParams, RendererOptions};
use crate::passes::painting_ribbons;
use crate::renderer::Renderer;
use crate::swing_tests::{read, read_texels};
use glam::{Mat4, Vec2, Vec3};
use pelage_formats::{
    AttributeVertex, Bounds, ContourFace, ContourMark, ContourMesh, CreasePoint, GeometryVertex, InkData, InkVertex,
    Limits, Manifest, MeshData, Package, PackageWriter, Part, Tag,
};
use pelage_stage::Gpu;
use std::collections::{BTreeMap, BTreeSet, HashMap};

#[path = "../../../examples/support/mod.rs"]
#[expect(dead_code, reason = "only the sphere is used")]
mod support;

const NO_NODE: u32 = u32::MAX;

/// Returns the contour mesh of a mesh whose equal positions are one vertex.
fn contour_mesh(mesh: &MeshData) -> ContourMesh {
    let mut first = HashMap::new();
    // Vertices with other normals are separate.
    let key = |v: &GeometryVertex| {
        [v.position, v.normal.map(|x| 0.1 * x.round())].map(|p| p.map(|x| (x * 1e5).round() as i32))
    };
    let vertices: Vec<u32> = mesh.geometry.iter().zip(0..).map(|(v, i)| *first.entry(key(v)).or_insert(i)).collect();
    let mut made = ContourMesh { most_nodes: 2048, ..ContourMesh::default() };
    let mut known = HashMap::new();
    for triangle in mesh.indices.chunks_exact(3) {
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
    made.marks = vec![ContourMark { line: 255, ..ContourMark::default() }; mesh.geometry.len()];
    made
}

/// Returns a package of a mesh with the ink style. Its contour mesh has no creases.
fn package_of(mesh: &MeshData, creases: Vec<CreasePoint>) -> Vec<u8> {
    let params = support::sphere::SphereParams { texels: 8, layers: 2, ink: true, ..Default::default() };
    let bytes = support::sphere::package(&params);
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    let parts = vec![Part { material: 1, first_index: 0, index_count: mesh.indices.len() as u32 }];
    let radius = mesh.geometry.iter().map(|v| Vec3::from(v.position).length()).fold(0.0, f32::max);
    let bounds = Bounds { radius, ..package.manifest().bounds };
    let manifest = Manifest { parts, bounds, ..package.manifest().clone() };
    let ink = package.ink().unwrap().unwrap().to_data();
    let ink = InkData { vertices: vec![InkVertex::default(); mesh.geometry.len()], ..ink };
    let contours = ContourMesh { creases, ..contour_mesh(mesh) };
    let mut writer = PackageWriter::new(manifest).mesh(mesh).ink(&ink).contours(&contours);
    for (index, section) in package.sections().iter().enumerate().filter(|(_, s)| s.tag == Tag::TEXTURE) {
        writer = writer.section(section.tag, package.section_bytes(index).unwrap().to_vec());
    }
    writer.finish().unwrap()
}

fn vertex(position: Vec3, normal: Vec3) -> GeometryVertex {
    let tangent = normal.any_orthonormal_vector().extend(1.0).to_array();
    GeometryVertex { position: position.into(), normal: normal.into(), tangent, ..GeometryVertex::default() }
}

fn mesh_of(geometry: Vec<GeometryVertex>, indices: Vec<u32>) -> MeshData {
    let attributes = vec![AttributeVertex { color: [255; 4], ..AttributeVertex::default() }; geometry.len()];
    MeshData { geometry, attributes, indices, ..MeshData::default() }
}

/// Adds a ball of 2 · `rings` meridians.
fn add_ball(mesh: &mut MeshData, center: Vec3, radius: f32, rings: u32) {
    let (first, sides) = (mesh.geometry.len() as u32, 2 * rings);
    for (i, j) in (0..=rings).flat_map(|i| (0..sides).map(move |j| (i, j))) {
        let (a, b) = (std::f32::consts::PI * i as f32 / rings as f32, std::f32::consts::PI * j as f32 / rings as f32);
        let ring = if i == 0 || i == rings { 0.0 } else { a.sin() };
        let normal = Vec3::new(ring * b.sin(), a.cos(), ring * b.cos());
        mesh.geometry.push(vertex(center + radius * normal, normal));
        let at = |i: u32, j: u32| first + i * sides + j % sides;
        if i > 0 && i < rings {
            mesh.indices.extend([at(i, j), at(i + 1, j), at(i, j + 1)]);
        }
        if i + 1 < rings {
            mesh.indices.extend([at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)]);
        }
    }
    *mesh = mesh_of(std::mem::take(&mut mesh.geometry), std::mem::take(&mut mesh.indices));
}

/// Returns a sphere of radius 0.1 m with the ink style and a contour mesh.
fn sphere(rings: u32) -> Vec<u8> {
    let mut mesh = MeshData::default();
    add_ball(&mut mesh, Vec3::ZERO, 0.1, rings);
    package_of(&mesh, Vec::new())
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
    let params =
        FrameParams::new(camera, size).with_ink(InkParams::default().with(|ink| ink.lines = InkLines::Strokes));
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
    for (rings, tolerance) in [(12, 3.2), (60, 0.6)] {
        let (_, lines) = draw(&gpu, &sphere(rings), camera(), SIZE, Mat4::IDENTITY);
        assert_eq!(lines.crossed as usize, lines.nodes.len());
        let chains = chains(&lines.nodes);
        assert_eq!((chains.len(), chains[0].1, chains[0].0.len()), (1, true, lines.nodes.len()), "{rings} rings");
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
                assert!((found - radius).abs() < off, "{rings} rings, {what}: {found}, expected {radius}");
            }
            assert!(Vec2::from(node.outward).dot((px - center) / radius) > 0.97, "{node:?}");
            assert!(node.weight > 0.99, "{node:?}");
            length += smooth.distance(lines.drawn[node.next as usize].px.into());
            assert_eq!(
                lines.nodes[node.next as usize].previous as usize,
                lines.nodes.iter().position(|n| std::ptr::eq(n, node)).unwrap()
            );
        }
        let expected = std::f32::consts::TAU * radius;
        assert!((length / expected - 1.0).abs() < 0.02, "{rings} rings: length {length}, expected {expected}");
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

#[test]
fn line_of_a_hidden_ball_is_hidden() {
    let Some(gpu) = gpu("line_of_a_hidden_ball_is_hidden") else { return };
    let mut mesh = MeshData::default();
    add_ball(&mut mesh, Vec3::ZERO, 0.1, 40);
    // The second ball is behind the first, except for its upper part.
    add_ball(&mut mesh, Vec3::new(0.0, 0.12, -0.2), 0.06, 40);
    let camera = Camera::framing(Vec3::ZERO, 0.16, Vec3::Z, 0.6, SIZE[0] as f32 / SIZE[1] as f32);
    let (_, lines) = draw(&gpu, &package_of(&mesh, Vec::new()), camera, SIZE, Mat4::IDENTITY);
    let chains = chains(&lines.nodes);
    assert_eq!(chains.len(), 2);
    let top = |chain: &[usize]| chain.iter().map(|i| lines.nodes[*i].depth).sum::<f32>() / chain.len() as f32;
    let far = chains.iter().max_by(|a, b| top(&a.0).total_cmp(&top(&b.0))).unwrap();
    let front = chains.iter().min_by(|a, b| top(&a.0).total_cmp(&top(&b.0))).unwrap();
    assert!(front.0.iter().all(|i| lines.nodes[*i].weight > 0.99));
    let (width, center) = (SIZE[1] as f32, Vec2::from(SIZE.map(|n| n as f32)) / 2.0);
    let radius = front.0.iter().map(|i| Vec2::from(lines.nodes[*i].px).distance(center)).fold(0.0, f32::max);
    let mut counts = [0; 2];
    for node in far.0.iter().map(|i| lines.nodes[*i]) {
        let out = Vec2::from(node.px).distance(center) - radius;
        // Depth is compared up to four units outside the line.
        if out.abs() > 5.0 * width / 424.0 {
            let expected = if out > 0.0 { 1.0 } else { 0.0 };
            assert!((node.weight - expected).abs() < 0.01, "{node:?}, {out} px outside");
            counts[usize::from(out > 0.0)] += 1;
        }
    }
    assert!(counts[0] > 20 && counts[1] > 20, "{counts:?}");
}

/// A ball rises from behind another. Its line grows from a point and never jumps.
#[test]
fn strokes_grow_without_jumps() {
    let Some(gpu) = gpu("strokes_grow_without_jumps") else { return };
    let camera = Camera::framing(Vec3::ZERO, 0.16, Vec3::Z, 0.6, SIZE[0] as f32 / SIZE[1] as f32);
    let total = |step: u16| {
        let mut mesh = MeshData::default();
        add_ball(&mut mesh, Vec3::ZERO, 0.1, 40);
        add_ball(&mut mesh, Vec3::new(0.0, 0.06 + 0.001 * f32::from(step), -0.2), 0.06, 40);
        let (frame, _) = draw(&gpu, &package_of(&mesh, Vec::new()), camera, SIZE, Mat4::IDENTITY);
        densities(&gpu, &frame).into_iter().map(|[wet, dry]| wet + dry).sum::<f32>()
    };
    let totals: Vec<f32> = (0..60).map(total).collect();
    let (first, last) = (totals[0], totals[59]);
    let largest = totals.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
    assert!(last > 1.1 * first && largest < 0.15 * (last - first), "{first} to {last}, largest step {largest}");
}

#[test]
fn cube_has_creases_and_no_contours() {
    let Some(gpu) = gpu("cube_has_creases_and_no_contours") else { return };
    const PARTS: u32 = 20;
    let (mut geometry, mut indices, mut creases) = (Vec::new(), Vec::new(), Vec::new());
    let mut known = BTreeSet::new();
    for normal in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z] {
        let u = Vec3::new(normal.y.abs(), normal.z.abs(), normal.x.abs());
        let v = normal.cross(u);
        let first = geometry.len() as u32;
        let corners = [-u - v, u - v, u + v, v - u].map(|p| 0.1 * (normal + p));
        geometry.extend(corners.map(|p| vertex(p, normal)));
        indices.extend([0, 1, 2, 0, 2, 3].map(|k| first + k));
        for k in 0..4 {
            let [a, b] = [corners[k], corners[(k + 1) % 4]];
            if !known.insert(((a + b) * 100.0).round().as_ivec3().to_array()) {
                continue;
            }
            let vertices = [first + k as u32, first + (k as u32 + 1) % 4];
            creases.extend((0..=PARTS).map(|i| CreasePoint {
                vertices,
                share: (65_535 * i / PARTS) as u16,
                kind: CreasePoint::SHARP,
                next: if i == PARTS { CreasePoint::NONE } else { 0 },
            }));
        }
    }
    for (point, next) in creases.iter_mut().zip(1..) {
        point.next = if point.next == 0 { next } else { point.next };
    }
    let package = package_of(&mesh_of(geometry, indices), creases);
    let towards = Vec3::new(0.5, 0.4, 1.0);
    let camera = Camera::framing(Vec3::ZERO, 0.2, towards, 0.6, SIZE[0] as f32 / SIZE[1] as f32);
    let (_, lines) = draw(&gpu, &package, camera, SIZE, Mat4::IDENTITY);
    assert_eq!((lines.crossed, lines.nodes.len()), (0, 12 * (PARTS as usize + 1)));
    let chains = chains(&lines.nodes);
    assert!(chains.len() == 12 && chains.iter().all(|(_, is_closed)| !is_closed));
    // Three edges are at the corner away from the eye.
    let middle = |chain: &[usize]| lines.nodes[chain[chain.len() / 2]].weight;
    let hidden = chains.iter().filter(|(chain, _)| middle(chain) < 0.01).count();
    let shown = chains.iter().filter(|(chain, _)| middle(chain) > 0.99).count();
    assert_eq!((hidden, shown), (3, 9));
}

/// Returns density of wet and of dry lines of each pixel.
fn densities(gpu: &Gpu, frame: &Frame) -> Vec<[f32; 2]> {
    let texels: Vec<[u16; 4]> = read_texels(gpu, frame.targets().view(&painting_ribbons::INK).unwrap().texture());
    // Densities are not negative, so the bits are those of a small f32 with another bias.
    let half = |bits: u16| f32::from_bits(u32::from(bits) << 13) * 2f32.powi(112);
    texels.into_iter().map(|[wet, dry, ..]| [half(wet), half(dry)]).collect()
}

#[test]
fn strokes_are_on_the_outline_and_heavier_in_shadow() {
    let Some(gpu) = gpu("strokes_are_on_the_outline_and_heavier_in_shadow") else { return };
    let (frame, lines) = draw(&gpu, &sphere(30), camera(), SIZE, Mat4::IDENTITY);
    let center = Vec2::from(SIZE.map(|n| n as f32)) / 2.0;
    let radius = lines.nodes.iter().map(|n| Vec2::from(n.px).distance(center)).sum::<f32>() / lines.nodes.len() as f32;
    let (mut all, mut beside, mut sides) = (0.0, 0.0, [0.0; 2]);
    for (i, [wet, dry]) in densities(&gpu, &frame).into_iter().enumerate() {
        let off = Vec2::new((i as u32 % SIZE[0]) as f32 + 0.5, (i as u32 / SIZE[0]) as f32 + 0.5) - center;
        let density = wet + dry;
        assert!((0.0..4.0).contains(&density), "{density}");
        all += density;
        beside += if (off.length() - radius).abs() > 8.0 { density } else { 0.0 };
        sides[usize::from(off.dot(Vec2::new(-0.57, -0.82)) < 0.0)] += density;
    }
    assert!(all > 500.0 && beside < 0.001 * all, "{beside} of {all}");
    assert!(sides[1] > 2.0 * sides[0], "lit and shadow: {sides:?}");
}
