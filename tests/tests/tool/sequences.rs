//! Tests of scene files, numbered pictures and videos of `pelage render`, with the real binary.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_tests::binary::{Run, Sandbox, walk, workspace};
use pelage_tests::gpu::gpu;
use pelage_tests::schema;
use serde_json::Value;
use std::io::Read as _;
use std::process::Stdio;
use std::time::Duration;

/// Bake settings for small textures, in formats that need no encoder.
const SMALL: [&str; 14] = [
    "--set",
    "slice.tile_texels=32",
    "--set",
    "slice.layers=4",
    "--set",
    "hair.density=60",
    "--set",
    "pack.shell_format=rgba8",
    "--set",
    "pack.direction_format=rg8",
    "--set",
    "pack.base_color_format=rgba8",
    "--set",
    "shading.model=kajiya-kay",
];

/// Returns a folder with `hare.pelage` and `torus.pelage`.
fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    for name in ["hare", "torus"] {
        let (model, package) = (workspace().join(format!("assets/models/{name}.glb")), format!("{name}.pelage"));
        sandbox.fixture(&[&[model.to_str().unwrap(), "-o", &package], &SMALL[..]].concat());
    }
    sandbox
}

#[track_caller]
fn rendered(sandbox: &Sandbox, args: &[&str]) -> (Value, Run) {
    let run = sandbox.run(&[&["render", "--json"], args].concat());
    assert_eq!(run.code, Some(0), "{args:?}: {run:?}");
    (schema::parse_answer(&run, "render"), run)
}

/// Runs `render` with the given arguments, and returns the bytes of the picture.
#[track_caller]
fn picture(sandbox: &Sandbox, args: &[&str]) -> Vec<u8> {
    rendered(sandbox, &[args, &["-o", "picture.png"]].concat());
    sandbox.read("picture.png")
}

#[test]
fn blend_option_interpolates_between_clips() {
    let Some(_) = gpu("blend_option_interpolates_between_clips") else { return };
    let sandbox = sandbox();
    let seen = ["hare.pelage", "--size", "120x90", "--camera", "0.5,0.6,1.5/0,0.2,0/25", "--time", "0.3"];
    let drawn = |more: &[&str]| picture(&sandbox, &[&seen[..], more].concat());
    let [rest, breath, walk] = [&[][..], &["--clip", "EarBreath"], &["--clip", "Walk"]].map(drawn);
    let half = drawn(&["--clip", "EarBreath", "--blend", "Walk:0.5"]);
    assert!(half != breath && half != walk, "halfway, the picture must equal neither clip");
    assert!(
        drawn(&["--clip", "EarBreath", "--blend", "Walk:0"]) == breath,
        "with weight 0, only the first clip must show"
    );
    assert!(
        drawn(&["--clip", "EarBreath", "--blend", "Walk:1"]) == walk,
        "with weight 1, only the second clip must show"
    );
    assert!(
        drawn(&["--blend", "Walk:0"]) == rest && drawn(&["--blend", "Walk:1"]) == walk,
        "the same must hold when blending from rest"
    );
    // The reference image must have the same pose as the rendered one.
    let traced = |more: &[&str]| {
        let run = sandbox.run(&[&["reference", "-o", "true.png", "--samples", "1"], &seen[..], more].concat());
        assert_eq!(run.code, Some(0), "{run:?}");
        sandbox.read("true.png")
    };
    let of_half = traced(&["--clip", "EarBreath", "--blend", "Walk:0.5"]);
    assert!(of_half != traced(&["--clip", "EarBreath"]) && of_half != traced(&["--clip", "Walk"]));
    assert!(traced(&["--blend", "Walk:1"]) == traced(&["--clip", "Walk"]));
    for (blend, code, word) in [("Gallop:0.5", 1, "Gallop"), ("Walk", 1, "Walk:0.3"), ("Walk:2", 1, "0 to 1")] {
        let run = sandbox.run(&["render", "hare.pelage", "-o", "no.png", "--blend", blend]);
        assert!(run.code == Some(code) && run.stderr.contains(word), "{run:?}");
    }
    assert!(!sandbox.path().join("no.png").exists());
}

#[test]
fn single_model_scene_equals_rendering_its_package() {
    let Some(_) = gpu("single_model_scene_equals_rendering_its_package") else { return };
    let sandbox = sandbox();
    let model = "[[model]]\npackage = \"../hare.pelage\"\n";
    let clip = format!("{model}clip = \"EarBreath\"\n");
    let words = "[view]\nsize = \"120x90\"\nbackground = \"200,210,220\"\n";
    let package = &["hare.pelage", "--size", "120x90", "--background", "200,210,220"][..];
    let moving = [package, &["--clip", "EarBreath"]].concat();
    let camera =
        "[camera]\neye = [0.5, 0.6, 1.5]\ntarget = [0, 0.2, 0]\nfov_deg = 25\n[light]\ndirection = [3, 1, 0]\n";
    let seen = ["--camera", "0.5,0.6,1.5/0,0.2,0/25", "--light", "3,1,0"];
    let look = "[picture]\nsize = \"120x90\"\nbackground = \"200,210,220\"\n";
    sandbox.write("scenes/looks/l.toml", look);
    let looked = ["hare.pelage", "--look", "scenes/looks/l.toml"];
    let mut drawn = Vec::new();
    for (scene, more, arguments) in [
        (format!("{words}{model}"), &[][..], package.to_vec()),
        (format!("look = \"looks/l.toml\"\n{model}"), &[], package.to_vec()),
        (
            format!("look = \"looks/l.toml\"\n{model}"),
            &["--style", "bare"],
            [&looked[..], &["--style", "bare"]].concat(),
        ),
        (format!("{words}style = \"bare\"\n{model}"), &[], [package, &["--style", "bare"]].concat()),
        (format!("{words}{camera}{model}"), &[], [package, &seen].concat()),
        (format!("{words}{camera}{clip}"), &["--time", "0.7"], [&moving[..], &seen, &["--time", "0.7"]].concat()),
        (format!("{words}{clip}start_s = 0.5\n"), &[], [&moving[..], &["--time", "0.5"]].concat()),
        (format!("{words}{clip}speed = 2\n"), &["--time", "0.5"], [&moving[..], &["--time", "1"]].concat()),
        (format!("{words}{clip}loop = false\n"), &["--time", "99"], [&moving[..], &["--time", "2"]].concat()),
        // Checks that command-line options have priority.
        (
            format!(
                "[view]\nsize = \"7x7\"\nstyle = \"bare\"\nbackground = \"1,2,3\"\nself_shadow = false\n{camera}{model}"
            ),
            &[
                "--size",
                "120x90",
                "--style",
                "fur",
                "--background",
                "200,210,220",
                "--light",
                "0,1,1",
                "--self-shadow",
                "on",
                "--camera",
                "0,1,2/0,0,0/30",
            ],
            [package, &["--light", "0,1,1", "--camera", "0,1,2/0,0,0/30"]].concat(),
        ),
    ] {
        sandbox.write("scenes/a.toml", &scene);
        let of_scene = picture(&sandbox, &[&["scenes/a.toml"], more].concat());
        assert!(of_scene == picture(&sandbox, &arguments), "{scene}, {more:?} is not {arguments:?}");
        drawn.push(of_scene);
    }
    // A look may come from a pipe, which can be read only once.
    #[cfg(unix)]
    {
        use std::io::Write as _;
        let args = ["render", "hare.pelage", "--look", "/dev/stdin", "-o", "piped.png"];
        let mut child = sandbox.command(&args).stdin(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(look.as_bytes()).unwrap();
        assert!(child.wait().unwrap().success());
        assert!(sandbox.read("piped.png") == drawn[0], "a look from a pipe");
    }
    // All of the settings above must change the picture. At its end, the clip returns to the rest pose, but the default
    // camera frames the whole clip.
    drawn.sort();
    drawn.dedup();
    assert_eq!(drawn.len(), 8);
}

#[test]
fn models_and_camera_follow_their_paths() {
    let Some(_) = gpu("models_and_camera_follow_their_paths") else { return };
    let sandbox = sandbox();
    let scene = |target: &str, place: &str| {
        let camera = format!("[camera]\npath = [\n{{ time_s = 0, {target} }},\n{{ time_s = 2, {target} }}]\n");
        let text = format!(
            "[view]\nsize = \"96x96\"\n{camera}[light]\ndirection = [0, 1, 0]\n\
             [[model]]\npackage = \"hare.pelage\"\n{place}\n"
        );
        sandbox.write("a.toml", text);
        let (value, _) = rendered(&sandbox, &["a.toml", "-o", "a.png", "--time", "1"]);
        (value["covered_pixels"].as_f64().unwrap(), image::open(sandbox.path().join("a.png")).unwrap().into_rgba8())
    };
    let (at_origin, first) = scene("eye = [0, 0.3, 2], target = [0, 0.2, 0]", "");
    assert!(at_origin > 300.0);
    // The model is halfway between two positions, and the camera is moved by the same amount. The picture must be the
    // same, except for rounding at edges.
    let path = "path = [{ time_s = 0, position = [4, 1, 0], heading_deg = 0 }, \
                { time_s = 2, position = [6, 1, 0], heading_deg = 0 }]";
    let (moved, second) = scene("eye = [5, 1.3, 2], target = [5, 1.2, 0]", path);
    assert!((moved / at_origin - 1.0).abs() < 0.02, "{at_origin} and {moved} pixels");
    let differ =
        first.pixels().zip(second.pixels()).filter(|(a, b)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 24));
    assert!(differ.count() < 96 * 96 / 50);
    // Seen from the side, the model moves along the picture. A hare that walks along +x, viewed along +x, must look
    // like a hare at rest viewed from its front.
    let way = "path = [{ time_s = 0, position = [-1, 0, 0] }, { time_s = 2, position = [1, 0, 0] }]";
    let (front, _) = scene("eye = [2, 0.3, 0], target = [0, 0.2, 0]", way);
    assert!((front / at_origin - 1.0).abs() < 0.02, "{at_origin} and {front} pixels");
    let (side, _) = scene("eye = [0, 0.3, 2], target = [0, 0.2, 0]", way);
    assert!((side / at_origin - 1.0).abs() > 0.1, "{at_origin} and {side} pixels");
    let (large, _) = scene("eye = [0, 0.6, 4], target = [0, 0.4, 0]", "scale = 2");
    assert!((large / at_origin - 1.0).abs() < 0.02, "{at_origin} and {large} pixels");
}

#[test]
fn scene_packages_are_loaded_once_and_drawn_together() {
    let Some(_) = gpu("scene_packages_are_loaded_once_and_drawn_together") else { return };
    let sandbox = sandbox();
    sandbox.write(
        "a.toml",
        "[view]\nsize = \"160x80\"\n[sequence]\nframes = 3\nfps = 5\n\
         [[model]]\nname = \"left\"\npackage = \"hare.pelage\"\nposition = [-0.5, 0, 0]\n\
         [[model]]\nname = \"right\"\npackage = \"./hare.pelage\"\nposition = [0.5, 0, 0]\nclip = \"EarBreath\"\n\
         [[model]]\npackage = \"torus.pelage\"\nposition = [0, 0.2, -1]\nscale = 0.3\n",
    );
    let (value, _) = rendered(&sandbox, &["a.toml", "-o", "a.png", "--layers", "2"]);
    assert_eq!(value["scene"]["models"], serde_json::json!(["left", "right", "torus"]));
    assert_eq!(value["scene"]["packages"], serde_json::json!(["hare.pelage", "torus.pelage"]));
    assert_eq!(value["detail"].as_array().unwrap().len(), 3);
    // A plain name gives one picture, whatever the sequence of the scene file is. Numbered names give as many pictures
    // as the file says.
    assert_eq!((&value["frames"], value["output"].as_str()), (&1.into(), Some("a.png")));
    let (value, _) = rendered(&sandbox, &["a.toml", "-o", "%02d.png"]);
    assert_eq!(value["outputs"], serde_json::json!(["00.png", "01.png", "02.png"]));
    assert_eq!((&value["frames"], &value["fps"]), (&3.into(), &5.into()));
    let (value, _) = rendered(&sandbox, &["a.toml", "-o", "b%1d.png", "--frames", "2", "--fps", "10"]);
    assert_eq!((&value["frames"], &value["fps"]), (&2.into(), &10.into()));
    // The second picture of one sequence must equal the third of the other.
    sandbox.write("c.toml", "[[model]]\npackage = \"hare.pelage\"\nclip = \"EarBreath\"\n");
    let draw =
        |fps: &str| rendered(&sandbox, &["c.toml", "--size", "64x64", "-o", "c%1d.png", "--frames", "3", "--fps", fps]);
    draw("5");
    let second = sandbox.read("c1.png");
    draw("10");
    assert!(second == sandbox.read("c2.png") && second != sandbox.read("c1.png"));
}

#[test]
fn bad_scenes_are_refused() {
    let sandbox = sandbox();
    let model = "[[model]]\npackage = \"hare.pelage\"\n";
    sandbox.write("good.toml", model);
    sandbox.write("latin.toml", b"# \xe9\n[[model]]\n");
    sandbox.write("no words.pelage", "hello");
    let go = "{ time_s = 0, position = [0, 0, 0] }";
    for (name, text) in [
        ("missing", "[[model]]\npackage = \"cow.pelage\"\n".to_owned()),
        ("broken", "\n[[model]]\npackage = \"no words.pelage\"\n".to_owned()),
        ("unknown", format!("{model}colour = \"red\"\n")),
        ("empty", "# nobody\n".to_owned()),
        ("no-keys", format!("{model}path = []\n")),
        ("back", format!("{model}path = [\n{go},\n{{ time_s = -1, position = [0, 0, 1] }},\n]\n")),
        ("nan", format!("[camera]\neye = [0, nan, 1]\ntarget = [0, 0, 0]\n{model}")),
        ("clip", format!("{model}clip = \"Gallop\"\n")),
    ] {
        sandbox.write(&format!("{name}.toml"), text);
    }
    for (name, look) in [("looked", "\"looks/faulty.toml\""), ("lost", "\"looks/none.toml\""), ("number", "3")] {
        sandbox
            .write(&format!("scenes/{name}.toml"), format!("look = {look}\n[[model]]\npackage = \"../hare.pelage\"\n"));
    }
    sandbox.write("scenes/looks/faulty.toml", "[ink]\ntone = 3\n");
    // A scene file is recognised by its contents, whatever its name is.
    sandbox.write("scene.txt", format!("{model}speed = 1\n"));
    let before = sandbox.files();
    for (args, code, words) in [
        (&["missing.toml"][..], 3, &["missing.toml: line 2, model[0].package", "cow.pelage: cannot read"][..]),
        (&["broken.toml"], 3, &["no words.pelage", "byte 0"]),
        (&["unknown.toml"], 3, &["unknown.toml: line 3, model[0]", "unknown field `colour`", "package"]),
        (&["empty.toml"], 3, &["empty.toml: model: found none"]),
        (&["no-keys.toml"], 3, &["line 3, model[0].path: found no keys"]),
        (&["back.toml"], 3, &["line 5, model[0].path[1].time_s: found -1 after 0, expected at least 0.001 s later"]),
        (&["nan.toml"], 3, &["line 2, camera.eye: found NaN, expected a number"]),
        (&["clip.toml"], 3, &["line 3, model[0].clip: found \"Gallop\"", "hare.pelage", "EarBreath"]),
        (&["latin.toml"], 3, &["latin.toml: byte 2", "UTF-8"]),
        (&["scene.txt"], 3, &["scene.txt: line 3, model[0].speed: found without a clip"]),
        // On the command line, paths are relative to the current folder.
        (
            &["scenes/looked.toml"],
            3,
            &["error: scenes/looks/faulty.toml: line 2, ink.tone: found 3, expected a number 0..=1"],
        ),
        (&["scenes/lost.toml"], 3, &["scenes/lost.toml: line 1, look: scenes/looks/none.toml: cannot read"]),
        (
            &["scenes/number.toml"],
            3,
            &["scenes/number.toml: line 1, look: found integer, expected the path of a look file"],
        ),
        (
            &["hare.pelage", "--look", "scenes/looks/faulty.toml"],
            3,
            &["error: scenes/looks/faulty.toml: line 2, ink.tone"],
        ),
        (&["good.toml", "--look", "looks/faulty.toml"], 2, &["looks/faulty.toml: cannot read"]),
        (&["no.toml"], 2, &["no.toml: cannot read"]),
        (&["good.toml", "--crowd", "4"], 1, &["--crowd", "good.toml", "left out"]),
        (&["good.toml", "--clip", "EarBreath"], 1, &["--clip", "good.toml", "left out"]),
        (&["good.toml", "--blend", "Walk:0.5"], 1, &["--blend", "good.toml", "left out"]),
        (&["good.toml", "--turn-light"], 1, &["--turn-light", "--frames"]),
        (&["hare.pelage", "--turn-light"], 1, &["--turn-light", "--frames"]),
    ] {
        let run = sandbox.run(&[&["render", "-o", "a.png"], args].concat());
        println!("{}", run.stderr.trim());
        assert_eq!(run.code, Some(code), "{args:?}: {run:?}");
        for word in words {
            assert!(run.stderr.contains(word), "{args:?}: no {word:?} in {}", run.stderr);
        }
        assert_eq!(sandbox.files(), before, "{args:?} left something behind");
    }
}

#[test]
fn videos_contain_the_pictures() {
    let Some(_) = gpu("videos_contain_the_pictures") else { return };
    let sandbox = sandbox();
    let (width, height) = (180, 130);
    let view = ["hare.pelage", "--size", "180x130", "--clip", "EarBreath", "--frames", "4", "--fps", "12"];
    let (value, _) = rendered(&sandbox, &[&view[..], &["-o", "a.y4m"]].concat());
    assert_eq!((&value["frames"], value["output"].as_str()), (&4.into(), Some("a.y4m")));
    assert_eq!(value["covered_pixels_per_picture"].as_array().unwrap().len(), 4);
    rendered(&sandbox, &[&view[..], &["-o", "%1d.png"]].concat());
    let video = sandbox.read("a.y4m");
    let header = b"YUV4MPEG2 W180 H130 F12:1 Ip A1:1 C444 XCOLORRANGE=LIMITED\n";
    assert!(video.starts_with(header));
    let planes = width * height;
    let frames: Vec<&[u8]> = video[header.len()..].chunks(6 + 3 * planes).collect();
    assert_eq!(frames.len(), 4);
    for (i, frame) in frames.iter().enumerate() {
        assert!(frame.starts_with(b"FRAME\n") && frame.len() == 6 + 3 * planes);
        let png = image::open(sandbox.path().join(format!("{i}.png"))).unwrap().into_rgba8();
        let mut transparent = 0;
        for (k, pixel) in png.pixels().enumerate() {
            let [y, cb, cr] = [0, 1, 2].map(|plane| f64::from(frame[6 + plane * planes + k]));
            // Inverse of the BT.709 matrix. Without chroma averaging, the bytes are exact to about one step of luma.
            let (y, cb, cr) = ((y - 16.0) / 219.0, (cb - 128.0) / 224.0, (cr - 128.0) / 224.0);
            let (r, b) = (y + 1.5748 * cr, y + 1.8556 * cb);
            let g = (y - 0.2126 * r - 0.0722 * b) / 0.7152;
            let expected = match pixel.0 {
                [_, _, _, 0] => [255.0; 3],
                [r, g, b, 255] => [r, g, b].map(f64::from),
                _ => continue,
            };
            transparent += usize::from(pixel.0[3] == 0);
            let found = [r, g, b].map(|x| 255.0 * x);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 2.5), "{i}, {k}: {found:?}, {expected:?}");
        }
        assert!(transparent > planes / 4);
    }

    // Stdout must contain the same bytes and nothing else. If the reader stops early, this is not an error.
    let mut child =
        sandbox.command(&[&["render"], &view[..], &["-o", "-"]].concat()).stdout(Stdio::piped()).spawn().unwrap();
    let mut piped = Vec::new();
    child.stdout.take().unwrap().read_to_end(&mut piped).unwrap();
    assert!(child.wait().unwrap().success() && piped == video);
    let mut child = sandbox
        .command(&[&["render"], &view[..], &["-o", "-"]].concat())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdout.take().unwrap().read_exact(&mut [0; 100]).unwrap();
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(0), "{ended:?}");
    assert!(!String::from_utf8_lossy(&ended.stderr).contains("error:"), "{ended:?}");
    let both = sandbox.run(&[&["render", "--json"], &view[..], &["-o", "-"]].concat());
    assert!(both.code == Some(1) && both.stderr.contains("--json") && both.stdout.contains("exit_code"), "{both:?}");
}

/// Returns the mean absolute difference of two pictures over all channels, 0..=255.
fn difference(sandbox: &Sandbox, a: &str, b: &str) -> f64 {
    let [a, b] = [a, b].map(|name| image::load_from_memory(&sandbox.read(name)).unwrap().to_rgba8());
    let off = a.as_raw().iter().zip(b.as_raw()).map(|(a, b)| f64::from(a.abs_diff(*b)));
    off.sum::<f64>() / a.as_raw().len() as f64
}

/// Writes `pony.pelage`.
fn bake_pony(sandbox: &Sandbox) {
    bake_pony_with(sandbox, &[]);
}

/// Writes `pony.pelage`, baked with additional options.
fn bake_pony_with(sandbox: &Sandbox, options: &[&str]) {
    let [model, recipe] = ["models/pony.glb", "recipes/pony.toml"].map(|name| workspace().join("assets").join(name));
    let [model, recipe] = [&model, &recipe].map(|path| path.to_str().unwrap());
    sandbox.fixture(&[&[model, "--recipe", recipe, "-o", "pony.pelage"], &SMALL[..], options].concat());
}

#[test]
fn notes_name_options_and_hair_without_effect() {
    let Some(_) = gpu("notes_name_options_and_hair_without_effect") else { return };
    let sandbox = Sandbox::new();
    // The built-in studio is the default for fibres alone.
    bake_pony_with(&sandbox, &["--set", "shading.model=marschner"]);
    let drawn = |options: &[&str]| {
        let run = sandbox.run(&[&["render", "pony.pelage", "-o", "a.png", "--size", "32x32"], options].concat());
        assert_eq!(run.code, Some(0), "{run:?}");
        run.stderr.lines().filter(|line| line.starts_with("note: ")).map(str::to_owned).collect::<Vec<_>>()
    };
    let note = "note: --ink-lines pixels does not draw guided hair: \"forelock\", \"mane\", \"tail\"";
    assert_eq!(drawn(&["--style", "ink", "--ink-lines", "pixels"]), [note]);
    assert_eq!((drawn(&["--style", "fur"]), drawn(&["--style", "ink"])), (vec![], vec![]));
    let older = workspace().join("formats/tests/golden/v3-ink.pelage");
    let run = sandbox.run(&["render", older.to_str().unwrap(), "-o", "a.png", "--size", "32x32", "--style", "ink"]);
    assert!(run.code == Some(0) && run.stderr.contains("v3-ink.pelage: found no strokes"), "{run:?}");
    let note = "note: --ground has no effect without --environment";
    assert_eq!(drawn(&["--ground", "#6b5a45", "--studio", "old"]), [note]);
    assert_eq!(drawn(&["--ground", "#6b5a45"]), [""; 0], "the studio has a ground");
    bake_pony_with(&sandbox, &["--set", "shading.model=kajiya-kay"]);
    let noted = drawn(&["--environment", "1,1,1"]);
    assert!(noted.len() == 1 && noted[0].contains("kajiya-kay") && noted[0].contains("marschner"), "{noted:?}");
    assert_eq!(drawn(&[]), [""; 0]);
}

/// Checks that the motion of manes and tails depends only on the time in a sequence: on neither the number of pictures
/// nor interruptions.
#[test]
fn hair_swings_in_sequences() {
    let Some(_) = gpu("hair_swings_in_sequences") else { return };
    let sandbox = Sandbox::new();
    bake_pony(&sandbox);
    for folder in ["a", "b", "c", "d", "e"] {
        std::fs::create_dir(sandbox.path().join(folder)).unwrap();
    }
    let view = ["pony.pelage", "--clip", "Walk", "--size", "120x100", "--samples", "1", "--look", "motion.wind=3,0,-2"];
    let shot = |more: &[&str]| rendered(&sandbox, &[&view[..], more].concat());
    shot(&["--frames", "4", "--fps", "12", "-o", "a/%d.png"]);
    shot(&["--frames", "7", "--fps", "24", "-o", "b/%d.png"]);
    shot(&["--frames", "5", "--fps", "16", "-o", "e/%d.png"]);
    shot(&["--frames", "4", "--fps", "12", "--look", "motion.hair=false", "-o", "c/%d.png"]);
    // Frame rates that divide the simulation rate must give identical bytes; others give nearly the same picture.
    assert!(sandbox.read("a/3.png") == sandbox.read("b/6.png"), "12 and 24 pictures a second");
    let (rate, swing) = (difference(&sandbox, "a/3.png", "e/4.png"), difference(&sandbox, "a/3.png", "c/3.png"));
    assert!(swing > 0.5 && rate < 0.15 * swing, "another frame rate differs by {rate}, stiff hair by {swing}");
    // In a single picture, hair must be at rest.
    rendered(&sandbox, &[&view[..], &["--time", "0.25", "-o", "still.png"]].concat());
    assert_eq!(difference(&sandbox, "still.png", "c/3.png"), 0.0);

    let more = ["--frames", "4", "--fps", "12", "-o", "d/%d.png"];
    let journal = sandbox.path().join("d/%d.png.pictures.jsonl");
    let mut child = sandbox
        .command(&[&["render"], &view[..], &more[..]].concat())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while std::fs::read_to_string(&journal).map_or(0, |text| text.matches('\n').count()) < 2 {
        assert_eq!(child.try_wait().unwrap(), None, "it ended before it could be killed");
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(shot(&more).0["skipped"].as_u64().unwrap() > 0);
    for i in 0..4 {
        assert!(sandbox.read(&format!("a/{i}.png")) == sandbox.read(&format!("d/{i}.png")), "picture {i}");
    }
}

#[test]
fn interrupted_sequence_resumes() {
    let Some(_) = gpu("interrupted_sequence_resumes") else { return };
    let sandbox = sandbox();
    sandbox.write(
        "a.toml",
        "[view]\nsize = \"200x150\"\n[sequence]\nframes = 14\n\
         [camera]\npath = [{ time_s = 0, eye = [0, 1, 2], target = [0, 0.2, 0] }, \
         { time_s = 1, eye = [1, 1, 2], target = [0, 0.2, 0] }]\n\
         [[model]]\npackage = \"hare.pelage\"\nclip = \"EarBreath\"\n\
         path = [{ time_s = 0, position = [-0.5, 0, 0] }, { time_s = 1, position = [0.5, 0, 0] }]\n\
         [[model]]\npackage = \"torus.pelage\"\nposition = [0, 0.2, -1]\nscale = 0.3\n",
    );
    std::fs::create_dir(sandbox.path().join("whole")).unwrap();
    std::fs::create_dir(sandbox.path().join("out")).unwrap();
    let (whole, _) = rendered(&sandbox, &["a.toml", "-o", "whole/%04d.png"]);
    assert_eq!((&whole["frames"], &whole["skipped"]), (&14.into(), &0.into()));

    let args = ["a.toml", "-o", "out/%04d.png"];
    let journal = sandbox.path().join("out/%04d.png.pictures.jsonl");
    let lines = || std::fs::read_to_string(&journal).map_or(0, |text| text.matches('\n').count());
    let mut child = sandbox
        .command(&[&["render"], &args[..]].concat())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while lines() < 3 {
        assert_eq!(child.try_wait().unwrap(), None, "it ended before it could be killed");
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let kept = lines();
    assert!(kept < 14);
    let saved = std::fs::read(&journal).unwrap();
    // Overwrites one picture and removes another.
    sandbox.write("out/0001.png", b"red");
    std::fs::remove_file(sandbox.path().join("out/0002.png")).unwrap();

    let same = || {
        for i in 0..14 {
            let name = format!("{i:04}.png");
            assert!(sandbox.read(&format!("out/{name}")) == sandbox.read(&format!("whole/{name}")), "{name}");
        }
        assert!(!journal.exists(), "the journal must be removed when all pictures are complete");
    };
    let (value, run) = rendered(&sandbox, &args);
    assert_eq!(value["skipped"], kept - 2, "{}", run.stderr);
    assert!(run.stderr.contains(&format!("{} of 14 pictures exist", kept - 2)), "{}", run.stderr);
    same();
    // The report must repeat the results of the earlier run.
    for key in ["covered_pixels_per_picture", "mean_luminance_per_picture", "passes", "detail"] {
        assert_eq!(value[key], whole[key], "{key}");
    }

    // With another view or with `--restart`, all pictures must be drawn again; with the same view, none.
    for (more, skipped, word) in [
        (
            &["--background", "1,2,3"][..],
            0,
            format!("pictures to draw again: {kept}, because scene, view, tool or adapter have changed"),
        ),
        (
            &["--fps", "23"],
            0,
            format!("pictures to draw again: {kept}, because scene, view, tool or adapter have changed"),
        ),
        (&["--restart"], 0, String::new()),
        (&[], kept, format!("{kept} of 14 pictures exist")),
    ] {
        std::fs::write(&journal, &saved).unwrap();
        let (value, run) = rendered(&sandbox, &[&args[..], more].concat());
        assert_eq!(value["skipped"], skipped, "{more:?}: {}", run.stderr);
        assert!(run.stderr.contains(&word), "{more:?}: {}", run.stderr);
    }
    same();
    // A changed scene file must count as another scene, and a changed package of the same name as another package.
    let text = std::fs::read_to_string(sandbox.path().join("a.toml")).unwrap();
    sandbox.write("a.toml", text.replace("0.3\n", "0.31\n"));
    std::fs::write(&journal, &saved).unwrap();
    assert_eq!(rendered(&sandbox, &args).0["skipped"], 0);
    sandbox.write("a.toml", text);
    std::fs::copy(sandbox.path().join("hare.pelage"), sandbox.path().join("torus.pelage")).unwrap();
    std::fs::write(&journal, &saved).unwrap();
    assert_eq!(rendered(&sandbox, &args).0["skipped"], 0);
}

/// Draws every scene in assets, with small packages of the models that it uses.
#[test]
fn asset_scenes_can_be_drawn() {
    let Some(_) = gpu("asset_scenes_can_be_drawn") else { return };
    let sandbox = Sandbox::new();
    let mut scenes = Vec::new();
    walk(&workspace().join("assets/scenes"), &mut scenes);
    assert!(!scenes.is_empty());
    for scene in scenes {
        let text = std::fs::read_to_string(&scene).unwrap();
        // Packages have the names of their models.
        let named = text.lines().filter_map(|line| line.strip_prefix("package = \"")?.strip_suffix(".pelage\""));
        for name in named.clone() {
            let asset = |path: String| workspace().join("assets").join(path).display().to_string();
            let (model, recipe) = (asset(format!("models/{name}.glb")), asset(format!("recipes/{name}.toml")));
            let args = [&model, "--recipe", &recipe, "-o", &format!("{name}.pelage")];
            sandbox.fixture(&[&args, &SMALL[..]].concat());
        }
        sandbox.write("scene.toml", &text);
        let small = ["scene.toml", "-o", "scene.png", "--size", "167x85", "--style", "bare"];
        let moment = |time: &str| rendered(&sandbox, &[&small[..], &["--time", time]].concat()).0;
        let (start, end) = (moment("0"), moment("2"));
        assert_eq!(start["scene"]["models"].as_array().unwrap().len(), named.count());
        for picture in [&start, &end] {
            assert!(picture["covered_pixels"].as_u64() > Some(500), "{}: {picture}", scene.display());
        }
    }
}
