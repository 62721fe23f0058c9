//! Tests of shapes, transforms and materials: models built in code, compared with numbers computed by hand.
#![allow(clippy::unwrap_used, reason = "tests")]

use crate::import::support::*;
use glam::{Vec2, Vec3};
use pelage_bake::stages::import::{ImportOptions, import};
use serde_json::json;

fn square(doc: &mut Doc) -> usize {
    doc.floats(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.], "VEC3")
}

#[test]
fn glb_and_gltf_give_the_same_model_whatever_the_file_name() {
    let mut doc = Doc::new();
    let position = doc.triangle();
    doc.show(json!({"attributes": {"POSITION": position}}));
    let (a, b) = (doc.model(), import_bytes(&doc.gltf()).unwrap());
    assert_eq!(a.mesh, b.mesh);
    assert_eq!(a.mesh.triangles, [[0, 1, 2]]);
    assert_eq!(a.mesh.parts[0].source, "mesh 0 \"body\", primitive 0");
    assert!(!a.mesh.parts[0].has_uvs && a.animation.is_none() && a.warnings.is_empty());
    assert_eq!(a.inputs.len(), 1);
    assert_eq!((a.inputs[0].role.as_str(), a.inputs[0].name.as_str()), ("model", "model.glb"));
    assert_eq!(a.inputs[0].bytes, doc.glb().len() as u64);
    let with_mark = [b"\xef\xbb\xbf \n".to_vec(), doc.gltf()].concat();
    assert_eq!(import_bytes(&with_mark).unwrap().mesh, a.mesh);
}

#[test]
fn all_index_types_and_unindexed_triangles_are_read() {
    let corners = [0_u8, 1, 2, 0, 2, 3];
    for component in [U8, U16, U32] {
        let mut doc = Doc::new();
        let position = square(&mut doc);
        let bytes = match component {
            U8 => corners[..].bytes(),
            U16 => corners.map(u16::from)[..].bytes(),
            _ => corners.map(u32::from)[..].bytes(),
        };
        let indices = doc.accessor(&bytes, component, "SCALAR", 6);
        doc.show(json!({"attributes": {"POSITION": position}, "indices": indices}));
        assert_eq!(doc.model().mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    }
    let mut doc = Doc::new();
    let position = square(&mut doc);
    doc.show(json!({"attributes": {"POSITION": position}}));
    let model = doc.model();
    assert_eq!(model.mesh.triangles, [[0, 1, 2]]);
    assert_warns(&model, "4 corners, which is not a multiple of 3");
}

#[test]
fn triangles_of_strips_and_fans_have_the_same_winding() {
    let mut doc = Doc::new();
    let strip = doc.floats(&[0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.], "VEC3");
    let fan = square(&mut doc);
    doc.push(
        "meshes",
        json!({"primitives": [
            {"attributes": {"POSITION": strip}, "mode": 5},
            {"attributes": {"POSITION": fan}, "mode": 6},
        ]}),
    );
    doc.push("nodes", json!({"mesh": 0}));
    let model = doc.model();
    assert_eq!(model.mesh.triangles, [[0, 1, 2], [1, 3, 2], [5, 6, 4], [6, 7, 4]]);
    for i in 0..4 {
        assert_near(face_normal(&model, i), [0.0, 0.0, 1.0]);
    }
}

#[test]
fn points_and_lines_are_left_out_with_a_warning() {
    let mut doc = Doc::new();
    let position = doc.triangle();
    let node = doc.show(json!({"attributes": {"POSITION": position}, "mode": 0}));
    assert_eq!(node, 0);
    let (place, reason) = doc.fault();
    assert_eq!(place, "/");
    assert!(reason.contains("no triangle") && reason.contains("1 primitives contain only points"), "{reason}");
    doc.show(json!({"attributes": {"POSITION": position}}));
    doc.show(json!({"attributes": {"POSITION": position}, "mode": 3}));
    let model = doc.model();
    assert_eq!(model.mesh.parts.len(), 1);
    assert_warns(&model, "holds points");
    assert_warns(&model, "holds a line strip");
}

#[test]
fn sparse_accessors_work_with_and_without_a_base() {
    for based in [true, false] {
        let mut doc = Doc::new();
        let indices = doc.view(&[0_u8, 2]);
        let values = doc.view(&[5.0_f32, 0., 0., 0., 7., 0.][..].bytes());
        let base = doc.triangle();
        let sparse = json!({"count": 2, "indices": {"bufferView": indices, "componentType": U8},
            "values": {"bufferView": values}});
        doc.json["accessors"][base]["sparse"] = sparse;
        if !based {
            doc.json["accessors"][base].as_object_mut().unwrap().remove("bufferView");
        }
        doc.show(json!({"attributes": {"POSITION": base}}));
        let middle = if based { Vec3::X } else { Vec3::ZERO };
        assert_eq!(doc.model().mesh.positions, [Vec3::new(5., 0., 0.), middle, Vec3::new(0., 7., 0.)]);
    }
}

#[test]
fn interleaved_vertices_are_read_by_stride() {
    let mut doc = Doc::new();
    // An offset of two bytes in the view misaligns the floats; some exporters do this.
    let mut bytes = vec![0xff; 2];
    for v in [[0.0_f32, 0., 0., 0.25, 0.5], [1., 0., 0., 0.75, 0.5], [0., 1., 0., 0.25, 1.]] {
        bytes.extend(v[..].bytes());
    }
    let view = doc.view(&bytes);
    doc.json["bufferViews"][view]["byteStride"] = json!(20);
    let common = json!({"bufferView": view, "componentType": F32, "count": 3});
    let mut position = common.clone();
    (position["type"], position["byteOffset"]) = (json!("VEC3"), json!(2));
    let mut uv = common;
    (uv["type"], uv["byteOffset"]) = (json!("VEC2"), json!(14));
    let (position, uv) = (doc.push("accessors", position), doc.push("accessors", uv));
    doc.show(json!({"attributes": {"POSITION": position, "TEXCOORD_0": uv}}));
    let mesh = doc.model().mesh;
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(mesh.uvs, [Vec2::new(0.25, 0.5), Vec2::new(0.75, 0.5), Vec2::new(0.25, 1.0)]);
}

#[test]
fn quantised_attributes_are_read_with_and_without_normalisation() {
    let mut doc = Doc::new();
    doc.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    // Normalised i8 maps -128 to -1 and 127 to 1; normalised u8 maps 255 to 1. Plain i16 and u16 are unchanged.
    let mut add = |bytes: Vec<u8>, component: u32, kind: &str, normalized: bool| {
        let accessor = doc.accessor(&bytes, component, kind, 3);
        doc.json["accessors"][accessor]["normalized"] = json!(normalized);
        accessor
    };
    let i8s = add([0_i8, 0, 0, 127, 0, 0, 0, -128, 0][..].bytes(), I8, "VEC3", true);
    let i16s = add([0_i16, 0, 0, 300, 0, 0, 0, -20, 0][..].bytes(), I16, "VEC3", false);
    let u16s = add([0_u16, 0, 0, 65_535, 0, 0, 0, 0, 65_535][..].bytes(), U16, "VEC3", true);
    let uv8 = add([0_u8, 255, 51, 0, 0, 0][..].bytes(), U8, "VEC2", true);
    let uv16 = add([0_u16, 3, 1, 0, 0, 0][..].bytes(), U16, "VEC2", false);
    let normals = add([0_i8, 0, -127, 0, 0, -127, 0, 0, -127][..].bytes(), I8, "VEC3", true);
    doc.show(json!({"attributes": {"POSITION": i8s, "TEXCOORD_0": uv8, "NORMAL": normals}}));
    doc.show(json!({"attributes": {"POSITION": i16s, "TEXCOORD_0": uv16}}));
    doc.show(json!({"attributes": {"POSITION": u16s}}));
    let mesh = doc.model().mesh;
    assert_eq!(mesh.positions[..3], [Vec3::ZERO, Vec3::X, Vec3::NEG_Y]);
    assert_eq!(mesh.positions[3..6], [Vec3::ZERO, Vec3::X * 300.0, Vec3::Y * -20.0]);
    assert_eq!(mesh.positions[6..], [Vec3::ZERO, Vec3::X, Vec3::Z]);
    assert_eq!(mesh.normals[..3], [Vec3::NEG_Z; 3]);
    assert_eq!(mesh.uvs[..2], [Vec2::new(0.0, 1.0), Vec2::new(0.2, 0.0)]);
    assert_eq!(mesh.uvs[3..5], [Vec2::new(0.0, 3.0), Vec2::new(1.0, 0.0)]);
}

/// Encodes a PNG of one white texel.
fn png() -> Vec<u8> {
    let mut out = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_pixel(1, 1, image::Rgba([255; 4])).write_to(&mut out, image::ImageFormat::Png).unwrap();
    out.into_inner()
}

fn textured(doc: &mut Doc, info: serde_json::Value) -> usize {
    let view = doc.view(&png());
    let image = doc.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    let texture = doc.push("textures", json!({"source": image}));
    let mut info = info;
    info["index"] = json!(texture);
    doc.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": info}}))
}

#[test]
fn texture_transform_rotates_and_selects_its_coordinate_set() {
    // The transform is an example in the extension's specification: quarter turn, half size, shifted down. It selects
    // the lower left quarter of the image.
    let mut doc = Doc::new();
    let position = square(&mut doc);
    let zero = doc.floats(&[9.0; 8], "VEC2");
    let uv = doc.floats(&[0., 0., 1., 0., 1., 1., 0., 1.], "VEC2");
    let transform =
        json!({"offset": [0, 1], "rotation": std::f32::consts::FRAC_PI_2, "scale": [0.5, 0.5], "texCoord": 1});
    let material = textured(&mut doc, json!({"texCoord": 0, "extensions": {"KHR_texture_transform": transform}}));
    let attributes = json!({"POSITION": position, "TEXCOORD_0": zero, "TEXCOORD_1": uv});
    doc.show(json!({"attributes": attributes, "material": material, "mode": 6}));
    let model = doc.model();
    assert!(model.mesh.parts[0].has_uvs);
    for (found, expected) in model.mesh.uvs.iter().zip([[0., 1.], [0., 0.5], [0.5, 0.5], [0.5, 1.]]) {
        assert!(found.abs_diff_eq(expected.into(), 1e-6), "{found} {expected:?}");
    }
    // An embedded image is recorded without a name.
    assert_eq!((model.inputs[1].role.as_str(), model.inputs[1].name.as_str()), ("image", ""));
}

#[test]
fn second_texture_coordinate_set_is_used_with_fallback() {
    let mut doc = Doc::new();
    let position = doc.triangle();
    let (first, second) = (doc.floats(&[0.25; 6], "VEC2"), doc.floats(&[0.75; 6], "VEC2"));
    let material = textured(&mut doc, json!({"texCoord": 1}));
    let both = json!({"POSITION": position, "TEXCOORD_0": first, "TEXCOORD_1": second});
    doc.show(json!({"attributes": both, "material": material}));
    doc.show(json!({"attributes": {"POSITION": position, "TEXCOORD_0": first}, "material": material}));
    let model = doc.model();
    assert_eq!(model.mesh.uvs, [[Vec2::splat(0.75); 3], [Vec2::splat(0.25); 3]].concat());
    assert_warns(&model, "no TEXCOORD_1");
    assert_eq!((model.images.len(), model.materials.len()), (1, 1));
}

#[test]
fn material_properties_needed_by_fur_are_kept() {
    let mut doc = Doc::new();
    let position = doc.triangle();
    let texture = textured(&mut doc, json!({}));
    let mask = json!({"name": "coat", "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
        "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4]}});
    let mask = doc.push("materials", mask);
    let old = json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0.5, 0.5, 0.5, 1.0]}}});
    let old = doc.push("materials", old);
    // No part uses this material, so its broken image is not an error.
    doc.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 99}}}));
    for material in [json!(mask), json!(texture), json!(null), json!(old), json!(mask)] {
        doc.show(json!({"attributes": {"POSITION": position}, "material": material}));
    }
    let model = doc.model();
    let order: Vec<usize> = model.mesh.parts.iter().map(|p| p.material).collect();
    assert_eq!(order, [0, 1, 2, 3, 0]);
    let coat = &model.materials[0];
    assert_eq!((coat.name.as_str(), coat.base_color), ("coat", [0.1, 0.2, 0.3, 0.4]));
    assert_eq!((coat.alpha_cutoff, coat.double_sided), (Some(0.25), true));
    assert_eq!(model.materials[1].base_color_image, Some(0));
    assert_eq!((model.images[0].width, model.images[0].rgba.as_slice()), (1, &[255; 4][..]));
    assert_eq!((model.materials[2].base_color, model.materials[2].alpha_cutoff), ([1.0; 4], None));
    assert_eq!(model.materials[3].base_color, [0.5, 0.5, 0.5, 1.0]);
}

#[test]
fn roughness_and_metallic_are_known_only_without_a_texture() {
    let mut doc = Doc::new();
    let position = doc.triangle();
    for pbr in [
        json!({"roughnessFactor": 0.25, "metallicFactor": 0.5}),
        // By the specification, omitted factors are 1.
        json!({}),
        // With an image, the factors are only upper bounds. The image is not read for this.
        json!({"roughnessFactor": 0.25, "metallicRoughnessTexture": {"index": 99}}),
    ] {
        let material = doc.push("materials", json!({"pbrMetallicRoughness": pbr}));
        doc.show(json!({"attributes": {"POSITION": position}, "material": material}));
    }
    let silent = doc.push("materials", json!({"name": "silent"}));
    doc.show(json!({"attributes": {"POSITION": position}, "material": silent}));
    let found: Vec<_> = doc.model().materials.iter().map(|m| (m.roughness, m.metallic)).collect();
    assert_eq!(found, [(Some(0.25), Some(0.5)), (Some(1.0), Some(1.0)), (None, None), (None, None)]);
}

#[test]
fn parts_have_the_names_of_their_node_and_mesh() {
    let mut doc = Doc::new();
    let position = doc.triangle();
    let primitive = || json!([{"attributes": {"POSITION": position}}]);
    let named = doc.push("meshes", json!({"name": "Cone.003", "primitives": primitive()}));
    let nameless = doc.push("meshes", json!({"primitives": primitive()}));
    for node in [json!({"name": "Horn.L", "mesh": named}), json!({"mesh": named}), json!({"mesh": nameless})] {
        let node = doc.push("nodes", node);
        doc.json["scenes"] = doc.json.get("scenes").cloned().unwrap_or_else(|| json!([{"nodes": []}]));
        doc.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(node));
    }
    let names: Vec<_> = doc.model().mesh.parts.into_iter().map(|part| part.names).collect();
    assert_eq!(names, [vec!["Horn.L", "Cone.003"], vec!["Cone.003"], vec![]]);
}

/// Eight faces of the octahedron with corners at distance 1 from the centre, without an index.
const OCTAHEDRON: [[[f32; 3]; 3]; 8] = {
    let (x, y, z) = ([1., 0., 0.], [0., 1., 0.], [0., 0., 1.]);
    let (mx, my, mz) = ([-1., 0., 0.], [0., -1., 0.], [0., 0., -1.]);
    [[x, y, z], [y, mx, z], [mx, my, z], [my, x, z], [y, x, mz], [mx, y, mz], [my, mx, mz], [x, my, mz]]
};

#[test]
fn missing_normals_are_flat() {
    let mut doc = Doc::new();
    let position = doc.floats(OCTAHEDRON.as_flattened().as_flattened(), "VEC3");
    doc.show(json!({"attributes": {"POSITION": position}}));
    let model = doc.model();
    for (triangle, corners) in model.mesh.triangles.iter().zip(OCTAHEDRON) {
        // (±1, ±1, ±1) / √3.
        let face = corners.map(Vec3::from).iter().sum::<Vec3>() / 3f32.sqrt();
        for v in triangle {
            assert_near(model.mesh.normals[*v as usize], face.to_array());
        }
    }
    assert!(model.warnings.is_empty());
}

#[test]
fn missing_normals_are_smooth_where_facets_do_not_show() {
    // A bowl of one metre that is a millimetre deep, with shared vertices.
    let rim = [[1., 0., 0.], [0., 0., -1.], [-1., 0., 0.], [0., 0., 1.]];
    let positions = [&[[0., -0.001, 0.]], &rim[..]].concat();
    let mut doc = Doc::new();
    let position = doc.floats(positions.as_flattened(), "VEC3");
    let indices = doc.accessor(&[0_u8, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1], U8, "SCALAR", 12);
    doc.show(json!({"attributes": {"POSITION": position}, "indices": indices}));
    let mesh = doc.model().mesh;
    assert_eq!(mesh.positions.len(), 5, "no vertex is split");
    assert_near(mesh.normals[0], [0., 1., 0.]);
}

#[test]
fn normals_of_both_sides_of_a_sheet_do_not_cancel() {
    let mut doc = Doc::new();
    let position = doc.floats(&[0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 0., 0., 1., 0., 1., 0., 0.], "VEC3");
    doc.show(json!({"attributes": {"POSITION": position}}));
    assert_eq!(doc.model().mesh.normals, [[Vec3::Z; 3], [Vec3::NEG_Z; 3]].concat());
}

#[test]
fn bad_normals_are_normalised_or_computed() {
    let mut doc = Doc::new();
    let position = doc.triangle();
    let normal = doc.floats(&[0., 0., 2., 0., 0., 0., f32::NAN, 0., 1.], "VEC3");
    doc.show(json!({"attributes": {"POSITION": position, "NORMAL": normal}}));
    let model = doc.model();
    assert_eq!(model.mesh.normals, [Vec3::Z; 3]);
    assert_warns(&model, "1 normals do not have unit length");
    assert_warns(&model, "2 normals are missing, zero or not finite");
}

#[test]
fn triangles_that_face_against_their_normals_are_flipped() {
    let mut doc = Doc::new();
    let position = doc.triangle();
    let normal = doc.floats(&[0., 0., -1., 0., 0., -1., 0., 0., -1.], "VEC3");
    doc.show(json!({"attributes": {"POSITION": position, "NORMAL": normal}}));
    let model = doc.model();
    assert_near(face_normal(&model, 0), [0.0, 0.0, -1.0]);
    assert_warns(&model, "face against their normals");
}

#[test]
fn vertex_colours_are_read_in_every_format() {
    let mut doc = Doc::new();
    let position = doc.triangle();
    let rgb = doc.floats(&[0., 0.5, 1., 2., -1., 0.2, f32::NAN, 0., 0.], "VEC3");
    let u8s = doc.accessor(&[1_u8, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12], U8, "VEC4", 3);
    let u16s = doc.accessor(&[65_535_u16, 0, 32_768, 65_535, 0, 0, 0, 0, 0, 0, 0, 0][..].bytes(), U16, "VEC4", 3);
    doc.json["accessors"][u16s]["normalized"] = json!(true);
    for color in [rgb, u8s, u16s] {
        doc.show(json!({"attributes": {"POSITION": position, "COLOR_0": color}}));
    }
    doc.show(json!({"attributes": {"POSITION": position}}));
    let colors = doc.model().mesh.colors;
    assert_eq!(colors[..3], [[0, 128, 255, 255], [255, 0, 51, 255], [0, 0, 0, 255]]);
    assert_eq!(colors[3..6], [[1, 2, 3, 4], [5, 6, 7, 8], [9, 10, 11, 12]]);
    assert_eq!(colors[6], [255, 0, 128, 255]);
    assert_eq!(colors[9..], [[255; 4]; 3]);
}

#[test]
fn node_transforms_compose_and_mirroring_keeps_faces_outward() {
    let mut doc = Doc::new();
    let position = doc.triangle();
    let normal = doc.floats(&[0., 0., 1., 0., 0., 1., 0., 0., 1.], "VEC3");
    let child = doc.show(json!({"attributes": {"POSITION": position, "NORMAL": normal}}));
    doc.json["nodes"][child]["translation"] = json!([1, 0, 0]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    // The parent rotates by a quarter turn about z and scales by two: (1,0,0)+(1,0,0) = (2,0,0) becomes
    // (0,4,0)+(0,0,5).
    let parent =
        json!({"children": [child], "rotation": [0, 0, half, half], "scale": [2, 2, 2], "translation": [0, 0, 5]});
    doc.push("nodes", parent);
    let model = doc.model();
    for (p, q) in model.mesh.positions.iter().zip([[0., 2., 5.], [0., 4., 5.], [-2., 2., 5.]]) {
        assert_near(*p, q);
    }
    assert_near(face_normal(&model, 0), [0., 0., 4.]);
    // If only x were mirrored, the back of the triangle would face +z.
    doc.json["nodes"][1]["scale"] = json!([-2, 2, 2]);
    let model = doc.model();
    assert_near(face_normal(&model, 0), [0., 0., 4.]);
    assert_eq!(model.mesh.triangles, [[0, 2, 1]]);
    assert!(model.mesh.normals.iter().all(|n| n.abs_diff_eq(Vec3::Z, 1e-6)));
    // Mirroring z turns both the normal and the front of the triangle to -z.
    doc.json["nodes"][1]["scale"] = json!([2, 2, -2]);
    let model = doc.model();
    assert_near(face_normal(&model, 0), [0., 0., -4.]);
    assert!(model.mesh.normals.iter().all(|n| n.abs_diff_eq(Vec3::NEG_Z, 1e-6)) && model.warnings.is_empty());
}

#[test]
fn sheared_matrices_are_exact_for_static_models() {
    let mut doc = Doc::new();
    let position = doc.triangle();
    let node = doc.show(json!({"attributes": {"POSITION": position}}));
    doc.json["nodes"][node]["matrix"] = json!([1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1]);
    let model = doc.model();
    assert_near(model.mesh.positions[2], [3.5, 1.0, 0.0]);
    assert_warns(&model, "contains shear");
}

#[test]
fn default_scene_selects_the_nodes() {
    let mut doc = Doc::new();
    let position = doc.triangle();
    for _ in 0..3 {
        doc.show(json!({"attributes": {"POSITION": position}}));
    }
    for (i, x) in [10, 20, 30].into_iter().enumerate() {
        doc.json["nodes"][i]["translation"] = json!([x, 0, 0]);
    }
    let shown = |doc: &Doc| doc.model().mesh.positions.iter().step_by(3).map(|p| p.x).collect::<Vec<_>>();
    assert_eq!(shown(&doc), [10., 20., 30.], "no scene: all roots");
    doc.json["scenes"] = json!([{"nodes": [2, 1]}, {"nodes": [0]}, {}]);
    assert_eq!(shown(&doc), [30., 20.], "no default: the first");
    doc.json["scene"] = json!(1);
    assert_eq!(shown(&doc), [10.]);
    doc.json["scene"] = json!(2);
    assert!(doc.fault().1.contains("no triangle"));
    doc.json.as_object_mut().unwrap().retain(|key, _| !["nodes", "scene", "scenes"].contains(&key.as_str()));
    let model = doc.model();
    assert_eq!(model.mesh.parts.len(), 3);
    assert_warns(&model, "no nodes");
}

#[test]
fn model_unit_scales_static_models() {
    let mut doc = Doc::new();
    let position = doc.triangle();
    let node = doc.show(json!({"attributes": {"POSITION": position}}));
    doc.json["nodes"][node]["translation"] = json!([100, 0, 0]);
    let options = ImportOptions { unit_m: 0.01 };
    let model = import("m", &doc.glb(), &mut |_, _| unreachable!(), &options).unwrap();
    assert_near(model.mesh.positions[1], [1.01, 0.0, 0.0]);
    for unit_m in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-9] {
        let refused = import("m", &doc.glb(), &mut |_, _| unreachable!(), &ImportOptions { unit_m });
        assert!(refused.unwrap_err().to_string().starts_with("model.unit_m: found "));
    }
}

#[test]
fn morph_targets_rest_at_their_default_weights() {
    let mut doc = Doc::new();
    let position = doc.triangle();
    let up = doc.floats(&[0., 0., 2., 0., 0., 2., 0., 0., 2.], "VEC3");
    let right = doc.floats(&[1., 0., 0., 1., 0., 0., 1., 0., 0.], "VEC3");
    let targets = json!([{"POSITION": up}, {"POSITION": right}]);
    let node = doc.show(json!({"attributes": {"POSITION": position}, "targets": targets}));
    assert_eq!(doc.model().mesh.positions[0], Vec3::ZERO);
    doc.json["meshes"][0]["weights"] = json!([0.5, 0]);
    assert_eq!(doc.model().mesh.positions[0], Vec3::Z);
    doc.json["nodes"][node]["weights"] = json!([0, 3]);
    let model = doc.model();
    assert_eq!(model.mesh.positions[0], Vec3::X * 3.0, "the node's weights override the mesh's");
    assert_eq!(model.warnings, [""; 0]);
    let targets = &model.animation.as_ref().unwrap().morphs.targets;
    assert_eq!(targets.iter().map(|t| (t.name.as_str(), t.weight)).collect::<Vec<_>>(), [("", 0.0), ("", 3.0)]);
    let row = &model.morph_rows.0[model.mesh.morph_rows[0] as usize];
    let moved: Vec<_> = row.iter().map(|d| (d.target, d.position, d.normal)).collect();
    assert_eq!(moved, [(0, Vec3::Z * 2.0, None), (1, Vec3::X, None)]);
    assert_eq!(model.mesh.morph_rows, [1, 1, 1], "vertices that move alike share a row");
}

/// Checks that two nodes with one mesh have their own morph targets.
#[test]
fn morph_targets_have_names_and_belong_to_nodes() {
    let mut doc = Doc::new();
    let position = doc.triangle();
    let normal = doc.floats(&[0., 0., 1., 0., 0., 1., 0., 0., 1.], "VEC3");
    let up = doc.floats(&[0., 0., 2., 0., 0., 0., 0., 0., 0.], "VEC3");
    let tilt = doc.floats(&[1., 0., 0., 0., 0., 0., 0., 0., 0.], "VEC3");
    let attributes = json!({"POSITION": position, "NORMAL": normal});
    let primitive = json!({"attributes": attributes, "targets": [{"POSITION": up, "NORMAL": tilt}]});
    doc.show(primitive);
    doc.json["meshes"][0]["extras"] = json!({"targetNames": ["smile"]});
    let other = doc.push("nodes", json!({"mesh": 0, "translation": [5, 0, 0], "weights": [0.75]}));
    let input = doc.floats(&[0., 1.], "SCALAR");
    let output = doc.floats(&[0., 1.], "SCALAR");
    let sampler = json!([{"input": input, "output": output}]);
    let channel = json!([{"sampler": 0, "target": {"node": other, "path": "weights"}}]);
    doc.push("animations", json!({"name": "talk", "samplers": sampler, "channels": channel}));
    let model = doc.model();
    let animation = model.animation.as_ref().unwrap();
    let targets = &animation.morphs.targets;
    assert_eq!(
        targets.iter().map(|t| (t.name.as_str(), t.weight)).collect::<Vec<_>>(),
        [("smile", 0.0), ("smile", 0.75)]
    );
    assert_ne!(targets[0].node, targets[1].node);
    let [channel] = &animation.morphs.channels[..] else { panic!("{:?}", animation.morphs.channels) };
    assert_eq!((channel.clip, channel.target, channel.count), (0, 1, 1));
    assert_eq!((animation.clips[0].name.as_str(), animation.clips[0].duration_s), ("talk", 1.0));
    let row = |v: usize| &model.morph_rows.0[model.mesh.morph_rows[v] as usize];
    assert_eq!((row(0)[0].normal, row(0)[0].target, row(3)[0].target), (Some(Vec3::X), 0, 1));
    assert!(row(1).is_empty());
    // The rest normal is (0.75, 0, 1) normalised; the delta of a morph target is scaled by the same factor.
    let length = model.mesh.normals[3].distance(Vec3::new(0.6, 0.0, 0.8));
    assert!(length < 1e-6 && (row(3)[0].normal.unwrap().x - 0.8).abs() < 1e-6, "{:?}", row(3));

    doc.json["animations"][0]["samplers"][0]["output"] = json!(position);
    assert_warns(&doc.model(), "/animations/0/samplers/0/output: accessor 0 has elements of 3 x f32");
    let many = vec![json!({}); 5000];
    doc.json["meshes"][0]["primitives"][0]["targets"] = json!(many);
    let (place, reason) = doc.fault();
    assert_eq!(place, "/meshes/0/primitives/0/targets");
    assert!(reason.contains("holds 5000 morph targets, expected at most 4096"), "{reason}");
}
