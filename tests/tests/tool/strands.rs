//! Tests of individual strands with the real binary: they are closer to the traced picture than layers, and
//! reproducible.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_formats::{Limits, Package};
use pelage_tests::binary::{Sandbox, workspace};
use pelage_tests::gpu::gpu;
use pelage_tests::mutate::bases::chunks;
use pelage_tests::schema;

#[test]
fn strands_are_nearer_to_the_reference_than_layers() {
    if gpu("strands_are_nearer_to_the_reference_than_layers").is_none() {
        return;
    }
    let sandbox = Sandbox::new();
    let file = |name: &str| workspace().join(name).to_str().unwrap().to_owned();
    let (model, recipe) = (file("assets/models/hare.glb"), file("assets/recipes/hare.toml"));
    let done = |args: &[&str]| {
        let run = sandbox.run(args);
        assert_eq!(run.code, Some(0), "{run:?}");
        run
    };
    // Scattered light would be noise in the reference image.
    let noiseless = ["--set", "shading.model=kajiya-kay"];
    done(&[&["bake", &model, "--recipe", &recipe, "-o", "hare.pelage", "-q"], &noiseless[..]].concat());
    let size = ["--size", "417x212"];
    done(&[&["reference", "hare.pelage", "-o", "true.png", "--samples", "64"], &size[..]].concat());
    let draw = |hair: &str, name: &str| {
        let how = ["--look", "picture.samples=4", "--detail", "full", "--hair", hair, "-o", name];
        done(&[&["render", "hare.pelage"], &size[..], &how].concat());
        let run = sandbox.run(&["compare", name, "true.png", "--json"]);
        let found = schema::parse_success(&run, "compare");
        found["flip"]["mean"].as_f64().unwrap()
    };
    let [strands, layers] = [draw("strands", "strands.png"), draw("shells", "layers.png")];
    println!("FLIP against the reference image: {strands:.4} in strands, {layers:.4} in layers");
    assert!(strands < 0.85 * layers && strands < 0.014, "{strands} and {layers}");
    draw("strands", "again.png");
    let [first, again] = ["strands.png", "again.png"].map(|name| std::fs::read(sandbox.path().join(name)).unwrap());
    assert!(first == again, "pictures of strands must be reproducible");
}

/// Checks guided hair that hangs from the hare, at rest and in the middle of a jump. It is so thin that each hair
/// matters.
#[test]
fn guided_hair_is_drawn_as_in_the_reference() {
    if gpu("guided_hair_is_drawn_as_in_the_reference").is_none() {
        return;
    }
    let sandbox = Sandbox::new();
    let recipe = std::fs::read_to_string(workspace().join("assets/recipes/hare.toml")).unwrap();
    let groups = "\n[[strands.group]]\nname = \"beard\"\nmaterial = \"Coat*\"\n\
                  hairs = 1500\nguides = 200\nlength_m = 0.12\n\
                  root_radius_m = 0.0006\nroot_color = \"#a04020\"\ntip_color = \"#e0c090\"\nclump = 0.3\n\
                  [[strands.tuft]]\nname = \"whiskers\"\nat = [0.03, 0.4, 0.4]\nmirrored = true\nlength_m = 0.1\n";
    std::fs::write(sandbox.path().join("hare.toml"), recipe + groups).unwrap();
    let model = workspace().join("assets/models/hare.glb").to_str().unwrap().to_owned();
    let done = |args: &[&str]| {
        let run = sandbox.run(args);
        assert_eq!(run.code, Some(0), "{run:?}");
        run
    };
    // Scattered light would be noise in the reference image.
    let noiseless = ["--set", "shading.model=kajiya-kay"];
    done(&[&["bake", &model, "--recipe", "hare.toml", "-o", "hare.pelage", "-q"], &noiseless[..]].concat());
    done(&["validate", "hare.pelage"]);
    let clip =
        schema::parse_success(&done(&["inspect", "hare.pelage", "--json"]), "inspect")["clips"][0]["name"].clone();
    let moving = ["--clip", clip.as_str().unwrap(), "--time", "0.2"];
    for (name, when) in [("rest", &[][..]), ("clip", &moving)] {
        let size = ["--size", "500x400", "--camera", "0.9,0.6,1.2/0,0.22,0/30"];
        let (true_png, drawn_png, bald_png) =
            (format!("{name}_true.png"), format!("{name}.png"), format!("{name}_bald.png"));
        done(&[&["reference", "hare.pelage", "-o", &true_png, "--samples", "48"][..], &size, when].concat());
        let samples = ["--look", "picture.samples=4"];
        done(&[&["render", "hare.pelage", "-o", &drawn_png][..], &size, &samples, when].concat());
        let against = |picture: &str| {
            let found = schema::parse_success(&sandbox.run(&["compare", picture, &true_png, "--json"]), "compare");
            [&found["coverage"], &found["flip"]["mean"]].map(|n| n.as_f64().unwrap())
        };
        let [coverage, flip] = against(&drawn_png);
        // The hare is also baked without the guided hair, for comparison.
        if name == "rest" {
            done(&[
                "bake",
                &model,
                "--recipe",
                &workspace().join("assets/recipes/hare.toml").display().to_string(),
                "-o",
                "bald.pelage",
                "-q",
            ]);
        }
        done(&[&["render", "bald.pelage", "-o", &bald_png][..], &size, &samples, when].concat());
        let [bald_coverage, bald_flip] = against(&bald_png);
        println!(
            "{name}: coverage off by {coverage:.4}, FLIP {flip:.4}; \
             without the hair {bald_coverage:.4} and {bald_flip:.4}"
        );
        assert!(coverage < 0.3 * bald_coverage && flip < 0.5 * bald_flip, "{name}");
    }
}

/// Checks that lines written by `export` are read back as the same guides, whether they are in one file or in two.
#[test]
fn exported_strands_are_read_as_guides() {
    let sandbox = Sandbox::new();
    let model = workspace().join("assets/models/torus.glb").to_str().unwrap().to_owned();
    let group = |keys: &str| {
        format!("[[strands.group]]\nname = \"beard\"\nhairs = 0\npoints = 9\nlength_variation = 0\nstray = 0\n{keys}\n")
    };
    let bake = |recipe: &str, package: &str| {
        sandbox.write("r.toml", recipe);
        let args = ["bake", &model, "--recipe", "r.toml", "-o", package, "-q", "--set", "ink.enabled=false"];
        let small = ["--set", "slice.layers=4", "--set", "slice.tile_texels=16", "--set", "hair.density=20"];
        sandbox.run(&[&args[..], &small].concat())
    };
    let groups = |package: &str| {
        let bytes = std::fs::read(sandbox.path().join(package)).unwrap();
        let opened = Package::open(&bytes, &Limits::default()).unwrap();
        (opened.hair_groups().unwrap(), opened.manifest().inputs.clone())
    };
    let run = bake(&group("guides = 30\nguide_points = 9"), "grown.pelage");
    assert_eq!(run.code, Some(0), "{run:?}");
    let run = sandbox.run(&["export", "grown.pelage", "--strands", "g.glb", "--group", "beard"]);
    assert_eq!(run.code, Some(0), "{run:?}");
    let run = bake(&group("file = \"g.glb\"\nguide_points = 9"), "read.pelage");
    assert_eq!((run.code, run.stderr.contains("left out")), (Some(0), false), "{run:?}");
    let [(grown, _), (read, _)] = ["grown.pelage", "read.pelage"].map(groups);
    assert_eq!((grown[0].guide_roots.len(), read[0].guide_roots.len()), (30, 30));
    let mut compared = 0;
    for i in 0..30 {
        let [tip, found] = [&grown, &read].map(|groups| *groups[0].guide(i).last().unwrap());
        // The roots must be the same. Their triangles may differ if a root is on an edge.
        if grown[0].guide_roots[i].0 == read[0].guide_roots[i].0 {
            assert!(found.distance(tip) < 0.01 * tip.length(), "guide {i}: {found}, expected {tip}");
            compared += 1;
        }
    }
    assert!(compared > 20, "{compared} of 30 on the same triangle");
    // Checks the same strands with the buffer in a separate file.
    let (mut document, buffer) = chunks(&std::fs::read(sandbox.path().join("g.glb")).unwrap()).unwrap();
    document["buffers"][0]["uri"] = "g.bin".into();
    sandbox.write("g.bin", buffer);
    sandbox.write("g.gltf", document.to_string());
    let run = bake(&group("file = \"g.gltf\"\nguide_points = 9"), "two.pelage");
    assert_eq!(run.code, Some(0), "{run:?}");
    let (two, inputs) = groups("two.pelage");
    assert_eq!(two, read);
    let names = |role: &str| inputs.iter().filter(|i| i.role == role).map(|i| i.name.clone()).collect::<Vec<_>>();
    assert_eq!((names("strands"), names("buffer")), (vec!["g.gltf".to_owned()], vec!["g.bin".to_owned()]));
    for (uri, expected) in [("gone.bin", "gone.bin"), ("../g.bin", "leads out of the model's folder")] {
        document["buffers"][0]["uri"] = uri.into();
        sandbox.write("g.gltf", document.to_string());
        let run = bake(&group("file = \"g.gltf\""), "none.pelage");
        assert_eq!(run.code, Some(3), "{run:?}");
        assert!(run.stderr.contains("g.gltf") && run.stderr.contains(expected), "{run:?}");
    }
    let run = bake(&group("file = \"g.bin\""), "none.pelage");
    assert!(run.code == Some(3) && run.stderr.contains(".hair, .tfx, .txt, .usda, .usd, .glb, .gltf"), "{run:?}");
    assert!(!sandbox.files().contains(&"none.pelage".to_owned()));
}
