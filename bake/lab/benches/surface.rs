//! Benchmark of the surface stage: seconds against the number of triangles, on a knotted tube of a thousand to a third
//! of a million triangles. The growth should be compared with n log n.
//!
//! `cargo bench --workspace --bench surface -- MODEL…` also measures models; paths are relative to `bake/`.
#![allow(clippy::disallowed_methods, reason = "packages made by tests are never kept")]

use glam::vec3;
use pelage_bake::io::{Reach, read_model};
use pelage_bake::recipe::{self, Recipe};
use pelage_bake::stages::groom::{Lengths, bounds};
use pelage_bake::stages::surface::{SurfaceParams, parameterize};
use pelage_import::ImportOptions;
use pelage_import::mesh::{Model, RestPose};
use pelage_lab::stability::surface::grid;
use std::time::Instant;

/// Returns a trefoil tube of `2 * along * around` triangles, with bumps.
fn knot(along: u32, around: u32) -> Model {
    let center = |t: f32| vec3(t.sin() + 2.0 * (2.0 * t).sin(), t.cos() - 2.0 * (2.0 * t).cos(), -(3.0 * t).sin());
    grid(along, around, |t, turn| {
        let tangent = (center(t + 0.01) - center(t - 0.01)).normalize();
        let side = tangent.cross(center(t)).normalize();
        let (sin, cos) = turn.sin_cos();
        center(t) + (side * cos + tangent.cross(side) * sin) * (0.5 + 0.025 * (9.0 * t).sin() * cos)
    })
}

/// Measures the model three times, prints the result and returns the median, seconds.
fn measure(name: &str, model: &Model) -> f64 {
    let box_of = bounds(&RestPose::of(&model.mesh, model.animation.as_ref()));
    let tile_size_m = Lengths::resolve(&Recipe::default(), &box_of).tile_size_m;
    let furred = vec![true; model.materials.len()];
    let params = SurfaceParams::from_recipe(&recipe::SurfaceParams::default(), tile_size_m, furred);
    let mut runs = Vec::new();
    for _ in 0..3 {
        let begun = Instant::now();
        match parameterize(name, model, &params) {
            Ok(surface) => runs.push((begun.elapsed().as_secs_f64(), surface.measures)),
            Err(error) => println!("{error}"),
        }
    }
    runs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some((seconds, m)) = runs.get(1) else { return f64::NAN };
    let (triangles, comb) = (model.mesh.triangles.len(), m.comb_misalignment_deg.unwrap_or(f64::NAN));
    println!(
        "{name:<24} {triangles:>9} {seconds:>8.3} {:>8} {:>8.4} {:>8.4} {comb:>8.2} {:>8.2}",
        m.patches, m.angle_distortion, m.area_distortion, m.seam_length_ratio
    );
    *seconds
}

fn main() {
    println!("mesh                     triangles  seconds  patches    angle     area comb deg     seam");
    let mut before: Option<(f64, f64)> = None;
    for scale in [1, 2, 3, 6, 9, 17] {
        let (along, around) = (64 * scale, 8 * scale);
        let n = f64::from(2 * along * around);
        let seconds = measure(&format!("knot {along} x {around}"), &knot(along, around));
        if let Some((m, t)) = before {
            println!("{:>42.2} times as long; n log n predicts {:.2}", seconds / t, n * n.ln() / (m * m.ln()));
        }
        before = Some((n, seconds));
    }
    for path in std::env::args().skip(1).filter(|a| !a.starts_with("--")) {
        match read_model(path.as_ref(), &ImportOptions::default(), Reach::Anywhere) {
            Ok(model) => drop(measure(path.rsplit('/').next().unwrap_or(&path), &model)),
            Err(error) => println!("{error}"),
        }
    }
}
