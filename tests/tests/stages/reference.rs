#![allow(missing_docs, clippy::unwrap_used, reason = "a test fails by panicking")]
//! Tests of the strands of a whole animal.

use pelage_bake::pipeline::{self, BakeInput};
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::groom::MapImages;
use pelage_bake::stages::import::{ImportOptions, import};
use pelage_bake::strands::{PosedMesh, grow_on, tile_hair};
use pelage_formats::{Limits, Package};
use std::path::PathBuf;

fn asset(path: &str) -> Vec<u8> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../assets").join(path);
    std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

#[test]
fn planted_root_count_matches_the_tiles() {
    let mut recipe = Recipe::parse("hare", std::str::from_utf8(&asset("recipes/hare.toml")).unwrap()).unwrap();
    recipe.slice.layers = 4;
    recipe.fins.enabled = false;
    let model = import(
        "hare",
        &asset("models/hare.glb"),
        &mut |_: &str, _: u64| unreachable!(),
        &ImportOptions { unit_m: 1.0 },
    );
    let baked =
        pipeline::bake(&BakeInput::new("hare", "hare", &recipe, &MapImages::default()), &model.unwrap(), &mut |_| ())
            .unwrap()
            .package;
    let package = Package::open(&baked, &Limits::default()).unwrap();
    let skin = PosedMesh::posed("hare", &package, &[]).unwrap();
    let hair = tile_hair("hare", package.manifest()).unwrap().unwrap();
    let tile_m = f64::from(package.manifest().fur.tile_size_m);
    let (curves, report) = grow_on(&skin, &hair, tile_m).unwrap();
    assert_eq!(report.strands, curves.len() as u64);
    assert!(report.crossed_patch_border > 1000 && 20 * report.slid_along_border < report.strands, "{report:?}");
    assert!(1000 * report.lost < report.strands, "{report:?}");

    let furred = (0..skin.triangles.len()).filter(|t| skin.material(*t).furred);
    let (mut tiles, mut area_m2) = (0.0, 0.0);
    for t in furred {
        let [a, b, c] = skin.corners(t);
        tiles += 0.5 * (b.tile_uv - a.tile_uv).perp_dot(c.tile_uv - a.tile_uv).abs();
        area_m2 += 0.5 * (b.position_ws - a.position_ws).cross(c.position_ws - a.position_ws).length();
    }
    // The count includes every copy of the tile's roots on the mesh surface. Roots are distributed more evenly than at
    // random.
    let grown = (report.strands + report.dropped_bare + report.dropped_thinned) as f64;
    let expected = tiles * f64::from(recipe.hair.density);
    assert!((grown - expected).abs() < 3.0 * expected.sqrt(), "{grown} roots, expected {expected}");
    // The tile has the size set in the recipe, apart from distortion by the patches.
    let density = grown * tile_m * tile_m / area_m2 / f64::from(recipe.hair.density);
    assert!((density - 1.0).abs() < 0.03, "{density} times the density");
    // No strand may be longer than the longest strand of the tile, or leave its root, apart from stretching by the
    // patches.
    let longest = 1.5 * f64::from(recipe.hair.length_m.unwrap());
    for i in 0..curves.len() {
        let strand = curves.strand(i);
        let length: f32 = strand.windows(2).map(|w| w[0].position_ws.distance(w[1].position_ws)).sum();
        assert!(f64::from(length) < longest, "strand {i} is {length} m long");
        assert!(strand.iter().all(|p| (0.0..=1.0).contains(&p.height) && (p.normal_ws.length() - 1.0).abs() < 1e-4));
    }
}
