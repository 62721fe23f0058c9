//! Tests of environment maps with the real binary: lights fitted to panoramas, invalid files, and pictures lit by
//! panoramas or by fitted lights.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_formats::meaning::srgb_to_linear;
use pelage_lab::chart::multiple::Squares;
use pelage_needs::data;
use pelage_stage::sky::{Environment, Sun, environment_from_toml, environment_to_toml};
use pelage_tests::binary::{Sandbox, workspace};
use pelage_tests::gpu::gpu;
use pelage_tests::schema;

/// Checks real skies of 1k × 512. The fit must keep the total light, be fast, and read back from its file as reported.
/// Errors of broken files must name the file and the fault.
#[test]
fn skies_are_fitted_by_few_lights() {
    let Some(data) = data("skies_are_fitted_by_few_lights") else { return };
    let sandbox = Sandbox::new();
    // Columns: name, and largest allowed error of the lobes' radiance. Lobes cannot represent sources smaller than 8
    // degrees.
    let skies = [
        ("venice_sunset_1k", 0.65),
        ("spiaggia_di_mondello_1k", 0.25),
        ("studio_small_03_1k", 0.55),
        ("dikhololo_night_1k", 0.45),
    ];
    for (name, most) in skies {
        let path = data.join("hdr").join(name).with_extension("hdr");
        let run = sandbox.run(&["sky", path.to_str().unwrap(), "-o", "sky.toml", "--json"]);
        let told = schema::parse_success(&run, "sky");
        let number = |key: &str| told[key].as_f64().unwrap();
        println!("{name}: {told}");
        assert!(number("energy") < 0.01 && number("error") < most, "{name}: {told}");
        assert_eq!(told["size"], serde_json::json!([1024, 512]));
        let text = std::fs::read_to_string(sandbox.path().join("sky.toml")).unwrap();
        let lights = environment_from_toml("sky.toml", &text).unwrap();
        assert_eq!(told["lobes"], lights.lobes.len());
        assert!(lights.fault().is_none() && lights.lobes.len() <= 16, "{lights:?}");
        let fewer = sandbox.run(&["sky", "sky.toml", "-o", "fewer.toml", "--lobes", "4"]);
        assert_eq!(fewer.code, Some(0), "{fewer:?}");
        let text = std::fs::read_to_string(sandbox.path().join("fewer.toml")).unwrap();
        let fewer = environment_from_toml("fewer.toml", &text).unwrap();
        assert_eq!(fewer.lobes.len(), 4);
        assert!((fewer.total() / lights.total() - 1.0).abs().max_element() < 1e-4, "{fewer:?}");
    }
    for (name, expected) in [
        ("broken/spiaggia_di_mondello_cut_in_header.hdr", "header: cannot be decoded"),
        ("broken/spiaggia_di_mondello_cut_in_pixels.hdr", "pixels: cannot be decoded"),
    ] {
        let path = data.join("hdr").join(name);
        let run = sandbox.run(&["sky", path.to_str().unwrap(), "-o", "broken.toml"]);
        assert_eq!(run.code, Some(3), "{run:?}");
        assert!(run.stderr.contains(name) && run.stderr.contains(expected), "{run:?}");
        assert!(!sandbox.path().join("broken.toml").exists());
    }
}

#[test]
fn environment_can_be_a_colour_or_a_file() {
    let sandbox = Sandbox::new();
    sandbox.write("torus.glb", std::fs::read(workspace().join("assets/models/torus.glb")).unwrap());
    let sets = ["slice.layers=4", "shading.model=marschner", "hair.density=100", "ink.enabled=false"];
    let sets = sets.map(|set| ["--set", set]).concat();
    assert_eq!(sandbox.run(&[&["bake", "torus.glb", "-o", "t.pelage"], &sets[..]].concat()).code, Some(0));
    let mean = |arguments: &[&str]| {
        let words = ["reference", "t.pelage", "-o", "t.exr", "--size", "24x24", "--samples", "4"];
        let run = sandbox.run(&[&words[..], arguments].concat());
        assert_eq!(run.code, Some(0), "{run:?}");
        let picture = image::open(sandbox.path().join("t.exr")).unwrap().into_rgba32f();
        picture.pixels().map(|p| p.0[1]).sum::<f32>()
    };
    let [dim, bright] = ["0.5,0.5,0.5", "1,1,1"].map(|sky| mean(&["--environment", sky]));
    assert!((bright / dim - 2.0).abs() < 1e-4, "{dim} {bright}");
    let same = mean(&["--environment", "0.5,0.5,0.5", "--environment-strength", "2"]);
    assert!((same / bright - 1.0).abs() < 1e-5, "{same} {bright}");
    // In a look file, a path is relative to the folder of that file.
    sandbox.write("looks/sky.toml", "even = [1.0, 1.0, 1.0]\n");
    sandbox.write("looks/l.toml", "[environment]\nsky = \"sky.toml:30\"\n");
    let filed = mean(&["--look", "looks/l.toml"]);
    assert!((filed / bright - 1.0).abs() < 1e-5, "{filed} {bright}");
    // The sun of an environment file becomes the key light. An explicit light shines in addition to the sky.
    let sunny = Environment { sun: Some(Sun { towards: [0.3, 1.0, 0.5], color: [1.0; 3] }), ..Environment::default() };
    sandbox.write("sun.toml", environment_to_toml(&sunny));
    let words = ["--light", "0.3,1,0.5", "--light-strength", "1", "--environment", "0,0,0", "--penumbra", "0.15"];
    let [sun, key] = [mean(&["--environment", "sun.toml"]), mean(&words)];
    assert!((sun / key - 1.0).abs() < 1e-4, "{sun} {key}");
    for (sky, expected) in [
        ("none.hdr", "none.hdr: cannot read"),
        ("sky.png", "the path of a .hdr, .exr or .toml"),
        ("1,2", "the path of a .hdr, .exr or .toml"),
        ("-1,0,0", "the path of a .hdr, .exr or .toml"),
        ("looks/l.toml", "line 1, environment: unknown field"),
    ] {
        let run = sandbox.run(&["reference", "t.pelage", "-o", "x.png", &format!("--environment={sky}")]);
        assert!(run.code != Some(0) && run.stderr.contains(expected), "{sky}: {run:?}");
    }
}

/// Checks that the sky is visible behind a traced picture. A ground must colour the lower half of the picture, and the
/// light from below.
#[test]
fn sky_is_visible_behind_the_model_and_above_a_ground() {
    let sandbox = Sandbox::new();
    sandbox.write("torus.glb", std::fs::read(workspace().join("assets/models/torus.glb")).unwrap());
    assert_eq!(sandbox.run(&["bake", "torus.glb", "-o", "t.pelage", "--set", "slice.layers=4"]).code, Some(0));
    let words = ["reference", "t.pelage", "-o", "t.png", "--size", "32x32", "--samples", "2"];
    let picture = |arguments: &[&str]| {
        let run = sandbox.run(&[&words[..], arguments].concat());
        assert_eq!(run.code, Some(0), "{run:?}");
        image::open(sandbox.path().join("t.png")).unwrap().into_rgba8()
    };
    let level = ["--camera", "0,0,9/0,0,0/90", "--background", "sky"];
    let plain = picture(&[&level[..], &["--environment", "0.2,0.4,0.8"]].concat());
    // Linear 0.2, 0.4 and 0.8 are 124, 170 and 231 in 8-bit sRGB.
    assert_eq!(plain.get_pixel(0, 0).0, [124, 170, 231, 255]);
    assert_eq!(plain.get_pixel(31, 31).0, [124, 170, 231, 255]);
    let ground = [&level[..], &["--environment", "1,1,1", "--environment-strength", "0.25", "--ground", "#ff0000"]];
    let over = picture(&ground.concat());
    let [above, below] = [0, 31].map(|y| over.get_pixel(16, y).0);
    assert!(above[2] > 110 && below[2] < 80 && below[0] > 120, "{above:?} {below:?}");
    // The fitted lights over a ground are written as a file.
    sandbox.write("even.toml", "even = [1.0, 1.0, 1.0]\n");
    let run = sandbox.run(&["sky", "even.toml", "-o", "over.toml", "--ground", "#000000"]);
    assert_eq!(run.code, Some(0), "{run:?}");
    let lights =
        environment_from_toml("over.toml", &std::fs::read_to_string(sandbox.path().join("over.toml")).unwrap());
    let lights = lights.unwrap();
    let [up, down] = [1.0, -1.0].map(|y| lights.radiance(glam::DVec3::new(0.0, y, 0.0)).x);
    assert!((up - 1.0).abs() < 0.15 && down.abs() < 0.15, "{up} {down}: {lights:?}");
    for (arguments, expected) in [
        (&["--background", "sky"][..], "expected --environment as well"),
        (&["--environment", "1,1,1", "--ground", "grass"], "expected \"none\""),
    ] {
        let run = sandbox.run(&[&words[..], arguments].concat());
        assert_eq!(run.code, Some(1), "{run:?}");
        assert!(run.stderr.contains(expected), "{run:?}");
    }
    assert!(sandbox.run(&["sky", "even.toml", "-o", "x.toml", "--ground", "1,2"]).stderr.contains("#rrggbb"));
}

/// Compares the built-in hare, as it comes, with its traced picture: mean light, light of squares, and dark specks.
#[test]
fn fur_in_the_studio_is_as_bright_as_in_the_reference() {
    if gpu("fur_in_the_studio_is_as_bright_as_in_the_reference").is_none() {
        return;
    }
    let sandbox = Sandbox::new();
    let model = workspace().join("assets/models/hare.glb").to_str().unwrap().to_owned();
    assert_eq!(sandbox.run(&["bake", &model, "-o", "hare.pelage", "-q"]).code, Some(0));
    let picture = |command: &str, samples: &str| {
        let words =
            ["hare.pelage", "-o", "hare.png", "--size", "240x180", "--tone-mapping", "off", "--samples", samples];
        let run = sandbox.run(&[&[command], &words[..]].concat());
        assert_eq!(run.code, Some(0), "{run:?}");
        image::open(sandbox.path().join("hare.png")).unwrap().into_rgba8()
    };
    let [frame, truth] = [picture("render", "4"), picture("reference", "24")];
    let squares = Squares::new(&linear(&truth), &frame, frame.width());
    let [specks, of_truth] = [&frame, &truth].map(|picture| dark_specks(&linear(picture), picture.width() as usize));
    let (mean, squares) = (squares.mean(), squares.rmse());
    println!("mean {mean:.3}, squares {squares:.3}, specks {specks:.4}, in the truth {of_truth:.4}");
    assert!(mean.abs() < 0.1, "{mean}");
    assert!(squares < 0.15, "{squares}");
    // The noise of the truth is itself dark specks.
    assert!(specks < 0.008 && specks < of_truth + 0.003, "{specks} and {of_truth}");
}

/// Returns the linear colours of a picture, premultiplied by its opacity.
fn linear(picture: &image::RgbaImage) -> Vec<[f32; 4]> {
    let premultiplied = |p: &image::Rgba<u8>| {
        let opacity = f32::from(p.0[3]) / 255.0;
        let [r, g, b] = [0, 1, 2].map(|i| srgb_to_linear(p.0[i]) * opacity);
        [r, g, b, opacity]
    };
    picture.pixels().map(premultiplied).collect()
}

/// Returns the share of opaque pixels whose green is below a quarter of the mean of the 25 pixels about them.
fn dark_specks(picture: &[[f32; 4]], width: usize) -> f64 {
    let height = picture.len() / width;
    let (mut dark, mut all) = (0.0, 0.0);
    for (x, y) in (2..height - 2).flat_map(|y| (2..width - 2).map(move |x| (x, y))) {
        let about = || (y - 2..=y + 2).flat_map(|y| (x - 2..=x + 2).map(move |x| picture[y * width + x]));
        if about().all(|p| p[3] > 0.98) {
            let mean = about().map(|p| p[1]).sum::<f32>() / 25.0;
            all += 1.0;
            dark += f64::from(u8::from(picture[y * width + x][1] < 0.25 * mean));
        }
    }
    dark / all
}
