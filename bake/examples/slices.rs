//! Developer tool that grows and slices a tile of hair without a model or a GPU, and prints times and memory. It draws
//! the layers beside two lit views of the tile, one from straight above and one at a slant.
//!
//! `cargo run --release --example slices -- OUT.png [RECIPE.toml] [key=value]… [height=0.4]` where `height` is the hair
//! length in tile widths.
#![allow(clippy::disallowed_methods, reason = "packages made by tests are never kept")]

use glam::{Vec2, Vec3};
use pelage_bake::recipe::{Coat, Recipe};
use pelage_bake::stages::simulate::{VolumeParams, simulate_recipe};
use pelage_bake::stages::slice::{ShellSet, collect_layers, slice};
use pelage_formats::meaning::srgb_to_linear;
use pelage_formats::{TextureFormat, decode_direction};
use std::time::Instant;

const FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;
/// Width of each layer and each view on the contact sheet, pixels.
const CELL: u32 = 192;
const VIEW: u32 = 768;
/// Number of tile widths shown in a view.
const TILES: f32 = 2.0;

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let out = arguments.next().unwrap_or_else(|| "slices.png".into());
    let (mut recipe, mut volume) = (Recipe::of_coat(Coat::Natural)?, VolumeParams::default());
    for argument in arguments {
        match argument.split_once('=') {
            Some(("height", value)) => volume.height = value.parse()?,
            Some(_) => recipe.set(&argument)?,
            None => recipe = Recipe::parse(&argument, &std::fs::read_to_string(&argument)?)?,
        }
    }

    let start = Instant::now();
    let strands = simulate_recipe(&recipe, &volume)?;
    let simulated = start.elapsed();
    let mut bytes = 0;
    slice(&strands, &recipe.slice, FORMAT, |layer| {
        bytes += layer.color.iter().chain(&layer.direction).map(Vec::len).sum::<usize>();
        Ok(())
    })?;
    println!("{} strands, {} points, height {:.3}", strands.len(), strands.points.len(), strands.height);
    println!(
        "simulate {:.3} s, slice {:.3} s, {bytes} bytes",
        simulated.as_secs_f32(),
        (start.elapsed() - simulated).as_secs_f32()
    );
    if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
        status.lines().filter(|l| l.starts_with("VmHWM")).for_each(|l| println!("{l}"));
    }
    if recipe.slice.tile_texels > 256 || recipe.slice.layers > 64 {
        println!("too large to draw");
        return Ok(());
    }

    let set = collect_layers(&strands, &recipe.slice, FORMAT)?;
    let columns = 4;
    let shown: Vec<_> = (0..16).map(|i| i * (set.layers.len() - 1) / 15).collect();
    let mut picture = image::RgbImage::new(CELL * columns + 2 * VIEW, VIEW);
    for (i, &k) in shown.iter().enumerate() {
        let (x0, y0) = (CELL * (i as u32 % columns), CELL * (i as u32 / columns));
        for (x, y) in (0..CELL).flat_map(|x| (0..CELL).map(move |y| (x, y))) {
            let texel = |p: u32| (p * set.texels / CELL) as usize;
            let at = 4 * (texel(y) * set.texels as usize + texel(x));
            let t = &set.layers[k].color[0][at..at + 4];
            // Composite over mid grey, so that black hair is distinguishable from no hair.
            let over = |c: u8| srgb_to_linear(c) + 0.2 * (1.0 - f32::from(t[3]) / 255.0);
            picture.put_pixel(
                x0 + x,
                y0 + y,
                image::Rgb([over(t[0]), over(t[1]), over(t[2])].map(pelage_formats::meaning::linear_to_srgb)),
            );
        }
    }
    let shading = recipe.shading;
    for (view, slant) in [(0u32, 0.0f32), (1, 1.2)] {
        // Direction to the eye. `slant` is also the distance by which a layer shifts in the view, per unit of its
        // height.
        let eye = Vec3::new(0.0, -slant, 1.0).normalize();
        let light = Vec3::new(0.6, 0.3, 0.9).normalize();
        let half = (eye + light).normalize();
        for (x, y) in (0..VIEW).flat_map(|x| (0..VIEW).map(move |y| (x, y))) {
            let uv = Vec2::new(x as f32, y as f32 * (1.0 + slant * slant).sqrt()) * (TILES / VIEW as f32);
            let (mut color, mut transmittance) = (Vec3::ZERO, 1.0f32);
            for layer in set.layers.iter().rev() {
                let t = layer.index as f32 / (set.layers.len() - 1) as f32;
                let at = uv + Vec2::new(0.0, -slant * t * strands.height);
                let (rgb, alpha) = sample(&set, &layer.color[0], at, true);
                let (d, _) = sample(&set, &layer.direction[0], at, false);
                let tangent = d.normalize_or(Vec3::Z);
                let sine = |v: Vec3| (1.0 - tangent.dot(v).powi(2)).max(0.0).sqrt();
                let ambient = shading.ambient_floor + (1.0 - shading.ambient_floor) * t;
                let diffuse = Vec3::from(shading.diffuse) * sine(light).powf(shading.diffuse_exponent) * ambient;
                let specular = Vec3::from(shading.specular) * sine(half).powf(shading.specular_exponent) * ambient;
                color += transmittance * (rgb * (Vec3::from(shading.ambient) * ambient + diffuse) + alpha * specular);
                transmittance *= 1.0 - alpha;
            }
            let pixel = image::Rgb(color.to_array().map(pelage_formats::meaning::linear_to_srgb));
            picture.put_pixel(CELL * columns + VIEW * view + x, y, pixel);
        }
    }
    picture.save(&out)?;
    println!("{out}");
    Ok(())
}

/// Returns a bilinear sample of a texture. With `color`, that is linear RGB and opacity; otherwise, a direction.
fn sample(set: &ShellSet, level: &[u8], uv: Vec2, color: bool) -> (Vec3, f32) {
    let n = set.texels as i32;
    let p = uv * n as f32 - 0.5;
    let (cell, f) = (p.floor(), p - p.floor());
    let mut sum = (Vec3::ZERO, 0.0);
    for (dx, dy, w) in
        [(0, 0, (1.0 - f.x) * (1.0 - f.y)), (1, 0, f.x * (1.0 - f.y)), (0, 1, (1.0 - f.x) * f.y), (1, 1, f.x * f.y)]
    {
        let wrap = |i: i32| i.rem_euclid(n) as usize;
        let at = 4 * (wrap(cell.y as i32 + dy) * n as usize + wrap(cell.x as i32 + dx));
        let t = [level[at], level[at + 1], level[at + 2], level[at + 3]];
        let value = match color {
            true => Vec3::new(srgb_to_linear(t[0]), srgb_to_linear(t[1]), srgb_to_linear(t[2])),
            false => decode_direction(t.map(|b| f32::from(b) / 255.0), FORMAT),
        };
        sum.0 += value * w;
        sum.1 += f32::from(t[3]) / 255.0 * w;
    }
    sum
}
