//! Topic `self-shadow`: accuracy and cost of baked visibility and of layer-wise shadow maps, for light that passes
//! through hair.
//!
//! The recipe's hair grows on a flat sheet, so that the frame of every tile is known and only hair occludes. The middle
//! tile is evaluated. The sheet around it is large enough for the slanted rays that end on that tile. The maps are the
//! runtime's own, rendered by the adapter and read back. Visibility is decoded from a package of the sheet. The truths
//! are [`SampledVolume`] and [`StrandField`].

use super::errors::Errors;
use super::hair_texels::{HairTexel, hair_texels};
use super::light_maps::LightMaps;
use super::self_shadow_forms::SelfShadowForm;
use super::{Cell, Panel};
use crate::truth::{SampledVolume, StrandField};
use glam::{DVec3, Vec2, Vec3, Vec4, vec2, vec3};
use pelage_bake::pipeline::{BakeInput, Outputs, STEPS};
use pelage_bake::recipe::{
    BcQuality, DirectionFormat, FinParams, PackParams, Recipe, ShellFormat, SurfaceParams, SurfaceSource,
};
use pelage_bake::stages::groom::{Lengths, MapImages};
use pelage_bake::stages::simulate::{Strands, VolumeParams, simulate_recipe};
use pelage_bake::stages::slice::{ShellSet, collect_layers, decode_texture};
use pelage_formats::meaning::layer_height;
use pelage_formats::{FormatError, Limits, Package, TextureFormat};
use pelage_import::BakeError;
use pelage_import::mesh::{Material, Mesh, MeshPart, Model};
use pelage_runtime::shared::layer_shadow::{layer_transmittance, slanted_path};
use pelage_runtime::shared::visibility::visibility_towards;
use pelage_runtime::{ShadowParams, SlantForm};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::time::Instant;

/// Angles between the light and the surface normal, degrees.
pub const ANGLES_DEG: [u32; 5] = [0, 30, 45, 60, 75];
/// Azimuths of the light, degrees from +u. Hair leans, so the light's azimuth relative to the lean matters.
const AZIMUTHS_DEG: [f64; 3] = [20.0, 140.0, 260.0];
/// Number of texels evaluated under each light, chosen evenly.
const POINTS: usize = 1 << 18;
/// Number of texels under each light that are compared with the strand truth, chosen evenly.
const STRAND_POINTS: usize = 6000;
/// Number of samples of texels that contain hair.
const HAIR_DRAWS: u32 = 6000;
/// Number of rays per texel for the strand truth.
const RAYS: u32 = 25;
/// Maximum number of texels of all layers, which are held in memory.
const MOST_TEXELS: u64 = 1 << 26;

/// Columns of the chart.
///
/// * `form`: `baked` for visibility. For maps, the formula for the fraction of light that a layer absorbs: `corrected`,
///   or `printed` as published. The columns after it are the settings of the form.
/// * `rmse`, `mean_error`, `off_by_0.1`: errors of the transmittance t against [`SampledVolume`], in texels of all
///   layers, with hair and without. Maps approximate this volume; baked visibility does not, because it is computed
///   from strands.
/// * `strands_`: the same errors against [`StrandField::transmittance`] in the same texels, which is the light in the
///   space between hairs. A ray that starts within a hair is blocked by it, as by any other hair.
/// * `hair_`: errors against [`StrandField::lights_strand`], only in texels with hair. Texels are weighted by the
///   amount of their hair, whether it is visible from outside or not. This is the light that reaches a hair past all
///   other strands. It is the light used for shading hair; baked visibility and the traced picture contain it.
/// * `milliseconds`: time to render all maps; 0 if baked. `timing`: clock used.
/// * `bytes`: size of all maps. For baked visibility, size of the texture of dry hair on a GPU that samples its format,
///   including mip levels and the far layer.
/// * `visibility_seconds`: duration of the bake stage `visibility` for one tile, without encoding; the faster of two
///   runs.
/// * `map_texels_per_hair_texel`: see [`Sheet::map_texels_per_hair_texel`]. `map_size_on_model`: [`Sheet::map_size_on`]
///   the model.
/// * `_0` to `_75`: errors only under lights at that angle to the normal, degrees.
/// * `volume_over_strands_rmse`, `volume_over_hair_rmse`: error that remains with perfect maps.
/// * `bc7_over_rgba8_rmse`: difference between t from BC7 blocks and t from uncompressed texels of the same visibility,
///   in the texels of `hair_`.
pub const COLUMNS: [&str; 40] = [
    "form",
    "pack.shell_format",
    "pack.bc_quality",
    "visibility.directions",
    "density",
    "map_size",
    "map_layers",
    "rmse",
    "mean_error",
    "off_by_0.1",
    "strands_rmse",
    "strands_mean_error",
    "strands_off_by_0.1",
    "hair_rmse",
    "hair_mean_error",
    "hair_off_by_0.1",
    "milliseconds",
    "timing",
    "bytes",
    "visibility_seconds",
    "map_texels_per_hair_texel",
    "map_size_on_model",
    "rmse_0",
    "rmse_30",
    "rmse_45",
    "rmse_60",
    "rmse_75",
    "strands_rmse_0",
    "strands_rmse_30",
    "strands_rmse_45",
    "strands_rmse_60",
    "strands_rmse_75",
    "hair_rmse_0",
    "hair_rmse_30",
    "hair_rmse_45",
    "hair_rmse_60",
    "hair_rmse_75",
    "volume_over_strands_rmse",
    "volume_over_hair_rmse",
    "bc7_over_rgba8_rmse",
];

/// Panels of the chart.
pub const PANELS: [Panel; 4] = [
    Panel {
        cost: "milliseconds",
        cost_label: "drawing all maps, milliseconds",
        error: "hair_rmse",
        error_label: "RMSE of t on hair against rays past other strands",
        only: None,
    },
    Panel {
        cost: "milliseconds",
        cost_label: "drawing all maps, milliseconds",
        error: "rmse",
        error_label: "RMSE of t against the sampled volume",
        only: None,
    },
    Panel {
        cost: "bytes",
        cost_label: "maps or visibility texture, bytes",
        error: "hair_rmse",
        error_label: "RMSE of t on hair against rays past other strands",
        only: None,
    },
    Panel {
        cost: "visibility_seconds",
        cost_label: "baking visibility, seconds",
        error: "hair_rmse",
        error_label: "RMSE of t on hair against rays past other strands",
        only: None,
    },
];

/// Direction towards a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slant {
    /// Index into [`ANGLES_DEG`].
    pub angle: usize,
    /// Unit vector towards the light in the tile's frame.
    pub light_ts: DVec3,
}

/// Returns all directions: each angle at each azimuth.
pub fn slants() -> Vec<Slant> {
    let towards = |angle: usize, azimuth: f64| {
        let (a, b) = (f64::from(ANGLES_DEG[angle]).to_radians(), azimuth.to_radians());
        Slant { angle, light_ts: DVec3::new(a.sin() * b.cos(), a.sin() * b.sin(), a.cos()) }
    };
    (0..ANGLES_DEG.len()).flat_map(|angle| AZIMUTHS_DEG.map(|azimuth| towards(angle, azimuth))).collect()
}

/// Flat sheet with hair.
pub struct Sheet {
    /// Package of the baked sheet.
    pub package: Vec<u8>,
    /// Number of layers, layer 0 included.
    pub layers: u32,
    recipe: Recipe,
    lengths: Lengths,
    set: ShellSet,
    volume: SampledVolume,
    field: StrandField,
    hair: BTreeMap<usize, HairTexel>,
    /// Corner of the evaluated tile in world space.
    corner: Vec3,
    /// Vectors along the tile's u and v in world space.
    along: [Vec3; 2],
    /// Vector from the mesh surface to the outermost layer, in world space.
    up: Vec3,
}

impl Sheet {
    /// Grows the hair of `recipe` on a sheet with the given lengths, and bakes the sheet.
    ///
    /// The recipe's settings for where hair grows on its model, and how long it is there, do not apply.
    ///
    /// # Errors
    ///
    /// Same as [`pelage_bake::pipeline::bake`]; also if all layers together have more texels than a chart holds in
    /// memory.
    pub fn new(recipe: &Recipe, lengths: Lengths) -> Result<Self, BakeError> {
        let recipe = sheet_recipe(recipe, lengths);
        let texels = u64::from(recipe.slice.tile_texels).pow(2) * u64::from(recipe.slice.layers);
        if texels > MOST_TEXELS {
            return Err(BakeError::Params {
                what: "slice.tile_texels",
                reason: format!(
                    "all layers together have {texels} texels, expected at most {MOST_TEXELS}: \
                 the chart holds them in memory"
                ),
            });
        }
        let package = bake_sheet(&recipe, lengths)?.0;
        let strands = strands_of(&recipe, lengths)?;
        let format = TextureFormat::from(recipe.pack.direction_format);
        let set = collect_layers(&strands, &recipe.slice, format)?;
        let volume = SampledVolume::new(&set, strands.height.into())?;
        let (corner, along, up) = middle_tile(&package)?;
        let layers = recipe.slice.layers;
        let hair = hair_texels(&strands, recipe.slice.tile_texels, layers, HAIR_DRAWS);
        let field = StrandField::new(&strands)?;
        Ok(Self { package, layers, recipe, lengths, set, volume, field, hair, corner, along, up })
    }

    /// Bakes the sheet with visibility, and reads the visibility from the package as a runtime does. Also returns the
    /// duration of the stage `visibility`, seconds.
    ///
    /// * `blocks`, `directions`: as in [`SelfShadowForm::Baked`]
    ///
    /// # Errors
    ///
    /// Same as [`pelage_bake::pipeline::bake`].
    pub fn visibility(&self, blocks: Option<BcQuality>, directions: u32) -> Result<(TileVisibility, f64), BakeError> {
        let mut recipe = self.recipe.clone();
        (recipe.visibility.enabled, recipe.visibility.directions) = (true, directions);
        if let Some(quality) = blocks {
            (recipe.pack.shell_format, recipe.pack.bc_quality) = (ShellFormat::Bc7, quality);
        }
        let (package, seconds) = bake_sheet(&recipe, self.lengths)?;
        Ok((TileVisibility::read(&package)?, seconds))
    }

    /// Transforms a direction towards the light to world space.
    pub fn to_world(&self, light_ts: DVec3) -> Vec3 {
        let axes = [self.along[0], self.along[1], self.up].map(Vec3::normalize_or_zero);
        axes[0] * light_ts.x as f32 + axes[1] * light_ts.y as f32 + axes[2] * light_ts.z as f32
    }

    /// Returns the width of a hair texel divided by the width of a map texel.
    pub fn map_texels_per_hair_texel(&self, maps: &LightMaps) -> f64 {
        let hair = self.along[0].length() / self.set.texels as f32;
        f64::from(hair * maps.size as f32 / maps.view.extent)
    }

    /// Returns the size of a map that covers a sphere of radius `radius_m` with the same resolution as `maps`, texels.
    pub fn map_size_on(&self, maps: &LightMaps, radius_m: f32) -> f64 {
        f64::from(maps.size as f32 * 2.0 * radius_m / maps.view.extent).round()
    }

    /// Computes all truths under a light.
    pub fn truth(&self, slant: &Slant) -> TransmittanceTruth {
        let texel = 1.0 / f64::from(self.set.texels);
        let place = |i: usize| {
            let (x, y, k) = self.texel(i);
            ((x as f64 + 0.5) * texel, (y as f64 + 0.5) * texel, k as f64 * self.volume.spacing())
        };
        let mut points: Vec<usize> = (0..self.texels()).step_by(stride(self.texels(), POINTS)).collect();
        let even = points.len();
        points.extend(self.hair.keys());
        let through_volume = |i: &usize| {
            let (u, v, z) = place(*i);
            self.volume.transmittance(u, v, z, slant.light_ts)
        };
        let volume = points.par_iter().map(through_volume).collect();
        let some: Vec<usize> = (0..even).step_by(stride(even, STRAND_POINTS)).collect();
        let past_strands = |p: usize| {
            let (u, v, z) = place(points[p]);
            (p, self.field.transmittance(u, v, z, texel, slant.light_ts, RAYS))
        };
        let strands = some.into_par_iter().map(past_strands).collect();
        let on_hair = |(i, texel): (usize, &HairTexel)| {
            let lit = texel.lit(|p| self.field.lights_strand(p.at, p.strand, slant.light_ts));
            (even + i, lit, texel.times)
        };
        let texels: Vec<&HairTexel> = self.hair.values().collect();
        let hair = texels.into_par_iter().enumerate().map(on_hair).collect();
        TransmittanceTruth { points, even, volume, strands, hair }
    }

    /// Returns the transmittance t at the points of a truth as the runtime computes it from maps. In the corrected
    /// form, the map's value is multiplied by the transmittance of half the point's own layer.
    pub fn transmittance_by_maps(
        &self,
        maps: &LightMaps,
        slant: &Slant,
        (shadows, form): (&ShadowParams, SlantForm),
        truth: &TransmittanceTruth,
    ) -> Vec<f64> {
        let n = self.set.texels as usize;
        let last_map_layer = (maps.layers.len() - 1) as f32;
        let path = slanted_path(slant.light_ts.z as f32);
        let t = |i: &usize| {
            let (x, y, k) = self.texel(*i);
            let share = layer_height(k as u32, self.layers);
            let [u, v] = [x, y].map(|x| (x as f32 + 0.5) / n as f32);
            let position = self.corner + self.along[0] * u + self.along[1] * v + self.up * share;
            let between = maps.layers.len() != self.layers as usize;
            let t = maps.light_through_hair(maps.project(position), share * last_map_layer, between);
            // Layer 0 has no hair of its own.
            if form == SlantForm::Printed || k == 0 {
                return f64::from(t);
            }
            let alpha = f32::from(self.set.layers[k].color[0][4 * (y * n + x) + 3]) / 255.0;
            f64::from(t * layer_transmittance(alpha, 0.5 * shadows.density * path))
        };
        truth.points.par_iter().map(t).collect()
    }

    /// Returns the transmittance t at the points of a truth as the runtime computes it from baked visibility. The hair
    /// of the sheet is neither flattened nor sheared compared with the tile. The light therefore has the same direction
    /// in the tile as above the mesh surface.
    pub fn transmittance_by_visibility(
        &self,
        visibility: &TileVisibility,
        slant: &Slant,
        truth: &TransmittanceTruth,
    ) -> Vec<f64> {
        let towards = slant.light_ts.as_vec3();
        truth.points.par_iter().map(|i| f64::from(visibility.transmittance_towards(*i, towards))).collect()
    }

    /// Returns the number of texels of all layers.
    fn texels(&self) -> usize {
        self.layers as usize * (self.set.texels as usize).pow(2)
    }

    /// Returns column, row and layer of a texel; the mesh surface is layer 0.
    fn texel(&self, i: usize) -> (usize, usize, usize) {
        let n = self.set.texels as usize;
        (i % n, i / n % n, i / (n * n))
    }
}

/// Returns the step that selects about `wanted` of `count` texels. It is odd, so that the selection does not align with
/// columns.
fn stride(count: usize, wanted: usize) -> usize {
    if count <= wanted { 1 } else { count.div_ceil(wanted) | 1 }
}

/// Visibility of the tile's hair as stored in a package.
#[derive(Clone, Debug, PartialEq)]
pub struct TileVisibility {
    /// Texels of the finest level, layer by layer from the mesh surface outwards, four bytes each.
    texels: Vec<u8>,
    horizon: f32,
    /// Size of the texture with all its levels and layers, in its own format, bytes.
    pub bytes: u64,
}

impl TileVisibility {
    fn read(package: &[u8]) -> Result<Self, BakeError> {
        let package = Package::open(package, &Limits::default()).map_err(fault)?;
        let lost = || BakeError::Internal("the sheet was baked without visibility".into());
        let horizon = package.visibility().map_err(fault)?.ok_or_else(lost)?.horizon;
        let view = package.visibility_textures().map_err(fault)?.ok_or_else(lost)?.dry;
        let layers = (0..view.layers).map(|layer| decode_texture(&view, 0, layer));
        Ok(Self { texels: layers.collect::<Result<Vec<_>, _>>()?.concat(), horizon, bytes: view.gpu_bytes() })
    }

    /// Returns the transmittance t towards a light in the unit direction `light_ts`, at a texel given by its index over
    /// all layers.
    fn transmittance_towards(&self, texel: usize, light_ts: Vec3) -> f32 {
        let bytes = [0, 1, 2, 3].map(|i| f32::from(self.texels[4 * texel + i]));
        visibility_towards(Vec4::from(bytes) / 255.0, light_ts, self.horizon)
    }
}

/// Transmittances of all truths.
#[derive(Clone, Debug, PartialEq)]
pub struct TransmittanceTruth {
    /// Indices of the evaluated texels: first texels of all layers from the mesh surface outwards (all or an even
    /// selection), then the sampled texels with hair.
    points: Vec<usize>,
    /// Number of `points` in the first group, which covers all layers.
    even: usize,
    /// Transmittance through the volume at each point.
    volume: Vec<f64>,
    /// Transmittance past the strands at some points of the first group: index into the points, and value.
    strands: Vec<(usize, f64)>,
    /// Light on the hair past other strands: index into the points, value, and weight (number of samples).
    hair: Vec<(usize, f64, u32)>,
}

impl TransmittanceTruth {
    /// Returns pairs of a measured value and the true transmittance between the strands.
    fn between_strands<'a>(&'a self, found: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
        self.strands.iter().map(|(i, t)| (found[*i], *t))
    }

    /// Returns pairs of a measured value and the true light on the hair, each repeated as often as its texel was
    /// sampled.
    fn on_hair<'a>(&'a self, found: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
        self.hair.iter().flat_map(|(i, t, times)| Self::repeated((found[*i], *t), *times))
    }

    fn repeated(pair: (f64, f64), times: u32) -> impl Iterator<Item = (f64, f64)> {
        std::iter::repeat_n(pair, times as usize)
    }
}

/// Errors of a configuration, summed over all lights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SelfShadowErrors {
    /// Errors by angle, compared with the volume, with the strands, and with the light on the hair.
    by_angle: [[Errors; 3]; ANGLES_DEG.len()],
    /// Errors of the volume, compared with the strands and with the light on the hair.
    volume: [Errors; 2],
    /// Errors of the light on hair, read from block-compressed texels and compared with the same texels uncompressed.
    blocks: Errors,
}

impl SelfShadowErrors {
    /// Adds the values measured at the points of a truth under a light. The volume's optical depth is scaled by the
    /// maps' `density`, so that only the error of the maps remains. The comparison with strands shows whether that
    /// density is right.
    pub fn add(&mut self, slant: &Slant, found: &[f64], density: f32, truth: &TransmittanceTruth) {
        let through: Vec<f64> = truth.volume.iter().map(|t| t.powf(density.into())).collect();
        let even = found.iter().copied().zip(through.iter().copied()).take(truth.even);
        let [volume, strands, hair] = &mut self.by_angle[slant.angle];
        *volume = volume.and(Errors::of(even));
        *strands = strands.and(Errors::of(truth.between_strands(found)));
        *hair = hair.and(Errors::of(truth.on_hair(found)));
        let [strands, hair] = &mut self.volume;
        *strands = strands.and(Errors::of(truth.between_strands(&through)));
        *hair = hair.and(Errors::of(truth.on_hair(&through)));
    }

    /// Adds the error of encoding: values measured at the points of a truth from blocks, compared with uncompressed
    /// texels.
    pub fn add_blocks(&mut self, found: &[f64], plain: &[f64], truth: &TransmittanceTruth) {
        let pairs =
            truth.hair.iter().flat_map(|(i, _, times)| TransmittanceTruth::repeated((found[*i], plain[*i]), *times));
        self.blocks = self.blocks.and(Errors::of(pairs));
    }

    fn total(&self, truth: usize) -> Errors {
        self.by_angle.iter().map(|errors| errors[truth]).fold(Errors::default(), Errors::and)
    }
}

/// Cost of a configuration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Milliseconds to render all maps once; 0 without maps.
    pub milliseconds: f64,
    /// Size of the maps or of the visibility texture, bytes.
    pub bytes: u64,
    /// Values that only maps have.
    pub maps: Option<MapCost>,
    /// Seconds to bake visibility; `None` for maps.
    pub visibility_seconds: Option<f64>,
}

/// Costs that only maps have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MapCost {
    /// Source of the milliseconds.
    pub timing: &'static str,
    /// Result of [`Sheet::map_texels_per_hair_texel`].
    pub texels_per_hair_texel: f64,
    /// Result of [`Sheet::map_size_on`] the model that the hair belongs to.
    pub map_size_on_model: f64,
}

/// Returns the cells of a row, in the order of [`COLUMNS`]. `layers` counts the hair's layers, layer 0 included.
pub fn cells(form: &SelfShadowForm, layers: u32, measured: &SelfShadowErrors, cost: &Cost) -> Vec<Cell> {
    let number = |x: Option<f64>| x.map_or(Cell::Empty, Cell::Number);
    let mut cells = form.cells(layers).to_vec();
    let totals = [0, 1, 2].map(|truth| measured.total(truth));
    cells.extend(totals.iter().flat_map(|e| [number(e.rmse()), number(e.mean()), number(e.large_error_fraction())]));
    cells.extend([
        Cell::Number(cost.milliseconds),
        cost.maps.map_or(Cell::Empty, |maps| Cell::Text(maps.timing.into())),
        Cell::Number(cost.bytes as f64),
        number(cost.visibility_seconds),
        number(cost.maps.map(|maps| maps.texels_per_hair_texel)),
        number(cost.maps.map(|maps| maps.map_size_on_model)),
    ]);
    for truth in 0..3 {
        cells.extend(measured.by_angle.iter().map(|errors| number(errors[truth].rmse())));
    }
    cells.extend(measured.volume.iter().chain([&measured.blocks]).map(|errors| number(errors.rmse())));
    cells
}

/// Returns a recipe with only the hair of `recipe`, in formats that every adapter reads unchanged.
fn sheet_recipe(recipe: &Recipe, lengths: Lengths) -> Recipe {
    let mut sheet = Recipe {
        hair: recipe.hair.clone(),
        underfur: recipe.underfur.clone(),
        visibility: recipe.visibility.clone(),
        color: recipe.color.clone(),
        shading: recipe.shading.clone(),
        slice: recipe.slice.clone(),
        ..Recipe::default()
    };
    sheet.color.pattern = None;
    sheet.hair.length_m = Some(lengths.length_m);
    sheet.surface = SurfaceParams {
        source: SurfaceSource::Model,
        tile_size_m: Some(lengths.tile_size_m),
        ..SurfaceParams::default()
    };
    sheet.fins = FinParams { enabled: false, ..FinParams::default() };
    sheet.pack = PackParams {
        shell_format: ShellFormat::Rgba8,
        direction_format: DirectionFormat::Rg8,
        ..PackParams::default()
    };
    sheet
}

/// Bakes a sheet with the hair of `recipe`, one step after another. Returns the package, and the duration of the stage
/// `visibility`, seconds.
fn bake_sheet(recipe: &Recipe, lengths: Lengths) -> Result<(Vec<u8>, f64), BakeError> {
    let height = f64::from(lengths.length_m / lengths.tile_size_m);
    let steepest = f64::from(ANGLES_DEG[ANGLES_DEG.len() - 1]).to_radians().tan();
    // The sheet consists of the middle tile and a margin on each side. The margin is as wide as the reach of the rays
    // that end on the tile. A larger sheet would only make the maps coarser.
    let tiles = (1.0 + 2.0 * 1.03 * height * steepest) as f32;
    let model = sheet_model(tiles * lengths.tile_size_m, tiles);
    let images = MapImages::default();
    let input = BakeInput::new("sheet", "sheet", recipe, &images);
    let mut outputs = Outputs::of_model(&model);
    let mut seconds = 0.0;
    for step in STEPS {
        let begun = Instant::now();
        step.run(&input, &outputs)?;
        if step.stage == "visibility" {
            seconds += begun.elapsed().as_secs_f64();
        }
    }
    let package = outputs.package.take().map(|package| package.bytes);
    Ok((package.ok_or_else(|| BakeError::Internal("the steps ended without a package".into()))?, seconds))
}

/// Returns an upward-facing square in the plane y = 0. Its texture coordinates are in units of tiles, and one tile is
/// in the middle.
fn sheet_model(width_m: f32, tiles: f32) -> Model {
    let corners = [vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(1.0, 1.0), vec2(0.0, 1.0)];
    let mesh = Mesh {
        positions: corners.map(|c| vec3(c.x - 0.5, 0.0, 0.5 - c.y) * width_m).to_vec(),
        normals: vec![Vec3::Y; 4],
        uvs: corners.map(|c: Vec2| 0.5 + (c - 0.5) * tiles).to_vec(),
        colors: vec![[255; 4]; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        parts: vec![MeshPart {
            source: "sheet".into(),
            names: Vec::new(),
            material: 0,
            first_triangle: 0,
            triangle_count: 2,
            has_uvs: true,
        }],
        ..Mesh::default()
    };
    Model { mesh, materials: vec![Material { name: "Sheet".into(), ..Material::default() }], ..Model::default() }
}

/// Returns the strands that the bake of the sheet grows.
fn strands_of(recipe: &Recipe, lengths: Lengths) -> Result<Strands, BakeError> {
    let volume = VolumeParams { height: lengths.length_m / lengths.tile_size_m };
    simulate_recipe(recipe, &volume)
}

/// Wraps an error in the sheet's package as a bake error.
fn fault(source: FormatError) -> BakeError {
    BakeError::Package { file: "sheet".into(), source }
}

/// Returns the geometry of the tile in the middle of the sheet: its corner at u = v = 0, the vectors along u and v, and
/// the fur's height along the normal.
fn middle_tile(bytes: &[u8]) -> Result<(Vec3, [Vec3; 2], Vec3), BakeError> {
    let package = Package::open(bytes, &Limits::default()).map_err(fault)?;
    let lost = || BakeError::Internal("the sheet was baked without a mesh".into());
    let mesh = package.mesh().map_err(fault)?.ok_or_else(lost)?.to_data();
    let vertex = |i: usize| {
        let index = mesh.indices[i] as usize;
        let (geometry, attributes) = (mesh.geometry[index], mesh.attributes[index]);
        (Vec3::from(geometry.position), Vec2::from(attributes.tile_uv), geometry)
    };
    let [(a, ta, geometry), (b, tb, _), (c, tc, _)] = [0, 1, 2].map(vertex);
    // Position is linear in the tile coordinates; solves for its derivatives along u and v.
    let (db, dc) = (tb - ta, tc - ta);
    let det = db.perp_dot(dc);
    if det == 0.0 {
        return Err(BakeError::Internal("a triangle of the sheet has no area in the tile's coordinates".into()));
    }
    let along = [((b - a) * dc.y - (c - a) * db.y) / det, ((c - a) * db.x - (b - a) * dc.x) / det];
    let bounds = mesh.attributes.iter().map(|v| Vec2::from(v.tile_uv)).fold(None, |bounds: Option<(Vec2, Vec2)>, p| {
        bounds.map_or(Some((p, p)), |(low, high)| Some((low.min(p), high.max(p))))
    });
    let (low, high) = bounds.ok_or_else(lost)?;
    let tile = (0.5 * (low + high) - 0.5).round();
    let corner = a + along[0] * (tile.x - ta.x) + along[1] * (tile.y - ta.y);
    let normal = Vec3::from(geometry.normal).normalize_or(Vec3::Y);
    Ok((corner, along, normal * geometry.fur_height))
}

#[cfg(test)]
#[path = "self_shadow_tests.rs"]
mod tests;
