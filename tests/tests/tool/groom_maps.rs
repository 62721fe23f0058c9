//! Tests with the real binary: groom maps that are written, painted on by a script, and read back.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_formats::{Limits, Package};
use pelage_tests::binary::{Sandbox, workspace};
use pelage_tests::schema::parse_success;

/// Returns a folder with the knot. Its texture coordinates are renamed, so that the model has none.
fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    let mut glb = std::fs::read(workspace().join("assets/models/knot.glb")).unwrap();
    let at = glb.windows(10).position(|w| w == b"TEXCOORD_0").unwrap();
    glb[at..at + 10].copy_from_slice(b"_EXCOORD_0");
    sandbox.write("m.glb", glb);
    sandbox
}

/// Parses the numbers in the lines of an OBJ file that begin with `word`.
fn numbers(obj: &str, word: &str) -> Vec<Vec<f32>> {
    let of =
        |line: &str| line.split_whitespace().skip(1).map(|x| x.split('/').next().unwrap().parse().unwrap()).collect();
    obj.lines().filter(|line| line.split_whitespace().next() == Some(word)).map(of).collect()
}

fn distance(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f32>().sqrt()
}

#[test]
fn spot_painted_on_the_atlas_applies_at_its_position() {
    let sandbox = sandbox();
    let write =
        ["groom", "m.glb", "--map", "length", "-o", "length.png", "--mesh", "m.obj", "--texels", "512", "--json"];
    let run = sandbox.run(&[&write[..], &["--set", "groom.length=0.5"]].concat());
    let said = parse_success(&run, "groom");
    assert_eq!((said["coordinates"].as_str(), said["map"].as_str()), (Some("atlas"), Some("length")));

    let path = sandbox.path().join("length.png");
    let mut map = image::open(&path).unwrap().into_rgba8();
    assert!(
        map.dimensions() == (512, 512)
            && map.pixels().all(|p| p[3] == 255 && p.0[..3].iter().all(|c| matches!(c, 127 | 128)))
    );
    let obj = std::fs::read_to_string(sandbox.path().join("m.obj")).unwrap();
    let (places, coordinates, faces) = (numbers(&obj, "v"), numbers(&obj, "vt"), numbers(&obj, "f"));
    assert!(places.len() == coordinates.len() && faces.len() > 500, "{} {}", places.len(), faces.len());
    let extent = places.iter().map(|p| distance(p, &[0.0; 3])).fold(0.0, f32::max);
    let (center, radius) = (places[faces[faces.len() / 3][0] as usize - 1].clone(), extent / 4.0);

    // Paints white around the point: all texels of triangles whose corners are all within the radius.
    for face in &faces {
        let corners: Vec<usize> = face.iter().map(|v| *v as usize - 1).collect();
        if corners.iter().any(|v| distance(&places[*v], &center) > radius) {
            continue;
        }
        let steps = || (0..=40).map(|k| k as f32 / 40.0);
        for (a, b) in steps().flat_map(|a| steps().map(move |b| (a, b))).filter(|(a, b)| a + b <= 1.0) {
            let mix = |k: usize| {
                let [p, q, r] = [0, 1, 2].map(|c| coordinates[corners[c]][k]);
                p * a + q * b + r * (1.0 - a - b)
            };
            let (x, y) = (mix(0) * 512.0, (1.0 - mix(1)) * 512.0);
            for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
                let at = [x as i64 + dx, y as i64 + dy].map(|k| k.clamp(0, 511) as u32);
                map.put_pixel(at[0], at[1], image::Rgba([255; 4]));
            }
        }
    }
    map.save(&path).unwrap();

    // The painted image must apply to the same part of the model, whatever other keys the recipe sets.
    for more in [&[][..], &["--set", "surface.tile_size_m=0.3", "--set", "surface.comb=gravity"]] {
        let bake = ["bake", "m.glb", "-o", "m.pelage", "--set", "slice.layers=4", "--set", "slice.tile_texels=16"];
        let read = ["--set", "groom.length=length.png", "--set", "groom.coordinates=atlas"];
        let run = sandbox.run(&[&bake[..], &read, more].concat());
        assert_eq!(run.code, Some(0), "{run:?}");
        let bytes = std::fs::read(sandbox.path().join("m.pelage")).unwrap();
        let package = Package::open(&bytes, &Limits::default()).unwrap();
        let height = package.manifest().fur.height_m;
        let (mut inside, mut outside) = (0, 0);
        for vertex in package.mesh().unwrap().unwrap().geometry() {
            let (away, share) = (distance(&vertex.position, &center), vertex.fur_height / height);
            if away < 0.7 * radius {
                assert!(share > 0.98, "{share} at {away} of {radius}");
                inside += 1;
            } else if away > 1.2 * radius {
                assert!((share - 0.5).abs() < 0.01, "{share} at {away} of {radius}");
                outside += 1;
            }
        }
        assert!(inside > 10 && outside > 100, "{inside} and {outside}");
    }
}

#[test]
fn exported_groom_mesh_is_a_valid_model_with_its_map() {
    let sandbox = sandbox();
    let write = ["groom", "m.glb", "--map", "comb", "-o", "comb.png", "--mesh", "worn.glb", "--texels", "128"];
    let run = sandbox.run(&write);
    assert_eq!(run.code, Some(0), "{run:?}");
    assert!(run.stdout.contains("groom.coordinates = \"atlas\""), "{run:?}");
    // If the atlas is the model's own texture coordinates, the map is read in these.
    let bake = ["bake", "worn.glb", "-o", "w.pelage", "--set", "groom.comb=comb.png", "--set", "slice.layers=4"];
    let run = sandbox.run(&bake);
    assert_eq!(run.code, Some(0), "{run:?}");
    assert!(!run.stderr.contains("no texture coordinates"), "{run:?}");
}

#[test]
fn groom_map_errors_are_reported() {
    let sandbox = sandbox();
    let run = |args: &[&str]| {
        let run = sandbox.run(&[&["groom", "m.glb"], args].concat());
        (run.code, run.stderr)
    };
    for (args, code, words) in [
        (&["--map", "size", "-o", "a.png"][..], 1, "length"),
        (&["--map", "length", "-o", "a.tga"], 1, ".png"),
        (&["--map", "length", "-o", "a.png", "--mesh", "a.fbx"], 1, ".obj"),
        (&["--map", "length", "-o", "none/a.png"], 2, "none"),
        (&["--map", "length", "-o", "a.png", "--coordinates", "model"], 3, "TEXCOORD_0"),
        (&["--map", "length", "-o", "a.png", "--set", "groom.length=none.png"], 3, "none.png"),
    ] {
        let (found, said) = run(args);
        assert!(found == Some(code) && said.contains(words), "{args:?}: {found:?} {said}");
    }
    assert_eq!(sandbox.files().len(), 1);
}
