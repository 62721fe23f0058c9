//! `pelage render`: a package into a picture, or a clip into many.

use super::exit::{Exit, Failure};
use super::gpu::Gpu;
use super::output::{Output, require_parent};
use super::package_file::PackageFile;
use super::scene::{Scene, detail};
use super::view::View;
use super::view_args::ViewArgs;
use glam::Quat;
use pelage_bake::io;
use pelage_bake::picture::encode_png;
use pelage_bake::textures::srgb_to_linear;
use pelage_runtime::{Frame, Light};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Draw a package into a PNG, or a clip into numbered ones
#[derive(Clone, Debug, clap::Args)]
pub struct RenderArgs {
    /// The package
    #[arg(value_name = "PKG")]
    package: PathBuf,
    /// The picture to write; with --frames, %04d in it stands for the picture's number, from 0
    #[arg(long, short, value_name = "PNG")]
    output: PathBuf,
    /// Pictures per second of the clip, with --frames
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u32).range(1..=1000))]
    fps: u32,
    /// Samples per pixel, 1 or 4: 4 smooths the edges of the skin
    #[arg(long, value_name = "N", default_value = "1", value_parser = ["1", "4"])]
    samples: String,
    /// The light goes once around the vertical axis while the pictures last, with --frames
    #[arg(long, requires = "frames")]
    turn_light: bool,
    #[command(flatten)]
    view: ViewArgs,
}

/// What a picture turned out to be.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Pixels with any opacity.
    pub covered_pixels: u64,
    /// Mean luminance of the covered pixels, linear, 0..=1; 0 where none is.
    pub mean_luminance: f64,
    /// The frame it was drawn from, with its report.
    passes: Vec<serde_json::Value>,
    /// What is drawn of each copy's fur.
    detail: Vec<serde_json::Value>,
}

/// Runs the subcommand.
pub fn run(args: &RenderArgs, output: &mut Output) -> Result<Exit, Failure> {
    let samples = if args.samples == "4" { 4 } else { 1 };
    let view = View { samples, ..View::try_from(&args.view)? };
    let names = names(&args.output, args.view.frames)?;
    names.iter().try_for_each(|name| require_parent(name))?;
    let file = PackageFile::read(&args.package)?;
    output.progress("loading");
    let mut scene = Scene::new(&file, &view, Gpu::open)?;
    let mut pictures = Vec::new();
    for (index, name) in names.iter().enumerate() {
        output.progress(&format!("picture {} of {}", index + 1, names.len()));
        scene.set_time(view.time_s + index as f32 / args.fps as f32);
        if args.turn_light {
            scene.params.light = turned(view.light, std::f32::consts::TAU * index as f32 / names.len() as f32);
        }
        pictures.push(draw(&mut scene, name)?);
    }
    report(output, &scene, &view, &names, &pictures)?;
    Ok(Exit::Done)
}

/// Draws the scene as it stands into a PNG file.
pub fn draw(scene: &mut Scene, path: &Path) -> Result<Picture, Failure> {
    let frame = scene.draw()?;
    let pixels = scene.canvas.read(&scene.gpu)?;
    let covered_pixels = pixels.pixels().filter(|p| p.0[3] > 0).count() as u64;
    io::write_atomic(path, &encode_png(&pixels)?)?;
    Ok(Picture {
        covered_pixels,
        mean_luminance: mean_luminance(&pixels),
        passes: passes(&frame),
        detail: detail(&frame),
    })
}

/// A light carried around the world's vertical axis.
fn turned(light: Light, angle_rad: f32) -> Light {
    let turn = Quat::from_rotation_y(angle_rad);
    match light {
        Light::Directional { towards_light, color } => {
            Light::Directional { towards_light: turn * towards_light, color }
        }
        Light::Point { position, color } => Light::Point { position: turn * position, color },
    }
}

/// Mean luminance (Rec. 709) of the pixels with any opacity.
fn mean_luminance(pixels: &image::RgbaImage) -> f64 {
    let covered = || pixels.pixels().filter(|p| p.0[3] > 0);
    let of = |p: &image::Rgba<u8>| {
        let [r, g, b, _] = p.0.map(|byte| f64::from(srgb_to_linear(byte)));
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    covered().map(of).sum::<f64>() / covered().count().max(1) as f64
}

/// The frame's report as JSON.
fn passes(frame: &Frame) -> Vec<serde_json::Value> {
    let report = frame.report();
    report.passes.iter().map(|p| json!({ "name": p.name, "ran": p.ran, "reason": p.reason })).collect()
}

/// File names of the pictures: the output itself, or one per frame.
fn names(output: &Path, frames: Option<u32>) -> Result<Vec<PathBuf>, Failure> {
    let Some(frames) = frames else { return Ok(vec![output.to_owned()]) };
    let text = output.to_str().ok_or_else(|| Failure::Usage(format!("-o {}: not UTF-8", output.display())))?;
    let pattern = match text.split_once('%') {
        Some((head, tail)) => {
            let digits = tail.split_once('d').and_then(|(d, rest)| Some((d.parse::<usize>().ok()?, rest)));
            let Some((width @ 1..=9, rest)) = digits else {
                let expected = "expected a number pattern such as %04d after the first %";
                return Err(Failure::Usage(format!("-o {text}: {expected}")));
            };
            (head.to_owned(), width, rest.to_owned())
        }
        None => {
            let extension = output.extension().map_or(String::new(), |e| format!(".{}", e.to_string_lossy()));
            (format!("{}_", text.strip_suffix(&extension).unwrap_or(text)), 4, extension)
        }
    };
    let (head, width, tail) = pattern;
    Ok((0..frames).map(|i| PathBuf::from(format!("{head}{i:0width$}{tail}"))).collect())
}

fn report(
    output: &mut Output,
    scene: &Scene,
    view: &View,
    names: &[PathBuf],
    pictures: &[Picture],
) -> Result<(), Failure> {
    let covered = |p: &Picture| json!(p.covered_pixels);
    let files: Vec<_> = names.iter().map(|n| n.display().to_string()).collect();
    let value = json!({
        "output": files[0],
        "outputs": files,
        "adapter": scene.gpu.info.name,
        "driver": format!("{} {}", scene.gpu.info.driver, scene.gpu.info.driver_info),
        "width": view.size.0,
        "height": view.size.1,
        "covered_pixels": covered(&pictures[0]),
        "covered_pixels_per_picture": pictures.iter().map(covered).collect::<Vec<_>>(),
        "mean_luminance_per_picture": pictures.iter().map(|p| p.mean_luminance).collect::<Vec<_>>(),
        "passes": pictures[0].passes,
        "detail": pictures[0].detail,
    });
    output.result(&files.join("\n"), &value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_numbered() {
        let list =
            |o: &str, n| names(Path::new(o), n).map(|v| v.iter().map(|p| p.display().to_string()).collect::<Vec<_>>());
        assert_eq!(list("a.png", None).ok(), Some(vec!["a.png".to_owned()]));
        assert_eq!(list("d/%04d.png", Some(2)).ok(), Some(vec!["d/0000.png".to_owned(), "d/0001.png".to_owned()]));
        assert_eq!(list("walk.png", Some(1)).ok(), Some(vec!["walk_0000.png".to_owned()]));
        assert!(list("a%s.png", Some(1)).is_err());
    }
}
