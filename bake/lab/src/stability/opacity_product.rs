//! Opacity product: with many layers, a faint hair has less than half a step of 8-bit opacity per layer.

use super::measures::{mean, slice, transmittances};
use super::row::{Finding, Row};
use glam::Vec3;
use pelage_bake::stages::simulate::Strands;
use pelage_bake::stages::slice::extinction;
use pelage_import::BakeError;

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "product of (1 - opacity)",
    cliff: "many layers in 8 bits: faint hair rounds to none, or to too much",
    naive: "round each layer by itself",
    safe: "carry the rounding error to the next layer",
    drive,
};

/// Returns upright hairs of equal radius, far apart.
fn faint(radius: f32, height: f32) -> Strands {
    let roots: Vec<_> =
        (0..16_u8).map(|i| Vec3::new(f32::from(i % 4) + 0.37, f32::from(i / 4) + 0.61, 0.0) * 0.25).collect();
    Strands {
        points: roots.iter().flat_map(|r| [*r, *r + Vec3::Z * height]).collect(),
        radii: vec![radius; 32],
        colors: vec![Vec3::ONE; 32],
        offsets: (0..=16).map(|i| 2 * i).collect(),
        height,
        root_color: Vec3::ONE,
    }
}

/// Returns the optical depth of a whole column for each of `n * n` texels, computed in f64 from the definition: each
/// hair's depth is spread by a Gaussian whose sum over the texels is one.
fn depths(strands: &Strands, n: usize, filter_width: f64) -> Vec<f64> {
    let mut depths = vec![0.0; n * n];
    for root in strands.points.iter().step_by(2) {
        let radius = f64::from(strands.radii[0]);
        let variance = 0.5 * (radius * n as f64).powi(2) + filter_width * filter_width;
        let density = f64::from(extinction((radius * n as f64 / variance.sqrt()) as f32));
        let total = density * std::f64::consts::PI * radius * f64::from(strands.height) * (n * n) as f64;
        let weights = |center: f32| {
            let center = f64::from(center) * n as f64;
            let of = |i: usize| {
                let d = (i as f64 + 0.5 - center).abs();
                let d = d.min(n as f64 - d);
                libm::exp(-0.5 * d * d / variance)
            };
            let all: Vec<_> = (0..n).map(of).collect();
            let sum: f64 = all.iter().sum();
            all.into_iter().map(move |w| w / sum).collect::<Vec<_>>()
        };
        let (wx, wy) = (weights(root.x), weights(root.y));
        for (i, depth) in depths.iter_mut().enumerate() {
            *depth += total * wx[i % n] * wy[i / n];
        }
    }
    depths
}

/// Number of texels along a side of a layer.
const TEXELS: usize = 64;
/// Factor by which the texels are finer along each axis when strands are rasterised; the result is then reduced.
const FINER: usize = 4;

/// Returns the mean transmittance of `slabs` stacked layers with 8-bit opacities. `fine` has the optical depths of the
/// finer texels. The opacity of each layer is rounded separately.
fn rounded(fine: &[f64], slabs: i32) -> f64 {
    let through = |layers: i32| {
        let share = f64::from(layers) / f64::from(slabs);
        fine.iter().map(|depth| libm::exp(-depth * share)).sum::<f64>() / fine.len() as f64
    };
    let opacity = |layer: i32| (255.0 * (1.0 - through(layer) / through(layer - 1).max(1e-300))).round() / 255.0;
    (1..=slabs).map(|layer| 1.0 - opacity(layer)).product()
}

fn drive() -> Result<Vec<Finding>, BakeError> {
    let strands = faint(0.0002, 0.2);
    let n = TEXELS * FINER;
    let depths = depths(&strands, n, 0.5);
    let truth = mean(&depths.iter().map(|d| libm::exp(-d)).collect::<Vec<_>>());
    let columns: Vec<Vec<f64>> = (0..TEXELS * TEXELS)
        .map(|i| {
            let (x, y) = (i % TEXELS * FINER, i / TEXELS * FINER);
            (0..FINER * FINER).map(|j| depths[(y + j / FINER) * n + x + j % FINER]).collect()
        })
        .filter(|column: &Vec<f64>| column.iter().any(|depth| *depth > 0.0))
        .collect();
    let empty = (TEXELS * TEXELS - columns.len()) as f64;
    let error = |found: f64| (found - truth).abs() / (1.0 - truth);
    let (mut naive, mut safe) = (0.0_f64, 0.0_f64);
    for layers in [4, 8, 16, 32, 64, 128, 256] {
        let sum: f64 = columns.iter().map(|column| rounded(column, layers - 1)).sum();
        naive = naive.max(error((sum + empty) / (TEXELS * TEXELS) as f64));
        safe = safe.max(error(mean(&transmittances(&slice(&strands, layers as u32, TEXELS as u32)?, 0))));
    }
    Ok(vec![Finding {
        case: "faint hair, worst of 4 to 256 layers".into(),
        measure: "relative error of coverage against f64",
        naive,
        safe,
        bound: 0.03,
        fails_above: 0.1,
    }])
}
