//! Tests with the real binary: comb marks in recipes, comb lines in models, and images projected in space.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::Vec3;
use pelage_formats::{AttributeVertex, GeometryVertex, Limits, Package};
use pelage_tests::binary::{Sandbox, workspace};
use pelage_tests::schema::parse_success;
use serde_json::{Value, json};

const BAKE: [&str; 8] =
    ["bake", "m.glb", "-o", "m.pelage", "--json", "--set", "slice.layers=24", "--set=slice.tile_texels=16"];

/// Returns a folder with the torus, without texture coordinates and colours. Its axis is y, its width is 0.28 m, and
/// its top is at y = 0.16 m. `change` edits the glTF document.
fn sandbox(change: impl FnOnce(&Sandbox, &mut Value)) -> Sandbox {
    let sandbox = Sandbox::new();
    let glb = std::fs::read(workspace().join("assets/models/torus.glb")).unwrap();
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let mut document: Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    document["meshes"][0]["primitives"][0]["attributes"] = json!({ "POSITION": 0, "NORMAL": 1 });
    change(&sandbox, &mut document);
    let text = serde_json::to_vec(&document).unwrap();
    sandbox.write("m.glb", pelage_glb::container_of_text(text, &glb[28 + length..]).unwrap());
    sandbox
}

/// Adds a line of 0.2 m along +x over the top of the torus, at z = 0.2 m. In the file the line runs along y; its node
/// rotates it.
fn add_line(sandbox: &Sandbox, document: &mut Value) {
    let points: [f32; 9] = [0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    sandbox.write("line.bin", points.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>());
    let list = |document: &mut Value, name: &str, value: Value| {
        let list = document[name].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    };
    let buffer = list(document, "buffers", json!({ "uri": "line.bin", "byteLength": 36 }));
    let view = list(document, "bufferViews", json!({ "buffer": buffer, "byteLength": 36 }));
    let accessor = json!({ "bufferView": view, "componentType": 5126, "count": 3, "type": "VEC3",
        "min": [0, -1, 0], "max": [0, 1, 0] });
    let position = list(document, "accessors", accessor);
    let mesh = json!({ "primitives": [{ "attributes": { "POSITION": position }, "mode": 3 }] });
    let mesh = list(document, "meshes", mesh);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let node = json!({ "name": "comb_top", "mesh": mesh, "translation": [0, 0.165, 0.2], "scale": [0.1, 0.1, 0.1],
        "rotation": [0, 0, -half, half] });
    let node = list(document, "nodes", node);
    list(&mut document["scenes"][0], "nodes", node.into());
}

fn vertices(sandbox: &Sandbox) -> (Vec<GeometryVertex>, Vec<AttributeVertex>, f32) {
    let bytes = std::fs::read(sandbox.path().join("m.pelage")).unwrap();
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    let mesh = package.mesh().unwrap().unwrap();
    (mesh.geometry().collect(), mesh.attributes().collect(), package.manifest().fur.height_m)
}

/// Runs a bake, and returns its report.
fn bake(sandbox: &Sandbox, more: &[&str]) -> Value {
    parse_success(&sandbox.run(&[&BAKE[..], more].concat()), "bake")
}

/// Returns the mean hair direction along the surface, over the vertices less than `within` metres from a point.
fn mean_hair_direction(sandbox: &Sandbox, place: Vec3, within: f32) -> Vec3 {
    let (geometry, ..) = vertices(sandbox);
    let near = geometry.iter().filter(|v| Vec3::from(v.position).distance(place) < within);
    let along_v = |v: &GeometryVertex| {
        let [x, y, z, hand] = v.tangent;
        Vec3::from(v.normal).cross(Vec3::new(x, y, z)) * hand
    };
    let directions: Vec<Vec3> = near.map(along_v).collect();
    assert!(directions.len() >= 3, "{} vertices at {place}", directions.len());
    directions.iter().sum::<Vec3>() / directions.len() as f32
}

const TOP: Vec3 = Vec3::new(0.0, 0.16, 0.2);
const FAR: Vec3 = Vec3::new(0.0, 0.16, -0.2);

#[test]
fn a_comb_line_turns_the_hair() {
    let sandbox = sandbox(|_, _| {});
    let plain = bake(&sandbox, &[]);
    let lines = |said: &Value| -> Vec<String> {
        said["decisions"].as_array().unwrap().iter().map(|d| d["line"].as_str().unwrap().to_owned()).collect()
    };
    assert!(!lines(&plain).iter().any(|line| line.starts_with("surface.comb")), "{plain}");
    let before = mean_hair_direction(&sandbox, TOP, 0.05);
    assert!(before.dot(Vec3::NEG_Z) > 0.9 && before.x.abs() < 0.2, "from nose to tail: {before}");

    let drawn = super::comb::sandbox(add_line);
    let said = bake(&drawn, &[]);
    assert!(lines(&said).contains(&"surface.comb = \"marks\"".to_owned()), "{said}");
    assert!(said["decisions"].to_string().contains("comb_top"), "{said}");
    assert_eq!(said["warnings"].as_array().unwrap().len(), 0, "{said}");
    let after = mean_hair_direction(&drawn, TOP, 0.05);
    // The effect is full within a quarter of the reach. That quarter is 21 mm here, while the vertices are up to 50 mm
    // away.
    assert!(after.dot(Vec3::X) > 0.75, "along the line: {after}");
    let far = mean_hair_direction(&drawn, FAR, 0.05);
    assert!(far.dot(Vec3::NEG_Z) > 0.9, "as far from the line as without: {far}");

    // The recipe has priority over the decision. If the recipe contains the line that the decision reports, the effect
    // is the same.
    let package = |more: &[&str]| {
        let said = bake(&drawn, more);
        (lines(&said), std::fs::read(drawn.path().join("m.pelage")).unwrap())
    };
    package(&["--set", "surface.comb=direction"]);
    let straight = mean_hair_direction(&drawn, TOP, 0.05);
    assert!(straight.dot(Vec3::NEG_Z) > 0.9, "{straight}");
    package(&["--set", "surface.comb_direction=[0,0,1]"]);
    let turned = mean_hair_direction(&drawn, TOP, 0.05);
    assert!(turned.dot(Vec3::Z) > 0.9, "{turned}");
    let (lines, _) = package(&["--set", "surface.comb=marks"]);
    assert!(!lines.iter().any(|line| line.starts_with("surface.comb")), "{lines:?}");
    assert!(mean_hair_direction(&drawn, TOP, 0.05).dot(Vec3::X) > 0.75);
    // The comb line of the model is used in addition to the comb marks of the recipe.
    let marks = "surface.comb_marks=[{ name = \"back\", at = [0, 0.16, -0.2], direction = [0, 0, 1] }]";
    package(&["--set", marks]);
    let (top, back) = (mean_hair_direction(&drawn, TOP, 0.05), mean_hair_direction(&drawn, FAR, 0.05));
    assert!(top.dot(Vec3::X) > 0.6 && back.dot(Vec3::Z) > 0.9, "{top} {back}");
}

/// Returns the relative hair length and the colour of the vertex nearest to a point.
fn length_and_color(sandbox: &Sandbox, place: Vec3) -> (f32, [u8; 4]) {
    let (geometry, attributes, height) = vertices(sandbox);
    let away = |v: &GeometryVertex| Vec3::from(v.position).distance(place);
    let nearest = geometry.iter().zip(&attributes).min_by(|a, b| away(a.0).total_cmp(&away(b.0))).unwrap();
    (nearest.0.fur_height / height, nearest.1.color)
}

#[test]
fn comb_mark_values_apply_at_their_position_and_fade_out() {
    let sandbox = sandbox(|_, _| {});
    let recipe = "[color]\nat_root = false\n[groom]\nlength = 0.8\n[surface]\ncomb_marks = [\n\
        { name = \"top\", at = [0, 0.16, 0.2], length = 0.2, reach_m = 0.2 },\n\
        { name = \"white\", at = [0, 0.16, 0.2], color = \"#ffffff\", reach_m = 0.2 },\n\
        { name = \"lost\", at = [0, 0.16, 1.2], lean = 1 }]\n";
    sandbox.write("r.toml", recipe);
    let said = bake(&sandbox, &["--recipe", "r.toml"]);
    let warnings = said["warnings"].to_string();
    assert!(warnings.contains("lost") && warnings.contains("m from the nearest skin"), "{warnings}");
    // The torus has no colour. Its fur is brown outside the white part, and the bake reports this decision.
    assert!(said["decisions"].to_string().contains("groom.color"), "{said}");
    let ((length, white), (elsewhere, brown)) = (length_and_color(&sandbox, TOP), length_and_color(&sandbox, FAR));
    assert!((length - 0.2).abs() < 0.02 && (elsewhere - 0.8).abs() < 0.01, "{length} {elsewhere}");
    assert!(white[..3] == [255; 3] && brown[2] < 100 && brown[0] > brown[2], "{white:?} {brown:?}");
    let between = length_and_color(&sandbox, Vec3::new(0.12, 0.16, 0.16)).0;
    assert!((0.25..0.75).contains(&between), "{between}");
}

#[test]
fn projected_image_applies_at_the_painted_position() {
    let sandbox = sandbox(|_, _| {});
    // Seen from +x, −z is on the right. The image is black on the left, white on the right, and grey in the lower half.
    let shade = |x: u32, y: u32| {
        if y >= 8 {
            128
        } else if x < 16 {
            0
        } else {
            255
        }
    };
    image::GrayImage::from_fn(32, 16, |x, y| image::Luma([shade(x, y)])).save(sandbox.path().join("l.png")).unwrap();
    let read = ["--set", "groom.length=l.png", "--set", "groom.coordinates=x"];
    let said = bake(&sandbox, &read);
    assert!(!said["warnings"].to_string().contains("no texture coordinates"), "{said}");
    for (place, expected) in [(TOP, 0.0), (FAR, 1.0), (Vec3::new(0.0, 0.0, 0.2), 0.5), (Vec3::new(0.0, 0.0, -0.2), 0.5)]
    {
        let (share, _) = length_and_color(&sandbox, place);
        assert!((share - expected).abs() < 0.01, "{place}: {share}");
    }
}

#[test]
fn invalid_comb_settings_are_refused_with_key_and_reason() {
    let sandbox = sandbox(|_, _| {});
    for (set, words) in [
        ("groom.coordinates=w", "box"),
        ("surface.comb_marks=[{ name = \"a\", at = [0, 0, 0] }]", "found none of direction, length"),
        ("surface.comb_marks=[{ name = \"a\", length = 1 }]", "found no `at`"),
        ("surface.comb_marks=[{ name = \"a\", at = [0, 0, 0], length = 2 }]", "length: "),
    ] {
        let run = sandbox.run(&[&BAKE[..], &["--set", set]].concat());
        let key = set.split('=').next().unwrap();
        assert!(run.code == Some(3) && run.stderr.contains(key) && run.stderr.contains(words), "{set}: {run:?}");
    }
    let none =
        ["--set", "surface.comb=marks", "--set", "surface.comb_marks=[{ name = \"a\", at = [0, 0, 0], length = 1 }]"];
    let run = sandbox.run(&[&BAKE[..], &none].concat());
    assert!(run.code == Some(3) && run.stderr.contains("no mark with a direction"), "{run:?}");
}
