//! Colours below clear texels, and memory for large pictures.
#![allow(clippy::unwrap_used, reason = "tests")]

use crate::import::support::*;
use base64::Engine as _;
use image::{DynamicImage, ImageFormat};
use pelage_bake::io::{Reach, read_model};
use pelage_bake::pipeline::{self, BakeInput};
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::groom::MapImages;
use pelage_bake::stages::import::ImportOptions;
use pelage_bake::stages::slice::decode_texture;
use pelage_formats::{Limits, Package};
use pelage_import::mesh::Model;
use pelage_tests::binary::Sandbox;
use pelage_tests::gpu::gpu;
use serde_json::{Value, json};

const ORANGE: [u8; 3] = [230, 140, 60];

/// Settings of a quick bake. Base colours are not compressed, and are stored as in the model.
const QUICK: [&str; 8] = [
    "color.at_root=false",
    "ink.enabled=false",
    "slice.tile_texels=32",
    "slice.layers=4",
    "hair.density=60",
    "pack.shell_format=rgba8",
    "pack.direction_format=rg8",
    "pack.base_color_format=rgba8",
];

/// Bakes a model with the settings [`QUICK`] and then `more`.
fn baked(model: &Model, more: &[&str]) -> Vec<u8> {
    let mut recipe = Recipe::default();
    QUICK.iter().chain(more).for_each(|set| recipe.set(set).unwrap());
    let images = MapImages::default();
    pipeline::bake(&BakeInput::new("m", "m", &recipe, &images), model, &mut |_| {}).unwrap().package
}

/// Returns the texels of a material's base colour, with all mip levels.
fn base_colors(package: &[u8], material: usize) -> Vec<Vec<[u8; 4]>> {
    let package = Package::open(package, &Limits::default()).unwrap();
    let view = package.base_color_texture(material).unwrap().unwrap();
    let level = |level| decode_texture(&view, level, 0).unwrap().as_chunks().0.to_vec();
    (0..view.levels).map(level).collect()
}

/// Asserts that all texels have the colour, in all mip levels.
#[track_caller]
fn assert_color(levels: &[Vec<[u8; 4]>], color: [u8; 3], about: &str) {
    for (level, texels) in levels.iter().enumerate() {
        for texel in texels {
            let apart = (0..3).map(|i| texel[i].abs_diff(color[i])).max();
            assert!(apart <= Some(1), "{about}, level {level}: found {texel:?}, expected {color:?}");
        }
    }
}

/// Returns a square with texture coordinates and one material.
fn square(material: Value) -> Doc {
    let mut doc = Doc::new();
    let position = doc.floats(&[-0.5, 0., 0., 0.5, 0., 0., 0.5, 1., 0., -0.5, 1., 0.], "VEC3");
    let uv = doc.floats(&[0., 1., 1., 1., 1., 0., 0., 0.], "VEC2");
    let indices = doc.accessor(&[0u16, 1, 2, 0, 2, 3].bytes(), U16, "SCALAR", 6);
    let attributes = json!({"POSITION": position, "TEXCOORD_0": uv});
    doc.show(json!({"attributes": attributes, "indices": indices, "material": 0}));
    doc.push("materials", material);
    doc
}

/// Returns squares, one for each of the image files, whose material has the file and alpha mode.
fn textured(images: &[(&[u8], &str)]) -> Doc {
    let mut doc = square(json!({}));
    let primitive = doc.json["meshes"][0]["primitives"][0].clone();
    let mut primitives = Vec::new();
    doc.json["materials"] = json!([]);
    for (number, (image, mode)) in images.iter().enumerate() {
        let view = doc.view(image);
        doc.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
        doc.push("textures", json!({"source": number}));
        let color = json!({"baseColorTexture": {"index": number}});
        doc.push("materials", json!({"pbrMetallicRoughness": color, "alphaMode": mode}));
        let mut primitive = primitive.clone();
        primitive["material"] = json!(number);
        primitives.push(primitive);
    }
    doc.json["meshes"][0]["primitives"] = json!(primitives);
    doc
}

fn encoded(image: impl Into<DynamicImage>) -> Vec<u8> {
    let mut out = std::io::Cursor::new(Vec::new());
    image.into().write_to(&mut out, ImageFormat::Png).unwrap();
    out.into_inner()
}

/// Encodes a PNG row by row.
fn png(
    size: [u32; 2],
    color: png::ColorType,
    more: impl FnOnce(&mut png::Encoder<'_, &mut Vec<u8>>),
    row: &[u8],
) -> Vec<u8> {
    use std::io::Write as _;
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, size[0], size[1]);
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fastest);
    more(&mut encoder);
    let mut writer = encoder.write_header().unwrap();
    let mut rows = writer.stream_writer().unwrap();
    (0..size[1]).for_each(|_| rows.write_all(row).unwrap());
    rows.finish().unwrap();
    drop(writer);
    out
}

/// Returns images of 8 × 8 texels of one colour, in all kinds of PNG that have alpha. Alpha is 0 in the first `clear`
/// columns and 255 in the others; the colour of clear texels is `below`.
fn with_alpha(color: [u8; 3], clear: u32, below: [u8; 3]) -> Vec<(&'static str, Vec<u8>)> {
    let rgba = image::RgbaImage::from_fn(8, 8, |x, _| {
        let ([r, g, b], alpha) = if x < clear { (below, 0) } else { (color, 255) };
        image::Rgba([r, g, b, alpha])
    });
    let palette = |encoder: &mut png::Encoder<'_, &mut Vec<u8>>| {
        encoder.set_palette([color, below].concat());
        encoder.set_trns(vec![255, 0]);
    };
    let indices: Vec<u8> = (0..8).map(|x| u8::from(x < clear)).collect();
    let mut images = vec![
        ("RGBA", encoded(rgba.clone())),
        ("RGBA of 16 bits", encoded(DynamicImage::from(rgba.clone()).into_rgba16())),
        ("palette", png([8, 8], png::ColorType::Indexed, palette, &indices)),
    ];
    if color[0] == color[1] && color[1] == color[2] {
        images.push(("grey and alpha", encoded(DynamicImage::from(rgba).into_luma_alpha8())));
    }
    images
}

#[test]
fn opaque_materials_ignore_alpha() {
    let mut cases = Vec::new();
    for color in [ORANGE, [140; 3]] {
        // Clear everywhere, and in some columns only.
        for clear in [8, 3] {
            cases.extend(with_alpha(color, clear, color).into_iter().map(|(kind, image)| (kind, image, color)));
        }
    }
    // The colour below clear texels is that of the file.
    cases.push(("two colours", with_alpha(ORANGE, 4, [0, 0, 255]).swap_remove(0).1, ORANGE));
    let images: Vec<_> = cases.iter().map(|(_, image, _)| (&image[..], "OPAQUE")).collect();
    let package = baked(&textured(&images).model(), &[]);
    for (material, (kind, _, color)) in cases.iter().enumerate() {
        let levels = base_colors(&package, material);
        assert!(levels.iter().flatten().all(|texel| texel[3] == 255), "{kind}: {levels:?}");
        if material + 1 < cases.len() {
            assert_color(&levels, *color, kind);
        } else {
            assert_eq!((levels[0][0], levels[0][7]), ([0, 0, 255, 255], [230, 140, 60, 255]));
        }
    }
}

#[test]
fn clear_texels_take_the_colour_of_visible_ones() {
    let mut cases = Vec::new();
    for mode in ["MASK", "BLEND"] {
        for below in [[0; 3], [255; 3]] {
            let images = with_alpha(ORANGE, 5, below).into_iter();
            cases.extend(images.map(|(kind, image)| (format!("{kind}, {mode}, {below:?}"), image, mode)));
        }
        // Without any visible texel, the colours are those of the file.
        cases.push((format!("clear, {mode}"), with_alpha(ORANGE, 8, ORANGE).swap_remove(0).1, mode));
    }
    let images: Vec<_> = cases.iter().map(|(_, image, mode)| (&image[..], *mode)).collect();
    let package = baked(&textured(&images).model(), &[]);
    for (material, (about, _, mode)) in cases.iter().enumerate() {
        let levels = base_colors(&package, material);
        assert_color(&levels, ORANGE, about);
        let visible = if about.starts_with("clear") { 0 } else { 255 };
        let expected = if *mode == "MASK" { [0, visible] } else { [255; 2] };
        assert_eq!([levels[0][0][3], levels[0][7][3]], expected, "{about}");
    }
}

#[test]
fn one_image_has_a_meaning_per_material() {
    let (_, image) = with_alpha(ORANGE, 4, [0, 0, 255]).swap_remove(0);
    let mut doc = textured(&[(&image, "OPAQUE")]);
    for mode in ["MASK", "BLEND", "OPAQUE"] {
        doc.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "alphaMode": mode}));
        let number = doc.json["materials"].as_array().unwrap().len() - 1;
        let mut primitive = doc.json["meshes"][0]["primitives"][0].clone();
        primitive["material"] = json!(number);
        doc.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
    }
    let package = baked(&doc.model(), &[]);
    let first = [0, 1, 2, 3].map(|material| base_colors(&package, material)[0][0]);
    let [r, g, b] = ORANGE;
    assert_eq!(first, [[0, 0, 255, 255], [r, g, b, 0], [r, g, b, 255], [0, 0, 255, 255]]);
    let package = Package::open(&package, &Limits::default()).unwrap();
    assert_eq!(package.manifest().materials[0].base_color_texture, package.manifest().materials[3].base_color_texture);
}

#[test]
fn alpha_of_vertex_colours_and_factors_changes_no_colour() {
    for (mode, kept) in [("OPAQUE", false), ("BLEND", false), ("MASK", true)] {
        let mut doc = square(json!({"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.25]}, "alphaMode": mode}));
        let colors: [[u8; 4]; 4] = [[230, 0, 60, 0], [230, 0, 60, 0], [0, 140, 60, 0], [0, 140, 60, 0]];
        let accessor = doc.accessor(&colors.concat(), U8, "VEC4", 4);
        doc.json["accessors"][accessor]["normalized"] = json!(true);
        doc.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(accessor);
        let model = doc.model();
        let bytes = baked(&model, &[]);
        let package = Package::open(&bytes, &Limits::default()).unwrap();
        let alpha = if kept { 0 } else { 255 };
        for vertex in package.mesh().unwrap().unwrap().attributes() {
            let expected = [[230, 0, 60, alpha], [0, 140, 60, alpha]];
            assert!(expected.contains(&vertex.color), "{mode}: {:?}", vertex.color);
        }
        assert_eq!(package.manifest().materials[0].base_color[3], if kept { 0.25 } else { 1.0 }, "{mode}");
        if kept {
            continue;
        }
        // Hair hangs over the other colour, so that colours go by a texture.
        let bytes = baked(&model, &["color.at_root=true", "groom.lean=0.8"]);
        let levels = base_colors(&bytes, 0);
        assert!(levels[0].iter().all(|texel| texel[3] == 255 && texel[0].max(texel[1]) > 60), "{mode}");
    }
}

#[test]
fn opaque_texture_of_alpha_0_is_orange() {
    let name = "opaque_texture_of_alpha_0_is_orange";
    let Some(data) = data(name) else { return };
    let path = data.join("cases/opaque_texture_alpha0.gltf");
    let model = read_model(&path, &ImportOptions::default(), Reach::OwnFolder).unwrap();
    assert_color(&base_colors(&baked(&model, &[]), 0), ORANGE, "levels");
    if gpu(name).is_none() {
        return;
    }
    // The picture is that of the same file with an opaque texture.
    let mut control: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    let opaque = encoded(image::RgbImage::from_pixel(1, 1, image::Rgb(ORANGE)));
    let opaque = base64::engine::general_purpose::STANDARD.encode(opaque);
    control["images"][0]["uri"] = json!(format!("data:image/png;base64,{opaque}"));
    let sandbox = Sandbox::new();
    sandbox.write("case.gltf", std::fs::read(&path).unwrap());
    sandbox.write("control.gltf", control.to_string());
    let pictures = ["case", "control"].map(|name| {
        let (model, package, picture) = (format!("{name}.gltf"), format!("{name}.pelage"), format!("{name}.png"));
        let bake = [&["bake", &model, "-o", &package][..], &QUICK.map(|set| ["--set", set]).concat()].concat();
        assert_eq!(sandbox.run(&bake).code, Some(0), "{name}");
        let run = sandbox.run(&["render", &package, "-o", &picture, "--style", "bare", "--size", "64x48"]);
        assert_eq!(run.code, Some(0), "{run:?}");
        image::load_from_memory(&sandbox.read(&picture)).unwrap().into_rgba8()
    });
    let [r, g, b, alpha] = pictures[0].get_pixel(32, 24).0;
    assert!(alpha == 255 && r > g && g > b && r > 100, "{:?}", [r, g, b, alpha]);
    assert!(pictures[0] == pictures[1], "the pictures of case and control differ");
}

#[test]
fn bare_place_of_an_image_has_no_bright_rim() {
    if gpu("bare_place_of_an_image_has_no_bright_rim").is_none() {
        return;
    }
    let sandbox = Sandbox::new();
    sandbox
        .write("square.gltf", square(json!({"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1]}})).gltf());
    // A disc in the middle with a blurred edge.
    let mask = image::GrayImage::from_fn(128, 128, |x, y| {
        let from_edge = 16.0 - f32::hypot(x as f32 - 63.5, y as f32 - 63.5);
        image::Luma([(255.0 * (0.5 + from_edge / 12.0).clamp(0.0, 1.0)) as u8])
    });
    sandbox.write("mask.png", encoded(mask));
    let set = ["groom.bare=\"mask.png\"", "hair.length_m=0.06", "groom.by_body=0", "hair.density=200"];
    let set = ["ink.enabled=false", "slice.tile_texels=64"].iter().chain(&set).flat_map(|set| ["--set", set]);
    let bake: Vec<_> = ["bake", "square.gltf", "-o", "square.pelage"].into_iter().chain(set).collect();
    assert_eq!(sandbox.run(&bake).code, Some(0));
    let camera = ["--size", "128x128", "--camera", "0,0.5,2/0,0.5,0/28", "--hair", "shells", "--soft-shadow", "off"];
    for light in ["1,0,0.02", "0,1,0.06", "-1,1,0.12"] {
        let render = [&["render", "square.pelage", "-o", "picture.png", "--light", light][..], &camera].concat();
        let run = sandbox.run(&render);
        assert_eq!(run.code, Some(0), "{run:?}");
        let picture = image::load_from_memory(&sandbox.read("picture.png")).unwrap().into_rgb8();
        // Mean green of rings about the middle, four pixels wide.
        let mut rings = [(0u32, 0u32); 13];
        for (x, y, texel) in picture.enumerate_pixels() {
            let ring = f32::hypot(x as f32 - 63.5, y as f32 - 63.5) as usize / 4;
            if let Some((sum, count)) = rings.get_mut(ring) {
                (*sum, *count) = (*sum + u32::from(texel[1]), *count + 1);
            }
        }
        let rings = rings.map(|(sum, count)| sum / count);
        let most = rings[0].max(rings[12]) * 103 / 100;
        assert!(rings[0].min(rings[12]) > 10, "light {light}: {rings:?}");
        assert!(rings.iter().all(|mean| *mean <= most), "light {light}: rings from the middle {rings:?}");
    }
}

#[test]
fn hair_of_another_colour_is_drawn_and_traced_over_skin_of_its_own() {
    if gpu("hair_of_another_colour_is_drawn_and_traced_over_skin_of_its_own").is_none() {
        return;
    }
    let sandbox = Sandbox::new();
    sandbox.write("blue.gltf", square(json!({"pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.1, 0.8, 1]}})).gltf());
    for at_root in ["false", "true"] {
        let at_root = format!("color.at_root={at_root}");
        let set = ["groom.hair_color=\"#c02020\"", "hair.length_m=0.06", &at_root, "ink.enabled=false"];
        let set = set.iter().chain(&["slice.tile_texels=32", "hair.density=60"]).flat_map(|set| ["--set", *set]);
        let bake: Vec<_> = ["bake", "blue.gltf", "-o", "blue.pelage"].into_iter().chain(set).collect();
        let run = sandbox.run(&bake);
        assert!(run.code == Some(0) && run.stdout.contains("furred, #5959e7"), "{run:?}");
        let is_red = |command: &str, more: &[&str]| {
            let view = ["--size", "48x48", "--camera", "0,0.5,1.5/0,0.5,0/28"];
            let run = sandbox.run(&[&[command, "blue.pelage", "-o", "blue.png"], more, &view].concat());
            assert_eq!(run.code, Some(0), "{run:?}");
            let picture = image::load_from_memory(&sandbox.read("blue.png")).unwrap().into_rgba8();
            let sum =
                picture.pixels().fold([0u32; 3], |sum, texel| std::array::from_fn(|i| sum[i] + u32::from(texel[i])));
            assert!(sum[0].max(sum[2]) > 48 * 48 * 20, "{command} {more:?}: {sum:?}");
            sum[0] > sum[2]
        };
        for hair in ["shells", "strands"] {
            assert!(is_red("render", &["--hair", hair]), "{hair}, {at_root}");
        }
        assert!(is_red("reference", &["--samples", "4"]), "reference, {at_root}");
        assert!(!is_red("render", &["--style", "bare"]), "bare, {at_root}");
    }
}

/// Imports and grooms a model with the binary. Returns the peak memory, MiB, and what was printed.
fn peak(sandbox: &Sandbox, model: &str) -> (u64, String) {
    let run = sandbox.run(&["groom", model, "--map", "bare", "-o", "map.png", "--record", "record.json"]);
    assert_eq!(run.code, Some(0), "{run:?}");
    let record: Value = serde_json::from_slice(&sandbox.read("record.json")).unwrap();
    (record["peak_bytes"].as_u64().unwrap_or(0) >> 20, run.stderr)
}

/// Returns the square with a texture in another file.
fn with_file(name: &str) -> Vec<u8> {
    let mut doc = square(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
    doc.push("images", json!({"uri": name}));
    doc.push("textures", json!({"source": 0}));
    doc.gltf()
}

#[test]
fn large_pictures_are_reduced_while_they_are_decoded() {
    let sandbox = Sandbox::new();
    sandbox.write("large.png", png([8192, 8192], png::ColorType::Grayscale, |_| {}, &[140; 8192]));
    sandbox.write("large.gltf", with_file("large.png"));
    let (peak, said) = peak(&sandbox, "large.gltf");
    assert!(said.contains("is 8192 x 8192 texels, read as 4096 x 4096 to limit memory"), "{said}");
    assert!(peak < 240, "peak memory {peak} MiB, expected 64 MiB for the reduced image and as much for the rest");
}

#[test]
fn large_images_of_all_kinds_keep_their_colour() {
    // Slightly more texels than are kept as they are.
    let size = [4097, 4096];
    let (row, rgb) = ([ORANGE; 4097].concat(), png::ColorType::Rgb);
    let mut jpeg = std::io::Cursor::new(Vec::new());
    image::GrayImage::from_pixel(size[0], size[1], image::Luma([140])).write_to(&mut jpeg, ImageFormat::Jpeg).unwrap();
    for (kind, bytes, color) in [("PNG", png(size, rgb, |_| {}, &row), ORANGE), ("JPEG", jpeg.into_inner(), [140; 3])] {
        let mut left = 1 << 28;
        let channels = pelage_import::image_file::Channels::Color;
        let (image, note) = pelage_import::image_file::decode_image(&bytes, &mut left, channels).unwrap();
        assert_eq!((image.width, image.height), (2049, 2048), "{kind}");
        assert_eq!(note.as_deref(), Some("is 4097 x 4096 texels, read as 2049 x 2048 to limit memory"));
        assert_eq!(left, (1 << 28) - 4097 * 4096);
        assert_color(&[image.rgba.as_chunks().0.to_vec()], color, kind);
    }
}

/// Returns a zlib stream of `runs` times 258 zero bytes: matches of the byte before, in the fixed Huffman code.
fn zeros(runs: usize) -> Vec<u8> {
    let mut bits: Vec<u8> = Vec::with_capacity(13 * runs + 32);
    // Final block with fixed codes, one literal 0, the matches (length code 285, distance code 0), end of block.
    bits.extend([1, 1, 0]);
    bits.extend([0, 0, 1, 1, 0, 0, 0, 0]);
    (0..runs).for_each(|_| bits.extend([1, 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0]));
    bits.extend([0; 7]);
    let byte = |bits: &[u8]| bits.iter().rev().fold(0, |byte, bit| byte << 1 | bit);
    let mut out = vec![0x78, 0x01];
    out.extend(bits.chunks(8).map(byte));
    // Adler-32 of zeros.
    let length = (258 * runs + 1) % 65521;
    out.extend([(length >> 8) as u8, length as u8, 0, 1]);
    out
}

#[test]
fn colour_profiles_are_not_unpacked_without_limit() {
    // The profile of half a GiB is inserted after the header.
    let image = encoded(image::RgbImage::from_pixel(4, 4, image::Rgb(ORANGE)));
    let body = [b"iCCPx\0\0".to_vec(), zeros(1 << 21)].concat();
    let chunk = [&(body.len() as u32 - 4).to_be_bytes()[..], &body, &crc32fast::hash(&body).to_be_bytes()].concat();
    let sandbox = Sandbox::new();
    sandbox.write("bomb.png", [&image[..33], &chunk, &image[33..]].concat());
    sandbox.write("bomb.gltf", with_file("bomb.png"));
    let (peak, _) = peak(&sandbox, "bomb.gltf");
    assert!(peak < 300, "peak memory {peak} MiB");
}

#[test]
fn picture_of_16384_texels_needs_little_memory() {
    let Some(data) = data("picture_of_16384_texels_needs_little_memory") else { return };
    let sandbox = Sandbox::new();
    let path = data.join("cases/basecolor_16384.gltf").display().to_string();
    let (peak, said) = peak(&sandbox, &path);
    assert!(peak < 240, "peak memory {peak} MiB");
    assert!(said.contains("read as 4096 x 4096"), "{said}");
}

#[test]
fn documents_that_need_too_much_memory_are_refused() {
    let nodes = vec![r#"{"children":[1]}"#; 1 << 20].join(",");
    let document = format!(r#"{{"asset":{{"version":"2.0"}},"nodes":[{nodes}]}}"#);
    let (place, reason) = fault(import_bytes(document.as_bytes()));
    assert_eq!(place, "byte 0");
    assert!(reason.contains("0.9 GiB of memory to parse") && reason.contains("limited to 1 GiB"), "{reason}");
}
