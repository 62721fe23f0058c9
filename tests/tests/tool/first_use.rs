//! Tests of problems of first-time users, and how pelage handles them: models of impossible sizes, edits with
//! unexpected results.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_tests::binary::{Run, Sandbox, workspace};
use serde_json::Value;
use std::io::{BufRead as _, BufReader};
use std::process::Stdio;

const HARE: &str = "assets/models/hare.glb";
/// OBJ square of one metre, made of two triangles; some tests add a third.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
/// Bake settings for the fastest bake.
const QUICK: [&str; 6] = ["--set", "slice.layers=4", "--set", "slice.tile_texels=16", "--set", "ink.enabled=false"];

fn bake(sandbox: &Sandbox, model: &str, more: &[&str]) -> Run {
    sandbox.run(&[&["bake", model, "-o", "out.pelage", "--json"], &QUICK[..], more].concat())
}

fn warnings(run: &Run) -> Vec<String> {
    let object: Value = serde_json::from_str(&run.stdout).unwrap();
    object["warnings"].as_array().unwrap().iter().map(|w| w.as_str().unwrap().to_owned()).collect()
}

#[track_caller]
fn assert_refused(sandbox: &Sandbox, run: &Run, words: &[&str]) {
    assert_eq!(run.code, Some(3), "{run:?}");
    for word in words {
        assert!(run.stderr.contains(word), "no {word:?} in {}", run.stderr);
    }
    assert!(!sandbox.path().join("out.pelage").exists(), "a package was left behind");
}

#[test]
fn implausible_sizes_are_refused_with_a_suggested_unit() {
    let sandbox = Sandbox::new();
    let hare = workspace().join(HARE).display().to_string();
    let run = bake(&sandbox, &hare, &["--set", "model.unit_m=100000"]);
    assert_refused(&sandbox, &run, &["hare.glb: whole model: it is ", "surface.tile_size_m", "set model.unit_m=1 "]);
    let run = bake(&sandbox, &hare, &["--set", "model.unit_m=0.00001"]);
    assert_refused(&sandbox, &run, &["hare.glb: whole model: it is ", "set model.unit_m=1 "]);
    // If the recipe sets the lengths, the size is accepted as intended, and the package is valid.
    let lengths = ["--set", "hair.length_m=100", "--set", "surface.tile_size_m=900", "--set", "model.unit_m=100000"];
    let run = bake(&sandbox, &hare, &lengths);
    assert_eq!(run.code, Some(0), "{run:?}");
    assert!(warnings(&run).iter().any(|w| w.contains("model.unit_m=1 or similar")), "{run:?}");
    assert_eq!(sandbox.run(&["validate", "out.pelage"]).code, Some(0));
}

#[test]
fn extreme_positions_are_refused_with_the_model_name() {
    let sandbox = Sandbox::new();
    sandbox.write("huge.obj", SQUARE.replace("v 1 1 0", "v 1e30 1 0"));
    let run = bake(&sandbox, "huge.obj", &[]);
    assert_refused(&sandbox, &run, &["huge.obj: whole model", "1.00e30"]);
}

#[test]
fn a_mesh_without_area_is_refused() {
    let sandbox = Sandbox::new();
    for (name, text) in
        [("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"), ("point.obj", "v 1 2 3\nv 1 2 3\nv 1 2 3\nf 1 2 3\n")]
    {
        sandbox.write(name, text);
        let run = bake(&sandbox, name, &[]);
        assert_refused(&sandbox, &run, &[name, "whole model: none of its 1 triangles has an area", "at rest"]);
    }
    // A single triangle with nonzero area is enough.
    sandbox.write("one.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 4\n");
    assert_eq!(bake(&sandbox, "one.obj", &[]).code, Some(0));
}

#[test]
fn model_oddities_are_reported() {
    let sandbox = Sandbox::new();
    let cube = |offset: f64, inwards: bool| {
        let mut text = String::new();
        for i in 0..8 {
            let [x, y, z] = [0, 1, 2].map(|axis| f64::from(i >> axis & 1));
            text += &format!("v {} {y} {z}\n", x + offset);
        }
        for face in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]] {
            let mut corners = face;
            if inwards {
                corners.reverse();
            }
            text += &format!("f {}\n", corners.map(|c| c.to_string()).join(" "));
        }
        text
    };
    for (text, words) in
        [(cube(0.0, false), &[][..]), (cube(0.0, true), &["face inwards"]), (cube(1e5, false), &["from the origin"])]
    {
        sandbox.write("cube.obj", text);
        // With fewer layers, another warning says that they are far apart.
        let run = bake(&sandbox, "cube.obj", &["--set", "slice.layers=24"]);
        assert_eq!(run.code, Some(0), "{run:?}");
        let found = warnings(&run);
        assert_eq!(found.len(), words.len(), "{found:?}");
        for word in words {
            assert!(found.iter().any(|w| w.contains(word)), "{found:?}");
        }
    }
}

#[test]
fn dissimilar_keys_get_no_suggestion() {
    let sandbox = Sandbox::new();
    sandbox.write("a.obj", SQUARE);
    let run = bake(&sandbox, "a.obj", &["--set", "a=b"]);
    assert_refused(&sandbox, &run, &["--set: a: unknown key, expected one such as hair.length_m"]);
    assert!(!run.stderr.contains("hair.seed"), "{run:?}");
}

#[test]
fn images_given_by_set_are_relative_to_the_working_folder() {
    let sandbox = Sandbox::new();
    sandbox.write("a.obj", SQUARE);
    sandbox.write("recipes/r.toml", "[hair]\ndensity = 50\n");
    let mut png = Vec::new();
    image::RgbImage::from_pixel(4, 4, image::Rgb([200, 100, 50]))
        .write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png)
        .unwrap();
    sandbox.write("here.png", &png);
    sandbox.write("recipes/beside.png", &png);
    let absolute = sandbox.write("elsewhere/far.png", &png);
    let recipe = ["--recipe", "recipes/r.toml", "--set"];
    for (path, recorded) in
        [("here.png", "here.png"), ("beside.png", "beside.png"), (&*absolute.display().to_string(), "far.png")]
    {
        let assignment = format!("color.pattern={path}");
        let run = bake(&sandbox, "a.obj", &[&recipe[..], &[&assignment]].concat());
        assert_eq!(run.code, Some(0), "{path}: {run:?}");
        let object: Value = serde_json::from_str(&sandbox.run(&["inspect", "out.pelage", "--json"]).stdout).unwrap();
        let text = object["recipe"].as_str().unwrap();
        // The recorded path must not contain a folder of this machine.
        assert!(text.contains(&format!("pattern = \"{recorded}\"")), "{text}");
        std::fs::remove_file(sandbox.path().join("out.pelage")).unwrap();
    }
    let run = bake(&sandbox, "a.obj", &[&recipe[..], &["color.pattern=nowhere.png"]].concat());
    assert_refused(&sandbox, &run, &["color.pattern", "nowhere.png"]);
}

#[test]
fn packing_an_edited_recipe_is_refused() {
    let sandbox = Sandbox::new();
    sandbox.write("a.obj", SQUARE);
    assert_eq!(bake(&sandbox, "a.obj", &["--set", "hair.coat=natural"]).code, Some(0));
    assert_eq!(sandbox.run(&["unpack", "out.pelage", "folder"]).code, Some(0));
    let whole = std::fs::read(sandbox.path().join("out.pelage")).unwrap();
    let recipe = std::fs::read_to_string(sandbox.path().join("folder/recipe.toml")).unwrap();
    std::fs::remove_file(sandbox.path().join("out.pelage")).unwrap();
    let pack = |text: &str| {
        sandbox.write("folder/recipe.toml", text);
        sandbox.run(&["pack", "folder", "out.pelage"])
    };
    let run = pack(&recipe.replace("density = 700", "density = 5"));
    let words = [
        "folder/recipe.toml: hair.density: is 5, expected 700",
        "does not bake fur",
        "bake the model with this recipe",
    ];
    assert_refused(&sandbox, &run, &words);
    assert_refused(&sandbox, &pack("[hair\n"), &["folder/recipe.toml: line 1"]);
    assert_refused(&sandbox, &pack("[hair]\ndensty = 3\n"), &["folder/recipe.toml: line 2, hair.densty"]);
    // Packing accepts a comment in the recipe. With the original recipe, it gives the original bytes.
    let run = pack(&format!("# my fox\n{recipe}"));
    assert_eq!((run.code, sandbox.run(&["validate", "out.pelage"]).code), (Some(0), Some(0)), "{run:?}");
    assert_eq!(pack(&recipe).code, Some(0));
    assert_eq!(std::fs::read(sandbox.path().join("out.pelage")).unwrap(), whole);
}

#[test]
fn packing_a_manifest_that_contradicts_the_recipe_is_refused() {
    let sandbox = Sandbox::new();
    sandbox.write("a.obj", SQUARE);
    assert_eq!(bake(&sandbox, "a.obj", &["--set", "hair.coat=natural"]).code, Some(0));
    assert_eq!(sandbox.run(&["unpack", "out.pelage", "folder"]).code, Some(0));
    let whole = std::fs::read(sandbox.path().join("out.pelage")).unwrap();
    std::fs::remove_file(sandbox.path().join("out.pelage")).unwrap();
    let text = std::fs::read(sandbox.path().join("folder/manifest.json")).unwrap();
    let manifest: Value = serde_json::from_slice(&text).unwrap();
    let pack = |change: &dyn Fn(&mut Value)| {
        let mut manifest = manifest.clone();
        change(&mut manifest);
        sandbox.write("folder/manifest.json", manifest.to_string());
        sandbox.run(&["pack", "folder", "out.pelage"])
    };
    let run = pack(&|manifest| manifest["manifest"]["fur"]["strands"] = 19.into());
    let words = ["folder/manifest.json: /manifest/fur: recipe.toml: hair.density is 700, expected 19", "undo the edit"];
    assert_refused(&sandbox, &run, &words);
    assert_refused(
        &sandbox,
        &pack(&|manifest| manifest["recipe_disagrees"] = 3.into()),
        &["/recipe_disagrees", "a list"],
    );
    assert_eq!(pack(&|_| ()).code, Some(0));
    assert_eq!(std::fs::read(sandbox.path().join("out.pelage")).unwrap(), whole);
}

#[test]
fn values_refused_by_a_stage_name_their_source() {
    let sandbox = Sandbox::new();
    sandbox.write("a.obj", SQUARE);
    sandbox.write("r.toml", "[hair]\nlength_m = 0.0001220703125\n[surface]\ntile_size_m = 0.25\n");
    let run = bake(&sandbox, "a.obj", &["--recipe", "r.toml"]);
    assert_refused(
        &sandbox,
        &run,
        &["r.toml: hair.length_m: the hair is 0.00048828125 times as long as its tile is wide"],
    );
    let set = ["--set", "hair.length_m=0.0001220703125", "--set", "surface.tile_size_m=0.25"];
    assert_refused(
        &sandbox,
        &bake(&sandbox, "a.obj", &set),
        &["--set: hair.length_m: the hair is 0.00048828125 times"],
    );
}

#[cfg(unix)]
#[test]
fn pipes_as_package_or_scene_files_are_refused() {
    let sandbox = Sandbox::new();
    sandbox.write("a.obj", SQUARE);
    assert_eq!(bake(&sandbox, "a.obj", &[]).code, Some(0));
    assert_eq!(sandbox.run(&["unpack", "out.pelage", "folder"]).code, Some(0));
    std::fs::remove_file(sandbox.path().join("out.pelage")).unwrap();
    std::fs::remove_file(sandbox.path().join("folder/mesh.glb")).unwrap();
    for path in ["folder/mesh.glb", "pipe"] {
        let made = std::process::Command::new("mkfifo").arg(sandbox.path().join(path)).status().unwrap();
        assert!(made.success());
    }
    let run = sandbox.run(&["pack", "folder", "out.pelage"]);
    assert!(run.code == Some(2) && run.stderr.contains("mesh.glb: cannot read: it is a pipe"), "{run:?}");
    let run = bake(&sandbox, "a.obj", &["--set", "color.pattern=pipe"]);
    assert_refused(&sandbox, &run, &["color.pattern", "it is a pipe, expected a file"]);
    sandbox.write("scene.toml", "[[model]]\npackage = \"pipe\"\n");
    let run = sandbox.run(&["render", "scene.toml", "-o", "out.png"]);
    assert!(run.code == Some(3) && run.stderr.contains("it is a pipe"), "{run:?}");
}

#[cfg(unix)]
#[test]
fn interrupted_process_leaves_no_partial_files() {
    let sandbox = Sandbox::new();
    sandbox.write("a.obj", SQUARE);
    // Writing the strands of 100 tiles as text takes long enough to be interrupted.
    let set = ["--set", "hair.length_m=0.05", "--set", "surface.tile_size_m=0.1"];
    assert_eq!(bake(&sandbox, "a.obj", &set).code, Some(0));
    let before = sandbox.files();
    for signal in ["INT", "TERM"] {
        let mut child =
            sandbox.command(&["export", "out.pelage", "--strands", "strands.txt", "--quiet"]).spawn().unwrap();
        // Waits until the command begins to write.
        while sandbox.files() == before && child.try_wait().unwrap().is_none() {
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        let writing = sandbox.files();
        assert!(writing.iter().any(|name| name.ends_with(".tmp")), "{writing:?}");
        let told = std::process::Command::new("kill").args(["-s", signal, &child.id().to_string()]).status().unwrap();
        assert!(told.success());
        assert_eq!(child.wait().unwrap().code(), Some(130), "{signal}");
        assert_eq!(sandbox.files(), before, "{signal}");
    }
}

/// Checks that long work announces its size. If stderr is not a terminal, it must also print occasional lines with
/// progress and remaining time.
#[test]
fn long_work_is_announced_and_shows_progress() {
    let sandbox = Sandbox::new();
    let hare = workspace().join(HARE).display().to_string();
    let large = ["--set", "slice.layers=256", "--set", "slice.tile_texels=2048"];
    let mut child = sandbox
        .command(&[&["bake", &hare, "-o", "out.pelage"], &large[..]].concat())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = Vec::new();
    // If the expected line is missing, the loop ends only when the bake does, minutes later.
    for line in BufReader::new(child.stderr.take().unwrap()).lines() {
        said.push(line.unwrap());
        if said.last().is_some_and(|line| line.contains("s: slice, ")) {
            break;
        }
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(said[0].starts_with("note: 256 layers of 2048 x 2048 texels will take 4.0 GiB"), "{said:?}");
    let last = said.last().unwrap();
    assert!(last.contains(" of 256"), "{said:?}");
}

#[test]
fn export_is_thinned_as_requested() {
    let sandbox = Sandbox::new();
    let hare = workspace().join(HARE).display().to_string();
    assert_eq!(bake(&sandbox, &hare, &["--set", "hair.density=100"]).code, Some(0));
    let export = |more: &[&str]| {
        let run = sandbox.run(&[&["export", "out.pelage", "--strands", "strands.txt", "--json"], more].concat());
        assert_eq!(run.code, Some(0), "{run:?}");
        let object: Value = serde_json::from_str(&run.stdout).unwrap();
        let number = |key: &str| object[key].as_u64().unwrap();
        let points = std::fs::read_to_string(sandbox.path().join("strands.txt")).unwrap();
        // A strand is a block of lines, and blocks are separated by blank lines.
        assert_eq!(points.split("\n\n").filter(|s| !s.trim().is_empty()).count() as u64, number("strands"));
        (number("strands"), number("of_strands"))
    };
    let (all, of) = export(&[]);
    assert!(all == of && all > 1000, "{all} of {of}");
    let (third, of) = export(&["--every", "3"]);
    assert_eq!((third, of), (all.div_ceil(3), all));
    let (few, of) = export(&["--max-strands", "50"]);
    assert!((25..=50).contains(&few) && of == all, "{few} of {of}");
    let (fewer, _) = export(&["--every", "3", "--max-strands", "50"]);
    assert!((25..=50).contains(&fewer), "{fewer}");
}
