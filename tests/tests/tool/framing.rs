//! Tests with the real binary: default camera and its framing, exposure of white surfaces, and the ground.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_tests::binary::{Sandbox, workspace};
use pelage_tests::gpu::gpu;
use pelage_tests::schema;
use serde_json::Value;

/// Bake settings for small textures, in formats that need no encoder.
const SMALL: &str = "--set slice.tile_texels=32 --set slice.layers=4 --set hair.density=60 \
    --set pack.shell_format=rgba8 --set pack.direction_format=rg8 --set pack.base_color_format=rgba8 \
    --set shading.model=kajiya-kay";

/// Returns a folder with `hare.pelage`.
fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    let model = workspace().join("assets/models/hare.glb");
    let args = vec![model.to_str().unwrap(), "-o", "hare.pelage"];
    sandbox.fixture(&[args, SMALL.split_whitespace().collect()].concat());
    sandbox
}

#[track_caller]
fn rendered(sandbox: &Sandbox, line: &str) -> Value {
    let args: Vec<&str> = ["render", "--json", "hare.pelage", "--size", "160x120"].into_iter().collect();
    let run = sandbox.run(&[args, line.split_whitespace().collect()].concat());
    assert_eq!(run.code, Some(0), "{line}: {run:?}");
    schema::parse_answer(&run, "render")
}

fn camera(sandbox: &Sandbox, line: &str) -> String {
    rendered(sandbox, &format!("{line} -o a.png"))["camera"].as_str().unwrap().to_owned()
}

/// Parses the numbers of a camera: eye, target and vertical field of view.
fn numbers(camera: &str) -> Vec<f32> {
    camera.split(['/', ',']).map(|n| n.parse().unwrap()).collect()
}

fn open(sandbox: &Sandbox, name: &str) -> image::RgbaImage {
    image::open(sandbox.path().join(name)).unwrap().to_rgba8()
}

/// Returns whether the picture shows something that does not touch its border.
fn is_whole(picture: &image::RgbaImage) -> bool {
    let (w, h) = picture.dimensions();
    let covered =
        |(x, y, p): &(u32, u32, &image::Rgba<u8>)| p.0[3] > 0 && (*x == 0 || *y == 0 || x + 1 == w || y + 1 == h);
    picture.pixels().any(|p| p.0[3] > 0) && !picture.enumerate_pixels().any(|pixel| covered(&pixel))
}

#[test]
fn printed_camera_reproduces_the_picture() {
    let Some(_) = gpu("printed_camera_reproduces_the_picture") else { return };
    let sandbox = sandbox();
    for line in ["--crowd 12 --clip Walk --time 0.2", "--orbit=-35,20,1.7", "--look-at head --orbit 20,5"] {
        let camera = camera(&sandbox, line);
        // Framing options cannot be combined with a camera.
        let line = if line.contains("orbit") { "" } else { line };
        rendered(&sandbox, &format!("{line} --camera={camera} -o b.png"));
        let bytes = |name: &str| std::fs::read(sandbox.path().join(name)).unwrap();
        assert!(bytes("a.png") == bytes("b.png"), "{line}: {camera}");
    }
}

#[test]
fn all_styles_use_the_same_camera() {
    let Some(_) = gpu("all_styles_use_the_same_camera") else { return };
    let sandbox = sandbox();
    let fur = camera(&sandbox, "");
    assert_eq!(camera(&sandbox, "--style bare"), fur);
    assert_eq!(camera(&sandbox, "--style ink"), fur);
}

#[test]
fn crowds_clips_and_turntables_stay_in_the_picture() {
    let Some(_) = gpu("crowds_clips_and_turntables_stay_in_the_picture") else { return };
    let sandbox = sandbox();
    for line in ["--crowd 12", "--crowd 5 --orbit 180,60 --clip Walk"] {
        rendered(&sandbox, &format!("{line} -o a.png"));
        assert!(is_whole(&open(&sandbox, "a.png")), "{line}");
    }
    for line in ["--clip Walk", "--auto-rotate --turn-light --orbit 0,70", "--auto-rotate --clip Walk"] {
        rendered(&sandbox, &format!("{line} --frames 7 --fps 7 -o a_%d.png"));
        let pictures: Vec<_> = (0..7).map(|i| open(&sandbox, &format!("a_{i}.png"))).collect();
        assert!(pictures.iter().all(is_whole), "{line}");
        assert!(pictures[1..].iter().all(|picture| *picture != pictures[0]), "{line}: nothing moves");
    }
}

#[test]
fn orbit_option_rotates_and_zooms() {
    let Some(_) = gpu("orbit_option_rotates_and_zooms") else { return };
    let sandbox = sandbox();
    let way = |line: &str| {
        let n = numbers(&camera(&sandbox, line));
        [n[0] - n[3], n[1] - n[4], n[2] - n[5]]
    };
    let [x, y, z] = way("--orbit 0,0");
    assert!(x.abs() < 1e-3 && y.abs() < 1e-3 && z > 0.1, "in front: {x} {y} {z}");
    let [x, _, z] = way("--orbit 90,0");
    assert!(x > 0.1 && z.abs() < 1e-3, "at the left: {x} {z}");
    let [x, y, z] = way("--orbit 0,90");
    assert!(x.abs() < 1e-3 && y > 0.1 && z.abs() < 1e-3, "above: {x} {y} {z}");
    let pixels = |line: &str| rendered(&sandbox, &format!("{line} -o a.png"))["covered_pixels"].as_u64().unwrap();
    let (far, plain, near) = (pixels("--orbit 40,10,0.5"), pixels("--orbit 40,10"), pixels("--orbit 40,10,1.5"));
    assert!(2 * far < plain && plain < near, "{far} {plain} {near}");
    assert!(camera(&sandbox, "--look-at head") != camera(&sandbox, ""));
}

#[test]
fn camera_option_errors_are_reported() {
    let sandbox = sandbox();
    let run = |line: &str| {
        let args: Vec<&str> = line.split_whitespace().collect();
        sandbox.run(&args)
    };
    for (line, words) in [
        ("render hare.pelage -o a.png --camera 0,1,2/0,0,0/30 --orbit 1,2", "--orbit"),
        ("render hare.pelage -o a.png --camera 0,1,2/0,0,0/30 --look-at Head", "--look-at"),
        ("render hare.pelage -o a.png --auto-rotate", "--auto-rotate: expected --frames"),
        ("doctor hare.pelage --camera 0,1,2/0,0,0/30 --orbit 1,2", "--orbit"),
        ("doctor hare.pelage --look-at Trunk", "look-at \"Trunk\": no material and no joint"),
        ("reference hare.pelage -o a.png --size 8x8 --look-at Trunk", "has the materials"),
    ] {
        let run = run(line);
        assert_eq!(run.code, Some(1), "{line}: {run:?}");
        assert!(run.stderr.contains(words), "{line}: {}", run.stderr);
    }
    assert!(run("doctor hare.pelage --look-at Trunk").stderr.contains("and the joints \""));
}

/// Returns a white sphere of one metre as OBJ text, without materials.
fn sphere() -> String {
    use std::fmt::Write as _;
    let (rings, sides) = (16u32, 32u32);
    let mut text = String::new();
    for ring in 0..=rings {
        for side in 0..sides {
            let (a, b) =
                (std::f32::consts::PI * ring as f32 / rings as f32, std::f32::consts::TAU * side as f32 / sides as f32);
            let (x, y, z) = (a.sin() * b.sin(), a.cos(), a.sin() * b.cos());
            writeln!(text, "v {x} {y} {z}\nvn {x} {y} {z}").unwrap();
        }
    }
    for ring in 0..rings {
        for side in 0..sides {
            let at = |r: u32, s: u32| (ring + r) * sides + (side + s) % sides + 1;
            let [a, b, c, d] = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
            writeln!(text, "f {a}//{a} {b}//{b} {c}//{c} {d}//{d}").unwrap();
        }
    }
    text
}

#[test]
fn white_sphere_without_fur_is_shaded() {
    let Some(_) = gpu("white_sphere_without_fur_is_shaded") else { return };
    let sandbox = Sandbox::new();
    std::fs::write(sandbox.path().join("sphere.obj"), sphere()).unwrap();
    let bake: Vec<&str> = "bake sphere.obj -o hare.pelage".split(' ').collect();
    let run = sandbox.run(&[bake, SMALL.split_whitespace().collect()].concat());
    assert_eq!(run.code, Some(0), "{run:?}");
    for light in ["", "--fill-light -1,0.2,1/0.5"] {
        rendered(&sandbox, &format!("--style bare {light} -o a.png"));
        let picture = open(&sandbox, "a.png");
        let covered: Vec<[u8; 4]> = picture.pixels().map(|p| p.0).filter(|p| p[3] == 255).collect();
        let clipped = covered.iter().filter(|p| p[..3] == [255; 3]).count() as f64 / covered.len() as f64;
        let mut greens: Vec<u8> = covered.iter().map(|p| p[1]).collect();
        greens.sort_unstable();
        let spread = greens[greens.len() * 9 / 10] - greens[greens.len() / 10];
        // Only the highlight may be white. If the lights summed to 1.55, half of the sphere would be clipped.
        assert!(clipped < 0.02, "{light}: {clipped} of the pixels are white");
        assert!(spread > 60, "{light}: nine tenths of the pixels lie within {spread} of 255");
        assert!(greens[greens.len() - 1] > 235, "{light}: the brightest is {}", greens[greens.len() - 1]);
    }
}

/// Checks that a ground darkens only pixels beside the hare, most at its feet, and that a studio fills the picture.
#[test]
fn models_cast_a_soft_shadow_on_the_ground() {
    let Some(_) = gpu("models_cast_a_soft_shadow_on_the_ground") else { return };
    let sandbox = sandbox();
    let drawn = |line: &str| {
        rendered(&sandbox, &format!("--environment studio --orbit 40,25,.6 {line} -o a.png"));
        open(&sandbox, "a.png")
    };
    let [plain, shadow] = ["", "--look picture.ground_shadow=true"].map(drawn);
    // Pixels that hair covers by less than half a step of alpha have its colour where the ground is opaque.
    let (mut darkest, mut coloured) = (0, 0);
    for (before, after) in plain.pixels().zip(shadow.pixels()) {
        if before.0[3] == 255 {
            assert_eq!(before, after);
        } else if before.0[3] == 0 {
            coloured += u32::from(after.0[..3] != [0; 3]);
            darkest = darkest.max(after.0[3]);
        }
    }
    assert!((100..=217).contains(&darkest) && coloured < 20, "{darkest} {coloured}");
    let lowest = plain.enumerate_pixels().filter(|(_, _, p)| p.0[3] == 255).map(|(_, y, _)| y).max().unwrap();
    let dark = |y: u32| (0..shadow.width()).map(|x| u32::from(shadow.get_pixel(x, y).0[3])).sum::<u32>();
    assert!(dark(lowest) > 4 * dark((lowest + 12).min(119)), "{} {}", dark(lowest), dark(lowest + 12));
    assert_eq!([(0, 0), (159, 0), (0, 119)].map(|(x, y)| shadow.get_pixel(x, y).0[3]), [0; 3]);
    let studio = drawn("--background studio");
    assert!(studio.pixels().all(|p| p.0[3] == 255));
    let [wall, floor] = [0, 119].map(|y| studio.get_pixel(0, y).0);
    assert!(floor[1] > wall[1] + 20, "{wall:?} {floor:?}");
}

/// Checks that a stop doubles the light, and that tone mapping keeps bright colours below white.
#[test]
fn exposure_and_tone_mapping_change_the_light_alone() {
    let Some(_) = gpu("exposure_and_tone_mapping_change_the_light_alone") else { return };
    let sandbox = sandbox();
    let mean = |line: &str| {
        let drawn = rendered(&sandbox, &format!("--samples 1 --hair shells {line} -o a.png"));
        drawn["mean_luminance_per_picture"][0].as_f64().unwrap()
    };
    for light in ["", "--environment 0.4,0.5,0.6", "--light-strength .5 --fill-light 1,0,0/.2"] {
        let [dark, bright] = ["-3", "-2"].map(|stops| mean(&format!("{light} --look picture.exposure={stops}")));
        assert!((bright / dark - 2.0).abs() < 0.05, "{light}: {dark} {bright}");
    }
    let over = |tone: &str| {
        mean(&format!("--look picture.exposure=4 --look picture.tone_mapping={tone}"));
        let picture = open(&sandbox, "a.png");
        picture.pixels().filter(|p| p.0[3] == 255 && p.0[..3].contains(&255)).count()
    };
    let [off, filmic] = ["off", "filmic"].map(over);
    assert!(off > 100 && filmic == 0, "{off} {filmic}");
}
