//! Normals: bare surface is lit by those of the file, and only hair stands along joined ones. Fur on a coarse mesh is
//! as smooth as its normals.
#![allow(clippy::unwrap_used, reason = "in tests a panic is the report")]

use base64::Engine as _;
use glam::Vec3;
use pelage_bake::pipeline::{self, BakeInput};
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::groom::MapImages;
use pelage_bake::stages::import::{ImportOptions, import};
use pelage_bake::strands::PosedMesh;
use pelage_needs::data;
use pelage_runtime::formats::{ClipLayer, Limits, Package};
use pelage_runtime::{Camera, FrameParams, HairGeometry, Instance, Projection, Renderer, RendererOptions, Style};
use pelage_stage::Gpu;
use pelage_tests::gpu::gpu;
use pelage_tests::pictures::{Picture, draw};
use serde_json::{Value, json};
use std::collections::HashMap;

/// Bake settings with little fur, which takes time and does not show in bare style.
const QUICK: [&str; 5] =
    ["slice.layers=4", "slice.tile_texels=64", "fins.enabled=false", "hair.density=50", "ink.enabled=false"];

/// Returns a glTF file with one mesh, whose node turns by 90° about the y axis in a clip of 1 s if `turns`.
fn gltf(positions: &[Vec3], normals: Option<&[Vec3]>, triangles: &[[u16; 3]], turns: bool) -> String {
    let mut bytes = Vec::new();
    let (mut views, mut accessors) = (Vec::new(), Vec::<Value>::new());
    let mut push = |part: &[u8], count: usize, component: u32, kind: &str| {
        views.push(json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": part.len() }));
        accessors.push(json!({
            "bufferView": views.len() - 1, "componentType": component, "count": count, "type": kind,
            "min": [-10.0, -10.0, -10.0], "max": [10.0, 10.0, 10.0]
        }));
        bytes.extend_from_slice(part);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        accessors.len() - 1
    };
    let floats = |of: &[Vec3]| of.iter().flat_map(Vec3::to_array).flat_map(f32::to_le_bytes).collect::<Vec<u8>>();
    let mut attributes = json!({ "POSITION": push(&floats(positions), positions.len(), 5126, "VEC3") });
    if let Some(normals) = normals {
        attributes["NORMAL"] = push(&floats(normals), normals.len(), 5126, "VEC3").into();
    }
    let corners: Vec<u8> = triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
    let indices = push(&corners, 3 * triangles.len(), 5123, "SCALAR");
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let numbers = |of: &[f32]| of.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let times = push(&numbers(&[0.0, 1.0]), 2, 5126, "SCALAR");
    let turn = push(&numbers(&[0.0, 0.0, 0.0, 1.0, 0.0, half, 0.0, half]), 2, 5126, "VEC4");
    for accessor in [indices, times, turn] {
        let accessor = accessors[accessor].as_object_mut().unwrap();
        accessor.retain(|key, _| key != "min" && key != "max");
    }
    (accessors[times]["min"], accessors[times]["max"]) = (json!([0.0]), json!([1.0]));
    let mut document = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": attributes, "indices": indices }] }],
        "accessors": accessors, "bufferViews": views,
    });
    let text = base64::engine::general_purpose::STANDARD.encode(&bytes);
    let uri = format!("data:application/octet-stream;base64,{text}");
    document["buffers"] = json!([{ "byteLength": bytes.len(), "uri": uri }]);
    if turns {
        document["animations"] = json!([{
            "name": "Turn", "samplers": [{ "input": times, "output": turn }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "rotation" } }],
        }]);
    }
    document.to_string()
}

/// Returns a cube of 1 m: eight corners, and twelve triangles that share them.
fn cube() -> (Vec<Vec3>, Vec<[u16; 3]>) {
    let corner = |i: u8| [i & 1, i >> 1 & 1, i >> 2].map(|bit| f32::from(bit) - 0.5).into();
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    ((0..8).map(corner).collect(), triangles)
}

/// Returns the same surface with vertices of its own and flat normals for each triangle.
fn split(positions: &[Vec3], triangles: &[[u16; 3]]) -> (Vec<Vec3>, Vec<Vec3>, Vec<[u16; 3]>) {
    let corners: Vec<Vec3> = triangles.iter().flatten().map(|i| positions[usize::from(*i)]).collect();
    let normal = |t: &[Vec3]| (t[1] - t[0]).cross(t[2] - t[0]).normalize();
    let normals = corners.chunks_exact(3).flat_map(|t| [normal(t); 3]).collect();
    let triangles = (0..triangles.len() as u16).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    (corners, normals, triangles)
}

/// Bakes a glTF file without compressing texels.
fn bake(text: &[u8], set: &[&str]) -> Vec<u8> {
    let mut recipe = Recipe::default();
    for assignment in ["pack.shell_format=rgba8", "pack.direction_format=rg8"].iter().chain(set) {
        recipe.set(assignment).unwrap();
    }
    let mut no_files = |uri: &str, _: u64| panic!("the model names the file {uri}");
    let model = import("model.gltf", text, &mut no_files, &ImportOptions { unit_m: 1.0 }).unwrap();
    let images = MapImages::default();
    let input = BakeInput::new("model.gltf", "model", &recipe, &images);
    pipeline::bake(&input, &model, &mut |_| ()).unwrap().package
}

/// Returns packages of cubes with hard edges: with flat normals, without normals, and moved by a clip.
fn cubes() -> Vec<(&'static str, Vec<u8>)> {
    let (positions, triangles) = cube();
    let (corners, normals, apart) = split(&positions, &triangles);
    vec![
        ("flat normals", bake(gltf(&corners, Some(&normals), &apart, false).as_bytes(), &QUICK)),
        ("no normals", bake(gltf(&positions, None, &triangles, false).as_bytes(), &QUICK)),
        ("no normals, moved", bake(gltf(&positions, None, &triangles, true).as_bytes(), &QUICK)),
    ]
}

/// Asserts that bare surface has the normals of its triangles, and that hair at one position has one normal.
#[track_caller]
fn assert_flat_under_joined_hair(name: &str, mesh: &PosedMesh) {
    let mut joined = HashMap::new();
    for t in 0..mesh.triangles.len() {
        let corners = mesh.corners(t);
        let [a, b, c] = corners.map(|corner| corner.position_ws);
        let face = (b - a).cross(c - a).normalize();
        for corner in corners {
            let off = corner.bare_normal_ws().angle_between(face).to_degrees();
            assert!(off < 0.1, "{name}: the normal of triangle {t} is {off}° off");
            let place = corner.position_ws.to_array().map(|x| (1e4 * x).round() as i64);
            let hair = *joined.entry(place).or_insert(corner.normal_ws);
            assert!(hair.distance(corner.normal_ws) < 1e-4, "{name}: hair parts at {place:?}");
            assert!(hair.angle_between(face).to_degrees() > 30.0, "{name}: hair stands along one face");
        }
    }
}

#[test]
fn bare_surface_keeps_hard_edges_in_every_pose() {
    for (name, package) in cubes() {
        let opened = Package::open(&package, &Limits::default()).unwrap();
        assert_eq!(Package::validate(&package, &Limits::default()), [], "{name}");
        assert_flat_under_joined_hair(name, &PosedMesh::posed(name, &opened, &[]).unwrap());
        if name.contains("moved") {
            let layers = [ClipLayer { clip: Some(0), time_s: 0.4, share: 1.0 }];
            assert_flat_under_joined_hair(name, &PosedMesh::posed(name, &opened, &layers).unwrap());
        }
    }
}

/// Draws a package in bare style from the front, above and the right.
fn bare_picture(gpu: &Gpu, package: &[u8]) -> Picture {
    let projection = Projection::Orthographic { height_m: 2.4, aspect: 1.0, near_m: 0.0, far_m: 10.0 };
    let camera = Camera::look_at(Vec3::new(1.4, 1.6, 2.6), Vec3::ZERO, projection);
    let params = FrameParams::new(camera, [128, 128]).with(|p| p.style = Style::Bare);
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let instance = Instance::new(0, &renderer.load_bytes(package).unwrap());
    draw(gpu, &mut renderer, &params, &[&instance])
}

/// Asserts that three colours cover a picture, except for mixtures at edges.
#[track_caller]
fn assert_three_tones(name: &str, picture: &Picture) {
    let mut counts: HashMap<[u8; 4], usize> = HashMap::new();
    picture.rgba.iter().filter(|texel| texel[3] > 0).for_each(|texel| *counts.entry(*texel).or_default() += 1);
    let mut tones: Vec<_> = counts.into_iter().map(|(tone, count)| (count, tone)).collect();
    tones.sort_unstable_by(|a, b| b.cmp(a));
    let share = tones.iter().take(3).map(|(count, _)| count).sum::<usize>() as f64 / picture.covered() as f64;
    assert!(share > 0.9, "{name}: three tones cover {share:.2} of the cube: {:?}", &tones[..5.min(tones.len())]);
    let [a, b, c] = [0, 1, 2].map(|i| tones[i].1[0]);
    assert!(a.abs_diff(b) > 5 && b.abs_diff(c) > 5 && a.abs_diff(c) > 5, "{name}: tones {a}, {b}, {c}");
}

#[test]
fn each_face_of_a_cube_has_one_tone() {
    let Some(gpu) = gpu("each_face_of_a_cube_has_one_tone") else { return };
    for (name, package) in cubes() {
        assert_three_tones(name, &bare_picture(gpu, &package));
    }
}

#[test]
fn the_cube_of_the_cases_has_hard_edges() {
    let Some(data) = data("the_cube_of_the_cases_has_hard_edges") else { return };
    let package = bake(&std::fs::read(data.join("cases/cube_hard_edges.gltf")).unwrap(), &QUICK);
    let opened = Package::open(&package, &Limits::default()).unwrap();
    assert_flat_under_joined_hair("the case", &PosedMesh::posed("the case", &opened, &[]).unwrap());
}

/// Returns an icosahedron subdivided `times` times, on the unit sphere.
fn ball(times: u32) -> (Vec<Vec3>, Vec<[u16; 3]>) {
    let golden = 0.5 + 1.25f32.sqrt();
    let axes = [[0.0, 1.0, golden], [1.0, golden, 0.0], [golden, 0.0, 1.0]];
    let signs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let corner = |[x, y, z]: [f32; 3], (s, t): (f32, f32)| {
        // The signs belong to the two components that are not 0.
        if x == 0.0 {
            Vec3::new(x, s * y, t * z)
        } else if y == 0.0 {
            Vec3::new(s * x, y, t * z)
        } else {
            Vec3::new(s * x, t * y, z)
        }
    };
    let mut positions: Vec<Vec3> =
        axes.iter().flat_map(|axis| signs.map(|sign| corner(*axis, sign).normalize())).collect();
    let near = |a: usize, b: usize| a != b && positions[a].dot(positions[b]) > 0.4;
    let mut triangles = Vec::new();
    for (a, b, c) in (0..12).flat_map(|a| (a..12).flat_map(move |b| (b..12).map(move |c| (a, b, c)))) {
        if near(a, b) && near(b, c) && near(a, c) {
            let outward = (positions[b] - positions[a]).cross(positions[c] - positions[a]).dot(positions[a]) > 0.0;
            triangles.push(if outward { [a, b, c] } else { [a, c, b] }.map(|i| i as u16));
        }
    }
    for _ in 0..times {
        let mut middles = HashMap::new();
        let mut middle = |a: u16, b: u16| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[usize::from(a)] + positions[usize::from(b)]).normalize());
                positions.len() as u16 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let [d, e, f] = [middle(a, b), middle(b, c), middle(c, a)];
                [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
            })
            .collect();
    }
    (positions, triangles)
}

#[test]
fn smooth_models_store_no_bare_normals() {
    let (positions, triangles) = ball(4);
    for normals in [Some(&positions[..]), None] {
        let package = bake(gltf(&positions, normals, &triangles, false).as_bytes(), &QUICK);
        let opened = Package::open(&package, &Limits::default()).unwrap();
        assert_eq!(opened.bare_normals().unwrap(), None);
    }
}

/// Bake settings with enough fur to measure its brightness, and none of the parts that take long.
const FURRY: [&str; 7] = [
    // Brightness then follows the surface closely; scattered light hides facets of layers.
    "shading.model=kajiya-kay",
    "slice.layers=8",
    "slice.tile_texels=64",
    "fins.enabled=false",
    "hair.density=600",
    "ink.enabled=false",
    "detail.enabled=false",
];

/// Returns the mean brightness of a picture of the unit sphere from above, within 0.07 m of a point of the sphere.
fn brightness(picture: &Picture, at: Vec3) -> f64 {
    let size = picture.size.0 as f32;
    let place = |x: f32| (0.5 + x / HEIGHT_M) * size;
    let (x, y, reach) = (place(at.x), place(at.z), 0.07 / HEIGHT_M * size);
    let span = |c: f32| (c - reach).round() as u32..=(c + reach).round() as u32;
    let texels = span(y).flat_map(|row| span(x).map(move |column| (row * picture.size.0 + column) as usize));
    let lights: Vec<f64> = texels.map(|i| picture.rgba[i][..3].iter().map(|c| f64::from(*c)).sum::<f64>()).collect();
    lights.iter().sum::<f64>() / lights.len() as f64
}

/// Height of the picture of [`brightness`], metres.
const HEIGHT_M: f32 = 2.6;

/// Draws a package of a unit sphere from above, with -z up.
fn from_above(gpu: &Gpu, package: &[u8], change: impl FnOnce(&mut FrameParams)) -> Picture {
    let projection = Projection::Orthographic { height_m: HEIGHT_M, aspect: 1.0, near_m: 0.0, far_m: 10.0 };
    let camera = Camera::look_at(Vec3::new(0.0, 5.0, 0.001), Vec3::ZERO, projection);
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let instance = Instance::new(0, &renderer.load_bytes(package).unwrap());
    let params = FrameParams::new(camera, [256, 256]).with(change);
    draw(gpu, &mut renderer, &params, &[&instance])
}

/// Returns the greatest step of brightness across the edges of a coarse sphere that face up, relative to the mean of
/// both sides.
fn greatest_step(picture: &Picture, positions: &[Vec3], triangles: &[[u16; 3]]) -> f64 {
    let mut greatest: f64 = 0.0;
    for [a, b] in triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]).filter(|[a, b]| a < b) {
        let [p, q] = [a, b].map(|i| positions[usize::from(i)]);
        if (p + q).normalize().y < 0.6 {
            continue;
        }
        let across = (q - p).cross(p + q).normalize() * 0.12;
        // Several places along the edge, because single hairs differ.
        let sides = [1.0, -1.0].map(|side| {
            let places = [0.2, 0.35, 0.5, 0.65, 0.8].map(|at| (p.lerp(q, at).normalize() + side * across).normalize());
            places.iter().map(|place| brightness(picture, *place)).sum::<f64>()
        });
        greatest = greatest.max((sides[0] - sides[1]).abs() / (0.5 * (sides[0] + sides[1])));
    }
    greatest
}

#[test]
fn fur_on_a_coarse_sphere_is_as_smooth_as_its_skin() {
    let Some(gpu) = gpu("fur_on_a_coarse_sphere_is_as_smooth_as_its_skin") else { return };
    let (positions, triangles) = ball(0);
    let text = gltf(&positions, Some(&positions), &triangles, false);
    // Steps in bare style, and of layers and single strands. A device that cannot hold the strands draws layers.
    let steps = |set: &str| {
        let package = bake(text.as_bytes(), &[&FURRY[..], &[set]].concat());
        [None, Some(HairGeometry::Shells), Some(HairGeometry::Strands)].map(|hair| {
            let picture = from_above(gpu, &package, |params| match (hair, params.fur_mut()) {
                (Some(hair), Some(fur)) => fur.hair = hair,
                _ => params.style = Style::Bare,
            });
            greatest_step(&picture, &positions, &triangles)
        })
    };
    let [bare, layers, strands] = steps("surface.rounded=true");
    println!("bare {bare:.3}, layers {layers:.3}, strands {strands:.3}");
    let allowed = bare + 0.12;
    assert!(layers < allowed && strands < allowed, "layers {layers:.3}, strands {strands:.3}, allowed {allowed:.3}");
    // The measure sees the facets that rounding avoids.
    let [bare, layers, strands] = steps("surface.rounded=false");
    println!("not rounded: bare {bare:.3}, layers {layers:.3}, strands {strands:.3}");
    assert!(layers.max(strands) > bare + 0.12, "bare {bare:.3}, layers {layers:.3}, strands {strands:.3}");
}

#[test]
fn only_coarse_smooth_surface_is_rounded() {
    let triangles_of = |text: &str, set: &str| {
        let package = bake(text.as_bytes(), &[&QUICK[..], &[set]].concat());
        let opened = Package::open(&package, &Limits::default()).unwrap();
        PosedMesh::posed("model", &opened, &[]).unwrap()
    };
    let (positions, triangles) = ball(0);
    let coarse = gltf(&positions, Some(&positions), &triangles, true);
    let rounded = triangles_of(&coarse, "surface.rounded=true");
    // Edges of 63° are halved three times.
    assert_eq!(rounded.triangles.len(), 20 * 64);
    for vertex in &rounded.vertices {
        let radius = vertex.position_ws.length();
        assert!((radius - 1.0).abs() < 0.04, "a vertex is {radius} m from the middle");
        assert!(vertex.normal_ws.dot(vertex.position_ws / radius) > 0.99);
    }
    assert_eq!(triangles_of(&coarse, "surface.rounded=false").triangles.len(), 20);
    // Hard edges stay.
    let (positions, triangles) = cube();
    assert_eq!(triangles_of(&gltf(&positions, None, &triangles, false), "surface.rounded=true").triangles.len(), 12);
    // So does a box whose corners have one normal each.
    let normals: Vec<Vec3> = positions.iter().map(|p| p.normalize()).collect();
    let box_like = gltf(&positions, Some(&normals), &triangles, false);
    assert_eq!(triangles_of(&box_like, "surface.rounded=true").triangles.len(), 12);
}
