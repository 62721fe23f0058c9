//! Lists of materials: the colours, textures and decisions that `bake` and `inspect` print.
#![allow(clippy::unwrap_used, reason = "tests")]

use crate::import::support::*;
use pelage_tests::binary::Sandbox;
use pelage_tests::schema;
use serde_json::{Value, json};
use std::f32::consts::{PI, TAU};

/// Colours of the bands, from the top.
const COLORS: [&str; 5] = ["#e03020", "#20a040", "#3050d0", "#f0e0a0", "#302820"];

/// Settings of a quick bake.
const QUICK: [&str; 5] =
    ["slice.tile_texels=16", "slice.layers=4", "hair.density=20", "visibility.enabled=false", "ink.enabled=false"];

/// Returns a linear factor for a colour in sRGB.
fn factor(hex: &str) -> Value {
    let channel = |at: usize| {
        let share = f64::from(u8::from_str_radix(&hex[at..at + 2], 16).unwrap()) / 255.0;
        if share <= 0.04045 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) }
    };
    json!([channel(1), channel(3), channel(5), 1.0])
}

/// Returns a sphere of five bands, each with an untextured material of its own, and a square whose texture is
/// white in a quarter and black elsewhere.
fn banded() -> Doc {
    let (columns, rows) = (40_u32, 30_u32);
    let mut doc = Doc::new();
    let (mut points, mut bands) = (Vec::new(), vec![Vec::new(); COLORS.len()]);
    for (row, column) in (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column))) {
        let (polar, turn) = (PI * row as f32 / rows as f32, TAU * column as f32 / columns as f32);
        points.extend([polar.sin() * turn.cos(), polar.cos(), polar.sin() * turn.sin()]);
        if row < rows && column < columns {
            let a = row * (columns + 1) + column;
            let [b, c] = [a + 1, a + columns + 1];
            bands[(5 * row / rows) as usize].extend([a, b, c + 1, a, c + 1, c]);
        }
    }
    let position = doc.floats(&points, "VEC3");
    let mut primitives = Vec::new();
    for (band, color) in bands.iter().zip(COLORS) {
        let indices = doc.accessor(&band.bytes(), U32, "SCALAR", band.len());
        let material = doc.push("materials", json!({"pbrMetallicRoughness": {"baseColorFactor": factor(color)}}));
        doc.json["materials"][material]["name"] = json!(format!("Band {material}"));
        primitives.push(json!({"attributes": {"POSITION": position}, "indices": indices, "material": material}));
    }
    let quarter = image::RgbImage::from_fn(8, 8, |x, _| image::Rgb([if x < 6 { 0 } else { 255 }; 3]));
    let mut png = std::io::Cursor::new(Vec::new());
    quarter.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let view = doc.view(&png.into_inner());
    doc.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    doc.push("textures", json!({"source": 0}));
    let texture = json!({"baseColorTexture": {"index": 0}});
    let material = doc.push("materials", json!({"name": "Sign", "pbrMetallicRoughness": texture}));
    let corners = doc.floats(&[2., 0., 0., 3., 0., 0., 3., 1., 0., 2., 1., 0.], "VEC3");
    let uv = doc.floats(&[0., 1., 1., 1., 1., 0., 0., 0.], "VEC2");
    let indices = doc.accessor(&[0u16, 1, 2, 0, 2, 3].bytes(), U16, "SCALAR", 6);
    let attributes = json!({"POSITION": corners, "TEXCOORD_0": uv});
    primitives.push(json!({"attributes": attributes, "indices": indices, "material": material}));
    let mesh = doc.push("meshes", json!({"primitives": primitives}));
    doc.push("nodes", json!({"mesh": mesh}));
    doc
}

#[test]
fn each_material_is_listed_with_its_own_colour() {
    let sandbox = Sandbox::new();
    sandbox.write("a.glb", banded().glb());
    for settings in [&["model.bare=[\"Si*\"]"][..], &["model.bare=[\"Si*\"]", "color.at_root=false"]] {
        let mut args = vec!["bake", "a.glb", "-o", "a.pelage", "--json"];
        args.extend(QUICK.iter().chain(settings).flat_map(|set| ["--set", set]));
        let baked = schema::parse_success(&sandbox.run(&args), "bake");
        let inspected = schema::parse_success(&sandbox.run(&["inspect", "a.pelage", "--json"]), "inspect");
        assert_eq!(baked["model"]["materials"], inspected["materials"]);
        let materials = inspected["materials"].as_array().unwrap();
        let of = |key: &str| materials.iter().map(|material| material[key].clone()).collect::<Vec<_>>();
        // A quarter of the light of white is 137 in sRGB.
        assert_eq!(of("color"), [&COLORS[..], &["#898989"]].concat(), "{settings:?}");
        assert_eq!(of("textured"), [false, false, false, false, false, true]);
        assert_eq!(of("furred"), [true, true, true, true, true, false]);
        assert_eq!(of("bare_by"), [json!(null), json!(null), json!(null), json!(null), json!(null), json!("Si*")]);
        assert!((of("share").iter().map(|share| share.as_f64().unwrap()).sum::<f64>() - 1.0).abs() < 1e-9);
    }
    let text = sandbox.run(&["inspect", "a.pelage"]).stdout;
    assert!(text.contains("\"Band 1\", furred, #20a040, 480 triangles"), "{text}");
    assert!(text.contains("\"Sign\", bare (model.bare has \"Si*\"), #898989, textured, 2 triangles"), "{text}");
}
