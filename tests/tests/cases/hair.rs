//! Strand files: single bad strands, other notations, and files without usable strands.
#![allow(clippy::unwrap_used, reason = "in tests a panic is the report")]

use pelage_bake::io::read_map_images;
use pelage_bake::pipeline::{self, BakeInput};
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::import::{ImportOptions, import};
use pelage_formats::{HairGroup, Limits, Package};
use pelage_import::BakeError;
use pelage_needs::data;
use std::path::Path;

/// Returns a flat scalp, 0.2 m wide, on which the strands of the test data stand: y = 0.38 m.
fn scalp() -> String {
    let line = |i: i32| 0.05 * (i - 2) as f32;
    let mut text = String::from("usemtl Scalp\n");
    for (i, j) in (0..5).flat_map(|i| (0..5).map(move |j| (i, j))) {
        text += &format!("v {} 0.38 {}\n", line(i), line(j));
    }
    for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
        let at = |i: i32, j: i32| 5 * i + j + 1;
        text += &format!("f {} {} {} {}\n", at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
    }
    text
}

/// Bakes the scalp with the strands of a file. Returns its guides, and the warnings about them.
fn bake(folder: &Path, file: &str) -> Result<(HairGroup, Vec<String>), BakeError> {
    let mut recipe = Recipe::parse(
        "r.toml",
        &format!(
            "[model]\nbare = [\"*\"]\n[[strands.group]]\nname = \"hair\"\nmaterial = \"Scalp\"\nfile = \"{file}\"\n\
             hairs = 0\n[ink]\nenabled = false\n[slice]\nlayers = 4\ntile_texels = 16\n[hair]\ndensity = 20\n\
             length_m = 0.01\n[pack]\nshell_format = \"rgba8\"\ndirection_format = \"rg8\"\n"
        ),
    )?;
    recipe.fins.enabled = false;
    let files = read_map_images("r.toml", &|name| folder.join(name), &recipe)?;
    let mut no_files = |uri: &str, _: u64| panic!("{uri} was asked for");
    let model = import("scalp.obj", scalp().as_bytes(), &mut no_files, &ImportOptions::default())?;
    let baked = pipeline::bake(&BakeInput::new("scalp.obj", "r.toml", &recipe, &files), &model, &mut |_| ())?;
    let package = Package::open(&baked.package, &Limits::default()).unwrap();
    let about_hair = baked.warnings.into_iter().filter(|warning| warning.contains("\"hair\"")).collect();
    Ok((package.hair_groups().unwrap()[0].clone(), about_hair))
}

/// Checks that both groups have the same guides, to within a share of their length that storage rounds.
fn same_guides(file: &str, found: &HairGroup, expected: &HairGroup) {
    assert_eq!(found.guide_roots.len(), expected.guide_roots.len(), "{file}");
    for i in 0..found.guide_roots.len() {
        for (p, q) in found.guide(i).into_iter().zip(expected.guide(i)) {
            assert!(p.distance(q) < 1e-4, "{file}: guide {i} at {p}, expected {q}");
        }
    }
}

#[test]
fn strand_files_with_small_faults_are_read() {
    let Some(data) = data("strand_files_with_small_faults_are_read") else { return };
    let cases = data.join("cases");
    let (expected, warnings) = bake(&cases, "strands.hair").unwrap();
    assert_eq!((expected.guide_roots.len(), &warnings[..]), (24, &[][..]));
    for (file, told) in [
        ("strands.usda", None),
        ("strands_with_commas.txt", None),
        ("tips_first.hair", Some("begin at their tips: their last points are on the scalp; they are turned")),
        ("last_point_at_origin.hair", Some("24 of 24 strands have a last piece many times longer than the others")),
    ] {
        let (found, warnings) = bake(&cases, file).unwrap();
        same_guides(file, &found, &expected);
        assert_eq!(warnings.len(), usize::from(told.is_some()), "{file}: {warnings:?}");
        assert!(warnings.iter().zip(told).all(|(warning, told)| warning.contains(told)), "{file}: {warnings:?}");
    }
    let (found, warnings) = bake(&cases, "one_point_nan.hair").unwrap();
    assert_eq!((found.guide_roots.len(), warnings.len()), (23, 1));
    let told = "1 of 24 strands in the file are left out: 1 with a coordinate that is not a finite number";
    assert!(warnings[0].contains(told), "{warnings:?}");
    let (found, warnings) = bake(&cases, "strands_without_blank_lines.txt").unwrap();
    assert_eq!((found.guide_roots.len(), warnings.len()), (1, 1));
    assert!(warnings[0].contains("the file is one strand with jumps, 96 points"), "{warnings:?}");
    let error = bake(&cases, "no_strands.hair").unwrap_err().to_string();
    assert!(error.contains("no_strands.hair: ") && error.contains("the file has no strands"), "{error}");
}

/// Checks hair of several prims in a hierarchy whose unit is the centimetre and whose z axis is up, and the message of
/// a recipe that uses binary USD.
#[test]
fn usd_hair_of_other_programs_is_baked() {
    let folder = tempfile::tempdir().unwrap();
    let prim = |name: &str, x: f32| {
        let points = |y: f32| format!("({x}, {y}, 0), ({x}, {y}, 2), ({x}, {}, 4), ({x}, {}, 5)", y + 1.0, y + 3.0);
        format!(
            "        def BasisCurves \"{name}\"\n        {{\n            int[] curveVertexCounts = [4, 4]\n            \
             point3f[] points = [{}, {}]\n            uniform token type = \"linear\"\n        }}\n",
            points(0.0),
            points(2.0)
        )
    };
    let text = format!(
        "#usda 1.0\n(\n    metersPerUnit = 0.01\n    upAxis = \"Z\"\n)\n\ndef Xform \"root\"\n{{\n    def Xform \
         \"head\"\n    {{\n        double3 xformOp:translate = (0, 0, 38)\n        uniform token[] xformOpOrder = \
         [\"xformOp:translate\"]\n{}{}    }}\n}}\n",
        prim("left", -4.0),
        prim("right", 4.0)
    );
    std::fs::write(folder.path().join("hair.usda"), text).unwrap();
    let (found, warnings) = bake(folder.path(), "hair.usda").unwrap();
    assert_eq!((found.guide_roots.len(), &warnings[..]), (4, &[][..]));
    // Z is up in the file, and its y axis points away from the viewer.
    let lengths: Vec<f32> = (0..4).map(|i| found.guide(i).last().unwrap().length()).collect();
    assert!(lengths.iter().all(|length| (length - 0.034_f32.hypot(0.048)).abs() < 0.01), "{lengths:?}");
    std::fs::write(folder.path().join("hair.usd"), b"PXR-USDC\0\0\0").unwrap();
    let error = bake(folder.path(), "hair.usd").unwrap_err().to_string();
    assert!(error.contains("binary USD, expected USD as text: export it as .usda"), "{error}");
    let error = bake(folder.path(), "hair.abc").unwrap_err().to_string();
    assert!(error.contains("expected a name that ends in .hair, .tfx, .txt, .usda, .usd, .glb, .gltf"), "{error}");
}
