//! How much hair there is outside the outline of the skin, against layers of four times the number and resolution.
//!
//! The error is the mean absolute difference of opacity within six pixels of the outline of the bare skin, between means over squares of
//! eight pixels: hair is noise to the pixel, and where each hair stands is not the same in both, so that single pixels differ by more than what
//! the eye takes for density. All pictures are supersampled, so that the sampling of a pixel's middle, which alone makes a difference of 0.07 a
//! pixel, is no part of the error.

use crate::binary::{data, workspace};
use crate::pictures::draw_passes;
use crate::support::headless::Gpu;
use glam::Vec3;
use pelage_bake::groom::MapImages;
use pelage_bake::import::ImportOptions;
use pelage_bake::recipe::Recipe;
use pelage_bake::{io, pipeline};
use pelage_formats::{Limits, Package};
use pelage_runtime::{Camera, FrameParams, Instance, Model, PassId, Renderer, RendererOptions, Style, wgpu};
use std::fmt::Write;
use std::path::PathBuf;

/// Opacity of every pixel, 0..=1.
#[derive(Clone, Debug)]
struct Coverage {
    /// Width and height, pixels.
    size: (u32, u32),
    /// `width * height`, row-major.
    alpha: Vec<f64>,
}

/// IEEE 754 binary16, little-endian; normal numbers and zero.
pub fn half_to_f32(bytes: [u8; 2]) -> f32 {
    let bits = u32::from(u16::from_le_bytes(bytes));
    if bits & 0x7fff == 0 {
        return 0.0;
    }
    f32::from_bits(((bits & 0x8000) << 16) | (((bits & 0x7fff) << 13) + (112 << 23)))
}

/// Draws one copy of a model, `samples` times as large each way, and averages.
fn coverage(
    gpu: &Gpu,
    package: &[u8],
    params: &FrameParams,
    size: (u32, u32),
    samples: u32,
    passes: &[PassId],
) -> Coverage {
    // 16-bit floats: 8 bits lose what thin layers add.
    let options = RendererOptions { color_format: wgpu::TextureFormat::Rgba16Float, ..RendererOptions::default() };
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options).expect("the options are valid");
    let model: Model = renderer.load_bytes(&gpu.device, &gpu.queue, package).expect("the package loads");
    let mut instance = Instance::new(&model);
    let large = (size.0 * samples, size.1 * samples);
    let texels = draw_passes(gpu, &mut renderer, large, params, &mut [&mut instance], passes);
    let mut alpha = vec![0.0; (size.0 * size.1) as usize];
    for (i, texel) in texels.chunks_exact(8).enumerate() {
        let (x, y) = (i as u32 % large.0 / samples, i as u32 / large.0 / samples);
        alpha[(y * size.0 + x) as usize] += f64::from(half_to_f32([texel[6], texel[7]]));
    }
    alpha.iter_mut().for_each(|a| *a /= f64::from(samples * samples));
    Coverage { size, alpha }
}

/// Distance of every pixel's centre to the nearest pixel that the bare skin covers by half, up to `reach` pixels; 0 on the skin.
fn distances(gpu: &Gpu, package: &[u8], params: &FrameParams, size: (u32, u32), reach: u32) -> Vec<f64> {
    let bare = FrameParams { style: Style::Bare, ..params.clone() };
    let skin = coverage(gpu, package, &bare, size, 4, &[PassId::Skin]);
    let (w, h, r) = (size.0 as i32, size.1 as i32, reach as i32);
    let inside: Vec<bool> = skin.alpha.iter().map(|a| *a >= 0.5).collect();
    let mut out = vec![f64::INFINITY; inside.len()];
    for y in 0..h {
        for x in 0..w {
            if !inside[(y * w + x) as usize] {
                continue;
            }
            out[(y * w + x) as usize] = 0.0;
            let edge = [(1, 0), (-1, 0), (0, 1), (0, -1)].iter().any(|(dx, dy)| {
                let (x, y) = (x + dx, y + dy);
                x >= 0 && y >= 0 && x < w && y < h && !inside[(y * w + x) as usize]
            });
            if !edge {
                continue;
            }
            for dy in -r..=r {
                for dx in -r..=r {
                    let (nx, ny) = (x + dx, y + dy);
                    if nx < 0 || ny < 0 || nx >= w || ny >= h {
                        continue;
                    }
                    let d = f64::from(dx * dx + dy * dy).sqrt();
                    let slot = &mut out[(ny * w + nx) as usize];
                    if d <= f64::from(reach) && d < *slot {
                        *slot = d;
                    }
                }
            }
        }
    }
    out
}

/// Mean opacity in each band of one pixel of distance from the outline: `(0, 1]`, `(1, 2]`, …
fn profile(coverage: &Coverage, distances: &[f64], bands: usize) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); bands];
    for (a, d) in coverage.alpha.iter().zip(distances) {
        if *d > 0.0 && *d <= bands as f64 {
            let sum = &mut sums[(d.ceil() as usize) - 1];
            *sum = (sum.0 + a, sum.1 + 1.0);
        }
    }
    sums.iter().map(|(a, n)| if *n > 0.0 { a / n } else { 0.0 }).collect()
}

/// Mean absolute difference of opacity within `reach` pixels of the outline, between means over squares of `window` pixels.
fn error(a: &Coverage, b: &Coverage, distances: &[f64], reach: f64, window: u32) -> f64 {
    let (w, h) = a.size;
    let (mut total, mut weight) = (0.0, 0.0);
    for y in (0..h).step_by(window as usize) {
        for x in (0..w).step_by(window as usize) {
            let (mut difference, mut n) = (0.0, 0.0);
            for (dx, dy) in (0..window * window).map(|i| (i % window, i / window)) {
                let (x, y) = (x + dx, y + dy);
                if x < w && y < h {
                    let i = (y * w + x) as usize;
                    if distances[i] > 0.0 && distances[i] <= reach {
                        difference += a.alpha[i] - b.alpha[i];
                        n += 1.0;
                    }
                }
            }
            total += f64::abs(difference);
            weight += n;
        }
    }
    total / f64::max(weight, 1.0)
}

/// A model to be measured.
#[derive(Clone, Debug)]
pub struct Case {
    /// For messages.
    pub name: &'static str,
    /// The model.
    pub model: PathBuf,
    /// Path of its recipe from the workspace's root; `None` for the default.
    pub recipe: Option<&'static str>,
    /// Size of the picture, pixels.
    pub size: (u32, u32),
}

/// The project's own models, and the bunny where the test data are there.
pub fn cases() -> Vec<Case> {
    let own = |name: &'static str, recipe, size| {
        let model = workspace().join(format!("assets/models/{name}.glb"));
        Case { name, model, recipe: Some(recipe), size }
    };
    let mut cases = vec![
        own("hare", "assets/recipes/hare.toml", (834, 424)),
        own("torus", "assets/recipes/torus.toml", (200, 200)),
        own("knot", "assets/recipes/knot.toml", (200, 200)),
    ];
    if let Some(data) = data() {
        let model = data.join("meshes/static/bunny.obj");
        cases.push(Case { name: "bunny", model, recipe: None, size: (400, 400) });
    }
    cases
}

/// What was measured of a model.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Its name.
    pub name: &'static str,
    /// Error of the layers without fins.
    pub shells_alone: f64,
    /// Error with fins.
    pub with_fins: f64,
    /// Opacity by distance from the outline: truth, layers without fins, layers beside fins and fins, fins alone.
    pub profiles: [Vec<f64>; 4],
}

/// Bands of one pixel in a profile.
const BANDS: usize = 10;
/// Distance from the outline within which the error is taken, pixels.
const REACH: f64 = 6.0;
/// Squares whose means are compared, pixels.
const WINDOW: u32 = 8;
/// Samples a pixel, each way.
const SAMPLES: u32 = 4;

impl Measured {
    /// The profiles and errors, for people.
    pub fn table(&self) -> String {
        let mut out = format!("{}: opacity by pixels from the outline\n", self.name);
        for (name, profile) in ["truth", "layers", "with fins", "fins alone"].iter().zip(&self.profiles) {
            let values: Vec<_> = profile.iter().map(|v| format!("{v:.3}")).collect();
            let _ = writeln!(out, "  {name:10} {}", values.join(" "));
        }
        let ratio = self.with_fins / self.shells_alone;
        let _ = write!(out, "  error {:.4} without, {:.4} with fins: {ratio:.2}", self.shells_alone, self.with_fins);
        out
    }
}

fn bake(case: &Case, set: &[&str]) -> Vec<u8> {
    let mut recipe = Recipe::default();
    if let Some(path) = case.recipe {
        let text = std::fs::read_to_string(workspace().join(path)).expect("the recipe is there");
        recipe = Recipe::parse(path, &text).expect("the recipe reads");
    }
    // Plain texels: a software rasteriser decodes blocks at every read.
    let plain = ["pack.shell_format=rgba8", "pack.direction_format=rg8", "pack.base_color_format=rgba8"];
    plain.iter().chain(set).for_each(|assignment| recipe.set(assignment).expect("the key exists"));
    let options = ImportOptions { unit_m: recipe.model.unit_m };
    let model = io::read_model(&case.model, &options).expect("the model reads");
    let file = case.model.display().to_string();
    pipeline::bake(&file, case.name, &model, &recipe, &MapImages::default(), &mut |_| ())
        .expect("the model bakes")
        .package
}

/// Measures a model from its front left.
pub fn measure(gpu: &Gpu, case: &Case) -> Measured {
    let package = bake(case, &[]);
    let recipe = Recipe::default().slice;
    let (layers, texels) = (4 * (recipe.layers - 1) + 1, 4 * recipe.tile_texels);
    let fine = [format!("slice.layers={layers}"), format!("slice.tile_texels={texels}"), "fins.enabled=false".into()];
    let fine = bake(case, &fine.each_ref().map(String::as_str));
    let bounds = Package::open(&package, &Limits::default()).expect("it opens").manifest().bounds;
    let aspect = case.size.0 as f32 / case.size.1 as f32;
    let camera = Camera::framing(Vec3::from(bounds.center), bounds.radius, Vec3::new(-0.7, 0.35, 0.8), 0.6, aspect);
    let with = FrameParams::new(camera);
    let without = FrameParams { fins: false, ..with.clone() };
    let draw = |package: &[u8], params: &FrameParams, passes: &[PassId]| {
        coverage(gpu, package, params, case.size, SAMPLES, passes)
    };
    let all = [PassId::Skin, PassId::Fins, PassId::Shells];
    let pictures = [
        draw(&fine, &without, &all),
        draw(&package, &without, &all),
        draw(&package, &with, &all),
        draw(&package, &with, &all[..2]),
    ];
    let distances = distances(gpu, &package, &with, case.size, BANDS as u32);
    let off = |k: usize| error(&pictures[k], &pictures[0], &distances, REACH, WINDOW);
    Measured {
        name: case.name,
        shells_alone: off(1),
        with_fins: off(2),
        profiles: pictures.each_ref().map(|picture| profile(picture, &distances, BANDS)),
    }
}

/// Opacity of two things behind each other, band by band.
pub fn stacked(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| 1.0 - (1.0 - a) * (1.0 - b)).collect()
}

/// Mean absolute difference of two profiles within reach of the error.
pub fn profile_error(a: &[f64], b: &[f64]) -> f64 {
    let bands = REACH as usize;
    a.iter().zip(b).take(bands).map(|(a, b)| (a - b).abs()).sum::<f64>() / bands as f64
}
