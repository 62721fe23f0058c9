//! Tests with the real binary: options for build systems, which all commands have: depfiles, records, caches, parts.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_tests::binary::{Run, Sandbox, workspace};
use pelage_tests::gpu::gpu;
use pelage_tests::schema;
use serde_json::Value;
use std::time::{Duration, SystemTime};

/// Bake settings for a fast bake.
pub const SMALL: [&str; 6] =
    ["--set", "slice.tile_texels=32", "--set", "slice.layers=4", "--set", "pack.shell_format=rgba8"];

/// Returns a folder with a model that has an external buffer and image, and with a recipe that names a map.
pub fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path().join("out")).unwrap();
    std::fs::create_dir(sandbox.path().join("other")).unwrap();
    let mut data = Vec::new();
    for corner in [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]] {
        data.extend(corner.iter().flat_map(|x| x.to_le_bytes()));
    }
    for uv in [[0.0_f32, 0.0], [1.0, 0.0], [0.0, 1.0]] {
        data.extend(uv.iter().flat_map(|x| x.to_le_bytes()));
    }
    sandbox.write("models/a mesh.bin", data);
    sandbox.write("models/skin #1.png", png(200));
    sandbox.write("recipes/length.png", png(100));
    sandbox.write("recipes/r.toml", "[hair]\ndensity = 20\nlength_m = 0.1\n[groom]\nlength = \"length.png\"\n");
    sandbox.write(
        "models/m.gltf",
        r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],
        "materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],
        "textures":[{"source":0}],"images":[{"uri":"skin%20%231.png"}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,-1],"max":[1,0,0]},
        {"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}],
        "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24}],
        "buffers":[{"uri":"a%20mesh.bin","byteLength":60}]}"#,
    );
    sandbox
}

fn png(grey: u8) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::GrayImage::from_pixel(4, 4, image::Luma([grey])).write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn bake(sandbox: &Sandbox, more: &[&str]) -> Run {
    let args = ["bake", "models/m.gltf", "--recipe", "recipes/r.toml"];
    sandbox.run(&[&args[..], &SMALL[..], more].concat())
}

#[track_caller]
fn json(sandbox: &Sandbox, name: &str) -> Value {
    serde_json::from_slice(&sandbox.read(name)).unwrap()
}

#[track_caller]
fn record(sandbox: &Sandbox, name: &str) -> Value {
    let record = json(sandbox, name);
    schema::assert_valid("record", &record);
    record
}

fn time(sandbox: &Sandbox, name: &str) -> SystemTime {
    std::fs::metadata(sandbox.path().join(name)).unwrap().modified().unwrap()
}

#[test]
fn depfile_names_every_file_read() {
    let sandbox = sandbox();
    let run = bake(&sandbox, &["-o", "out/m.pelage", "--depfile", "out/m.d"]);
    assert_eq!(run.code, Some(0), "{run:?}");
    let text = String::from_utf8(sandbox.read("out/m.d")).unwrap();
    let rule = text.split("\n\n").next().unwrap();
    let expected = concat!(
        "out/m.pelage: \\\n",
        "  recipes/r.toml \\\n",
        "  recipes/length.png \\\n",
        "  models/m.gltf \\\n",
        "  models/a\\ mesh.bin \\\n",
        "  models/skin\\ \\#1.png"
    );
    assert_eq!(rule.trim_end(), expected);
    // With an empty rule, a deleted file is not an error in Make.
    assert!(text.contains("\nrecipes/length.png:\n"), "{text}");
    // If the command has no output file, the target of the rule is the record. Without a record, the target is the
    // depfile itself.
    for (more, target) in [(&["--record", "out/i.json"][..], "out/i.json"), (&[], "out/i.d")] {
        let run = sandbox.run(&[&["inspect", "out/m.pelage", "--depfile", "out/i.d"], more].concat());
        assert_eq!(run.code, Some(0), "{run:?}");
        let text = String::from_utf8(sandbox.read("out/i.d")).unwrap();
        assert!(text.starts_with(&format!("{target}: \\\n  out/m.pelage\n")), "{text}");
    }
}

#[test]
fn unchanged_outputs_keep_their_modification_time() {
    let sandbox = sandbox();
    assert_eq!(bake(&sandbox, &["-o", "out/m.pelage"]).code, Some(0));
    let long_ago = SystemTime::now() - Duration::from_secs(3600);
    let file = std::fs::File::options().append(true).open(sandbox.path().join("out/m.pelage")).unwrap();
    file.set_modified(long_ago).unwrap();
    drop(file);
    assert_eq!(bake(&sandbox, &["-o", "out/m.pelage"]).code, Some(0));
    assert_eq!(time(&sandbox, "out/m.pelage"), long_ago);
    assert_eq!(bake(&sandbox, &["-o", "out/m.pelage", "--set", "hair.lean=0.2"]).code, Some(0));
    assert!(time(&sandbox, "out/m.pelage") > long_ago);
    assert_eq!(sandbox.files().iter().filter(|name| name.contains(".pelage-")).count(), 0);
}

#[test]
fn record_states_the_outcome_of_a_command() {
    let sandbox = sandbox();
    assert_eq!(bake(&sandbox, &["-o", "out/m.pelage", "--record", "out/m.json"]).code, Some(0));
    let whole = record(&sandbox, "out/m.json");
    assert_eq!((&whole["exit_code"], &whole["error"], &whole["cached"]), (&0.into(), &Value::Null, &false.into()));
    assert_eq!(whole["result"]["output"], "out/m.pelage");
    assert!(whole["seconds"].as_f64().unwrap() > 0.0);
    assert!(!cfg!(target_os = "linux") || whole["peak_bytes"].as_u64().unwrap() > 1 << 20);
    sandbox.write("models/m.gltf", "no model");
    let run = bake(&sandbox, &["-o", "out/m.pelage", "--record", "out/m.json"]);
    assert_eq!(run.code, Some(3));
    let failed = record(&sandbox, "out/m.json");
    assert_eq!(failed["exit_code"], 3);
    assert!(failed["error"].as_str().unwrap().contains("models/m.gltf"), "{failed}");
    // A record must also be written for an invalid command line, wherever its option is.
    for args in [["--record", "out/r.json", "--odd"], ["--odd", "--record=out/r.json", "--quiet"]] {
        let run = bake(&sandbox, &args);
        assert_eq!(run.code, Some(1), "{run:?}");
        let refused = record(&sandbox, "out/r.json");
        assert_eq!(refused["exit_code"], 1);
        assert!(refused["error"].as_str().unwrap().contains("'--odd'"), "{refused}");
        std::fs::remove_file(sandbox.path().join("out/r.json")).unwrap();
    }
    let run = bake(&sandbox, &["--odd", "--record", "none/r.json"]);
    assert!(run.code == Some(1) && run.stderr.contains("none: cannot create a file in"), "{run:?}");
}

#[test]
fn cached_results_are_reused() {
    let sandbox = sandbox();
    let bake = |out: &str, more: &[&str]| {
        let (package, record_file) = (format!("{out}/m.pelage"), format!("{out}/m.json"));
        let args = ["-o", &package, "--record", &record_file, "--cache", "cache", "--json"];
        let run = bake(&sandbox, &[&args[..], more].concat());
        assert_eq!(run.code, Some(0), "{run:?}");
        let said = schema::parse_answer(&run, "bake");
        assert_eq!(said["output"], package.as_str(), "the result must have the current names");
        (record(&sandbox, &record_file)["cached"].as_bool().unwrap(), sandbox.read(&package))
    };
    let (cached, first) = bake("out", &[]);
    assert!(!cached);
    let (cached, again) = bake("other", &["--threads", "1"]);
    assert!(cached && again == first, "threads and folders must not change the result");
    // A changed argument, image of the model or map of the recipe must give another package. If the inputs are
    // restored, the earlier package must be restored too.
    assert!(!bake("out", &["--set", "hair.lean=0.2"]).0);
    for (file, grey) in [("models/skin #1.png", 200), ("recipes/length.png", 100)] {
        sandbox.write(file, png(50));
        let (cached, other) = bake("out", &[]);
        assert!(!cached && other != first, "{file}");
        sandbox.write(file, png(grey));
        let (cached, again) = bake("out", &[]);
        assert!(cached && again == first, "{file}");
    }
    // Damaged cache entries must be replaced. On a cache hit, the depfile must be written as well.
    let mut files = Vec::new();
    pelage_tests::binary::walk(&sandbox.path().join("cache/v1/files"), &mut files);
    files.iter().for_each(|file| std::fs::write(file, "damaged").unwrap());
    let (cached, again) = bake("out", &[]);
    assert!(!cached && again == first);
    pelage_tests::binary::walk(&sandbox.path().join("cache/v1/states"), &mut files);
    files.iter().for_each(|file| std::fs::remove_file(file).unwrap());
    assert!(!bake("out", &[]).0);
    let (cached, _) = bake("out", &["--depfile", "out/m.d"]);
    assert!(cached);
    assert!(String::from_utf8(sandbox.read("out/m.d")).unwrap().contains("models/skin\\ \\#1.png"));
}

#[test]
fn unwritable_cache_is_only_a_note() {
    let sandbox = sandbox();
    sandbox.write("cache", "a file");
    let run = bake(&sandbox, &["-o", "out/m.pelage", "--cache", "cache"]);
    assert_eq!(run.code, Some(0), "{run:?}");
    assert!(run.stderr.contains("note: --cache: ") && run.stderr.contains("the result is not cached"), "{run:?}");
}

#[test]
fn pictures_and_comparisons_are_cached() {
    let Some(_) = gpu("pictures_and_comparisons_are_cached") else { return };
    let sandbox = sandbox();
    assert_eq!(bake(&sandbox, &["-o", "m.pelage"]).code, Some(0));
    sandbox.write("look.toml", "[light]\nstrength = 1.5\n");
    let run = |out: &str, args: &[&str], code: i32| {
        let record_file = format!("{out}/record.json");
        let args = [args, &["--record", &record_file, "--cache", "cache", "--quiet"]].concat();
        let run = sandbox.run(&args);
        assert_eq!(run.code, Some(code), "{args:?}: {run:?}");
        record(&sandbox, &record_file)["cached"].as_bool().unwrap()
    };
    let render = |out: &str| {
        let file = format!("{out}/p.png");
        run(out, &["render", "m.pelage", "-o", &file, "--size", "32x32", "--look", "look.toml"], 0)
    };
    assert_eq!([render("out"), render("other")], [false, true]);
    assert_eq!(sandbox.read("out/p.png"), sandbox.read("other/p.png"));
    sandbox.write("look.toml", "[light]\nstrength = 0.5\n");
    assert!(!render("other"), "a changed look must give a new picture");
    let compare = |out: &str| run(out, &["compare", "out/p.png", "other/p.png", "--max-rmse", "0"], 7);
    assert_eq!([compare("out"), compare("other")], [false, true], "a found difference must be cached");
    let sequence = |out: &str, frames: &str| {
        let file = format!("{out}/%02d.png");
        run(out, &["render", "m.pelage", "-o", &file, "--size", "32x32", "--auto-rotate", "--frames", frames], 0)
    };
    assert_eq!(
        [sequence("out", "0..2/4"), sequence("other", "0..2/4"), sequence("other", "2..4/4")],
        [false, true, false]
    );
    assert_eq!(sandbox.read("out/01.png"), sandbox.read("other/01.png"));
    // Pictures rendered in ranges must be the same as those of the whole sequence.
    assert!(!sequence("out", "4"));
    for picture in ["00.png", "01.png", "02.png", "03.png"] {
        let (whole, range) = (sandbox.read(&format!("out/{picture}")), sandbox.read(&format!("other/{picture}")));
        assert_eq!(whole, range, "{picture}");
    }
    let refused = sandbox.run(&["render", "m.pelage", "-o", "%d.png", "--auto-rotate", "--frames", "0..2"]);
    assert!(refused.code == Some(1) && refused.stderr.contains("expected --frames A..B/N"), "{refused:?}");
}

#[test]
fn reference_parts_add_up_to_the_whole() {
    let sandbox = sandbox();
    assert_eq!(bake(&sandbox, &["-o", "m.pelage"]).code, Some(0));
    let view = ["--size", "50x40", "--samples", "3"];
    let trace = |out: &str, more: &[&str]| {
        let run = sandbox.run(&[&["reference", "m.pelage", "-o", out, "--quiet"], &view[..], more].concat());
        assert_eq!(run.code, Some(0), "{run:?}");
    };
    let merge = |args: &[&str]| sandbox.run(&[&["merge", "--json"], args].concat());
    let all = ["3.part", "1.part", "2.part"];
    for more in [&[][..], &["--background", "10,20,30"][..]] {
        for part in ["1", "2", "3"] {
            trace(&format!("{part}.part"), &[&["--part", &format!("{part}/3")], more].concat());
        }
        trace("whole.png", more);
        let run = merge(&[&all[..], &["-o", "merged.png"]].concat());
        assert_eq!(run.code, Some(0), "{run:?}");
        let said = schema::parse_answer(&run, "merge");
        assert_eq!((&said["parts"], &said["primary_rays"]), (&3.into(), &(50 * 40 * 3).into()));
        assert_eq!(sandbox.read("merged.png"), sandbox.read("whole.png"), "{more:?}");
        let exr = merge(&[&all[..], &["-o", "merged.exr"]].concat());
        if more.is_empty() {
            trace("whole.exr", more);
            assert_eq!((exr.code, sandbox.read("merged.exr")), (Some(0), sandbox.read("whole.exr")));
        } else {
            assert!(exr.code == Some(3) && exr.stderr.contains("3.part: line 2: has a background"), "{exr:?}");
        }
    }
    for (args, code, word) in [
        (&["1.part", "2.part", "-o", "m.png"][..], 1, "parts 3 of 3 are missing"),
        (&["1.part", "2.part", "1.part", "-o", "m.png"], 3, "is part 1 of 3, the same as 1.part"),
        (&["whole.png", "-o", "m.png"], 3, "whole.png: byte 0: is not a part of a picture"),
        (&["none.part", "-o", "m.png"], 2, "none.part"),
        (&["1.part", "-o", "m.jpg"], 1, "expected a name that ends in .png or .exr"),
    ] {
        let run = merge(args);
        assert!(run.code == Some(code) && run.stderr.contains(word), "{args:?}: {run:?}");
    }
    trace("3.part", &["--part", "3/3", "--style", "bare"]);
    let run = merge(&[&all[..], &["-o", "m.png"]].concat());
    assert!(run.code == Some(3) && run.stderr.contains("of picture"), "parts of another picture: {run:?}");
    let run = sandbox.run(&["reference", "m.pelage", "-o", "a.png", "--part", "1/3"]);
    assert!(run.code == Some(1) && run.stderr.contains("ends in .part"), "{run:?}");
    assert!(!sandbox.path().join("m.png").exists());
}

#[test]
fn chart_rows_can_be_split_between_runs() {
    let sandbox = sandbox().with_lab();
    let model = workspace().join("assets/models/torus.glb");
    let chart = |args: &[&str]| {
        let run = sandbox.run(&[&["chart", "surface", model.to_str().unwrap(), "--json"], args].concat());
        assert_eq!(run.code, Some(0), "{run:?}");
        schema::parse_answer(&run, "chart")
    };
    let rows = chart(&["--rows", "1/4", "--part", "-o", "a"])["measured"].as_array().unwrap().len();
    chart(&["--rows", "2/4,3/4,4/4", "--part", "-o", "b"]);
    assert!(!sandbox.path().join("a/surface.csv").exists());
    let from = ["--from", "a/surface.rows.jsonl", "--from", "b/surface.rows.jsonl", "-o", "all"];
    let run = sandbox.run(&[&["chart", "surface", model.to_str().unwrap()], &from[..]].concat());
    let all = chart(&from)["rows"].as_array().unwrap().len();
    assert!(run.stderr.contains(&format!("{all} of {all} rows exist")), "{run:?}");
    assert!(rows > 1 && all > 3 * rows && sandbox.path().join("all/surface.svg").exists());
    assert!(sandbox.path().join("a/surface.rows.jsonl").exists(), "rows measured elsewhere must be kept");
}
