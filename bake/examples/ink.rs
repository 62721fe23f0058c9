//! Developer tool that draws the ink textures of a recipe on one sheet, with a row per texture and a column per
//! channel. It also prints the time that each texture takes.
//!
//! `cargo run --release --example ink -- OUT.png [RECIPE.toml] [key=value]… [height=0.15]` where `height` is the hair
//! length in tile widths.

use image::GrayImage;
use pelage_bake::io::read_map_images;
use pelage_bake::progress::StageProgress;
use pelage_bake::recipe::{Coat, FilePath, Recipe};
use pelage_bake::stages::ink::{self, Plane};
use pelage_bake::stages::simulate::{VolumeParams, simulate_recipe};
use std::time::Instant;

/// Width of one channel on the sheet, pixels.
const CELL: u32 = 512;

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let out = arguments.next().unwrap_or_else(|| "ink.png".into());
    let (mut recipe, mut volume) = (Recipe::of_coat(Coat::Natural)?, VolumeParams { height: 0.15 });
    for argument in arguments {
        match argument.split_once('=') {
            Some(("height", value)) => volume.height = value.parse()?,
            Some(_) => recipe.set(&argument)?,
            None => recipe = Recipe::parse(&argument, &std::fs::read_to_string(&argument)?)?,
        }
    }
    let strands = simulate_recipe(&recipe, &volume)?;
    let images = read_map_images("recipe", &|name| name.into(), &recipe)?;
    let scan = |path: &Option<FilePath>| path.as_ref().map(|p| (p.0.clone(), images.get(&p.0)));
    let band = scan(&recipe.ink.stroke_image).map(|(path, image)| ink::stroke_band(&path, image?)).transpose()?;
    let tile = scan(&recipe.ink.wash_image).map(|(path, image)| ink::wash_tile(&path, image?)).transpose()?;
    let mut rows = Vec::new();
    let mut row = |name: &str, paint: &dyn Fn() -> Vec<[Plane; 4]>| {
        let start = Instant::now();
        let layers = paint();
        println!("{name}: {:.3} s", start.elapsed().as_secs_f32());
        for (layer, planes) in layers.into_iter().enumerate() {
            let figures = planes.each_ref().map(|p| format!("{:.3} ± {:.3}", p.mean(), p.deviation()));
            println!("  layer {layer}: {}", figures.join(", "));
            rows.push(planes);
        }
    };
    row("stroke", &|| vec![ink::stroke(&recipe.ink, band.as_ref())]);
    row("wash", &|| vec![ink::wash(&recipe.ink, tile.as_ref())]);
    row("paper", &|| vec![ink::paper(&recipe.ink)]);
    row("fur", &|| ink::fur(&strands, recipe.ink.fur_texels, recipe.ink.seed).to_vec());
    let start = Instant::now();
    let textures = ink::textures(&recipe.ink, &recipe.pack, &images, Some(&strands), StageProgress::ignored())?;
    let bytes = [&textures.stroke, &textures.wash, &textures.paper].map(|(_, file)| file.len());
    let fur = textures.fur.map_or(0, |(_, file)| file.len());
    println!("all, encoded: {:.3} s; {bytes:?} and {fur} bytes", start.elapsed().as_secs_f32());

    let mut sheet = GrayImage::new(4 * CELL, CELL * rows.len() as u32);
    for (y, planes) in rows.iter().enumerate() {
        for (x, plane) in planes.iter().enumerate() {
            let side = plane.side as u32;
            let texel = |i: u32| (i * side / CELL) as usize;
            for (i, j) in (0..CELL).flat_map(|j| (0..CELL).map(move |i| (i, j))) {
                let value = plane.values[texel(j) * plane.side + texel(i)];
                let pixel = image::Luma([(255.0 * value).round() as u8]);
                sheet.put_pixel(x as u32 * CELL + i, y as u32 * CELL + j, pixel);
            }
        }
    }
    sheet.save(&out)?;
    println!("{out}");
    Ok(())
}
