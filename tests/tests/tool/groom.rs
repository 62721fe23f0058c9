//! Tests of groom maps with the real binary: recipes that name images.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_formats::{Limits, Package};
use pelage_tests::binary::{Sandbox, workspace};

/// Encodes a PNG of two adjacent texels.
fn png(texels: [[u8; 4]; 2]) -> Vec<u8> {
    let image = image::RgbaImage::from_raw(2, 1, texels.concat()).unwrap();
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// Returns a folder with the torus.
fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.write("torus.glb", std::fs::read(workspace().join("assets/models/torus.glb")).unwrap());
    sandbox
}

const BAKE: [&str; 8] =
    ["bake", "torus.glb", "-o", "t.pelage", "--recipe", "recipes/r.toml", "--set", "slice.layers=4"];

#[test]
fn images_beside_the_recipe_are_baked_into_the_package() {
    let sandbox = sandbox();
    let map = png([[255, 0, 0, 255], [0, 255, 0, 255]]);
    sandbox.write("recipes/maps/coat.png", &map);
    // The textures use the model's own coordinates.
    let recipe = "[color]\nat_root = false\n\
        [groom]\nbare = \"maps/coat.png\"\nwetness = \"maps/coat.png#g\"\ncolor = \"maps/coat.png\"\nlean = 0.5\n\
        [[groom.material]]\nname = \"Coat\"\nlength = 0.5\n[pack]\ndirection_format = \"rg8\"\n";
    sandbox.write("recipes/r.toml", recipe);
    let run = sandbox.run(&BAKE);
    assert_eq!(run.code, Some(0), "{run:?}");
    let bytes = std::fs::read(sandbox.path().join("t.pelage")).unwrap();
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    let manifest = package.manifest();

    let read: Vec<_> = manifest.inputs.iter().filter(|i| i.role == "image").collect();
    assert!(matches!(&read[..], [one] if one.name == "coat.png" && one.bytes == map.len() as u64), "{read:?}");
    assert!(manifest.recipe.contains("maps/coat.png#g"), "{}", manifest.recipe);
    let groom = package.groom_texture(0).unwrap().unwrap();
    assert_eq!(
        (groom.width, groom.height, groom.level(0)),
        (2, 1, &[0, 0, 255, 255][..]),
        "share of the hair, wetness"
    );
    assert!(manifest.materials[0].base_color_texture.is_some() && package.wet_textures().unwrap().is_some());
    let mesh = package.mesh().unwrap().unwrap();
    let half = manifest.fur.height_m / 2.0;
    assert!(mesh.geometry().all(|v| v.lean == 0.5 && (v.fur_height - half).abs() < 1e-7));

    // The maps can also be set with `--set`, whose paths may be relative to the recipe's folder.
    sandbox.write("recipes/r.toml", recipe.replace("color = \"maps/coat.png\"\n", ""));
    let run = sandbox.run(&[&BAKE[..], &["--set", "groom.color=maps/coat.png"]].concat());
    assert_eq!(run.code, Some(0), "{run:?}");
}

#[test]
fn unreadable_groom_images_are_named_with_recipe_and_key() {
    let sandbox = sandbox();
    sandbox.write("recipes/broken.png", b"\x89PNG\r\n\x1a\n and no more");
    for (recipe, words) in [
        ("[groom]\nbare = \"none.png\"", ["recipes/r.toml", "groom.bare", "recipes/none.png"]),
        ("[groom]\nlength = \"broken.png\"", ["recipes/r.toml", "groom.length", "recipes/broken.png"]),
        (
            "[[groom.material]]\nname = \"Coat\"\ncolor = \"r.toml\"",
            ["recipes/r.toml", "groom.material, table 0, color", "recipes/r.toml is 49 bytes"],
        ),
        ("[groom]\nbare = \"../../../../etc\"", ["recipes/r.toml", "groom.bare", "etc"]),
    ] {
        sandbox.write("recipes/r.toml", recipe);
        let before = sandbox.files();
        let run = sandbox.run(&BAKE);
        assert_eq!(run.code, Some(3), "{recipe}: {run:?}");
        for word in words {
            assert!(run.stderr.contains(word), "{recipe}: no {word:?} in {}", run.stderr);
        }
        assert_eq!(sandbox.files(), before, "{recipe} left something behind");
    }
}

#[test]
fn patterns_work_without_texture_coordinates() {
    let sandbox = Sandbox::new();
    let glb = std::fs::read(workspace().join("assets/models/knot.glb")).unwrap();
    // Renderers ignore the renamed attribute. The new name is as long as the old, so that the length of the JSON is
    // unchanged.
    let at = glb.windows(10).position(|w| w == b"TEXCOORD_0").unwrap();
    let mut stripped = glb.clone();
    stripped[at..at + 10].copy_from_slice(b"_EXCOORD_0");
    sandbox.write("bare.glb", &stripped);
    for name in ["patterns/zebra.png", "recipes/zebra.toml"] {
        sandbox.write(name, std::fs::read(workspace().join("assets").join(name)).unwrap());
    }
    let bake = ["bake", "bare.glb", "-o", "b.pelage", "--recipe", "recipes/zebra.toml", "--set", "slice.layers=4"];
    let quick = ["--set", "pack.base_color_format=rgba8", "--set", "color.pattern_texels=512"];
    let run = sandbox.run(&[&bake[..], &quick].concat());
    assert_eq!(run.code, Some(0), "{run:?}");
    let bytes = std::fs::read(sandbox.path().join("b.pelage")).unwrap();
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    let texture = package.base_color_texture(0).unwrap().unwrap();
    assert_eq!((texture.width, texture.height), (512, 512));
    let shades: Vec<u8> = texture.level(0).chunks_exact(4).map(|t| t[0]).collect();
    let (dark, light) = (shades.iter().filter(|s| **s < 60).count(), shades.iter().filter(|s| **s > 220).count());
    assert!(dark > shades.len() / 6 && light > shades.len() / 6, "{dark} dark and {light} light texels");
    let uvs: Vec<_> = package.mesh().unwrap().unwrap().attributes().map(|v| v.base_uv).collect();
    assert!(uvs.iter().flatten().all(|x| (0.0..=1.0).contains(x)) && uvs.iter().any(|uv| *uv != uvs[0]));

    let run = sandbox.run(&[&bake[..], &["--set", "color.pattern_texels=64"]].concat());
    let small = run.code == Some(0) && run.stderr.contains("gutters") || run.stderr.contains("color.pattern_texels");
    assert!(small, "{run:?}");
}
