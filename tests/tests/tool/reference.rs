//! Tests of `reference` and `export` with the real binary: strands of a package, traced and exported to other programs.
//! No adapter is needed.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_tests::binary::{Sandbox, workspace};
use pelage_tests::schema;

/// Returns a folder with the built-in torus as `torus.pelage`. It has no ink, which does not affect strands.
fn torus(settings: &[&str]) -> Sandbox {
    let sandbox = Sandbox::new();
    let model = workspace().join("assets/models/torus.glb");
    let recipe = workspace().join("assets/recipes/torus.toml");
    let (model, recipe) = (model.to_str().unwrap(), recipe.to_str().unwrap());
    let mut args = vec![model, "--recipe", recipe, "-o", "torus.pelage", "--set", "ink.enabled=false"];
    args.extend(settings.iter().flat_map(|s| ["--set", s]));
    sandbox.fixture(&args);
    sandbox
}

const SMALL: [&str; 6] = ["reference", "torus.pelage", "--size", "96x64", "--samples", "8"];

#[test]
fn reference_picture_does_not_depend_on_thread_count() {
    let sandbox = torus(&[]);
    let trace = |threads: &str, name: &str| {
        let run = sandbox.run(&[&SMALL[..], &["--threads", threads, "-o", name, "--json"]].concat());
        (schema::parse_success(&run, "reference"), std::fs::read(sandbox.path().join(name)).unwrap())
    };
    let (one, bytes) = trace("1", "one.png");
    let (four, same) = trace("4", "four.png");
    assert_eq!(bytes, same);
    for key in ["strands", "segments", "primary_rays", "shadow_rays", "covered_pixels"] {
        assert!(one[key].as_u64().unwrap() > 0 && one[key] == four[key], "{key}: {one} {four}");
    }
    assert_eq!(one["primary_rays"], 96 * 64 * 8);
    let picture = image::open(sandbox.path().join("one.png")).unwrap().to_rgba8();
    assert_eq!(picture.dimensions(), (96, 64));
    let covered = picture.pixels().filter(|p| p.0[3] > 0).count();
    assert_eq!(one["covered_pixels"], covered as u64);
    assert!((500..5000).contains(&covered), "{covered} pixels");
}

#[test]
fn time_limit_ends_with_equally_many_samples_of_each_pixel() {
    let sandbox = torus(&["hair.density=60"]);
    let trace = |more: &[&str]| {
        let run = sandbox.run(&[&["reference", "torus.pelage", "--size", "48x32", "--json"], more].concat());
        assert!(run.stderr.contains("note: expected "), "{run:?}");
        schema::parse_success(&run, "reference")
    };
    let least = trace(&["--seconds", "1e-6", "-o", "least.png"]);
    assert_eq!((&least["spp"], &least["out_of_time"]), (&1.into(), &true.into()));
    let some = trace(&["--seconds", "0.3", "-o", "some.png"]);
    let samples = some["spp"].as_u64().unwrap();
    assert!(samples >= 1 && some["primary_rays"] == 48 * 32 * samples && some["seconds"].as_f64().unwrap() < 5.0);
    let same = trace(&["--samples", &samples.to_string(), "-o", "same.png"]);
    assert_eq!((&same["spp"], &same["out_of_time"]), (&samples.into(), &false.into()));
    assert_eq!(sandbox.read("some.png"), sandbox.read("same.png"), "{samples} samples");
    let both = trace(&["--samples", "2", "--seconds", "60", "-o", "both.png"]);
    assert_eq!((&both["spp"], &both["out_of_time"]), (&2.into(), &false.into()));
    let run = sandbox.run(&["reference", "torus.pelage", "-o", "a.part", "--part", "1/2", "--seconds", "9"]);
    assert!(run.code == Some(1) && run.stderr.contains("cannot be used with"), "{run:?}");
}

#[test]
fn store_page_command_of_the_guide_draws_on_paper() {
    let command = |page: &str| {
        let text = std::fs::read_to_string(workspace().join("bake/docs").join(page)).unwrap();
        text.lines().find(|line| line.contains(" -o store.png ")).unwrap().trim().to_owned()
    };
    assert_eq!(command("artists.md"), command("artists.zh-CN.md"));
    let line = command("artists.md").replace("hare.pelage", "torus.pelage").replace("1200x1200", "48x48");
    let line = line.replace("--seconds 600", "--samples 2");
    let sandbox = torus(&["hair.density=60"]);
    let words: Vec<&str> = line.strip_prefix("pelage ").unwrap().split(' ').collect();
    let run = sandbox.run(&words);
    assert_eq!(run.code, Some(0), "{run:?}");
    let picture = image::open(sandbox.path().join("store.png")).unwrap().to_rgba8();
    let paper = image::Rgba([238, 234, 228, 255]);
    assert_eq!((picture.dimensions(), *picture.get_pixel(0, 0)), ((48, 48), paper));
    let covered = picture.pixels().filter(|pixel| **pixel != paper).count();
    assert!((300..2000).contains(&covered) && picture.pixels().all(|pixel| pixel.0[3] == 255), "{covered}");
}

#[test]
fn light_options_change_the_reference_picture() {
    let sandbox = torus(&["shading.model=kajiya-kay"]);
    let mean = |more: &[&str]| {
        let run = sandbox.run(&[&SMALL[..], &["-o", "a.exr"], more].concat());
        assert_eq!(run.code, Some(0), "{run:?}");
        let picture = image::open(sandbox.path().join("a.exr")).unwrap().to_rgba32f();
        let sum = |channel: usize| picture.pixels().map(|p| f64::from(p.0[channel])).sum::<f64>();
        (sum(1), sum(3))
    };
    let (full, alpha) = mean(&[]);
    let (unshadowed, same_alpha) = mean(&["--self-shadow", "off", "--soft-shadow", "off"]);
    let (skin, skin_alpha) = mean(&["--style", "bare"]);
    let (below, _) = mean(&["--light", "0,-1,0"]);
    assert!(full < 0.98 * unshadowed && (alpha - same_alpha).abs() < 1e-3, "{full} {unshadowed}");
    assert!(skin_alpha < alpha && skin > 0.0, "the skin alone covers {skin_alpha}, with fur {alpha}");
    assert!((below - full).abs() > 0.02 * full, "{below} {full}");
    assert!(mean(&["--ambient-attenuation", "off"]).0 > full && mean(&["--fill-light", "1,0,0/0.5"]).0 > full);
}

#[test]
fn strands_and_mesh_are_exported() {
    let sandbox = torus(&["hair.density=60", "shading.model=kajiya-kay"]);
    for extension in ["txt", "pbrt", "glb", "hair", "usda"] {
        let name = format!("strands.{extension}");
        let run = sandbox.run(&["export", "torus.pelage", "--strands", &name, "--mesh", "skin.obj", "--json"]);
        let object = schema::parse_success(&run, "export");
        let bytes = std::fs::read(sandbox.path().join(&name)).unwrap();
        let (strands, segments) = (object["strands"].as_u64().unwrap(), object["segments"].as_u64().unwrap());
        assert!(strands > 100 && segments >= strands, "{object}");
        let points = strands + segments;
        match extension {
            "txt" => {
                let text = String::from_utf8(bytes).unwrap();
                assert_eq!(text.lines().filter(|l| l.is_empty()).count() as u64, strands - 1);
                assert_eq!(text.lines().filter(|l| l.split(' ').count() == 4).count() as u64, points);
            }
            "pbrt" => assert_eq!(String::from_utf8(bytes).unwrap().matches("Shape \"curve\"").count() as u64, segments),
            "glb" => assert!(bytes.starts_with(b"glTF") && bytes.len() as u64 > 28 * points + 8 * segments),
            "usda" => {
                let text = String::from_utf8(bytes).unwrap();
                let points_of = |line: &str| line.matches('(').count() as u64;
                let list = text.split("point3f[] points = [").nth(1).unwrap().split(']').next().unwrap();
                assert_eq!((list.lines().count() as u64, points_of(list)), (strands, points));
                assert!(text.starts_with("#usda 1.0\n") && text.contains("def BasisCurves \"coat\"\n"));
            }
            _ => assert_eq!(bytes.len() as u64, 128 + 2 * strands + 28 * points),
        }
        assert_eq!(object["groups"], serde_json::json!([{ "name": "coat", "first": 0, "strands": strands }]));
        assert_eq!(object["files"], serde_json::json!([name, "skin.obj", "skin.mtl"]));
        let obj = std::fs::read_to_string(sandbox.path().join("skin.obj")).unwrap();
        assert_eq!(obj.lines().filter(|l| l.starts_with("f ")).count() as u64, object["triangles"].as_u64().unwrap());
        let mtl = std::fs::read_to_string(sandbox.path().join("skin.mtl")).unwrap();
        let used = obj.lines().filter_map(|l| l.strip_prefix("usemtl "));
        assert!(
            used.clone().count() > 0 && used.clone().all(|name| mtl.contains(&format!("newmtl {name}\n"))),
            "{mtl}"
        );
    }
    for (args, word) in [
        (&["--strands", "a.abc"][..], ".txt, .pbrt, .glb, .hair, .usda"),
        (
            &["--strands", "a.txt", "--group", "mane"],
            "--group mane: no such group of strands in torus.pelage, expected coat",
        ),
        (&["--mesh", "a.ply"], "ends in .obj"),
        (&[], "--strands"),
        (&["--strands", "a.txt", "--clip", "Walk"], "no such clip"),
    ] {
        let run = sandbox.run(&[&["export", "torus.pelage"], args].concat());
        assert!(run.code == Some(1) && run.stderr.contains(word), "{args:?}: {run:?}");
    }
    let part = |more: &[&str]| {
        let run = sandbox.run(&[&["export", "torus.pelage", "--strands", "part.txt", "--json"], more].concat());
        schema::parse_success(&run, "export")["groups"][0]["strands"].as_u64().unwrap()
    };
    assert_eq!(part(&["--group", "coat"]), part(&[]));
    assert_eq!(part(&["--group", "coat", "--every", "3"]), part(&[]).div_ceil(3));
    let run = sandbox.run(&["export", "torus.pelage", "--strands", "no-folder/a.txt"]);
    assert!(run.code == Some(2) && run.stderr.contains("no-folder"), "{run:?}");
}

#[test]
fn reference_option_errors_are_reported() {
    let sandbox = torus(&[]);
    for (more, word) in [
        (&["-o", "a.jpg"][..], ".png or .exr"),
        (&["-o", "a.png", "--layers", "4"], "--layers applies to"),
        (&["-o", "a.png", "--fins", "on"], "--fins applies to"),
        (&["-o", "a.png", "--shadow-map", "64"], "--shadow-map applies to"),
        (&["-o", "a.exr", "--background", "1,2,3"], "--background"),
        (&["-o", "a.png", "--clip", "Walk"], "no such clip"),
        (&["-o", "a.png", "--samples", "0"], "0 is not in"),
    ] {
        let run = sandbox.run(&[&["reference", "torus.pelage"], more].concat());
        assert!(run.code == Some(1) && run.stderr.contains(word), "{more:?}: {run:?}");
    }
    // With a changed recipe, the grown strands would not match the slices of the package.
    assert_eq!(sandbox.run(&["unpack", "torus.pelage", "folder", "-q"]).code, Some(0));
    let recipe = std::fs::read_to_string(sandbox.path().join("folder/recipe.toml")).unwrap();
    let wrong: Vec<String> =
        recipe
            .lines()
            .map(|line| {
                if line.starts_with("length_variation = ") { "length_variation = 1.0".into() } else { line.to_owned() }
            })
            .collect();
    sandbox.write("folder/recipe.toml", wrong.join("\n"));
    assert_eq!(sandbox.run(&["pack", "folder", "b.pelage", "-q"]).code, Some(0));
    let run = sandbox.run(&["reference", "b.pelage", "-o", "b.png"]);
    assert!(run.code == Some(3) && run.stderr.contains("b.pelage: the manifest's recipe"), "{run:?}");
    assert!(!sandbox.path().join("b.png").exists());
}
