//! Many furred models in one picture, to be looked at:
//! `cargo run --workspace --bin contact_sheet -- OUT.png COLUMNS WxH MODEL [bake options] [+ MODEL [bake options]]…`.
//!
//! Bakes and draws every model through the real binary, each `WxH` pixels, row by row, and says on stdout which is where and what its
//! surface stage measured. A model that cannot be baked or drawn ends the run with the binary's own words.

use anyhow::{Context as _, bail, ensure};
use image::{GenericImage as _, Rgb, RgbImage};
use pelage_tests::binary::{Sandbox, finish};
use serde_json::Value;

/// Behind the models, and where a row is not full.
const BACKGROUND: Rgb<u8> = Rgb([204, 209, 217]);

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [out, columns, size, models @ ..] = arguments.as_slice() else {
        bail!("expected OUT.png COLUMNS WxH MODEL [bake options] [+ MODEL [bake options]]…");
    };
    let columns: usize =
        columns.parse().ok().filter(|n| *n > 0).with_context(|| format!("{columns}: no number of columns"))?;
    let models: Vec<&[String]> = models.split(|a| a == "+").filter(|m| !m.is_empty()).collect();
    ensure!(!models.is_empty(), "no model given");
    let sandbox = Sandbox::new();
    let mut pictures = Vec::new();
    for (index, model) in models.iter().enumerate() {
        pictures.push(draw(&sandbox, model, size).with_context(|| format!("picture {}: {}", index + 1, model[0]))?);
    }
    let (w, h) = pictures[0].dimensions();
    let size = (w * columns.min(pictures.len()) as u32, h * pictures.len().div_ceil(columns) as u32);
    let mut sheet = RgbImage::from_pixel(size.0, size.1, BACKGROUND);
    for (index, picture) in pictures.iter().enumerate() {
        sheet.copy_from(picture, w * (index % columns) as u32, h * (index / columns) as u32)?;
    }
    sheet.save(out).with_context(|| format!("cannot write {out}"))
}

fn draw(sandbox: &Sandbox, model: &[String], size: &str) -> anyhow::Result<RgbImage> {
    let here = std::env::current_dir()?;
    let run = |arguments: &[&str]| {
        let mut command = sandbox.command(arguments);
        // Paths on the command line are those of whoever typed it.
        command.current_dir(&here);
        let run = finish(command);
        ensure!(run.code == Some(0), "{}", run.stderr.trim());
        Ok(run)
    };
    let [package, picture] = ["a.pelage", "a.png"].map(|name| sandbox.path().join(name).display().to_string());
    let mut bake = vec!["bake", "-o", &package, "--json", "--quiet"];
    // A software rasteriser reads plain texels many times faster than blocks.
    bake.extend(["--set", "pack.shell_format=rgba8", "--set", "pack.direction_format=rg8"]);
    bake.extend(model.iter().map(String::as_str));
    let report: Value = serde_json::from_str(&run(&bake)?.stdout)?;
    let figures = ["patches", "flipped_triangles", "angle_distortion", "area_distortion", "comb_misalignment_deg"];
    let figures: Vec<String> = figures.iter().map(|name| format!("{name} {}", report[name])).collect();
    println!("{}: {}", model[0], figures.join(", "));
    run(&[
        "render",
        &package,
        "-o",
        &picture,
        "--size",
        size,
        "--samples",
        "4",
        "--background",
        "204,209,217",
        "--quiet",
    ])?;
    Ok(image::open(&picture)?.to_rgb8())
}
