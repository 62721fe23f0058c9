//! Benchmark `cargo bench -p pelage-bake`: how the time of each step of a bake grows with the model. Each model is
//! baked with n and with 4 n elements. Steps of n log n take slightly more than 4 times as long, quadratic ones 16
//! times. Prints both times of each step and their ratio; fails if a ratio exceeds the limit.
#![allow(clippy::unwrap_used, reason = "in a benchmark a panic is the report")]

use pelage_bake::pipeline::{BakeInput, Outputs, STEPS};
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::groom::MapImages;
use pelage_import::{ImportOptions, import};
use std::fmt::Write as _;
use std::process::ExitCode;
use std::time::Instant;

/// Largest ratio that is not reported as a fault, with a margin for interference by other programs.
const MOST_GROWTH: f64 = 7.0;
/// Steps that take less than this at 4 n, seconds, are not judged.
const LEAST_S: f64 = 0.5;

/// Model whose size can be chosen.
struct Case {
    name: &'static str,
    /// Smaller number of elements.
    n: u32,
    /// Returns the text of an OBJ file with that number of elements.
    text: fn(u32) -> String,
}

const CASES: [Case; 4] = [
    Case { name: "triangles of a terrain", n: 25_000, text: terrain },
    Case { name: "corners of a polygon", n: 8_000, text: polygon },
    Case { name: "loose pieces", n: 250, text: |n| grids(n, false) },
    Case { name: "materials", n: 100, text: |n| grids(n, true) },
];

/// Writes a hilly square of 1 m at `x`, with `side` × `side` quads, whose first vertex is number `first` of the file.
fn grid(text: &mut String, x: f64, side: u32, first: u32) {
    for (i, k) in (0..=side).flat_map(|i| (0..=side).map(move |k| (i, k))) {
        let [u, v] = [i, k].map(|at| f64::from(at) / f64::from(side));
        writeln!(text, "v {:.6} {:.6} {v:.6}", x + u, 0.05 * libm::sin(9.0 * u) * libm::cos(7.0 * v)).unwrap();
    }
    for (i, k) in (0..side).flat_map(|i| (0..side).map(move |k| (i, k))) {
        let a = first + i * (side + 1) + k;
        writeln!(text, "f {a} {} {} {}", a + 1, a + side + 2, a + side + 1).unwrap();
    }
}

/// Returns a hilly square of about `n` triangles.
fn terrain(n: u32) -> String {
    let mut text = String::new();
    grid(&mut text, 0.0, (f64::from(n) / 2.0).sqrt() as u32, 1);
    text
}

/// Returns a disc that is a single polygon of `n` corners.
fn polygon(n: u32) -> String {
    let mut text = String::new();
    for i in 0..n {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(i) / f64::from(n));
        writeln!(text, "v {:.6} 0 {:.6}", 0.3 * cos, -0.3 * sin).unwrap();
    }
    (0..n).fold(text + "f", |text, i| text + &format!(" {}", i + 1))
}

/// Returns `n` separate squares of 72 triangles, each with a material of its own if `materials` is true.
fn grids(n: u32, materials: bool) -> String {
    const SIDE: u32 = 6;
    let mut text = String::new();
    for i in 0..n {
        if materials {
            writeln!(text, "usemtl m{i}").unwrap();
        }
        grid(&mut text, 1.5 * f64::from(i), SIDE, 1 + i * (SIDE + 1) * (SIDE + 1));
    }
    text
}

/// Bakes the text of an OBJ file, one step after another. Returns the stage and output of each step, and its time,
/// seconds.
fn steps_of(text: &str) -> Vec<(String, f64)> {
    let begun = Instant::now();
    let model = import("growth.obj", text.as_bytes(), &mut |_, _| Ok(Vec::new()), &ImportOptions::default()).unwrap();
    let mut times = vec![("import".to_owned(), begun.elapsed().as_secs_f64())];
    let (recipe, images) = (Recipe::default(), MapImages::default());
    let input = BakeInput::new("growth", "growth", &recipe, &images);
    let outputs = Outputs::of_model(&model);
    for step in STEPS {
        let begun = Instant::now();
        step.run(&input, &outputs).unwrap();
        times.push((format!("{}, {:?}", step.stage, step.makes), begun.elapsed().as_secs_f64()));
    }
    times
}

fn main() -> ExitCode {
    let mut steep = 0;
    for case in CASES {
        let [small, large] = [case.n, 4 * case.n].map(|n| steps_of(&(case.text)(n)));
        println!("{} and {} {}", case.n, 4 * case.n, case.name);
        for ((step, less), (_, more)) in small.into_iter().zip(large) {
            let growth = more / less;
            let judged = more >= LEAST_S;
            let mark = if judged && growth > MOST_GROWTH { "  too steep" } else { "" };
            steep += usize::from(!mark.is_empty());
            let ratio = if judged { format!("{growth:6.2}") } else { "     -".to_owned() };
            println!("  {step:<28} {less:8.3} s {more:8.3} s {ratio}{mark}");
        }
    }
    if steep > 0 {
        println!("{steep} steps grow by more than {MOST_GROWTH} for four times the elements");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}
