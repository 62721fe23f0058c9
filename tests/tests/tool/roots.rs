//! Tests with the real binary that hair keeps the colour of its root where it leans over surface of another colour.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_formats::{Limits, Package};
use pelage_tests::binary::Sandbox;
use pelage_tests::gpu::gpu;

/// Writes a plane of one by two metres, whose back half is blue and whose front half is red. Hair leans from the front
/// over the back.
fn write_plane(sandbox: &Sandbox) {
    sandbox.write("plane.mtl", "newmtl behind\nKd 0.1 0.1 0.8\nnewmtl front\nKd 0.8 0.1 0.1\n");
    let mut obj = String::from("mtllib plane.mtl\n");
    for i in 0..45 {
        obj += &format!("v {} 0 {}\n", 0.25 * f64::from(i % 5) - 0.5, 0.25 * f64::from(i / 5) - 1.0);
    }
    for (material, rows) in [("behind", 0..4), ("front", 4..8)] {
        obj += &format!("usemtl {material}\n");
        for (row, column) in rows.flat_map(|row| (0..4).map(move |column| (row, column))) {
            let a = 5 * row + column + 1;
            obj += &format!("f {a} {} {} {}\n", a + 5, a + 6, a + 1);
        }
    }
    sandbox.write("plane.obj", obj);
}

fn done(sandbox: &Sandbox, args: &[&str]) {
    let run = sandbox.run(args);
    assert_eq!(run.code, Some(0), "{args:?}: {run:?}");
}

fn bake(sandbox: &Sandbox, package: &str, more: &[&str]) {
    let hair =
        ["hair.length_m=0.15", "surface.tile_size_m=0.4", "hair.lean=0.9", "hair.density=1500", "ink.enabled=false"];
    let mut args = vec!["bake", "plane.obj", "-q", "-o", package];
    hair.iter().chain(more).for_each(|set| args.extend(["--set", set]));
    done(sandbox, &args);
    done(sandbox, &["validate", package]);
}

/// Returns the share of red among hair pixels in the middle of a picture from above.
fn red_share(sandbox: &Sandbox, picture: &str) -> f64 {
    let pixels = image::open(sandbox.path().join(picture)).unwrap().to_rgb8();
    let middle = || pixels.enumerate_pixels().filter(|(x, y, _)| (40..60).contains(x) && (50..100).contains(y));
    let [red, blue] = [(0, 2), (2, 0)].map(|(more, less)| middle().filter(|(.., p)| p[more] > p[less]).count() as f64);
    assert!(red + blue > 900.0, "{picture} shows no hair");
    red / (red + blue)
}

const VIEW: [&str; 6] = ["--size", "100x150", "--camera=0,4,0.001/0,0,0/32", "--background", "0,0,0", "-q"];

#[test]
fn hair_at_a_border_has_its_roots_colour() {
    if gpu("hair_at_a_border_has_its_roots_colour").is_none() {
        return;
    }
    let sandbox = Sandbox::new();
    write_plane(&sandbox);
    let share = |package: &str, hair: &str| {
        let name = format!("{package}_{hair}.png");
        // Blended edges would mix in the colour of what lies behind a strand.
        let exact = ["--fins", "on", "--strand-edges", "samples"];
        done(
            &sandbox,
            &[&["render", package, "-o", &name, "--hair", hair, "--samples", "1"][..], &exact, &VIEW].concat(),
        );
        red_share(&sandbox, &name)
    };
    bake(&sandbox, "root", &["color.at_root=true", "fins.enabled=true"]);
    bake(&sandbox, "below", &["color.at_root=false", "fins.enabled=true"]);
    done(&sandbox, &[&["reference", "root", "-o", "true.png", "--samples", "16"][..], &VIEW].concat());
    let truth = red_share(&sandbox, "true.png");
    let [root, below] = ["root", "below"].map(|package| share(package, "shells"));
    println!("red: true {truth:.3}, by the root {root:.3}, by the skin below {below:.3}");
    assert!(truth - below > 0.05 && (truth - root).abs() < 0.3 * (truth - below), "{truth}, {root} and {below}");
    // Individual strands always have the colour of their root. Both packages have the same roots, so their strands must
    // have the same colours.
    let [strands, before] = ["root", "below"].map(|package| share(package, "strands"));
    assert!((strands - before).abs() < 0.005 && (strands - truth).abs() < 0.03, "{strands}, {before} and {truth}");
}

#[test]
fn uniform_colours_need_no_root_texture() {
    let sandbox = Sandbox::new();
    write_plane(&sandbox);
    sandbox.write("plane.mtl", "newmtl behind\nKd 0.8 0.1 0.1\nnewmtl front\nKd 0.8 0.1 0.1\n");
    let small = ["slice.tile_texels=16", "slice.layers=4"];
    let sections = |at_root: &str| {
        bake(&sandbox, "out", &[&small[..], &[at_root]].concat());
        let bytes = std::fs::read(sandbox.path().join("out")).unwrap();
        let package = Package::open(&bytes, &Limits::default()).unwrap();
        assert_eq!(package.roots().unwrap(), None);
        // The manifest is excluded, because the recipe in it contains the setting itself.
        let all = (1..package.sections().len()).map(|i| package.section_bytes(i).unwrap().to_vec());
        all.collect::<Vec<_>>()
    };
    assert!(sections("color.at_root=true") == sections("color.at_root=false"));
}
