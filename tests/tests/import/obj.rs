//! Tests of the importer for Wavefront OBJ: its results and errors.
#![allow(clippy::unwrap_used, reason = "tests")]

use crate::import::support::*;
use glam::{Vec2, Vec3};
use pelage_bake::io::{Reach, read_model};
use pelage_bake::stages::import::{ImportOptions, import};
use pelage_import::BakeError;
use pelage_import::mesh::Model;
use std::collections::BTreeMap;
use std::path::Path;

/// Imports a text with other files. The text is named `folder/model`, without an extension.
fn with_files(text: &str, files: &[(&str, &[u8])], options: &ImportOptions) -> Result<Model, BakeError> {
    let files: BTreeMap<_, _> = files.iter().copied().collect();
    let mut resolve = |uri: &str, _: u64| {
        let source = std::io::ErrorKind::NotFound.into();
        files.get(uri).map(|b| b.to_vec()).ok_or(BakeError::Io { path: uri.into(), action: "read", source })
    };
    import("folder/model", text.as_bytes(), &mut resolve, options)
}

fn model(text: &str) -> Model {
    let model = with_files(text, &[], &ImportOptions::default()).unwrap();
    assert_sound(&model);
    model
}

fn refused(text: &str) -> (String, String) {
    fault(with_files(text, &[], &ImportOptions::default()))
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn obj_square_with_all_attributes_is_read() {
    let m = model(&format!(
        "{SQUARE}vt 0 0\nvt 1 0\nvt 1 0.75\nvt 0 1\nvn 0 0 1\no box\ng side\nusemtl skin\nf 1/1/1 2/2/1 3/3/1 4/4/1\n"
    ));
    assert_eq!(m.mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(m.mesh.positions[2], Vec3::new(1.0, 1.0, 0.0));
    // After the import, texture coordinates begin at the top row of the image.
    assert_eq!(m.mesh.uvs[2], Vec2::new(1.0, 0.25));
    assert!(m.mesh.parts[0].has_uvs && m.animation.is_none());
    assert_eq!(m.mesh.parts[0].source, r#"object "box", group "side", material "skin""#);
    assert_eq!(m.mesh.parts[0].names, ["box", "side"]);
    assert_eq!((m.materials[0].name.as_str(), m.materials[0].base_color), ("skin", [1.0; 4]));
    assert_eq!((m.inputs[0].role.as_str(), m.inputs[0].name.as_str()), ("model", "model"));
    assert!(m.warnings.is_empty(), "{:?}", m.warnings);
}

#[test]
fn positive_and_negative_obj_indices_are_read() {
    let forward = model(&format!("{SQUARE}f 1 2 3\nv 5 5 5\nf 1 3 4\n"));
    let backward = model(&format!("{SQUARE}f -4 -3 -2\nv 5 5 5\nf -5 -3 -2\n"));
    assert_eq!(forward.mesh, backward.mesh);
    // Checks that a face may precede its vertices.
    assert_eq!(model(&format!("f 1 2 3\n{SQUARE}")).mesh.triangles, [[0, 1, 2]]);
}

#[test]
fn faces_are_grouped_by_object_group_and_material() {
    let m = model(&format!(
        "{SQUARE}usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\nusemtl a\nf 1 2 4\ng tail\nf 2 3 4\no other\ng tail\nf 1 2 3\n"
    ));
    let found: Vec<_> = m.mesh.parts.iter().map(|p| (p.source.as_str(), p.triangle_count, p.material)).collect();
    let expected = [
        (r#"material "a""#, 2, 0),
        (r#"material "b""#, 1, 1),
        (r#"group "tail", material "a""#, 1, 0),
        (r#"object "other", group "tail", material "a""#, 1, 0),
    ];
    assert_eq!(found, expected);
    assert_eq!(m.materials.len(), 2);
}

#[test]
fn computed_normals_do_not_depend_on_the_triangulation() {
    // The model is a cube of quads. At each corner three faces meet, with four, five or six triangles in total.
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
        f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n";
    let m = model(cube);
    assert_eq!((m.mesh.positions.len(), m.mesh.triangles.len()), (8, 12));
    for (position, normal) in m.mesh.positions.iter().zip(&m.mesh.normals) {
        let outward = (*position - Vec3::splat(0.5)).normalize();
        assert!(normal.abs_diff_eq(outward, 1e-6), "{position}: {normal}");
    }
    // Vertices with equal positions are joined, also across parts.
    let split = cube.replace("f 5 6 7 8", "v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nusemtl lid\nf -4 -3 -2 -1");
    let n = model(&split);
    assert_eq!(n.mesh.parts.len(), 2);
    for (position, normal) in n.mesh.positions.iter().zip(&n.mesh.normals) {
        assert!(normal.abs_diff_eq((*position - Vec3::splat(0.5)).normalize(), 1e-6), "{position}: {normal}");
    }
    // Checks that existing normals are kept, and missing ones are computed.
    let m = model(&format!("{SQUARE}vn 0 0.6 0.8\nf 1//1 2//1 3//1\nf 1 3 4\n"));
    assert_near(m.mesh.normals[0], [0.0, 0.6, 0.8]);
    assert_near(m.mesh.normals[5], [0.0, 0.0, 1.0]);
    assert_warns(&m, "3 normals are missing");
    // Checks that triangles are flipped, and normals kept, if their directions disagree.
    let m = model(&format!("{SQUARE}vn 0 0 -1\nf 1//1 2//1 3//1\n"));
    assert!(face_normal(&m, 0).z < 0.0);
    assert_warns(&m, "face against their normals");
}

#[test]
fn concave_polygons_keep_their_shape() {
    // The quad is an arrow head whose second corner is the notch.
    let m = model("v 2 2 0\nv 0 1 0\nv -2 2 0\nv 0 0 0\nf 1 2 3 4\n");
    let areas: Vec<f32> = (0..2).map(|i| face_normal(&m, i).z).collect();
    assert!(areas.iter().all(|z| *z > 0.0) && (areas.iter().sum::<f32>() - 4.0).abs() < 1e-6, "{areas:?}");
    let m = model("v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n");
    assert_warns(&m, "line 5: the polygon of 4 corners crosses itself");
}

#[test]
fn vertex_colours_are_srgb_and_default_to_white() {
    let m = model("v 0 0 0\nv 1 0 0 1 0.5 0\nv 1 1 0 1 1 0.5 0\nf 1 2 3\n");
    // By IEC 61966-2-1, sRGB 0.5 is 0.214 in linear light, which is 55 of 255.
    assert_eq!(m.mesh.colors, [[255; 4], [255, 55, 0, 255], [255, 55, 0, 255]]);
}

#[test]
fn texture_coordinates_need_all_corners_of_a_part() {
    let m = model(&format!("{SQUARE}vt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\nf 1 3 4\n"));
    assert!(!m.mesh.parts[0].has_uvs);
    assert_warns(&m, "3 of 6 corners have no texture coordinates");
    assert!(!model(&format!("{SQUARE}f 1 2 3\n")).mesh.parts[0].has_uvs);
    let m = model(&format!("{SQUARE}f 1/1/1 2/2/2 3/3/3\n"));
    assert!(!m.mesh.parts[0].has_uvs);
    assert_warns(&m, "3 corners refer to a texture coordinate, but the file has none");
    assert_warns(&m, "3 corners refer to a normal, but the file has none");
    let m = model(&format!("{SQUARE}vt nan 0\nf 1/1 2/1 3/1\n"));
    assert_warns(&m, "1 texture coordinates are not finite");
}

#[test]
fn model_unit_scales_obj_models() {
    let m = with_files(&format!("{SQUARE}f 1 2 3\n"), &[], &ImportOptions { unit_m: 0.01 }).unwrap();
    assert_eq!(m.mesh.positions[2], Vec3::new(0.01, 0.01, 0.0));
    let far = with_files("v 0 0 0\nv 1e38 0 0\nv 0 1 0\nf 1 2 3\n", &[], &ImportOptions { unit_m: 1e6 });
    let (place, reason) = fault(far);
    assert!(place == "line 2" && reason.contains("units of 1000000 m"), "{place}: {reason}");
}

#[test]
fn statements_other_than_surfaces_are_counted() {
    let m = model(&format!("{SQUARE}p 1 2\nl 1 2\nl 2 3\nf 1 2\nf 1\nf 1 2 3\ncurv 0 1 1 2\nzz\nzz\ns off\nlod 3\n"));
    for text in [
        "1 `p` statements",
        "2 `l` statements",
        "2 faces of fewer than 3 corners left out, the first in line 8",
        "1 free-form",
        "line 12: `zz` is not an OBJ statement; 2 lines",
    ] {
        assert_warns(&m, text);
    }
    assert_eq!(m.warnings.len(), 5, "{:?}", m.warnings);
}

#[test]
fn obj_errors_name_the_line() {
    for (text, line, words) in [
        ("v 0 0\nf 1 1 1", 1, "`v` has 2 numbers, expected 3 to 7"),
        ("v 0 0 0 0 0\nf 1 1 1", 1, "`v` has 5 numbers, expected 3"),
        ("v 0 0 0 1 1 1 1 1\nf 1 1 1", 1, "8 numbers, expected 3 to 7"),
        ("v 0 0 0,5\nf 1 1 1", 1, "`v` has `0,5`, expected a number"),
        ("\n\nv 0 \\\n0 inf\nf 1 1 1", 3, "has `inf`, expected a finite 32-bit number"),
        ("v 0 0 1e39\nf 1 1 1", 1, "has `1e39`, expected a finite 32-bit number"),
        ("v 0 NaN 0\nf 1 1 1", 1, "has `NaN`, expected a finite 32-bit number"),
        ("v 0 0 0\nvn 0 0\nf 1 1 1", 2, "`vn` has 2 numbers, expected 3"),
        ("v 0 0 0\nvt\nf 1 1 1", 2, "`vt` has 0 numbers, expected 1 to 3"),
        ("v 0 0 0\nf 1 1 2", 2, "corner 3 has vertex 2, expected 1..=1"),
        ("v 0 0 0\nf 1 1 0", 2, "`f` has `0`, expected a vertex index from 1"),
        ("v 0 0 0\nf 1 1 -2", 2, "`f` has `-2`, expected a vertex index from 1, or from -1 to -1"),
        ("v 0 0 0\nf 1 1 99999999999", 2, "corner 3 has vertex 4294967296, expected 1..=1"),
        ("v 0 0 0\nf 1 1 999999999999999999999", 2, "expected whole numbers"),
        ("v 0 0 0\nf 1 1 1.5", 2, "`1.5`, expected whole numbers"),
        ("v 0 0 0\nvt 0\nf 1/1 1/2 1/1", 3, "corner 2 has texture coordinate 2, expected 1..=1"),
        ("v 0 0 0\nvn 0 0 1\nf 1//1 1//1 1//-2", 3, "a normal index from 1"),
        ("v 0 0 0\nf /1 /1 /1", 2, "expected a corner such as"),
        ("v 0 0 0\nvt 0\nvn 0 0 1\nf 1/1/1/1 1 1", 4, "`1/1/1/1`, expected a corner such as"),
    ] {
        let (place, reason) = refused(text);
        assert_eq!(place, format!("line {line}"), "{text:?}: {reason}");
        assert!(reason.contains(words), "{text:?}: {reason}");
    }
    let (place, reason) = refused("v 0 0 0\nvn 0 0 1\np 1\n");
    assert!(place == "whole file" && reason.contains("no face") && reason.contains("1 vertices"), "{place}: {reason}");
}

#[test]
fn extension_decides_only_for_ambiguous_contents() {
    let named = |name: &str, bytes: &[u8]| {
        let mut none = |uri: &str, _: u64| -> Result<Vec<u8>, BakeError> { panic!("unexpected request for {uri}") };
        import(name, bytes, &mut none, &ImportOptions::default())
    };
    let text = format!("# made by hand\n\n{SQUARE}f 1 2 3\n");
    for name in ["a.obj", "a.glb", "a.gltf", "a.txt", "a"] {
        assert_sound(&named(name, text.as_bytes()).unwrap());
    }
    let mut doc = Doc::new();
    let position = doc.triangle();
    doc.show(serde_json::json!({"attributes": {"POSITION": position}}));
    for bytes in [doc.glb(), doc.gltf()] {
        assert_sound(&named("a.obj", &bytes).unwrap());
    }
    // The first line is not an OBJ statement, so only the file extension shows that the file is an OBJ file.
    assert_eq!(fault(named("a.OBJ", b"vv 1 2 3\nv 0 0 0\nf 1 1 5")).0, "line 3");
    assert!(fault(named("a.txt", b"vv 1 2 3\nv 0 0 0\nf 1 1 5")).1.contains("neither GLB nor JSON nor OBJ"));
    assert!(fault(named("a.obj", b"ply\nformat ascii 1.0\n")).1.contains("a PLY file"));
    assert!(fault(named("a.obj", b"")).1.contains("empty"));
}

#[test]
fn utf_16_text_is_read() {
    let text = format!("{SQUARE}usemtl Fell\u{e4}\nf 1 2 3\n");
    let plain = model(&text);
    for encode in [u16::to_be_bytes as fn(u16) -> [u8; 2], u16::to_le_bytes] {
        let bytes: Vec<u8> = "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(encode).collect();
        assert_eq!(import_bytes(&bytes).unwrap().mesh, plain.mesh);
        let (place, reason) = fault(import_bytes(&bytes[..bytes.len() - 1]));
        assert!(place == format!("byte {}", bytes.len() - 2) && reason.contains("cut off"), "{place}: {reason}");
    }
    assert_eq!(plain.materials[0].name, "Fell\u{e4}");
}

fn png() -> Vec<u8> {
    let mut out = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(4, 2).write_to(&mut out, image::ImageFormat::Png).unwrap();
    out.into_inner()
}

#[test]
fn material_colours_and_images_are_read() {
    let text = format!("mtllib my skins/a.mtl\n{SQUARE}usemtl coat\nf 1 2 3\nusemtl grey\nf 1 3 4\n");
    let mtl = b"newmtl coat\nKd 0.5 0.25 0\nmap_Kd -s 1 1 1 maps\\coat 1.png\n\
                newmtl grey\nKd 0.5\nnewmtl unused\nmap_Kd no.png\n";
    let png = png();
    let files = [("my%20skins/a.mtl", &mtl[..]), ("my%20skins/maps/coat%201.png", &png)];
    let m = with_files(&text, &files, &ImportOptions::default()).unwrap();
    assert_sound(&m);
    assert_eq!(m.materials[0].base_color, [0.5, 0.25, 0.0, 1.0]);
    assert_eq!(m.materials[0].base_color_image, Some(0));
    assert_eq!((m.images[0].width, m.images[0].height), (4, 2));
    assert_eq!((m.materials[1].base_color, m.materials[1].base_color_image), ([0.5, 0.5, 0.5, 1.0], None));
    let records: Vec<_> = m.inputs.iter().map(|i| (i.role.as_str(), i.name.as_str(), i.bytes)).collect();
    let expected = [
        ("model", "model", text.len() as u64),
        ("material", "a.mtl", mtl.len() as u64),
        ("image", "coat 1.png", png.len() as u64),
    ];
    assert_eq!(records, expected);
    assert!(m.inputs.iter().all(|i| i.sha256 != [0; 32]));
    assert!(m.warnings.is_empty(), "{:?}", m.warnings);
}

#[test]
fn material_errors_are_only_warnings() {
    let use_it = format!("{SQUARE}usemtl a\nf 1 2 3\n");
    let read = |library: &str, files: &[(&str, &[u8])]| {
        let m = with_files(&format!("mtllib {library}\n{use_it}"), files, &ImportOptions::default()).unwrap();
        assert_sound(&m);
        m
    };
    let missing = read("b.mtl", &[]);
    assert_warns(&missing, "line 1 names the material file \"b.mtl\": it does not exist");
    assert_eq!(missing.materials[0].base_color, [1.0; 4]);
    assert_warns(&read("C:\\skins\\b.mtl", &[]), "absolute path");
    assert_warns(&read("/etc/b.mtl", &[]), "absolute path");
    assert_eq!(
        read("b.mtl c.mtl", &[("b.mtl", b""), ("c.mtl", b"newmtl a\nKd 0 0 1")]).materials[0].base_color[0],
        0.0
    );
    for (mtl, words) in [
        (&b"newmtl b"[..], "material \"a\" is not in any material file"),
        (b"newmtl a\nKd red", "b.mtl: line 2: `Kd` has `red`, expected a number"),
        (b"newmtl a\nKd spectral a.rfl", "b.mtl: line 2: `Kd` is `spectral`"),
        (b"newmtl a\nnewmtl a", "defined twice"),
        (b"newmtl a\nmap_Kd", "b.mtl: line 2: `map_Kd` names no file"),
        (b"newmtl a\nmap_Kd no.png", "b.mtl: line 2 names the image file \"no.png\": it does not exist"),
        (b"newmtl a\nmap_Kd b.mtl", "b.mtl: line 2 names the image file \"b.mtl\": it is 21 bytes"),
        (b"newmtl a\nKd 0 0 0\nmap_Kd c.png", "black Kd"),
        (b"\xff\xfen", "cut off"),
    ] {
        assert_warns(&read("b.mtl", &[("b.mtl", mtl), ("c.png", &png())]), words);
    }
}

/// Readable files of the test data: number of triangles after triangulation (from the data's README), parts and
/// materials.
const READABLE: &[(&str, usize, usize, usize)] = &[
    ("static/armadillo.obj", 29_170, 1, 1),
    ("static/bunny.obj", 6598, 1, 1),
    ("static/cat-low-resolution.obj", 15_894, 1, 1),
    ("static/cube_no_bottom.obj", 40, 1, 1),
    ("static/fish_control_mesh.obj", 220, 1, 1),
    ("static/goathead.obj", 5522, 1, 1),
    ("static/human_neutral.obj", 20_908, 2, 2),
    ("static/penguin.obj", 6720, 1, 1),
    ("static/plane_holes.obj", 16_747, 1, 1),
    ("static/spot.obj", 5856, 1, 1),
    ("static/spot_control_mesh.obj", 372, 1, 1),
    ("static/stanford-bunny-full.obj", 69_451, 1, 1),
    ("static/torus.obj", 4608, 1, 1),
    ("hard-obj/assimp_WusonOBJ.obj", 3732, 1, 1),
    ("hard-obj/assimp_box_UTF16BE.obj", 12, 1, 1),
    ("hard-obj/assimp_box_without_lineending.obj", 12, 1, 1),
    ("hard-obj/assimp_cube_with_vertexcolors.obj", 12, 1, 1),
    ("hard-obj/assimp_empty_mat.obj", 256, 1, 1),
    // The file has four named materials. Its four groups of teeth and its eye share two of them, but are separate
    // parts.
    ("hard-obj/assimp_spider.obj", 1368, 19, 9),
    ("hard-obj/assimp_testmixed.obj", 12, 1, 1),
    ("hard-obj/draco_cube_quads.obj", 12, 1, 1),
    ("hard-obj/draco_deg_faces.obj", 4, 1, 1),
    ("hard-obj/draco_empty_name.obj", 1, 1, 1),
    ("hard-obj/draco_mat_test.obj", 1300, 7, 7),
    ("hard-obj/draco_multiple_isolated_triangles.obj", 5, 1, 1),
    ("hard-obj/draco_sphere.obj", 224, 1, 1),
    ("hard-obj/draco_test_nm.obj", 170, 1, 1),
    // The faces name normals that do not exist.
    ("hard-obj/draco_test_wrong_attribute_mapping.obj", 1, 1, 1),
    ("hard-obj/trimesh_capsule/capsule.obj", 10_200, 1, 1),
    ("hard-obj/trimesh_face_in_group_name_mid_file.obj", 2, 2, 1),
    // The file has fourteen groups, and faces before the first group.
    ("hard-obj/trimesh_groups.obj", 2308, 15, 1),
    ("hard-obj/trimesh_jacked.obj", 12, 1, 1),
    ("hard-obj/trimesh_joined_tetrahedra.obj", 8, 2, 1),
    ("hard-obj/trimesh_negative_indices.obj", 12, 1, 1),
    ("hard-obj/trimesh_not_convex.obj", 96, 1, 1),
    // The file has two faces, and one has only two corners.
    ("hard-obj/trimesh_notenoughindices.obj", 1, 1, 1),
    ("hard-obj/trimesh_polygonfaces.obj", 3, 1, 1),
    ("hard-obj/trimesh_quadknot.obj", 2880, 1, 1),
    ("hard-obj/trimesh_target.obj", 3318, 1, 1),
];

/// Rejected files: path, location of the error, and part of its reason.
const REFUSED: &[(&str, &str, &str)] = &[
    // The rejected index is zero; two of the faces before it are also out of range.
    ("hard-obj/assimp_malformed.obj", "line 28", "`0`, expected a vertex index from 1"),
    // `3.1+e2` is not a valid number.
    ("hard-obj/assimp_number_formats.obj", "line 11", "`3.1+e2`, expected a number"),
    ("hard-obj/assimp_point_cloud.obj", "whole file", "no faces, expected at least one; it has 3 vertices"),
    ("hard-obj/draco_inf_nan.obj", "line 1", "`inf`, expected a finite 32-bit number"),
    ("hard-obj/draco_test_lines.obj", "whole file", "242 lines"),
    ("hard-obj/trimesh_empty.obj", "whole file", "no face"),
    ("hard-obj/trimesh_obj_wireframe.obj", "whole file", "12 lines"),
];

#[test]
fn every_obj_of_the_test_data_is_read_as_expected() {
    let Some(data) = data("every_obj_of_the_test_data_is_read_as_expected") else { return };
    let read = |name: &str| read_model(&data.join("meshes").join(name), &ImportOptions::default(), Reach::OwnFolder);
    let mut seen = 0;
    for (name, triangles, parts, materials) in READABLE {
        let model = read(name).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_sound(&model);
        let found = (model.mesh.triangles.len(), model.mesh.parts.len(), model.materials.len());
        assert_eq!(found, (*triangles, *parts, *materials), "{name}");
        seen += 1;
    }
    for (name, place, reason) in REFUSED {
        let found = fault(read(name));
        assert_eq!(&found.0, place, "{name}: {}", found.1);
        assert!(found.1.contains(reason), "{name}: {}", found.1);
        seen += 1;
    }
    let mut all = 0;
    for folder in ["static", "hard-obj", "hard-obj/trimesh_capsule"] {
        let entries = std::fs::read_dir(data.join("meshes").join(folder)).unwrap();
        all += entries.filter(|e| e.as_ref().unwrap().path().extension().is_some_and(|e| e == "obj")).count();
    }
    assert_eq!(seen, all, "files without an expectation");
}

/// Compares valid files with the result of `tobj`: positions, texture coordinates and triangles.
#[test]
fn importer_and_tobj_agree_on_valid_files() {
    let Some(data) = data("importer_and_tobj_agree_on_valid_files") else { return };
    for name in [
        "static/bunny.obj",
        "static/spot.obj",
        "static/goathead.obj",
        "static/human_neutral.obj",
        "hard-obj/assimp_WusonOBJ.obj",
        "hard-obj/trimesh_groups.obj",
        "hard-obj/trimesh_negative_indices.obj",
        "hard-obj/trimesh_quadknot.obj",
    ] {
        let path = data.join("meshes").join(name);
        let ours = read_model(&path, &ImportOptions::default(), Reach::OwnFolder).unwrap();
        let theirs = by_tobj(&path);
        // The order of parts may differ, and the corners of a triangle may be rotated.
        let mut found: Vec<_> = ours
            .mesh
            .triangles
            .iter()
            .map(|t| rotated(t.map(|i| (ours.mesh.positions[i as usize], ours.mesh.uvs[i as usize]))))
            .collect();
        let mut expected: Vec<_> = theirs.into_iter().map(rotated).collect();
        for list in [&mut found, &mut expected] {
            list.sort_by(|a, b| a.partial_cmp(b).unwrap());
        }
        assert_eq!(found.len(), expected.len(), "{name}");
        assert!(found == expected, "{name}");
    }
}

type Key = [[f32; 5]; 3];

fn rotated(corners: [(Vec3, Vec2); 3]) -> Key {
    let mut key = corners.map(|(p, uv)| [p.x, p.y, p.z, uv.x, uv.y]);
    let least = (0..3).min_by(|a, b| key[*a].partial_cmp(&key[*b]).unwrap()).unwrap();
    key.rotate_left(least);
    key
}

fn by_tobj(path: &Path) -> Vec<[(Vec3, Vec2); 3]> {
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ..Default::default() };
    let (models, _) = tobj::load_obj(path, &options).unwrap();
    let mut out = Vec::new();
    for mesh in models.iter().map(|m| &m.mesh) {
        let corner = |i: &u32| {
            let i = *i as usize;
            let p = Vec3::from_slice(&mesh.positions[3 * i..]);
            let uv = mesh.texcoords.get(2 * i..2 * i + 2);
            (p, uv.map_or(Vec2::ZERO, |uv| Vec2::new(uv[0], 1.0 - uv[1])))
        };
        out.extend(mesh.indices.as_chunks::<3>().0.iter().map(|t| t.each_ref().map(corner)));
    }
    out
}
