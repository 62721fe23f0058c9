//! Tests of `bake`, `render` and `bench` with the real binary: bad models and recipes, all difficult glTF files of the
//! test data, missing adapters.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_needs::data;
use pelage_tests::binary::{Run, Sandbox, run_to_end, walk, workspace};
use pelage_tests::schema;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Bake settings for the smallest package; these tests do not depend on texture sizes.
const SMALL: [&str; 6] = ["--set", "slice.tile_texels=16", "--set", "slice.layers=4", "--set", "hair.density=20"];

fn bake(sandbox: &Sandbox, model: &str, more: &[&str]) -> Run {
    sandbox.run(&[&["bake", model, "-o", "out.pelage"][..], &SMALL, more].concat())
}

/// Runs the binary. Asserts the exit code, that stderr contains `words`, and that the list of files is unchanged.
#[track_caller]
fn assert_refused(sandbox: &Sandbox, args: &[&str], code: i32, words: &[&str]) {
    let before = sandbox.files();
    let run = sandbox.run(args);
    println!("{code}  {}", run.stderr.trim());
    assert_eq!(run.code, Some(code), "{args:?}: {run:?}");
    for word in words {
        assert!(run.stderr.contains(word), "{args:?}: no {word:?} in {}", run.stderr);
    }
    assert_eq!(sandbox.files(), before, "{args:?} left something behind");
}

/// Returns a triangle with texture coordinates and without normals, whose data is in `triangle.bin`.
fn triangle() -> Value {
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "indices": 2 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2" },
            { "bufferView": 2, "componentType": 5125, "count": 3, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 24 },
            { "buffer": 0, "byteOffset": 60, "byteLength": 12 },
        ],
        "buffers": [{ "uri": "triangle.bin", "byteLength": 72 }],
    })
}

fn triangle_bin() -> Vec<u8> {
    let floats: [f32; 15] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0];
    let indices: [u32; 3] = [0, 1, 2];
    floats.iter().flat_map(|f| f.to_le_bytes()).chain(indices.iter().flat_map(|i| i.to_le_bytes())).collect()
}

fn glb(version: u32, length: u32) -> Vec<u8> {
    [&b"glTF"[..], &version.to_le_bytes(), &length.to_le_bytes(), &length.to_le_bytes(), b"JSON"].concat()
}

#[test]
fn valid_triangle_bakes() {
    // This input is valid. Each bad input in the other tests differs from it in one item.
    let sandbox = Sandbox::new();
    sandbox.write("a.gltf", triangle().to_string());
    sandbox.write("triangle.bin", triangle_bin());
    let object = schema::parse_success(&bake(&sandbox, "a.gltf", &["--json"]), "bake");
    assert_eq!(object["output"], "out.pelage");
    assert_eq!(object["bytes"], std::fs::metadata(sandbox.path().join("out.pelage")).unwrap().len());
    assert_eq!(sandbox.files(), ["a.gltf", "out.pelage", "triangle.bin"]);
    assert_eq!(sandbox.run(&["validate", "out.pelage"]).code, Some(0));
}

#[test]
fn bad_models_are_refused() {
    type Spoil = fn(&mut Value, &mut Vec<u8>);
    let cases: &[(Spoil, &[&str])] = &[
        (|_, b| b[0..4].copy_from_slice(&f32::NAN.to_le_bytes()), &["a.gltf", "NaN"]),
        (|_, b| b[60..64].copy_from_slice(&3u32.to_le_bytes()), &["a.gltf", "/meshes/0/primitives/0", "3"]),
        (|_, b| b.truncate(50), &["a.gltf", "/buffers/0", "50", "72"]),
        (|g, _| g["buffers"][0]["uri"] = json!("gone.bin"), &["/buffers/0", "gone.bin"]),
        (|g, _| g["buffers"][0]["uri"] = json!("../triangle.bin"), &["triangle.bin"]),
        (
            |g, _| g["extensionsRequired"] = json!(["KHR_meshopt_compression"]),
            &["KHR_meshopt_compression", "gltf-transform"],
        ),
        (|g, _| g["extensionsRequired"] = json!(["EXT_no_such_thing"]), &["EXT_no_such_thing"]),
        (
            |g, _| g["accessors"][0]["count"] = json!(4_294_967_295u32),
            &["/meshes/0/primitives/0", "4294967295 vertices"],
        ),
        (|g, _| g["buffers"][0]["byteLength"] = json!(4_294_967_296u64), &["/buffers/0", "72", "4294967296"]),
        (|g, _| g["accessors"][0]["bufferView"] = json!(9), &["/accessors/0/bufferView", "9"]),
        (|g, _| g["nodes"][0]["children"] = json!([0]), &["/nodes/0"]),
        (|g, _| g["asset"]["version"] = json!("1.0"), &["/asset", "1.0"]),
        (|g, _| g["meshes"] = json!([]), &["a.gltf"]),
    ];
    for (spoil, words) in cases {
        let sandbox = Sandbox::new();
        let (mut document, mut bytes) = (triangle(), triangle_bin());
        spoil(&mut document, &mut bytes);
        sandbox.write("a.gltf", document.to_string());
        sandbox.write("triangle.bin", bytes);
        assert_refused(&sandbox, &[&["bake", "a.gltf", "-o", "out.pelage"][..], &SMALL].concat(), 3, words);
    }

    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path().join("folder.glb")).unwrap();
    sandbox.write("empty.glb", "");
    sandbox.write("text.gltf", "{ \"asset\": ");
    sandbox.write("other.png", b"\x89PNG\r\n\x1a\n");
    sandbox.write("long.glb", glb(2, u32::MAX));
    sandbox.write("old.glb", glb(1, 20));
    let torus = std::fs::read(workspace().join("assets/models/torus.glb")).unwrap();
    sandbox.write("cut.glb", &torus[..torus.len() / 2]);
    sandbox.write("good.glb", &torus);
    for (model, code, words) in [
        ("missing.glb", 2, &["missing.glb: cannot read"][..]),
        ("folder.glb", 2, &["folder.glb: cannot read", "folder"]),
        ("empty.glb", 3, &["empty.glb", "empty"]),
        ("text.gltf", 3, &["text.gltf", "line 1"]),
        ("other.png", 3, &["other.png"]),
        ("long.glb", 3, &["long.glb: byte 8", "4294967295"]),
        ("old.glb", 3, &["old.glb: byte 4", "1"]),
        ("cut.glb", 3, &["cut.glb: byte 8"]),
    ] {
        assert_refused(&sandbox, &["bake", model, "-o", "out.pelage"], code, words);
    }
    assert_refused(
        &sandbox,
        &["bake", "good.glb", "-o", "no/out.pelage"],
        2,
        &["no: cannot write into", "create it first"],
    );
    assert_refused(&sandbox, &["bake", "good.glb", "-o", "folder.glb"], 2, &["folder.glb: cannot write", "folder"]);
    assert_refused(&sandbox, &["bake", "good.glb"], 1, &["--output"]);
    assert_refused(&sandbox, &["bake", "good.glb", "-o", "out.pelage", "--threads", "0"], 1, &["--threads"]);
}

#[test]
fn texture_coordinates_are_required_only_where_they_are_used() {
    let sandbox = Sandbox::new();
    let mut document = triangle();
    document["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
    sandbox.write("a.gltf", document.to_string());
    sandbox.write("triangle.bin", triangle_bin());
    for set in ["surface.source=model", "surface.comb=tangents"] {
        let args = [&["bake", "a.gltf", "-o", "out.pelage", "--set", set][..], &SMALL].concat();
        assert_refused(&sandbox, &args, 3, &["a.gltf: mesh 0", "no texture coordinates", "surface."]);
    }
    assert_eq!(bake(&sandbox, "a.gltf", &[]).code, Some(0), "patches need none");
}

#[test]
fn bad_recipes_are_refused() {
    let sandbox = Sandbox::new();
    sandbox.write("good.glb", std::fs::read(workspace().join("assets/models/torus.glb")).unwrap());
    std::fs::create_dir(sandbox.path().join("folder.toml")).unwrap();
    for (text, words) in [
        ("[hair]\ndensty = 5\n", &["r.toml: line 2, hair.densty", "hair.density"][..]),
        ("[hiar]\n", &["r.toml: line 1", "hair"]),
        ("[hair]\n\ndensity = 5 6\n", &["r.toml: line 3"]),
        ("[hair]\ndensity = \"many\"\n", &["line 2, hair.density", "\"many\""]),
        ("[slice]\nlayers = 0\n", &["line 2, slice.layers", "found 0", "4..=256"]),
        ("[slice]\ntile_texels = 100\n", &["line 2, slice.tile_texels", "100"]),
        ("[hair]\nlean = nan\n", &["line 2, hair.lean", "NaN"]),
        ("[hair]\nlength_m = -1.0\n", &["line 2, hair.length_m", "-1"]),
    ] {
        sandbox.write("r.toml", text);
        assert_refused(&sandbox, &["bake", "good.glb", "-o", "out.pelage", "--recipe", "r.toml"], 3, words);
    }
    sandbox.write("r.toml", b"\xff");
    assert_refused(
        &sandbox,
        &["bake", "good.glb", "-o", "out.pelage", "--recipe", "r.toml"],
        3,
        &["r.toml: byte 0", "UTF-8"],
    );
    assert_refused(
        &sandbox,
        &["bake", "good.glb", "-o", "o.pelage", "--recipe", "no.toml"],
        2,
        &["no.toml: cannot read"],
    );
    assert_refused(&sandbox, &["bake", "good.glb", "-o", "o.pelage", "--recipe", "folder.toml"], 2, &["folder.toml"]);
    for (set, words) in [
        ("slice.layers=0", &["slice.layers", "found 0"][..]),
        ("slice.layer=8", &["slice.layer", "did you mean slice.layers"]),
        ("layers", &["key=value"]),
    ] {
        assert_refused(&sandbox, &["bake", "good.glb", "-o", "out.pelage", "--set", set], 3, words);
    }
}

#[test]
fn bad_render_and_bench_requests_are_refused() {
    let sandbox = Sandbox::new();
    sandbox.write("good.glb", std::fs::read(workspace().join("assets/models/torus.glb")).unwrap());
    assert_eq!(bake(&sandbox, "good.glb", &["--set", "ink.enabled=false"]).code, Some(0));
    std::fs::rename(sandbox.path().join("out.pelage"), sandbox.path().join("plain.pelage")).unwrap();
    assert_eq!(bake(&sandbox, "good.glb", &[]).code, Some(0));
    sandbox.write("cut.pelage", &std::fs::read(sandbox.path().join("out.pelage")).unwrap()[..100]);
    for (args, code, words) in [
        (&["render", "out.pelage", "-o", "a.png", "--size", "0x0"][..], 1, &["--size", "0x0", "1 to 8192"][..]),
        (&["bench", "out.pelage", "--size", "0x0"], 1, &["--size", "0x0"]),
        (&["render", "out.pelage", "-o", "a.png", "--layers", "0"], 1, &["--layers"]),
        (&["render", "plain.pelage", "-o", "a.png", "--style", "ink"], 3, &["plain.pelage", "INKW", "ink.enabled"]),
        (&["bench", "out.pelage", "--style", "ink", "--ink-width", "9"], 1, &["--ink-width", "7px", "0.01m"]),
        (&["render", "out.pelage", "-o", "no/a.png"], 2, &["no: cannot write into"]),
        (&["render", "no.pelage", "-o", "a.png"], 2, &["no.pelage: cannot read"]),
        (&["render", "cut.pelage", "-o", "a.png"], 3, &["cut.pelage", "cut short"]),
        (&["bench", "cut.pelage"], 3, &["cut.pelage", "cut short"]),
        (&["render", "out.pelage", "-o", "a.png", "--clip", "Walk"], 1, &["Walk"]),
    ] {
        assert_refused(&sandbox, args, code, words);
    }
    // An empty driver list simulates a machine without a graphics driver.
    for args in [&["render", "out.pelage", "-o", "a.png"][..], &["bench", "out.pelage"], &["demo", "-o", "pictures"]] {
        let before = sandbox.files();
        let mut command = sandbox.command(args);
        for key in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
            command.env(key, "/nonexistent/icd.json");
        }
        command.env_remove("VK_ADD_DRIVER_FILES");
        let run = run_to_end(command);
        assert_eq!(run.code, Some(4), "{args:?}: {run:?}");
        for word in ["no usable graphics adapter", "mesa-vulkan-drivers"] {
            assert!(run.stderr.contains(word), "{args:?}: {run:?}");
        }
        assert_eq!(sandbox.files(), before, "{args:?} left something behind");
    }
    let run = sandbox.run(&["render", "out.pelage", "-o", "a.png", "--size", "48x32", "--json"]);
    let object = schema::parse_success(&run, "render");
    assert!(object["covered_pixels"].as_u64().is_some_and(|n| n > 50), "{object}");
    let picture = image::open(sandbox.path().join("a.png")).unwrap();
    assert_eq!((picture.width(), picture.height()), (48, 32));
    schema::parse_success(
        &sandbox.run(&["bench", "out.pelage", "--size", "48x32", "--frames", "2", "--json"]),
        "bench",
    );

    let strokes =
        ["painting_depth", "painting_strokes", "painting_ribbons", "painting_wet", "ink_contours", "ink_lines"];
    let ran = |object: &Value| {
        let passes = object["passes"].as_array().unwrap().clone();
        passes.into_iter().filter(|p| p["ran"] == true).map(|p| p["name"].clone()).collect::<Vec<_>>()
    };
    let ink = ["--style", "ink", "--size", "48x32", "--json"];
    let run = sandbox.run(&[&["render", "out.pelage", "-o", "ink.png"][..], &ink].concat());
    let object = schema::parse_success(&run, "render");
    assert_eq!(object["covered_pixels"], 48 * 32, "paper must cover the whole picture: {object}");
    assert_eq!(ran(&object), [&strokes[..], &["painting_sheet"]].concat(), "{object}");
    let ink = [&ink[..], &["--ink-lines", "pixels"]].concat();
    let run = sandbox.run(&[&["render", "out.pelage", "-o", "lines.png"][..], &ink].concat());
    let object = schema::parse_success(&run, "render");
    let passes = ["ink_normals", "ink_features", "ink_trace", "ink_dilate", "ink_stroke", "ink_composite", "ink_fur"]
        .map(Value::from);
    assert_eq!(ran(&object), passes, "{object}");
    // No recipe says that the model is furred, so it has no fur strokes.
    let small = ["--set", "slice.tile_texels=16", "--set", "slice.layers=4"];
    let run = sandbox.run(&[&["bake", "good.glb", "-o", "stone.pelage"][..], &small].concat());
    assert_eq!(run.code, Some(0), "{run:?}");
    let run = sandbox.run(&[&["render", "stone.pelage", "-o", "stone.png"][..], &ink].concat());
    assert_eq!(ran(&schema::parse_success(&run, "render")), passes[..6], "{run:?}");
    let bench = |size: &str, lines: &str| {
        let of_ink = ["--style", "ink", "--ink-lines", lines, "--size", size, "--json"];
        let args = [&["bench", "out.pelage", "--frames", "2"][..], &of_ink].concat();
        schema::parse_success(&sandbox.run(&args), "bench")
    };
    let (small, large) = (bench("48x32", "pixels"), bench("96x64", "pixels"));
    let names = small["passes"].as_array().unwrap().iter().map(|p| p["name"].clone()).collect::<Vec<_>>();
    // The benchmark poses the model in every frame, and fur motion follows the posed surface. It lists all passes of
    // the style, also those of painted strokes.
    let before = [&["pose", "fur_motion"].map(Value::from)[..], &passes[..5], &strokes.map(Value::from)].concat();
    assert_eq!(names, [&before[..], &passes[5..], &[Value::from("painting_sheet"), Value::from("ink_seal")]].concat());
    let bytes = |object: &Value| object["gpu_bytes"].as_u64().unwrap();
    // The sum lists the bytes per pixel of normals, surface, features, line features, rows, strokes and depth.
    assert_eq!(bytes(&large) - bytes(&small), 3 * 48 * 32 * (8 + 4 + 4 + 4 + 4 + 4 + 4));
    // Washes, ink, pigments and depth; wet washes and rows at a quarter of the width and height.
    let [small, large] = ["48x32", "96x64"].map(|size| bytes(&bench(size, "strokes")));
    assert_eq!(large - small, 3 * (48 * 32 * (8 + 8 + 4 + 4) + 12 * 8 * (8 + 8)));
}

/// Bakes all models in one sandbox on several threads. Each bake must leave a complete package or nothing.
fn bake_all(models: &[PathBuf], more: &[&str]) -> BTreeMap<PathBuf, Run> {
    let (next, results) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(2, std::num::NonZero::get) {
            scope.spawn(|| {
                let sandbox = Sandbox::new();
                while let Some(model) = models.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let run = bake(&sandbox, model.to_str().unwrap(), &[&["--threads", "1", "--quiet"], more].concat());
                    let written = sandbox.files();
                    let expected = if run.code == Some(0) { vec!["out.pelage".to_owned()] } else { Vec::new() };
                    assert_eq!(written, expected, "{}: {run:?}", model.display());
                    for file in &written {
                        std::fs::remove_file(sandbox.path().join(file)).unwrap();
                    }
                    results.lock().unwrap_or_else(PoisonError::into_inner).insert(model.clone(), run);
                }
            });
        }
    });
    let results = results.into_inner().unwrap();
    assert_eq!(results.len(), models.len());
    results
}

#[test]
fn hard_gltf_files_never_crash_the_tool() {
    let Some(data) = data("hard_gltf_files_never_crash_the_tool") else { return };
    let mut models = Vec::new();
    for folder in ["hard-gltf", "gltf-validator", "gltf-asset-generator"] {
        walk(&data.join("meshes").join(folder), &mut models);
    }
    // Other files of the folder (buffers, images, notes) are bad input, and are baked as well.
    assert!(models.len() > 150, "only {} files found", models.len());
    let results = bake_all(&models, &["--set", "ink.enabled=false", "--set", "slice.layers=4"]);
    let mut wrong = Vec::new();
    let mut counts = BTreeMap::new();
    for (model, run) in &results {
        let name = model.strip_prefix(&data).unwrap().display().to_string();
        let message = run.stderr.trim().replace(&*data.to_string_lossy(), "");
        println!("{:?}  {name}  {message}", run.code);
        *counts.entry(run.code).or_insert(0) += 1;
        let says_where = run.code == Some(0) || run.stderr.starts_with("error: ");
        if !matches!(run.code, Some(0 | 3)) || !says_where {
            wrong.push(format!("{name}: {run:?}"));
        }
    }
    println!("exit codes: {counts:?}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    // Many files of the test data have no triangles or are broken on purpose, and must be rejected.
    assert!(counts.get(&Some(0)).is_some_and(|n| *n >= 8), "the good models must bake: {counts:?}");
}

/// OBJ files that must be rejected, and part of the reason. All others can be baked.
const REFUSED_OBJ: &[(&str, &str)] = &[
    ("assimp_malformed", "line 28: `f` has `0`"),
    ("assimp_number_formats", "line 11: `v` has `3.1+e2`, expected a number"),
    ("assimp_point_cloud", "no faces, expected at least one"),
    ("draco_inf_nan", "line 1: `v` has `inf`"),
    ("draco_test_lines", "no faces, expected at least one"),
    ("trimesh_empty", "no faces, expected at least one"),
    ("trimesh_obj_wireframe", "no faces, expected at least one"),
];

#[test]
fn every_obj_file_bakes_or_is_refused() {
    let Some(data) = data("every_obj_file_bakes_or_is_refused") else { return };
    let mut models = Vec::new();
    for folder in ["static", "hard-obj"] {
        walk(&data.join("meshes").join(folder), &mut models);
    }
    models.retain(|m| m.extension().is_some_and(|e| e == "obj"));
    assert!(models.len() >= 46, "only {} files found", models.len());
    // Ink textures are disabled: they do not depend on the model and take two seconds each. Shadows of the body on
    // itself are disabled too.
    for (model, run) in bake_all(&models, &["--set", "ink.enabled=false", "--set", "visibility.enabled=false"]) {
        let name = model.file_stem().unwrap().to_str().unwrap();
        match REFUSED_OBJ.iter().find(|(file, _)| *file == name) {
            Some((_, words)) => {
                assert_eq!(run.code, Some(3), "{name}: {run:?}");
                let right = run.stderr.starts_with("error: ") && run.stderr.contains(words);
                assert!(right && run.stderr.contains(&*model.to_string_lossy()), "{name}: {run:?}");
            }
            None => assert_eq!(run.code, Some(0), "{name}: {run:?}"),
        }
    }
}

#[test]
fn obj_with_materials_bakes() {
    let sandbox = Sandbox::new();
    sandbox.write("a.png", {
        let mut png = std::io::Cursor::new(Vec::new());
        image::RgbImage::new(4, 4).write_to(&mut png, image::ImageFormat::Png).unwrap();
        png.into_inner()
    });
    sandbox.write("a.mtl", "newmtl coat\nmap_Kd a.png\n");
    let text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
        usemtl coat\nf 1/1 2/2 3/3 4/4\n";
    sandbox.write("a.obj", text);
    // The contents of a file determine its format, whatever its name is.
    sandbox.write("a.gltf", text);
    // With fewer layers, a warning says that they are far apart.
    let object = schema::parse_success(&bake(&sandbox, "a.obj", &["--json", "--set", "slice.layers=24"]), "bake");
    assert_eq!(object["warnings"], json!([]));
    assert_eq!(sandbox.run(&["validate", "out.pelage"]).code, Some(0));
    assert_eq!(sandbox.run(&["unpack", "out.pelage", "in"]).code, Some(0));
    let manifest: Value =
        serde_json::from_slice(&std::fs::read(sandbox.path().join("in/manifest.json")).unwrap()).unwrap();
    let inputs = manifest["manifest"]["inputs"].as_array().unwrap();
    let found: Vec<_> = inputs.iter().map(|i| (i["role"].as_str().unwrap(), i["name"].as_str().unwrap())).collect();
    assert_eq!(found, [("model", "a.obj"), ("material", "a.mtl"), ("image", "a.png")]);
    assert_eq!(bake(&sandbox, "a.gltf", &[]).code, Some(0));
    sandbox.write("b.obj", text.replace("f 1/1", "f 9/1"));
    std::fs::remove_file(sandbox.path().join("out.pelage")).unwrap();
    assert_refused(
        &sandbox,
        &["bake", "b.obj", "-o", "out.pelage"],
        3,
        &["b.obj: line 11", "vertex 9, expected 1..=4"],
    );
}
