//! Hair outside the outline of the mesh surface, compared with the true strands.
//!
//! The error is the mean absolute difference of opacity within six pixels of the outline of the bare surface. It is
//! measured between means over squares of eight pixels, because a hair does not end at the same pixel in both pictures.
//! All pictures are supersampled: with one sample per pixel, sampling alone would cause a difference of 0.07 per pixel.

use super::row::{DrawCallback, Drawing};
use crate::mask::Mask;
use glam::{Mat4, Vec3};
use pelage_bake::pipeline;
use pelage_bake::pipeline::BakeInput;
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::groom::MapImages;
use pelage_bake::strands::{Curves, PosedMesh, grow_on, tile_hair};
use pelage_formats::{Limits, Package};
use pelage_import::BakeError;
use pelage_import::mesh::Model;
use pelage_runtime::{Camera, Detail, FrameParams, HairGeometry, PassId, SlantForm, Style};
use pelage_truth::{Lens, TrueCamera, TrueLight, TrueLighting, TrueScene};
use std::fmt::Write as _;

/// Opacity of every pixel, 0..=1.
#[derive(Clone, Debug)]
struct Coverage {
    /// Width and height, pixels.
    size: (u32, u32),
    /// Opacities of `width * height` pixels, row-major.
    alpha: Vec<f64>,
}

/// Renders one instance of a model at [`SAMPLES`] times the size along each axis, and averages.
fn coverage(
    draw: &mut DrawCallback<'_>,
    package: &[u8],
    params: &FrameParams,
    size: (u32, u32),
    passes: &[PassId],
) -> Result<Coverage, BakeError> {
    let large = (size.0 * SAMPLES, size.1 * SAMPLES);
    let params = &params.clone().with(|params| params.viewport = large.into());
    let found = draw(&Drawing { package, params, size: large, passes, at: Mat4::IDENTITY })?;
    let mut alpha = vec![0.0; (size.0 * size.1) as usize];
    for (i, [.., opacity]) in found.into_iter().enumerate() {
        let (x, y) = (i as u32 % large.0 / SAMPLES, i as u32 / large.0 / SAMPLES);
        alpha[(y * size.0 + x) as usize] += f64::from(opacity);
    }
    alpha.iter_mut().for_each(|a| *a /= f64::from(SAMPLES * SAMPLES));
    Ok(Coverage { size, alpha })
}

/// Returns the distance from every pixel's centre to the nearest pixel at least half covered by the bare `skin`. It is
/// 0 on the surface.
fn distances(skin: &Coverage) -> Vec<f64> {
    let (width, height) = skin.size;
    Mask { width, height, pixels: skin.alpha.iter().map(|a| *a >= 0.5).collect() }.distances()
}

/// Returns the mean opacity in bands of distance from the outline, each one pixel wide: `(0, 1]`, `(1, 2]`, …
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

/// Returns the mean absolute difference of opacity within `reach` pixels of the outline, between means over squares of
/// side `window`, pixels.
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

/// Silhouette measurements of a model.
#[derive(Clone, Debug)]
pub struct SilhouetteMeasures {
    /// Error of layers rendered as sheets, whose opacity does not depend on the view angle, without fins.
    pub sheets: f64,
    /// Error of layers rendered as slabs, whose opacity depends on the length of the view path through them, with fins.
    pub ours: f64,
    /// Opacity by distance from the outline: of the truth, of sheets, of slabs without fins, of slabs with fins, and of
    /// fins only.
    pub profiles: [Vec<f64>; 5],
}

/// Number of one-pixel bands in a profile.
const BANDS: usize = 10;
/// Distance from the outline within which the error is measured, pixels.
const REACH: f64 = 6.0;
/// Side of the squares whose means are compared, pixels.
const WINDOW: u32 = 8;
/// Samples per pixel along each axis.
const SAMPLES: u32 = 4;

/// Number of samples per pixel of the truth.
const TRUE_SAMPLES: u32 = 16;

impl SilhouetteMeasures {
    /// Formats the profiles and errors as text.
    pub fn table(&self) -> String {
        let mut out = "opacity by distance from the outline, pixels\n".to_owned();
        for (name, profile) in ["truth", "sheets", "slabs", "with fins", "fins alone"].iter().zip(&self.profiles) {
            let values: Vec<_> = profile.iter().map(|v| format!("{v:.3}")).collect();
            let _ = writeln!(out, "  {name:10} {}", values.join(" "));
        }
        let _ = write!(
            out,
            "  error: sheets {:.4}, ours {:.4}, ratio {:.2}",
            self.sheets,
            self.ours,
            self.ours / self.sheets
        );
        out
    }
}

/// Bakes a model with uncompressed texels, so that block compression adds no error.
///
/// # Errors
///
/// Same as [`pipeline::bake`].
pub fn bake(file: &str, model: &Model, recipe: &Recipe) -> Result<Vec<u8>, BakeError> {
    let mut recipe = recipe.clone();
    let plain = ["pack.shell_format=rgba8", "pack.direction_format=rg8", "pack.base_color_format=rgba8"];
    plain.iter().try_for_each(|set| recipe.set(set))?;
    let baked =
        pipeline::bake(&BakeInput::new(file, "silhouette", &recipe, &MapImages::default()), model, &mut |_| ())?;
    Ok(baked.package)
}

/// Measures a package from the front left, in a picture of `size` pixels.
///
/// # Errors
///
/// [`BakeError::Internal`] if the package does not open, and any error that `draw` returns.
pub fn measure(package: &[u8], size: (u32, u32), draw: &mut DrawCallback<'_>) -> Result<SilhouetteMeasures, BakeError> {
    let opened = Package::open(package, &Limits::default());
    let opened = opened.map_err(|e| BakeError::Internal(format!("cannot read back the baked package: {e}")))?;
    let bounds = opened.manifest().bounds;
    let aspect = size.0 as f32 / size.1 as f32;
    let camera =
        Camera::framing(Vec3::from(bounds.center), bounds.radius, Vec3::new(-0.7, 0.35, 0.8), FOV_Y_RAD, aspect);
    let with = FrameParams::new(camera, [size.0, size.1]);
    let with = with.with_fur(|fur| (fur.detail, fur.hair) = (Detail::Full, HairGeometry::Shells));
    let without = with.clone().with_fur(|fur| fur.fins = false);
    let sheets = without.clone().with(|p| p.study.view_slant = SlantForm::Printed);
    let all = [PassId::SKIN, PassId::FINS, PassId::SHELLS];
    let pictures = [
        truth(&opened, &camera, size)?,
        coverage(draw, package, &sheets, size, &all)?,
        coverage(draw, package, &without, size, &all)?,
        coverage(draw, package, &with, size, &all)?,
        coverage(draw, package, &with, size, &all[..2])?,
    ];
    let bare = with.with(|p| p.style = Style::Bare);
    let skin = coverage(draw, package, &bare, size, &all[..1])?;
    let distances = distances(&skin);
    let off = |k: usize| error(&pictures[k], &pictures[0], &distances, REACH, WINDOW);
    Ok(SilhouetteMeasures {
        sheets: off(1),
        ours: off(3),
        profiles: pictures.each_ref().map(|picture| profile(picture, &distances, BANDS)),
    })
}

/// Vertical field of view, radians.
const FOV_Y_RAD: f32 = 0.6;

/// Returns the coverage of the true strands.
fn truth(package: &Package<'_>, camera: &Camera, size: (u32, u32)) -> Result<Coverage, BakeError> {
    let manifest = package.manifest();
    let skin = PosedMesh::posed("silhouette", package, &[])?;
    let hair = tile_hair("silhouette", manifest)?;
    let curves = match &hair {
        Some(hair) => grow_on(&skin, hair, f64::from(manifest.fur.tile_size_m))?.0,
        None => Curves::default(),
    };
    let scene = TrueScene::new(curves, skin, hair.as_ref(), manifest.shading)?;
    let camera = TrueCamera::from_view(camera.view_from_world, Lens::Perspective { fov_y_rad: FOV_Y_RAD });
    // Only coverage is needed, so lighting casts no rays.
    let lighting = TrueLighting {
        key: TrueLight::Directional { towards_light_ws: Vec3::Y, color: Vec3::ONE },
        penumbra: 0.0,
        fill: Vec::new(),
        ambient_attenuation: false,
        back_attenuation: false,
        hair_shadows: false,
        fill_shadows: false,
        skin_shadows: false,
        rolled_off: false,
        scattering: None,
        sky: None,
    };
    let traced = scene.picture(&camera, &lighting, size, TRUE_SAMPLES, &mut |_, _| ());
    Ok(Coverage { size, alpha: traced.pixels.iter().map(|p| f64::from(p[3])).collect() })
}

/// Returns the mean absolute difference of two profiles within `REACH`.
pub fn profile_error(a: &[f64], b: &[f64]) -> f64 {
    let bands = REACH as usize;
    a.iter().zip(b).take(bands).map(|(a, b)| (a - b).abs()).sum::<f64>() / bands as f64
}
