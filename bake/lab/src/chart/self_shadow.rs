//! Topic `self-shadow`: how well baked visibility and layer-wise shadow maps know what light the hair lets through, and
//! what they cost.
//!
//! The recipe's hair grows on a flat sheet, so that the frame of every tile is known and nothing but hair stands in the
//! light; the tile in its middle is judged, and about it lies as much sheet as the slanted rays that end on it need.
//! The maps are the runtime's own, drawn by the adapter and read back; visibility is that of a package of the sheet,
//! decoded. The truths are [`SampledVolume`] and [`StrandField`].

use super::errors::Errors;
use super::hair_texels::{HairTexel, hair_texels};
use super::light_maps::LightMaps;
use super::self_shadow_forms::Form;
use super::{Cell, Panel};
use crate::truth::{SampledVolume, StrandField};
use glam::{DVec3, Vec2, Vec3, Vec4, vec2, vec3};
use pelage_bake::pipeline;
use pelage_bake::pipeline::Told;
use pelage_bake::recipe::{
    BcQuality, DirectionFormat, FinParams, PackParams, Recipe, ShellFormat, SurfaceParams, SurfaceSource,
};
use pelage_bake::stages::groom::{Lengths, MapImages};
use pelage_bake::stages::hair::{Strands, VolumeParams, simulate_recipe};
use pelage_bake::stages::textures::{ShellSet, collect_layers, decode_texture};
use pelage_formats::meaning::layer_height;
use pelage_formats::{FormatError, Limits, Package, TextureFormat};
use pelage_import::BakeError;
use pelage_import::mesh::{Material, Mesh, MeshPart, Model};
use pelage_runtime::shared::layer_shadow::{layer_transmittance, slanted_path};
use pelage_runtime::shared::visibility::visibility_towards;
use pelage_runtime::{ShadowParams, SlantForm};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Angles between the light and the skin's normal, degrees.
pub const ANGLES_DEG: [u32; 5] = [0, 30, 45, 60, 75];
/// Directions about the normal that the light is slanted towards, degrees from +u: hair leans, and with it and against
/// it are not the same.
const AZIMUTHS_DEG: [f64; 3] = [20.0, 140.0, 260.0];
/// Texels that are judged under each light, and those of them that the strand truth is taken at; all others are skipped
/// evenly.
const POINTS: usize = 1 << 18;
const STRAND_POINTS: usize = 6000;
/// Draws of texels with hair.
const HAIR_DRAWS: u32 = 6000;
/// Rays of the strand truth from a texel.
const RAYS: u32 = 25;
/// Texels of all layers that are held in memory.
const MOST_TEXELS: u64 = 1 << 26;

/// Columns of the chart.
///
/// * `form`: `baked`, or of maps the share of light that a layer takes, `corrected` or `printed`; then the settings of
///   either.
/// * `rmse`, `mean_error`, `off_by_0.1`: t against [`SampledVolume`] in texels of all layers, with hair and without.
///   Maps approximate it, and visibility that is baked does not: it knows strands.
/// * `strands_`: the same against [`StrandField::transmittance`] in the same texels, which is the light in the space
///   between hairs. A ray that starts within a hair is blocked, by the hair that is to be lit as by any other.
/// * `hair_`: against [`StrandField::lights_strand`] in texels with hair alone, drawn as often as they hold hair, seen
///   from outside or not: the light that reaches the hair itself past all other strands. It is what hair is shaded
///   with, what baked visibility means, and what the traced picture has.
/// * `milliseconds`: drawing all maps; 0 of what is baked. `timing` says by which clock.
/// * `bytes`: of all maps, or of the visibility texture of dry hair with its mip levels and its layer for the coat, on
///   a GPU that samples its format.
/// * `visibility_seconds`: the stage `visibility` of the bake of one tile, without encoding; the faster of two runs.
/// * `map_texels_per_hair_texel`, `map_size_on_model`: [`Sheet::map_texels_per_hair_texel`] and [`Sheet::map_size_on`]
///   the model.
/// * `_0` to `_75`: of light at that angle to the normal alone, degrees.
/// * `volume_over_strands_rmse`, `volume_over_hair_rmse`: what is left of an error where maps are perfect.
/// * `bc7_over_rgba8_rmse`: of t from blocks of BC7 against t from plain texels of the same visibility, in the texels
///   of `hair_`.
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
        cost_label: "making all maps, milliseconds",
        error: "hair_rmse",
        error_label: "RMSE of t on hair against rays past other strands",
        only: None,
    },
    Panel {
        cost: "milliseconds",
        cost_label: "making all maps, milliseconds",
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

/// A direction that light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slant {
    /// Index into [`ANGLES_DEG`].
    pub angle: usize,
    /// Towards the light in the frame of the tile, unit length.
    pub light_ts: DVec3,
}

/// All directions: each angle from a few sides.
pub fn slants() -> Vec<Slant> {
    let towards = |angle: usize, azimuth: f64| {
        let (a, b) = (f64::from(ANGLES_DEG[angle]).to_radians(), azimuth.to_radians());
        Slant { angle, light_ts: DVec3::new(a.sin() * b.cos(), a.sin() * b.sin(), a.cos()) }
    };
    (0..ANGLES_DEG.len()).flat_map(|angle| AZIMUTHS_DEG.map(|azimuth| towards(angle, azimuth))).collect()
}

/// Hair on a flat sheet.
pub struct Sheet {
    /// The baked sheet.
    pub package: Vec<u8>,
    /// Layers, skin counted.
    pub layers: u32,
    recipe: Recipe,
    lengths: Lengths,
    set: ShellSet,
    volume: SampledVolume,
    field: StrandField,
    hair: BTreeMap<usize, HairTexel>,
    /// World position of the judged tile's corner, the ways along its u and v, and from the skin to the outermost
    /// layer.
    corner: Vec3,
    along: [Vec3; 2],
    up: Vec3,
}

impl Sheet {
    /// Grows the hair of `recipe`, with lengths as on some model, on a sheet, and bakes that.
    ///
    /// What the recipe says about where and how long hair grows on its model does not apply.
    ///
    /// # Errors
    ///
    /// As [`pipeline::bake`].
    pub fn new(recipe: &Recipe, lengths: Lengths) -> Result<Self, BakeError> {
        let recipe = sheet_recipe(recipe, lengths);
        let texels = u64::from(recipe.slice.tile_texels).pow(2) * u64::from(recipe.slice.layers);
        if texels > MOST_TEXELS {
            return Err(BakeError::Params {
                what: "slice.tile_texels",
                reason: format!(
                    "all layers have {texels} texels, expected at most {MOST_TEXELS} where a chart holds them in memory"
                ),
            });
        }
        let package = bake_sheet(&recipe, lengths, &mut |_| ())?;
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

    /// Bakes the sheet with visibility, and reads from the package what a runtime reads.
    ///
    /// * `blocks`, `directions`: as in [`Form::Baked`]
    /// * `on_stage`: called with the name of each of [`pipeline::STAGES`] as it begins
    ///
    /// # Errors
    ///
    /// As [`pipeline::bake`].
    pub fn visibility(
        &self,
        blocks: Option<BcQuality>,
        directions: u32,
        on_stage: &mut dyn FnMut(&'static str),
    ) -> Result<TileVisibility, BakeError> {
        let mut recipe = self.recipe.clone();
        (recipe.visibility.enabled, recipe.visibility.directions) = (true, directions);
        if let Some(quality) = blocks {
            (recipe.pack.shell_format, recipe.pack.bc_quality) = (ShellFormat::Bc7, quality);
        }
        TileVisibility::read(&bake_sheet(&recipe, self.lengths, on_stage)?)
    }

    /// Towards the light in world space.
    pub fn to_world(&self, light_ts: DVec3) -> Vec3 {
        let axes = [self.along[0], self.along[1], self.up].map(Vec3::normalize_or_zero);
        axes[0] * light_ts.x as f32 + axes[1] * light_ts.y as f32 + axes[2] * light_ts.z as f32
    }

    /// Texels of the maps in the width of a texel of the hair.
    pub fn map_texels_per_hair_texel(&self, maps: &LightMaps) -> f64 {
        let hair = self.along[0].length() / self.set.texels as f32;
        f64::from(hair * maps.size as f32 / maps.view.extent)
    }

    /// Size of the maps that would be as fine if they covered a sphere of that radius, metres.
    pub fn map_size_on(&self, maps: &LightMaps, radius_m: f32) -> f64 {
        f64::from(maps.size as f32 * 2.0 * radius_m / maps.view.extent).round()
    }

    /// The truths at the texels of all layers.
    pub fn truth(&self, slant: &Slant) -> Truth {
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
        Truth { points, even, volume, strands, hair }
    }

    /// t at the points of a truth as the runtime has it of maps: the map, and of the corrected form half of the own
    /// layer.
    pub fn by_maps(
        &self,
        maps: &LightMaps,
        slant: &Slant,
        (shadows, form): (&ShadowParams, SlantForm),
        truth: &Truth,
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
            let t = maps.light_through_hair(maps.place(position), share * last_map_layer, between);
            // The skin has no layer of hair of its own.
            if form == SlantForm::Printed || k == 0 {
                return f64::from(t);
            }
            let alpha = f32::from(self.set.layers[k].color[0][4 * (y * n + x) + 3]) / 255.0;
            f64::from(t * layer_transmittance(alpha, 0.5 * shadows.density * path))
        };
        truth.points.par_iter().map(t).collect()
    }

    /// t at the points of a truth as the runtime has it of baked visibility. The sheet's hair is the tile's, neither
    /// pressed flat nor sheared, so that the light in the tile is that above the skin.
    pub fn by_visibility(&self, visibility: &TileVisibility, slant: &Slant, truth: &Truth) -> Vec<f64> {
        let towards = slant.light_ts.as_vec3();
        truth.points.par_iter().map(|i| f64::from(visibility.towards(*i, towards))).collect()
    }

    /// Texels of all layers.
    fn texels(&self) -> usize {
        self.layers as usize * (self.set.texels as usize).pow(2)
    }

    /// Column, row and layer of a texel, the skin being layer 0.
    fn texel(&self, i: usize) -> (usize, usize, usize) {
        let n = self.set.texels as usize;
        (i % n, i / n % n, i / (n * n))
    }
}

/// The step that takes about `wanted` of `count`. Odd, so that what is taken does not fall into columns.
fn stride(count: usize, wanted: usize) -> usize {
    if count <= wanted { 1 } else { count.div_ceil(wanted) | 1 }
}

/// How much light reaches the hair of the tile, as a package has it.
#[derive(Clone, Debug, PartialEq)]
pub struct TileVisibility {
    /// Texels of the finest level, layer after layer from the skin, four bytes each.
    texels: Vec<u8>,
    horizon: f32,
    /// Of the texture with all its levels and layers, in its own format.
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

    /// t of a light in that direction, of unit length, in a texel by its index over all layers.
    fn towards(&self, texel: usize, light_ts: Vec3) -> f32 {
        let bytes = [0, 1, 2, 3].map(|i| f32::from(self.texels[4 * texel + i]));
        visibility_towards(Vec4::from(bytes) / 255.0, light_ts, self.horizon)
    }
}

/// Transmittances of all truths.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// The judged texels: first all of them, layer after layer from the skin, or evenly some; then those with hair that
    /// are drawn.
    points: Vec<usize>,
    /// How many the first are.
    even: usize,
    /// Through the volume, at each.
    volume: Vec<f64>,
    /// Past the strands, at some of the first: index into the points, and value.
    strands: Vec<(usize, f64)>,
    /// On the hair past other strands: index into the points, value, and how often it counts.
    hair: Vec<(usize, f64, u32)>,
}

impl Truth {
    /// Pairs of what was found at the points and the truth between the strands.
    fn between_strands<'a>(&'a self, found: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
        self.strands.iter().map(|(i, t)| (found[*i], *t))
    }

    /// Pairs of what was found at the points and the truth on the hair.
    fn on_hair<'a>(&'a self, found: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
        self.hair.iter().flat_map(|(i, t, times)| Self::repeated((found[*i], *t), *times))
    }

    fn repeated(pair: (f64, f64), times: u32) -> impl Iterator<Item = (f64, f64)> {
        std::iter::repeat_n(pair, times as usize)
    }
}

/// Errors of a configuration, light by light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// Against the volume, the strands, and the light on the hair, by angle.
    by_angle: [[Errors; 3]; ANGLES_DEG.len()],
    /// Of the volume against the strands, and the light on the hair.
    volume: [Errors; 2],
    /// On the hair, of a form with its texels in blocks against the same in plain texels.
    blocks: Errors,
}

impl Measured {
    /// Adds what was found at the points of a truth under a light. The volume is met at the same `density` as the maps:
    /// what is left is the error of the maps; whether that density is right, the strands tell.
    pub fn add(&mut self, slant: &Slant, found: &[f64], density: f32, truth: &Truth) {
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

    /// Adds what encoding does: what was found at the points of a truth in blocks, and in plain texels.
    pub fn add_blocks(&mut self, found: &[f64], plain: &[f64], truth: &Truth) {
        let pairs = truth.hair.iter().flat_map(|(i, _, times)| Truth::repeated((found[*i], plain[*i]), *times));
        self.blocks = self.blocks.and(Errors::of(pairs));
    }

    fn total(&self, truth: usize) -> Errors {
        self.by_angle.iter().map(|errors| errors[truth]).fold(Errors::default(), Errors::and)
    }
}

/// What a configuration takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Drawing all maps, once; 0 without any.
    pub milliseconds: f64,
    /// Of the maps, or of the visibility texture.
    pub bytes: u64,
    /// What only maps have.
    pub maps: Option<MapCost>,
    /// Baking visibility; `None` of maps.
    pub visibility_seconds: Option<f64>,
}

/// What is to be said of maps alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MapCost {
    /// Where the milliseconds come from.
    pub timing: &'static str,
    /// [`Sheet::map_texels_per_hair_texel`].
    pub texels_per_hair_texel: f64,
    /// [`Sheet::map_size_on`] the model that the hair is of.
    pub map_size_on_model: f64,
}

/// The cells of a row, in the order of [`COLUMNS`]; `layers` of the hair, skin counted.
pub fn cells(form: &Form, layers: u32, measured: &Measured, cost: &Cost) -> Vec<Cell> {
    let number = |x: Option<f64>| x.map_or(Cell::Empty, Cell::Number);
    let mut cells = form.cells(layers).to_vec();
    let totals = [0, 1, 2].map(|truth| measured.total(truth));
    cells.extend(totals.iter().flat_map(|e| [number(e.rmse()), number(e.mean()), number(e.off_share())]));
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

/// The recipe's hair alone, in formats that every adapter reads as they are.
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

/// Bakes a sheet of that hair; `on_stage` as in [`pipeline::bake`].
fn bake_sheet(recipe: &Recipe, lengths: Lengths, on_stage: &mut dyn FnMut(&'static str)) -> Result<Vec<u8>, BakeError> {
    let height = f64::from(lengths.length_m / lengths.tile_size_m);
    let steepest = f64::from(ANGLES_DEG[ANGLES_DEG.len() - 1]).to_radians().tan();
    // The middle tile, and on each side as much as the rays run over that end on it. More would only make the maps
    // coarser.
    let tiles = (1.0 + 2.0 * 1.03 * height * steepest) as f32;
    let model = sheet_model(tiles * lengths.tile_size_m, tiles);
    Ok(pipeline::bake(&Told::new("sheet", "sheet", recipe, &MapImages::default()), &model, on_stage)?.package)
}

/// A square in the plane y = 0 that looks up, with texture coordinates that count tiles; one of them lies in its
/// middle.
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

/// The strands that a bake of the sheet grows.
fn strands_of(recipe: &Recipe, lengths: Lengths) -> Result<Strands, BakeError> {
    let volume = VolumeParams { height: lengths.length_m / lengths.tile_size_m };
    simulate_recipe(recipe, &volume)
}

/// A fault of the sheet's package.
fn fault(source: FormatError) -> BakeError {
    BakeError::Package { file: "sheet".into(), source }
}

/// Where the package has the tile in the middle of the sheet: its corner at u = v = 0, the ways along u and v, and the
/// fur's height.
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
    // Position is linear in the tile's coordinates: solve for its two slopes.
    let (db, dc) = (tb - ta, tc - ta);
    let det = db.perp_dot(dc);
    if det == 0.0 {
        return Err(BakeError::Internal("the sheet has no area in its tile".into()));
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
