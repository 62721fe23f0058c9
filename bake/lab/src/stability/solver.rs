//! Slivers make the equations of a patch nearly singular. The naive form uses conjugate gradients in f32, with a fixed
//! number of iterations and no check of the result.

use super::row::{Finding, Row};
use super::surface::{model, not_positive, parameterize_default};
use glam::{DVec2, Vec2, vec3};
use pelage_import::BakeError;
use pelage_import::mesh::Model;

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "solver",
    cliff: "nearly singular systems from slivers",
    naive: "conjugate gradients in f32, 56 iterations, the result unchecked",
    safe: "factorise in f64, check the residual, fall back with a warning",
    drive,
};

/// Widths of the narrowest slivers, relative to the width of a quad.
pub const LEAST: [f32; 5] = [1e-2, 1e-3, 1e-4, 1e-5, 3e-6];

/// Returns a square sheet whose columns narrow from quads to slivers, from width 1 to `least`.
pub fn slivers(least: f32) -> Model {
    let (columns, rows) = (24u32, 24u32);
    let mut x = vec![0.0f32];
    for k in 0..columns {
        x.push(x[k as usize] + least.powf(k as f32 / (columns - 1) as f32));
    }
    let positions =
        x.iter().flat_map(|x| (0..=rows).map(|j| vec3(*x, 0.02 * (*x * 3.0).sin(), j as f32 / rows as f32)));
    let at = |i: u32, j: u32| i * (rows + 1) + j;
    let quad = |i: u32, j: u32| {
        let (a, b, c, d) = (at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
        [[a, b, c], [a, c, d]]
    };
    let triangles = (0..columns).flat_map(|i| (0..rows).flat_map(move |j| quad(i, j))).collect();
    model(positions.collect(), triangles)
}

/// Solves the Poisson system of formulas 6.3 by 56 iterations of Jacobi-preconditioned conjugate gradients. Returns the
/// number of flipped triangles.
pub fn naive_flips(model: &Model, tile_m: f32) -> usize {
    let mesh = &model.mesh;
    let n = mesh.positions.len();
    let mut rows: Vec<Vec<(usize, f32)>> = vec![Vec::new(); n];
    let mut right = vec![Vec2::ZERO; n];
    for t in &mesh.triangles {
        let p = t.map(|v| mesh.positions[v as usize]);
        let cross = (p[1] - p[0]).cross(p[2] - p[0]);
        let (area, normal) = (cross.length() / 2.0, cross / cross.length());
        let along = vec3(0.0, -0.35, -1.0).reject_from(normal).normalize();
        let gradient = [0, 1, 2].map(|i| normal.cross(p[(i + 2) % 3] - p[(i + 1) % 3]) / (2.0 * area));
        for i in 0..3 {
            for j in 0..3 {
                rows[t[i] as usize].push((t[j] as usize, area * gradient[i].dot(gradient[j])));
            }
            right[t[i] as usize] +=
                Vec2::new(gradient[i].dot(along.cross(normal)), gradient[i].dot(along)) * (area / tile_m);
        }
    }
    let apply = |x: &[Vec2]| -> Vec<Vec2> {
        let sum = |i: usize| rows[i].iter().filter(|(j, _)| *j > 0).map(|(j, w)| x[*j] * *w).sum();
        (0..n).map(|i| if i == 0 { Vec2::ZERO } else { sum(i) }).collect()
    };
    let diagonal: Vec<f32> = (0..n).map(|i| rows[i].iter().filter(|(j, _)| *j == i).map(|(_, w)| w).sum()).collect();
    let dot = |a: &[Vec2], b: &[Vec2]| a.iter().zip(b).map(|(a, b)| *a * *b).sum::<Vec2>();
    let mut x = vec![Vec2::ZERO; n];
    let mut residual: Vec<Vec2> = right.iter().enumerate().map(|(i, r)| if i == 0 { Vec2::ZERO } else { *r }).collect();
    let precondition = |r: &[Vec2]| -> Vec<Vec2> { r.iter().zip(&diagonal).map(|(r, d)| *r / *d).collect() };
    let mut z = precondition(&residual);
    let mut direction = z.clone();
    let mut rz = dot(&residual, &z);
    for _ in 0..56 {
        let q = apply(&direction);
        let step = rz / dot(&direction, &q);
        for i in 0..n {
            x[i] += direction[i] * step;
            residual[i] -= q[i] * step;
        }
        z = precondition(&residual);
        let next = dot(&residual, &z);
        for i in 0..n {
            direction[i] = z[i] + direction[i] * (next / rz);
        }
        rz = next;
    }
    let det = |t: &[u32; 3]| {
        let [a, b, c]: [DVec2; 3] = t.map(|v| x[v as usize].as_dvec2());
        (b - a).perp_dot(c - a)
    };
    // NaN does not count as a positive area.
    mesh.triangles.iter().filter(|t| det(t).is_nan() || det(t) <= 0.0).count()
}

fn drive() -> Result<Vec<Finding>, BakeError> {
    let (mut naive, mut safe) = (0, 0);
    for least in LEAST {
        let model = slivers(least);
        naive += naive_flips(&model, 0.5);
        safe += not_positive(&parameterize_default(&model, 0.5)?);
    }
    Ok(vec![Finding {
        case: format!("{} sheets of slivers, down to {:e} wide", LEAST.len(), LEAST[LEAST.len() - 1]),
        measure: "triangles flipped or without area in the tile",
        naive: naive as f64,
        safe: safe as f64,
        bound: 0.0,
        fails_above: 20.0,
    }])
}
