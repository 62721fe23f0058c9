//! Makes a contact sheet of many furred models: `chores contact-sheet OUT.png COLUMNS WxH MODEL [bake options] [+ MODEL
//! [bake options]]…`.
//!
//! Bakes and draws every model through the real binary, at `WxH` pixels each, row by row. Prints the cell of each model
//! and the measurements of its surface stage to stdout. If a model cannot be baked or drawn, the run ends with the
//! binary's error message.

use anyhow::{Context as _, bail, ensure};
use image::RgbImage;
use pelage_tests::chores::{ChoreFolder, sheet};

pub fn run(arguments: &[String]) -> anyhow::Result<()> {
    let [out, columns, size, models @ ..] = arguments else {
        bail!("expected OUT.png COLUMNS WxH MODEL [bake options] [+ MODEL [bake options]]…");
    };
    let columns: usize = columns
        .parse()
        .ok()
        .filter(|n| *n > 0)
        .with_context(|| format!("found {columns}, expected the number of columns"))?;
    let models: Vec<&[String]> = models.split(|a| a == "+").filter(|m| !m.is_empty()).collect();
    ensure!(!models.is_empty(), "no model given");
    let workshop = ChoreFolder::default();
    let mut pictures = Vec::new();
    for (index, model) in models.iter().enumerate() {
        pictures.push(draw(&workshop, model, size).with_context(|| format!("picture {}: {}", index + 1, model[0]))?);
    }
    sheet(&pictures, columns)?.save(out).with_context(|| format!("cannot write {out}"))
}

fn draw(workshop: &ChoreFolder, model: &[String], size: &str) -> anyhow::Result<RgbImage> {
    let baked = workshop.bake("model", model)?;
    let figures = ["patches", "flipped_triangles", "angle_distortion", "area_distortion", "comb_misalignment_deg"];
    let figures: Vec<String> = figures.iter().map(|name| format!("{name} {}", baked.report[name])).collect();
    println!("{}: {}", model[0], figures.join(", "));
    workshop.draw::<&str>(&baked, size, &[])
}
