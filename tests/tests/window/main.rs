#![allow(missing_docs, clippy::unwrap_used, reason = "a test fails by panicking")]
//! Tests of `pelage view` in a real window on a virtual display, with real key and mouse events.

use pelage_bake::pipeline::STAGES;
use pelage_tests::binary::{Sandbox, walk, workspace};
use pelage_tests::desktop::{Desktop, ViewerWindow};
use serde_json::Value;
use std::path::Path;
use std::time::Duration;

/// Bakes `hare.pelage` with little hair.
fn package(sandbox: &Sandbox) {
    let model = workspace().join("assets/models/hare.glb").display().to_string();
    let set = SMALL.iter().flat_map(|set| ["--set", set]);
    sandbox.fixture(&[&model, "-o", "hare.pelage"].into_iter().chain(set).collect::<Vec<_>>());
}

const SMALL: [&str; 4] = ["slice.layers=6", "slice.tile_texels=32", "hair.density=80", "pack.shell_format=rgba8"];

fn open_window<'a>(desktop: &'a Desktop, sandbox: &Sandbox, args: &[&str]) -> ViewerWindow<'a> {
    let mut view = desktop.view(sandbox.path(), args);
    view.wait_for("first picture");
    view.focus();
    view
}

fn pixels(path: &Path) -> image::RgbaImage {
    image::open(path).unwrap().to_rgba8()
}

#[test]
fn window_matches_render_and_responds_to_input() {
    let Some(desktop) = Desktop::open("window_matches_render_and_responds_to_input") else { return };
    let sandbox = Sandbox::new();
    package(&sandbox);
    let mut view = open_window(&desktop, &sandbox, &["hare.pelage", "--window", "500x400", "--no-panels"]);

    // The picture must equal that of `render` with the camera that the window reports.
    view.skip_events();
    view.key("p");
    let told = view.wait_for("pictured");
    view.wait_for("saved");
    let first = pixels(&sandbox.path().join("hare-0001.png"));
    assert_eq!(first.dimensions(), (500, 400));
    let camera = format!("--camera={}", told["camera"].as_str().unwrap());
    let run = sandbox.run(&["render", "hare.pelage", "-o", "drawn.png", "--size", "500x400", &camera]);
    assert_eq!(run.code, Some(0), "{run:?}");
    let drawn = pixels(&sandbox.path().join("drawn.png"));
    let off = first.as_raw().iter().zip(drawn.as_raw()).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(off <= Some(1), "a pixel is off by {off:?} bytes");

    // A drag orbits the camera, and the key R resets it.
    view.drag("1", (150, 200), (350, 230));
    std::thread::sleep(Duration::from_millis(400));
    let turned = pixels(&view.save("p"));
    assert!(turned != first, "the drag moved nothing");
    view.key("r");
    let back = pixels(&view.save("p"));
    assert!(back == first, "R did not restore the first view");

    // Style, mouse wheel, flight and light must each change the picture.
    let mut before = back;
    for (what, hands) in [
        ("bare skin", &["key", "3"][..]),
        ("fur", &["key", "1"]),
        ("the wheel", &["mousemove", "250", "200", "click", "--repeat", "3", "4"]),
        ("flight", &["keydown", "w", "sleep", "0.4", "keyup", "w"]),
        ("an arrow", &["keydown", "Left", "sleep", "0.4", "keyup", "Left"]),
    ] {
        view.xdotool(hands);
        std::thread::sleep(Duration::from_millis(400));
        let after = pixels(&view.save("p"));
        assert!(after != before, "{what} changed nothing");
        before = after;
    }
    view.xdotool(&["keydown", "ctrl"]);
    view.drag("1", (150, 200), (300, 200));
    view.xdotool(&["keyup", "ctrl"]);
    std::thread::sleep(Duration::from_millis(400));
    let lit = pixels(&view.save("p"));
    assert!(lit != before, "the light did not change");
    view.xdotool(&["key", "ctrl+z"]);
    assert!(pixels(&view.save("p")) == before, "undo did not restore the light");

    // The picture shows the whole window, including its panels.
    view.key("n");
    let window = pixels(&view.save("F12"));
    assert_eq!(window.dimensions(), (500, 400));
    view.key("n");

    // The window is reduced to its minimum size, and restored.
    let id = view.focus();
    view.xdotool(&["windowsize", &id, "1", "1"]);
    std::thread::sleep(Duration::from_millis(300));
    view.assert_alive();
    view.xdotool(&["windowsize", "--sync", &id, "420", "300"]);
    // The new size arrives after the frame that is being drawn, which takes long on a loaded machine.
    let mut saved = (0, 0);
    for _ in 0..20 {
        std::thread::sleep(Duration::from_millis(500));
        saved = pixels(&view.save("p")).dimensions();
        if saved == (420, 300) {
            break;
        }
    }
    assert_eq!(saved, (420, 300));

    // The reference image is shown beside the real-time picture. The test waits for its first sample.
    view.skip_events();
    view.key("t");
    let truth = view.wait_for("truth");
    assert!(truth["flip"].as_f64().is_some_and(|flip| flip > 0.0 && flip < 0.3), "{truth}");
    view.assert_alive();
}

#[test]
fn window_says_that_a_picture_shows_nothing() {
    let Some(desktop) = Desktop::open("window_says_that_a_picture_shows_nothing") else { return };
    let sandbox = Sandbox::new();
    // The triangle looks down, and the camera looks from above.
    sandbox.write("down.obj", "v 0 0 0\nv 1 0 0\nv 1 0 1\nf 1 2 3\n");
    sandbox.fixture(&["down.obj", "-o", "down.pelage", "--set=slice.layers=4", "--set=slice.tile_texels=16"]);
    let mut view = desktop.view(sandbox.path(), &["down.pelage", "--style", "bare", "--window", "300x200"]);
    view.wait_for("first picture");
    view.wait_for("empty picture");
    view.assert_alive();
}

#[test]
fn saved_recipe_is_rebaked_and_a_broken_one_is_reported() {
    let Some(desktop) = Desktop::open("saved_recipe_is_rebaked_and_a_broken_one_is_reported") else {
        return;
    };
    let sandbox = Sandbox::new();
    let model = workspace().join("assets/models/hare.glb").display().to_string();
    let recipe = |shading: &str| {
        format!(
            "# Small.\n[hair]\ndensity = 80\n[slice]\nlayers = 6\ntile_texels = 32\n\
             [pack]\nshell_format = \"rgba8\"\n[shading]\nambient = {shading}\n\
             model = \"kajiya-kay\"\n"
        )
    };
    sandbox.write("hare.toml", recipe("[0.3, 0.3, 0.3]"));
    let mut view =
        desktop.view(sandbox.path(), &[&model, "--recipe", "hare.toml", "--window", "400x300", "--no-panels"]);
    let stages_of = |made: &Value| -> Vec<String> {
        made["stages"].as_array().unwrap().iter().map(|s| s["name"].as_str().unwrap().to_owned()).collect()
    };
    let made = view.wait_for("made");
    assert_eq!(stages_of(&made), STAGES, "{made}");
    view.wait_for("first picture");
    view.focus();
    let dark = pixels(&view.save("p"));

    // Editors save a file by renaming a new file to its name.
    sandbox.write("hare.toml.new", recipe("[2.5, 2.5, 2.5]"));
    std::fs::rename(sandbox.path().join("hare.toml.new"), sandbox.path().join("hare.toml")).unwrap();
    let made = view.wait_for("made");
    assert_eq!(stages_of(&made), ["pack"], "a change of shading");
    view.wait_for("picture");
    let bright = pixels(&view.save("p"));
    assert!(bright != dark, "the new shading has no effect");

    sandbox.write("hare.toml", recipe("[2.5, 2.5]"));
    let failure = view.wait_for("failure");
    let reason = failure["reason"].as_str().unwrap();
    for word in ["hare.toml", "line 10", "shading.ambient", "[2.5, 2.5]", "three numbers"] {
        assert!(reason.contains(word), "{word:?} is not in {reason:?}");
    }
    assert!(pixels(&view.save("p")) == bright, "the previous picture must stay");

    sandbox.write("hare.toml", recipe("[0.3, 0.3, 0.3]"));
    view.wait_for("mended");
    view.wait_for("picture");
    assert!(pixels(&view.save("p")) == dark, "the corrected recipe must be shown");

    // If the recipe is saved without changes, its text must stay the same.
    view.skip_events();
    view.xdotool(&["key", "ctrl+s"]);
    view.wait_for("saved");
    assert_eq!(std::fs::read_to_string(sandbox.path().join("hare.toml")).unwrap(), recipe("[0.3, 0.3, 0.3]"));
}

#[test]
fn window_survives_files_other_than_packages() {
    let Some(desktop) = Desktop::open("window_survives_files_other_than_packages") else { return };
    let sandbox = Sandbox::new();
    package(&sandbox);
    let whole = std::fs::read(sandbox.path().join("hare.pelage")).unwrap();
    sandbox.write("a-cut.pelage", &whole[..whole.len() / 2]);
    let mut flipped = whole.clone();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 0x55;
    sandbox.write("b-flipped.pelage", &flipped);
    sandbox.write("c-empty.pelage", b"");
    sandbox.write("d-text.pelage", b"This is a letter.");
    sandbox.write("e-broken.glb", b"glTF\x02\0\0\0\xff\xff\xff\xff");
    let mut bad = 5;
    // Files of the test data that are not models are opened too, under names that the window accepts.
    if let Some(data) = pelage_needs::data("window_survives_files_other_than_packages") {
        let mut files = Vec::new();
        walk(&data, &mut files);
        files.retain(|file| !file.extension().is_some_and(|e| ["glb", "gltf", "obj"].iter().any(|model| e == *model)));
        assert!(files.len() > 300, "only {} files", files.len());
        for (number, file) in files.iter().enumerate() {
            std::fs::copy(file, sandbox.path().join(format!("f-{number:04}.pelage"))).unwrap();
        }
        bad += files.len();
    }
    let mut view = desktop.view(sandbox.path(), &["a-cut.pelage", "--window", "300x240", "--no-panels"]);
    let failure = view.wait_for("failure");
    assert!(failure["reason"].as_str().unwrap().contains("a-cut.pelage"), "{failure}");
    view.focus();
    for _ in 1..bad {
        view.key("Next");
        let failure = view.wait_for("failure");
        let reason = failure["reason"].as_str().unwrap();
        assert!(reason.contains(".pelage") || reason.contains(".glb"), "the reason names no file: {reason}");
    }
    view.key("Next");
    let made = view.wait_for("made");
    assert_eq!(made["name"], "./hare.pelage");
    view.wait_for("first picture");
    view.assert_alive();
}

#[test]
fn view_without_a_display_reports_what_is_missing() {
    let sandbox = Sandbox::new();
    sandbox.write("a.pelage", b"");
    let mut command = sandbox.command(&["view", "a.pelage"]);
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    let run = pelage_tests::binary::run_to_end(command);
    assert_eq!(run.code, Some(4), "{run:?}");
    for word in ["no window can be opened", "DISPLAY", "pelage render"] {
        assert!(run.stderr.contains(word), "{word:?} is not in {run:?}");
    }
    let run = sandbox.run(&["view", "no-such.pelage"]);
    assert_eq!(run.code, Some(2), "{run:?}");
}
