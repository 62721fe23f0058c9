#![allow(missing_docs, clippy::unwrap_used, reason = "a test fails by panicking")]
//! Tests of lapped patches on real meshes: every mesh of the test data, and quality bounds for well-known meshes.

use pelage_bake::io::{Reach, read_model};
use pelage_bake::recipe::{self, Recipe};
use pelage_bake::stages::groom::{Lengths, bounds};
use pelage_bake::stages::surface::{Surface, SurfaceParams, parameterize};
use pelage_import::BakeError;
use pelage_import::ImportOptions;
use pelage_import::mesh::{Model, RestPose};
use pelage_needs::data;
use pelage_tests::binary::{walk, workspace};
use std::path::{Path, PathBuf};

/// Returns whether the importer supports the file extension.
fn is_model(path: &Path) -> bool {
    path.extension().is_some_and(|e| ["glb", "gltf", "obj"].iter().any(|x| e == *x))
}

/// Runs the surface stage as `pelage bake` does without a recipe.
fn surface(model: &Model) -> Result<Surface, BakeError> {
    let box_of = bounds(&RestPose::of(&model.mesh, model.animation.as_ref()));
    let tile_size_m = Lengths::resolve(&Recipe::default(), &box_of).tile_size_m;
    let furred = vec![true; model.materials.len()];
    let params = SurfaceParams::from_recipe(&recipe::SurfaceParams::default(), tile_size_m, furred);
    parameterize("model", model, &params)
}

#[test]
fn no_triangle_of_any_mesh_is_flipped() {
    let Some(data) = data("no_triangle_of_any_mesh_is_flipped") else { return };
    let mut models = Vec::new();
    walk(&data.join("meshes"), &mut models);
    models.retain(|m| is_model(m));
    let mut seen = 0;
    for path in models {
        let name = path.strip_prefix(&data).unwrap().display().to_string();
        let Ok(model) = read_model(&path, &ImportOptions { unit_m: 1.0 }, Reach::OwnFolder) else { continue };
        let s = match surface(&model) {
            Ok(s) => s,
            // A mesh without area must be rejected with exactly this message.
            Err(error) => {
                assert!(error.to_string().contains("triangles has an area"), "{name}: {error}");
                continue;
            }
        };
        seen += 1;
        assert_eq!(s.measures.flipped_triangles, 0, "{name}: {:?}", s.measures);
        assert!(s.tile_uvs.iter().all(|uv| uv.is_finite()), "{name}");
        let unit = |t: &glam::Vec4| (t.truncate().length() - 1.0).abs() < 1e-3 && t.w.abs() == 1.0;
        assert!(s.tangents.iter().all(unit), "{name}");
        assert_eq!(s.mesh.triangles.len(), s.patch_of_triangle.len(), "{name}");
        assert_eq!(s.mesh.positions.len(), s.input_vertex.len(), "{name}");
    }
    println!("{seen} meshes with a triangle");
    assert!(seen >= 75, "only {seen} meshes had a triangle");
}

/// Upper bounds of `angle_distortion`, `area_distortion` and `comb_misalignment_deg`.
const PROMISED: [f64; 3] = [0.03, 0.04, 10.0];

#[test]
fn distortion_of_known_meshes_is_within_bounds() {
    let Some(data) = data("distortion_of_known_meshes_is_within_bounds") else { return };
    let mut models: Vec<PathBuf> = ["bunny", "spot", "armadillo", "cat-low-resolution", "penguin", "goathead"]
        .iter()
        .map(|name| data.join("meshes/static").join(format!("{name}.obj")))
        .collect();
    walk(&data.join("meshes/skinned"), &mut models);
    models.retain(|m| is_model(m));
    models.push(workspace().join("assets/models/hare.glb"));
    println!("mesh                     faces patches   angle    area    comb    seam singular");
    for path in models {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let s = surface(&read_model(&path, &ImportOptions { unit_m: 1.0 }, Reach::OwnFolder).unwrap()).unwrap();
        let m = s.measures;
        let comb = m.comb_misalignment_deg.unwrap();
        println!(
            "{name:<24} {:>5} {:>7} {:>7.4} {:>7.4} {comb:>7.2} {:>7.2} {:>5}",
            s.mesh.triangles.len(),
            m.patches,
            m.angle_distortion,
            m.area_distortion,
            m.seam_length_ratio,
            m.singularities
        );
        for (found, most) in [m.angle_distortion, m.area_distortion, comb].iter().zip(PROMISED) {
            assert!(*found <= most, "{name}: {m:?}");
        }
    }
}
