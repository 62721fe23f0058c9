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
