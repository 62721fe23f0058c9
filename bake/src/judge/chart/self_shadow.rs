//! Topic `self-shadow`: how well layer-wise shadow maps know what light the hair lets through, and what the maps cost.
//!
//! The recipe's hair grows on a flat sheet, so that the frame of every tile is known and nothing but hair stands in the light; the tile in its
//! middle is judged, and about it lies as much sheet as the slanted rays that end on it need. The maps are the runtime's own, drawn by the adapter and
//! read back; the truths are [`SampledVolume`] and [`StrandField`].

use super::errors::Errors;
use super::light_maps::LightMaps;
use super::{Cell, Panel};
use crate::BakeError;
use crate::judge::truth::{SampledVolume, StrandField};
use crate::mesh::{Material, Mesh, MeshPart, Model};
use crate::pipeline::{self, Told};
use crate::recipe::{DirectionFormat, FinParams, PackParams, Recipe, ShellFormat, SurfaceParams, SurfaceSource};
use crate::stages::groom::{Lengths, MapImages};
use crate::stages::hair::{Strands, VolumeParams, simulate};
use crate::stages::textures::{ShellSet, collect_layers};
use glam::{DVec3, Vec2, Vec3, vec2, vec3};
use pelage_formats::meaning::layer_height;
use pelage_formats::{Limits, Package, TextureFormat};
use pelage_runtime::shared::layer_shadow::{layer_transmittance, slanted_path};
use pelage_runtime::{ShadowParams, SlantForm};
use rayon::prelude::*;

/// Angles between the light and the skin's normal, degrees.
pub const ANGLES_DEG: [u32; 5] = [0, 30, 45, 60, 75];
/// Directions about the normal that the light is slanted towards, degrees from +u: hair leans, and with it and against it are not the same.
const AZIMUTHS_DEG: [f64; 3] = [20.0, 140.0, 260.0];
/// Texels that are judged under each light, and those of them that the strand truth is taken at; all others are skipped evenly.
const POINTS: usize = 1 << 18;
const STRAND_POINTS: usize = 6000;
/// Rays of the strand truth from a texel.
const RAYS: u32 = 25;
/// Texels of all layers that are held in memory.
const MOST_TEXELS: u64 = 1 << 26;

/// A way to make the maps.
#[derive(Clone, Debug, PartialEq)]
pub struct Configuration {
    /// What is varied.
    pub series: &'static str,
    /// Its value, short.
    pub label: String,
    /// Settings of the runtime.
    pub shadows: ShadowParams,
    /// How much of the light a layer takes.
    pub slant: SlantForm,
}

impl Configuration {
    /// Whether it is what the runtime does.
    pub fn is_default(&self) -> bool {
        self.shadows == ShadowParams::default() && self.slant == SlantForm::default()
    }
}

/// Columns of the chart.
pub const COLUMNS: [&str; 25] = [
    "form",
    "density",
    "map_size",
    "map_layers",
    "rmse",
    "mean_error",
    "off_by_0.1",
    "strands_rmse",
    "strands_mean_error",
    "strands_off_by_0.1",
    "milliseconds",
    "timing",
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
    "volume_over_strands_rmse",
];

/// Panels of the chart.
pub const PANELS: [Panel; 2] = [
    Panel {
        cost: "milliseconds",
        cost_label: "making all maps, milliseconds",
        error: "rmse",
        error_label: "RMSE of t against the sampled volume, 0 to 75 degrees",
    },
    Panel {
        cost: "milliseconds",
        cost_label: "making all maps, milliseconds",
        error: "strands_rmse",
        error_label: "RMSE of t against rays past the strands, 0 to 75 degrees",
    },
];

/// What to measure for fur of so many layers, the runtime's default first.
pub fn configurations(layers: u32) -> Vec<Configuration> {
    let base = ShadowParams::default();
    // The paper's maps have what the layers have.
    let ours = SlantForm::Corrected;
    let mut out =
        vec![Configuration { series: "as the runtime does", label: String::new(), shadows: base, slant: ours }];
    let mut add = |series, label: String, slant, shadows: ShadowParams| {
        if !out.iter().any(|c: &Configuration| (c.shadows, c.slant) == (shadows, slant)) {
            out.push(Configuration { series, label, shadows, slant });
        }
    };
    for map_size in [64, 128, 256, 512, 1024] {
        add("map size", format!("{map_size}²"), ours, base.with(|s| s.map_size = map_size));
    }
    for map_size in [64, 128, 256, 512, 1024] {
        let printed = base.with(|s| (s.map_size, s.density) = (map_size, 1.0));
        add("map size, as printed", format!("{map_size}²"), SlantForm::Printed, printed);
    }
    for density in [0.4, 0.7, 1.4, 2.0] {
        add("density", density.to_string(), ours, base.with(|s| s.density = density));
    }
    for part in [0.125, 0.25, 0.5, 0.75] {
        let map_layers = Some(((layers - 1) as f32 * part).round() as u32 + 1).filter(|n| (2..layers).contains(n));
        if let Some(n) = map_layers {
            add("fewer map layers", n.to_string(), ours, base.with(|s| s.map_layers = map_layers));
            add(
                "smaller maps, fewer layers",
                format!("256² × {n}"),
                ours,
                base.with(|s| (s.map_layers, s.map_size) = (map_layers, 256)),
            );
        }
    }
    out
}

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
    set: ShellSet,
    volume: SampledVolume,
    field: StrandField,
    /// World position of the judged tile's corner, the ways along its u and v, and from the skin to the outermost layer.
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
        let height = f64::from(lengths.length_m / lengths.tile_size_m);
        let steepest = f64::from(ANGLES_DEG[ANGLES_DEG.len() - 1]).to_radians().tan();
        // The middle tile, and on each side as much as the rays run over that end on it. More would only make the maps coarser.
        let tiles = (1.0 + 2.0 * 1.03 * height * steepest) as f32;
        let model = sheet_model(tiles * lengths.tile_size_m, tiles);
        let baked = pipeline::bake(&Told::new("sheet", "sheet", &recipe, &MapImages::default()), &model, &mut |_| ())?;
        let strands = strands_of(&recipe, lengths)?;
        let format = TextureFormat::from(recipe.pack.direction_format);
        let set = collect_layers(&strands, &recipe.slice, format)?;
        let volume = SampledVolume::new(&set, strands.height.into())?;
        let (corner, along, up) = middle_tile(&baked.package)?;
        let layers = recipe.slice.layers;
        Ok(Self { package: baked.package, layers, set, volume, field: StrandField::new(&strands)?, corner, along, up })
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
        let points: Vec<usize> = (0..self.texels()).step_by(stride(self.texels(), POINTS)).collect();
        let through_volume = |i: &usize| {
            let (u, v, z) = place(*i);
            self.volume.transmittance(u, v, z, slant.light_ts)
        };
        let volume = points.par_iter().map(through_volume).collect();
        let some: Vec<usize> = (0..points.len()).step_by(stride(points.len(), STRAND_POINTS)).collect();
        let past_strands = |p: usize| {
            let (u, v, z) = place(points[p]);
            (p, self.field.transmittance(u, v, z, texel, slant.light_ts, RAYS))
        };
        let strands = some.into_par_iter().map(past_strands).collect();
        Truth { points, volume, strands }
    }

    /// t at the points of a truth as the runtime has it: the map, and of the corrected form half of the own layer.
    pub fn fast(
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

/// Transmittances of both truths.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// The judged texels: all of them, layer after layer from the skin, or evenly some.
    points: Vec<usize>,
    /// Through the volume, at each.
    volume: Vec<f64>,
    /// Past the strands, at some: index into the points, and value.
    strands: Vec<(usize, f64)>,
}

/// Errors of a configuration, light by light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// Against the volume, and against the strands, by angle.
    by_angle: [[Errors; 2]; ANGLES_DEG.len()],
    /// Of the volume against the strands.
    volume: Errors,
}

impl Measured {
    /// Adds what was found under a light. The volume is met at the same `density` as the maps: what is left is the error of the maps;
    /// whether that density is right, the strands tell.
    pub fn add(&mut self, slant: &Slant, fast: &[f64], density: f32, truth: &Truth) {
        let through: Vec<f64> = truth.volume.iter().map(|t| t.powf(density.into())).collect();
        let [volume, strands] = &mut self.by_angle[slant.angle];
        *volume = volume.and(Errors::of(fast.iter().copied().zip(through.iter().copied())));
        *strands = strands.and(Errors::of(truth.strands.iter().map(|(i, t)| (fast[*i], *t))));
        self.volume = self.volume.and(Errors::of(truth.strands.iter().map(|(i, t)| (through[*i], *t))));
    }

    fn total(&self, truth: usize) -> Errors {
        self.by_angle.iter().map(|errors| errors[truth]).fold(Errors::default(), Errors::and)
    }
}

/// What drawing the maps of a configuration took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// All maps, once.
    pub milliseconds: f64,
    /// Where the milliseconds come from.
    pub timing: &'static str,
    /// [`Sheet::map_texels_per_hair_texel`].
    pub texels_per_hair_texel: f64,
    /// [`Sheet::map_size_on`] the model that the hair is of.
    pub map_size_on_model: f64,
}

/// The cells of a row, in the order of [`COLUMNS`].
pub fn cells((shadows, form): (&ShadowParams, SlantForm), layers: u32, measured: &Measured, cost: &Cost) -> Vec<Cell> {
    let number = |x: Option<f64>| x.map_or(Cell::Empty, Cell::Number);
    let form = if form == SlantForm::Printed { "printed" } else { "corrected" };
    let totals = [measured.total(0), measured.total(1)];
    let mut cells = vec![
        Cell::Text(form.into()),
        Cell::Number(shadows.density.into()),
        Cell::Number(shadows.map_size.into()),
        Cell::Number(shadows.map_layers.unwrap_or(layers).into()),
    ];
    cells.extend(totals.iter().flat_map(|e| [number(e.rmse()), number(e.mean()), number(e.off_share())]));
    cells.extend([Cell::Number(cost.milliseconds), Cell::Text(cost.timing.into())]);
    cells.extend([cost.texels_per_hair_texel, cost.map_size_on_model].map(Cell::Number));
    for truth in 0..2 {
        cells.extend(measured.by_angle.iter().map(|errors| number(errors[truth].rmse())));
    }
    cells.push(number(measured.volume.rmse()));
    cells
}

/// The recipe's hair alone, in formats that every adapter reads as they are.
fn sheet_recipe(recipe: &Recipe, lengths: Lengths) -> Recipe {
    let mut sheet = Recipe {
        hair: recipe.hair.clone(),
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

/// A square in the plane y = 0 that looks up, with texture coordinates that count tiles; one of them lies in its middle.
fn sheet_model(width_m: f32, tiles: f32) -> Model {
    let corners = [vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(1.0, 1.0), vec2(0.0, 1.0)];
    let mesh = Mesh {
        positions: corners.map(|c| vec3(c.x - 0.5, 0.0, 0.5 - c.y) * width_m).to_vec(),
        normals: vec![Vec3::Y; 4],
        uvs: corners.map(|c: Vec2| 0.5 + (c - 0.5) * tiles).to_vec(),
        colors: vec![[255; 4]; 4],
        skin: Vec::new(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        parts: vec![MeshPart {
            source: "sheet".into(),
            material: 0,
            first_triangle: 0,
            triangle_count: 2,
            has_uvs: true,
        }],
    };
    Model { mesh, materials: vec![Material { name: "Sheet".into(), ..Material::default() }], ..Model::default() }
}

/// The strands that a bake of the sheet grows.
fn strands_of(recipe: &Recipe, lengths: Lengths) -> Result<Strands, BakeError> {
    let volume = VolumeParams { height: lengths.length_m / lengths.tile_size_m };
    simulate(&recipe.hair, &recipe.color, &volume)
}

/// Where the package has the tile in the middle of the sheet: its corner at u = v = 0, the ways along u and v, and the fur's height.
fn middle_tile(bytes: &[u8]) -> Result<(Vec3, [Vec3; 2], Vec3), BakeError> {
    let fault = |source| BakeError::Package { file: "sheet".into(), source };
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
