//! Tests of `inspect`, `validate`, `unpack` and `pack` with the real binary.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use crate::tool::common::random::Random;
use crate::tool::common::{ktx2_file, sample_animation, sample_manifest_v1, sample_mesh, sample_package};
use pelage_formats::*;
use pelage_tests::binary::{Sandbox, workspace};
use pelage_tests::schema;
use serde_json::Value;
use std::process::Stdio;

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.write("a.pelage", sample_package());
    sandbox
}

#[test]
fn inspect_prints_package_contents() {
    let sandbox = sandbox();
    let run = sandbox.run(&["inspect", "a.pelage", "--json"]);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let object = schema::parse_answer(&run, "inspect");
    for (pointer, expected) in [
        ("/version", "3"),
        ("/triangles", "4"),
        ("/vertices", "5"),
        ("/patches", "3"),
        ("/layers", "2"),
        ("/fins", "3"),
        ("/joints", "2"),
        ("/clips/0/name", "\"breathe\""),
        ("/clips/0/seconds", "0.5"),
        ("/textures/1/format", "\"bc5-rg-unorm\""),
        ("/textures/0/levels", "3"),
        ("/sections/0/tag", "\"MANI\""),
        ("/sections/5/tag", "\"XTRA\""),
        ("/inputs/1/bytes", "1099511627776"),
    ] {
        assert_eq!(object.pointer(pointer).unwrap().to_string(), expected, "{pointer}");
    }
    assert_eq!(object["bytes"], std::fs::metadata(sandbox.path().join("a.pelage")).unwrap().len());
    let text = sandbox.run(&["inspect", "a.pelage"]);
    assert_eq!(text.code, Some(0));
    for word in ["4 triangles", "bc5-rg-unorm", "breathe", "XTRA", "angle_distortion", "3 triangles without area"] {
        assert!(text.stdout.contains(word), "{word}: {}", text.stdout);
    }
    // Only packages of version 3 have this data.
    for words in [
        "0.75 of the fur height",
        "1 layer in 2, 50 % of the fins",
        "the far layer alone",
        "binding limit: max_error",
        "next cheaper",
    ] {
        assert!(text.stdout.contains(words), "{words}: {}", text.stdout);
    }
}

#[test]
fn validate_lists_each_fault_with_its_position() {
    let sandbox = sandbox();
    let run = sandbox.run(&["validate", "a.pelage", "--json"]);
    let object = schema::parse_answer(&run, "validate");
    // The sample's recipe has an unknown key. This is the only fault of the sample, and only the tool can detect it.
    assert_eq!((run.code, object["valid"].as_bool()), (Some(7), Some(false)), "{run:?}");
    let message = object["faults"][0]["message"].to_string();
    assert!(object["faults"].as_array().unwrap().len() == 1 && message.contains("strands"), "{object}");

    let sound = PackageWriter::new(Manifest { recipe: String::new(), ..sample_manifest_v1() })
        .mesh(&sample_mesh(true))
        .animation(&sample_animation())
        .texture(ktx2_file(TextureFormat::Rgba8Srgb, 4, 4, 2, 3, 1))
        .texture(ktx2_file(TextureFormat::Bc5Unorm, 4, 4, 2, 1, 2))
        .texture(ktx2_file(TextureFormat::Bc7Srgb, 8, 4, 0, 2, 3))
        .finish()
        .unwrap();
    let sections = Package::open(&sound, &Limits::default()).unwrap().sections().to_vec();
    sandbox.write("sound.pelage", &sound);
    let run = sandbox.run(&["validate", "sound.pelage", "--json"]);
    assert_eq!((run.code, schema::parse_answer(&run, "validate")["valid"].as_bool()), (Some(0), Some(true)), "{run:?}");

    // Two damaged sections must give two faults.
    let mut damaged = sound.clone();
    for section in [&sections[2], &sections[4]] {
        damaged[(section.offset + section.length) as usize - 1] ^= 1;
    }
    sandbox.write("damaged.pelage", &damaged);
    let run = sandbox.run(&["validate", "damaged.pelage", "--json"]);
    let object = schema::parse_answer(&run, "validate");
    assert_eq!(run.code, Some(7));
    let faults = object["faults"].as_array().unwrap();
    let damaged_offsets: Vec<_> =
        faults.iter().filter(|f| f["message"].to_string().contains("damaged")).map(|f| f["offset"].as_u64()).collect();
    assert!(damaged_offsets.contains(&Some(sections[2].offset)), "{object}");
    assert!(damaged_offsets.contains(&Some(sections[4].offset)), "{object}");
    let text = sandbox.run(&["validate", "damaged.pelage"]);
    assert!(text.stdout.contains(&format!("section KTX2, byte {}", sections[4].offset)), "{}", text.stdout);
}

/// Unpacks and packs a package, and asserts that the bytes are the same. Returns the file names of the folder.
#[track_caller]
fn assert_round_trip(sandbox: &Sandbox, package: &[u8]) -> Vec<String> {
    sandbox.write("in.pelage", package);
    let run = sandbox.run(&["unpack", "in.pelage", "folder", "--json"]);
    assert_eq!(run.code, Some(0), "{run:?}");
    schema::parse_answer(&run, "unpack");
    let run = sandbox.run(&["pack", "folder", "out.pelage", "--json"]);
    assert_eq!(run.code, Some(0), "{run:?}");
    schema::parse_answer(&run, "pack");
    assert!(std::fs::read(sandbox.path().join("out.pelage")).unwrap() == package, "the bytes differ");
    sandbox.files().into_iter().filter_map(|f| f.strip_prefix("folder/").map(str::to_owned)).collect()
}

#[test]
fn pack_reverses_unpack() {
    let sandbox = Sandbox::new();
    let files = assert_round_trip(&sandbox, &sample_package());
    let expected = [
        "",
        "animation.json",
        "base-color.ktx2",
        "fin_color.ktx2",
        "fin_direction.ktx2",
        "fins.bin",
        "groom.ktx2",
        "manifest.json",
        "mesh.glb",
        "recipe.toml",
        "section_5_XTRA.bin",
        "shell_color.ktx2",
        "shell_direction.ktx2",
        "wet_color.ktx2",
        "wet_direction.ktx2",
    ];
    assert_eq!(files, expected);
    assert_round_trip(&sandbox, &PackageWriter::new(Manifest::default()).finish().unwrap());
    // A package of an older version must keep its version.
    for version in 1..=FORMAT_VERSION {
        let golden = workspace().join(format!("formats/tests/golden/v{version}.pelage"));
        assert_round_trip(&sandbox, &std::fs::read(golden).unwrap());
    }
    let files = assert_round_trip(&sandbox, &ink_package());
    assert!(files.contains(&"ink.bin".to_owned()), "{files:?}");
}

fn ink_package() -> Vec<u8> {
    std::fs::read(workspace().join("formats/tests/golden/v3-ink.pelage")).unwrap()
}

#[test]
fn inspect_prints_ink() {
    let sandbox = sandbox();
    assert_eq!(schema::parse_answer(&sandbox.run(&["inspect", "a.pelage", "--json"]), "inspect")["ink"], Value::Null);
    sandbox.write("ink.pelage", ink_package());
    let ink = schema::parse_answer(&sandbox.run(&["inspect", "ink.pelage", "--json"]), "inspect")["ink"].clone();
    let bytes = ink_package();
    let expected = Package::open(&bytes, &Limits::default()).unwrap().ink().unwrap().unwrap().info;
    assert_eq!(ink["stroke_texture"], expected.stroke_texture);
    assert_eq!(ink["shading"]["wash_speed"].as_f64().unwrap() as f32, expected.shading.wash_speed);
    let text = sandbox.run(&["inspect", "ink.pelage"]).stdout;
    let range = format!(
        "wash: grey {:.2} at the centre, slope {:.2}",
        expected.shading.wash_range, expected.shading.wash_speed
    );
    assert!(text.contains(&range), "{text}");
}

#[test]
fn errors_in_unpacked_ink_name_the_file() {
    let sandbox = Sandbox::new();
    sandbox.write("ink.pelage", ink_package());
    assert_eq!(sandbox.run(&["unpack", "ink.pelage", "folder"]).code, Some(0));
    let mut ink = std::fs::read(sandbox.path().join("folder/ink.bin")).unwrap();
    // The last byte is a reserved byte of a vertex.
    *ink.last_mut().unwrap() = 7;
    sandbox.write("folder/ink.bin", ink);
    let run = sandbox.run(&["pack", "folder", "out.pelage"]);
    assert_eq!(run.code, Some(3), "{run:?}");
    assert!(run.stderr.contains("ink.bin") && run.stderr.contains("reserved"), "{}", run.stderr);
}

#[test]
fn pack_reverses_unpack_for_generated_packages() {
    let sandbox = Sandbox::new();
    for seed in 0..24 {
        assert_round_trip(&sandbox, &random_package(&mut Random(seed)));
    }
}

/// Returns a finite number of random magnitude and sign.
fn float(random: &mut Random) -> f32 {
    loop {
        let value = f32::from_bits(random.next_u64() as u32);
        if value.is_finite() {
            return value;
        }
    }
}

/// Returns a package with random sizes and numbers, in which each optional section may be missing.
fn random_package(random: &mut Random) -> Vec<u8> {
    let vertices = random.below(40);
    let triangles = if vertices == 0 { 0 } else { random.below(60) };
    let skinned = vertices > 0 && random.below(2) == 0;
    let floats3 = |random: &mut Random| [float(random), float(random), float(random)];
    let mut mesh = MeshData::default();
    for _ in 0..vertices {
        mesh.geometry.push(GeometryVertex {
            position: floats3(random),
            fur_height: float(random).abs(),
            normal: floats3(random),
            lean: [0.0, 1.0, 0.1][random.below(3)],
            tangent: [float(random), float(random), float(random), 1.0],
        });
        mesh.attributes.push(AttributeVertex {
            tile_uv: [float(random), float(random)],
            base_uv: [float(random), float(random)],
            color: (random.next_u64() as u32).to_le_bytes(),
            groom: [random.next_u64() as u8, random.next_u64() as u8, 0, 0],
        });
        if skinned {
            mesh.skin.push(SkinVertex { joints: [random.below(2) as u16, 1, 0, 0], weights: [0.75, 0.25, 0.0, 0.0] });
        }
    }
    mesh.indices = (0..triangles * 3).map(|_| random.below(vertices) as u32).collect();
    let split = random.below(triangles + 1) as u32 * 3;
    let parts = vec![
        Part { material: 0, first_index: 0, index_count: split },
        Part { material: 1, first_index: split, index_count: triangles as u32 * 3 - split },
    ];
    let mut animation = sample_animation();
    for node in &mut animation.nodes {
        node.translation = floats3(random);
        node.name = ["", "\u{0}\"\\/\n", "häre 🐇"][random.below(3)].to_owned();
    }
    for value in animation.clips.iter_mut().flat_map(|c| &mut c.channels).flat_map(|c| &mut c.values) {
        *value = float(random);
    }
    let mut manifest = sample_manifest_v1();
    manifest.fur = FurInfo::default();
    let (a, b) = (floats3(random), floats3(random));
    let pick = |f: fn(f32, f32) -> f32| [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2])];
    manifest.bounds =
        Bounds { min: pick(f32::min), max: pick(f32::max), center: floats3(random), radius: float(random).abs() };
    manifest.shading.ambient = floats3(random);
    manifest.recipe = ["", "\u{feff}[hair]\r\n", "\u{0}"][random.below(3)].to_owned();
    manifest.quality[0].value = f64::from_bits(random.next_u64() & !(1 << 62));
    manifest.parts = parts;
    manifest.textures.clear();
    for material in &mut manifest.materials {
        material.base_color_texture = None;
    }
    let mut textures = Vec::new();
    for k in 0..random.below(3) {
        manifest.textures.push(TextureEntry { name: format!("t-{k}") });
        let format = TextureFormat::ALL[random.below(TextureFormat::ALL.len())];
        textures.push(ktx2_file(format, 4 << random.below(3), 8, random.below(4) as u32, 1, random.next_u64() as u8));
    }
    let mut writer = PackageWriter::new(manifest);
    if random.below(2) == 0 {
        writer = writer.section(Tag([0xff, b'/', 0, b'.']), (0..random.below(50) as u8).collect::<Vec<_>>());
    }
    writer = writer.mesh(&mesh);
    for texture in textures {
        writer = writer.texture(texture).section(Tag(*b"more"), Vec::new());
    }
    if skinned || random.below(2) == 0 {
        if !skinned {
            animation.joints.clear();
        }
        writer = writer.animation(&animation);
    }
    writer.finish().unwrap()
}

#[test]
fn the_unpacked_mesh_opens_as_gltf() {
    let sandbox = sandbox();
    assert_eq!(sandbox.run(&["unpack", "a.pelage", "folder"]).code, Some(0));
    // The importer shares no code with the writer, so it is an independent check.
    let options = pelage_import::ImportOptions::default();
    let model = pelage_bake::io::read_model(
        &sandbox.path().join("folder/mesh.glb"),
        &options,
        pelage_bake::io::Reach::OwnFolder,
    )
    .unwrap();
    assert_eq!((model.mesh.triangles.len(), model.mesh.parts.len()), (4, 2));
    assert_eq!(model.mesh.colors[0], [255, 128, 64, 255]);
    assert_eq!(model.materials[1].name, "eyes");
}

#[test]
fn unpack_replaces_only_its_own_folders() {
    let sandbox = sandbox();
    assert_eq!(sandbox.run(&["unpack", "a.pelage", "folder"]).code, Some(0));
    assert_eq!(sandbox.run(&["unpack", "a.pelage", "folder"]).code, Some(0), "a folder of unpack is replaced");
    sandbox.write("folder/notes.txt", "mine");
    let run = sandbox.run(&["unpack", "a.pelage", "folder"]);
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("folder: cannot replace") && run.stderr.contains("--force"), "{run:?}");
    assert_eq!(sandbox.run(&["unpack", "a.pelage", "folder", "--force"]).code, Some(0));
    assert_eq!(std::fs::read(sandbox.path().join("folder/notes.txt")).unwrap(), b"mine");
    let run = sandbox.run(&["pack", "folder", "b.pelage"]);
    assert!(run.code == Some(0) && run.stderr.contains("notes.txt: not packed"), "{run:?}");
    assert_eq!(sandbox.run(&["pack", "folder", "b.pelage", "--quiet"]).stderr, "");
    assert!(!sandbox.files().iter().any(|f| f.contains(".tmp")), "{:?}", sandbox.files());
}

#[test]
fn a_broken_pipe_is_success() {
    let sandbox = sandbox();
    let mut child =
        sandbox.command(&["inspect", "a.pelage"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // The pipe is usually closed before the command writes its first byte. If closing takes longer, the test covers
    // another code path.
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr.len()), (Some(0), 0), "{output:?}");
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_an_error() {
    let sandbox = sandbox();
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = sandbox.command(&["inspect", "a.pelage"]).stdout(full).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("standard output: cannot write"));
}

#[test]
fn short_help_fits_on_a_screen_and_long_help_is_grouped() {
    let sandbox = Sandbox::new();
    for command in ["render", "reference", "bench", "view"] {
        let short = sandbox.run(&[command, "-h"]).stdout;
        assert!(short.lines().count() <= 40 && short.contains("More options with --help"), "{command}: {short}");
    }
    let long = sandbox.run(&["render", "--help"]).stdout;
    let options = long.split("\nOptions:\n").nth(1).unwrap();
    let is_option = |line: &&str| line.starts_with("      --") || line.starts_with("  -");
    let flags: Vec<&str> = options
        .lines()
        .filter(is_option)
        .map(|line| line.split("--").nth(1).unwrap().split(' ').next().unwrap())
        .take(10)
        .collect();
    let common = "output size style orbit camera light environment background clip time";
    assert_eq!(flags.join(" "), common, "{long}");
    for heading in ["Sequences:", "Camera:", "Light:", "Fur:", "Shadows:", "Motion:", "Ink style:"] {
        assert_eq!(long.lines().filter(|line| *line == heading).count(), 1, "{heading}");
    }
}

#[test]
fn help_and_version_succeed() {
    let sandbox = Sandbox::new();
    for args in [&["--help"][..], &["--version"], &["help"], &["inspect", "--help"]] {
        let run = sandbox.run(args);
        assert!(run.code == Some(0) && !run.stdout.is_empty() && run.stderr.is_empty(), "{args:?}: {run:?}");
    }
}
