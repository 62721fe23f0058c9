//! Building blocks of the chores: bake a model, draw it and measure it with the real binary, and combine pictures.

use crate::binary::{Run, Sandbox, run_to_end};
use anyhow::{Context as _, ensure};
use image::{GenericImage as _, Rgb, RgbImage};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Background colour of the pictures and of empty cells in a sheet.
pub const BACKGROUND: Rgb<u8> = Rgb([204, 209, 217]);

/// Temporary folder for packages and pictures, in which a chore runs the binary.
#[derive(Debug, Default)]
pub struct ChoreFolder {
    sandbox: Sandbox,
}

/// Baked package and the report of the bake.
#[derive(Clone, Debug)]
pub struct Baked {
    /// Path of the package in the [`ChoreFolder`].
    pub package: PathBuf,
    /// Output of `pelage bake --json`.
    pub report: Value,
}

impl ChoreFolder {
    /// Runs the binary. Paths in `arguments` are relative to the caller's current folder.
    ///
    /// # Errors
    ///
    /// The binary's error message if it fails.
    pub fn run(&self, arguments: &[&str]) -> anyhow::Result<Run> {
        let mut command = self.sandbox.command(arguments);
        command.current_dir(std::env::current_dir()?);
        let run = run_to_end(command);
        ensure!(run.code == Some(0), "{}", run.stderr.trim());
        Ok(run)
    }

    /// Bakes a model with uncompressed texels, which need no encoder. `model` is the path and options of `pelage bake`.
    ///
    /// # Errors
    ///
    /// Same as [`Self::run`].
    pub fn bake<S: AsRef<str>>(&self, name: &str, model: &[S]) -> anyhow::Result<Baked> {
        let package = self.sandbox.path().join(format!("{name}.pelage"));
        let path = package.display().to_string();
        let mut arguments = vec!["bake", "-o", &path, "--json", "--quiet"];
        arguments.extend(["--set", "pack.shell_format=rgba8", "--set", "pack.direction_format=rg8"]);
        arguments.extend(model.iter().map(AsRef::as_ref));
        let report = serde_json::from_str(&self.run(&arguments)?.stdout)?;
        Ok(Baked { package, report })
    }

    /// Draws a package over [`BACKGROUND`], with options of `pelage render`.
    ///
    /// # Errors
    ///
    /// Same as [`Self::run`].
    pub fn draw<S: AsRef<str>>(&self, baked: &Baked, size: &str, options: &[S]) -> anyhow::Result<RgbImage> {
        let picture = self.sandbox.path().join("picture.png").display().to_string();
        let package = baked.package.display().to_string();
        let mut arguments = vec!["render", &package, "-o", &picture, "--size", size, "--samples", "4", "--quiet"];
        arguments.extend(["--background", "204,209,217"]);
        arguments.extend(options.iter().map(AsRef::as_ref));
        self.run(&arguments)?;
        Ok(image::open(&picture)?.to_rgb8())
    }
}

impl ChoreFolder {
    /// Draws a package in ink on paper, with options of `pelage render`.
    ///
    /// # Errors
    ///
    /// Same as [`Self::run`].
    pub fn paint<S: AsRef<str>>(&self, baked: &Baked, size: &str, options: &[S]) -> anyhow::Result<RgbImage> {
        let picture = self.sandbox.path().join("painting.png").display().to_string();
        let package = baked.package.display().to_string();
        let mut arguments = vec!["render", &package, "-o", &picture, "--size", size, "--style", "ink", "--quiet"];
        arguments.extend(options.iter().map(AsRef::as_ref));
        self.run(&arguments)?;
        Ok(image::open(&picture)?.to_rgb8())
    }

    /// Draws a sequence of pictures, like [`Self::draw`].
    ///
    /// # Errors
    ///
    /// Same as [`Self::run`].
    pub fn sequence<S: AsRef<str>>(
        &self,
        baked: &Baked,
        size: &str,
        count: usize,
        options: &[S],
    ) -> anyhow::Result<Vec<RgbImage>> {
        let folder = self.sandbox.path().join("sequence");
        if folder.exists() {
            std::fs::remove_dir_all(&folder)?;
        }
        let (pictures, package) = (folder.join("%03d.png").display().to_string(), baked.package.display().to_string());
        let frames = count.to_string();
        let mut arguments = vec!["render", &package, "-o", &pictures, "--frames", &frames, "--size", size];
        arguments.extend(["--samples", "4", "--quiet", "--background", "204,209,217"]);
        arguments.extend(options.iter().map(AsRef::as_ref));
        self.run(&arguments)?;
        let read = |index: usize| Ok(image::open(folder.join(format!("{index:03}.png")))?.to_rgb8());
        (0..count).map(read).collect()
    }
}

/// Combines pictures of the same size into a sheet, row by row.
///
/// # Errors
///
/// If `pictures` is empty, or a picture is larger than the first.
pub fn sheet(pictures: &[RgbImage], columns: usize) -> anyhow::Result<RgbImage> {
    let (w, h) = pictures.first().context("no picture")?.dimensions();
    let size = (w * columns.min(pictures.len()) as u32, h * pictures.len().div_ceil(columns) as u32);
    let mut sheet = RgbImage::from_pixel(size.0, size.1, BACKGROUND);
    for (index, picture) in pictures.iter().enumerate() {
        sheet.copy_from(picture, w * (index % columns) as u32, h * (index / columns) as u32)?;
    }
    Ok(sheet)
}

/// Saves a picture with at most 256 colours as a small PNG. Colours of about the same brightness and hue become their
/// mean.
///
/// # Errors
///
/// If the file cannot be written.
pub fn save_indexed(picture: &RgbImage, path: &Path) -> anyhow::Result<()> {
    // Group of a colour: its brightness in finer steps than its hue.
    let group = |p: &Rgb<u8>, step: i32| {
        let [r, g, b] = p.0.map(i32::from);
        [(r + g + b) / step, (r - g).div_euclid(4 * step), (b - g).div_euclid(4 * step)]
    };
    let mut means: BTreeMap<[i32; 3], [u64; 4]> = BTreeMap::new();
    let step = (3..=96).find(|step| {
        means.clear();
        for p in picture.pixels() {
            let sum = means.entry(group(p, *step)).or_default();
            sum.iter_mut().zip(p.0.map(u64::from).into_iter().chain([1])).for_each(|(sum, value)| *sum += value);
        }
        means.len() <= 256
    });
    let step = step.context("more than 256 colours")?;
    let numbers: BTreeMap<[i32; 3], u8> = means.keys().copied().zip(0..=255).collect();
    let palette: Vec<u8> =
        means.values().flat_map(|[r, g, b, n]| [r, g, b].map(|sum| ((sum + n / 2) / n) as u8)).collect();
    let indices: Vec<u8> = picture.pixels().map(|p| numbers[&group(p, step)]).collect();
    let file = std::fs::File::create(path).with_context(|| format!("cannot write {}", path.display()))?;
    let mut encoder = png::Encoder::new(std::io::BufWriter::new(file), picture.width(), picture.height());
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette);
    encoder.set_compression(png::Compression::High);
    encoder.set_filter(png::Filter::NoFilter);
    encoder.write_header()?.write_image_data(&indices)?;
    Ok(())
}
