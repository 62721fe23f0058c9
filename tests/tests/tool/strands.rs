//! Single strands through the real binary: nearer to the traced picture than layers, and the same every time.
#![allow(clippy::unwrap_used, reason = "in tests a panic is the report")]

use pelage_tests::binary::{Sandbox, workspace};
use pelage_tests::gpu::gpu;
use pelage_tests::schema;

#[test]
fn strands_are_nearer_to_the_true_picture_than_layers() {
    if gpu("strands_are_nearer_to_the_true_picture_than_layers").is_none() {
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
    done(&["bake", &model, "--recipe", &recipe, "-o", "hare.pelage", "-q", "--set", "strands.enabled=true"]);
    let size = ["--size", "417x212"];
    done(&[&["reference", "hare.pelage", "-o", "true.png", "--spp", "64"], &size[..]].concat());
    let draw = |hair: &str, name: &str| {
        let how = ["--look", "picture.samples=4", "--hair", hair, "-o", name];
        done(&[&["render", "hare.pelage"], &size[..], &how].concat());
        let run = sandbox.run(&["compare", name, "true.png", "--json"]);
        let found = schema::done(&run, "compare");
        found["flip"]["mean"].as_f64().unwrap()
    };
    let [strands, layers] = [draw("strands", "strands.png"), draw("shells", "layers.png")];
    println!("FLIP against the true picture: {strands:.4} in strands, {layers:.4} in layers");
    assert!(strands < 0.85 * layers && strands < 0.014, "{strands} and {layers}");
    draw("strands", "again.png");
    let [first, again] = ["strands.png", "again.png"].map(|name| std::fs::read(sandbox.path().join(name)).unwrap());
    assert!(first == again, "a picture of strands is the same every time");
}

/// Hair on guides: fur that hangs from the hare, thin enough that every hair counts, at rest and in the middle of a jump.
#[test]
fn hair_on_guides_is_drawn_where_the_true_picture_has_it() {
    if gpu("hair_on_guides_is_drawn_where_the_true_picture_has_it").is_none() {
        return;
    }
    let sandbox = Sandbox::new();
    let recipe = std::fs::read_to_string(workspace().join("assets/recipes/hare.toml")).unwrap();
    let groups = "\n[[strands.group]]\nname = \"beard\"\nmaterial = \"Coat*\"\nhairs = 1500\nguides = 200\nlength_m = 0.12\n\
                  root_radius_m = 0.0006\nroot_color = \"#a04020\"\ntip_color = \"#e0c090\"\nclump = 0.3\n\
                  [[strands.tuft]]\nname = \"whiskers\"\nat = [0.03, 0.4, 0.4]\nmirrored = true\nlength_m = 0.1\n";
    std::fs::write(sandbox.path().join("hare.toml"), recipe + groups).unwrap();
    let model = workspace().join("assets/models/hare.glb").to_str().unwrap().to_owned();
    let done = |args: &[&str]| {
        let run = sandbox.run(args);
        assert_eq!(run.code, Some(0), "{run:?}");
        run
    };
    done(&["bake", &model, "--recipe", "hare.toml", "-o", "hare.pelage", "-q"]);
    done(&["validate", "hare.pelage"]);
    let clip = schema::done(&done(&["inspect", "hare.pelage", "--json"]), "inspect")["clips"][0]["name"].clone();
    let moving = ["--clip", clip.as_str().unwrap(), "--time", "0.2"];
    for (name, when) in [("rest", &[][..]), ("clip", &moving)] {
        let size = ["--size", "500x400", "--camera", "0.9,0.6,1.2/0,0.22,0/30"];
        let (true_png, drawn_png, bald_png) =
            (format!("{name}_true.png"), format!("{name}.png"), format!("{name}_bald.png"));
        done(&[&["reference", "hare.pelage", "-o", &true_png, "--spp", "48"][..], &size, when].concat());
        let samples = ["--look", "picture.samples=4"];
        done(&[&["render", "hare.pelage", "-o", &drawn_png][..], &size, &samples, when].concat());
        let against = |picture: &str| {
            let found = schema::done(&sandbox.run(&["compare", picture, &true_png, "--json"]), "compare");
            [&found["coverage"], &found["flip"]["mean"]].map(|n| n.as_f64().unwrap())
        };
        let [coverage, flip] = against(&drawn_png);
        // The same hare without it.
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
            "{name}: coverage off by {coverage:.4}, FLIP {flip:.4}; without the hair {bald_coverage:.4} and {bald_flip:.4}"
        );
        assert!(coverage < 0.3 * bald_coverage && flip < 0.5 * bald_flip, "{name}");
    }
}
