//! `pelage chart self-shadow` and `soft-shadow`: the runtime's shadow maps, drawn by the adapter, against the slow truths.

use super::chart::{ChartArgs, Subject, shell_word};
use super::exit::Failure;
use super::gpu::{Gpu, lost, read_texture};
use super::measure::{Clock, Meter, PASSES, Spread};
use super::output::Output;
use super::package_file::PackageFile;
use super::scene::{Scene, View};
use glam::Vec3;
use pelage_bake::chart::light_maps::LightMaps;
use pelage_bake::chart::{Chart, Row, self_shadow, soft_shadow};
use pelage_bake::groom::{self, Lengths};
use pelage_bake::mesh::RestPose;
use pelage_bake::pipeline;
use pelage_bake::recipe::{DirectionFormat, ShellFormat};
use pelage_runtime::{Light, PassId, ShadowMaps, ShadowParams};
use std::time::Instant;

/// A configuration as it is measured: errors so far, and the milliseconds of each drawing of its maps.
struct Trial<C, M> {
    /// Its number in the table, from 1.
    number: usize,
    configuration: C,
    measured: M,
    milliseconds: Vec<f64>,
}

fn trials<C, M: Default>(args: &ChartArgs, configurations: Vec<C>) -> Result<Vec<Trial<C, M>>, Failure> {
    let numbers: Vec<usize> = args.numbers(configurations.len())?.collect();
    let trial =
        |(i, configuration)| Trial { number: i + 1, configuration, measured: M::default(), milliseconds: Vec::new() };
    let chosen = configurations.into_iter().enumerate().map(trial).filter(|trial| numbers.contains(&trial.number));
    Ok(chosen.collect())
}

/// The command that measures one row again, into a folder of its own: the whole table stays.
pub(super) fn command(args: &ChartArgs, subject: &Subject, topic: &str, number: usize) -> String {
    let folder = args.output.clone().unwrap_or_default().join(format!("row-{number}"));
    let folder = shell_word(&folder.display().to_string());
    format!("pelage chart {topic}{} --rows {number} -o {folder} --json", subject.arguments)
}

/// The topic `self-shadow`.
pub fn self_shadow_chart(args: &ChartArgs, subject: &Subject, output: &mut Output) -> Result<Chart, Failure> {
    let bounds = groom::bounds(&RestPose::of(&subject.model.mesh, subject.model.animation.as_ref()));
    let recipe = &subject.recipe;
    let lengths = Lengths::resolve(recipe.hair.length_m, recipe.surface.tile_size_m, &bounds);
    let mut trials = trials::<_, self_shadow::Measured>(args, self_shadow::configurations(recipe.slice.layers))?;
    output.progress("growing a sheet of hair");
    let sheet = self_shadow::Sheet::new(recipe, lengths)?;
    let mut bench = LightBench::new("sheet", &sheet.package)?;
    let mut costs = vec![self_shadow::Cost { timing: bench.clock_word(), ..Default::default() }; trials.len()];
    let slants = self_shadow::slants();
    // Light by light and within each all configurations: what else the machine does falls on all of them alike.
    for (i, slant) in slants.iter().enumerate() {
        output.progress_of(i, slants.len(), "light on a sheet of hair");
        let truth = sheet.truth(slant);
        for (trial, cost) in trials.iter_mut().zip(&mut costs) {
            let shadows = trial.configuration.shadows;
            let (maps, ms) = bench.draw(sheet.to_world(slant.light_ts), shadows, PassId::LayerShadow)?;
            trial.measured.add(slant, &sheet.fast(&maps, slant, &shadows, &truth), shadows.density, &truth);
            trial.milliseconds.push(ms);
            cost.texels_per_hair_texel = sheet.map_texels_per_hair_texel(&maps);
            cost.map_size_on_model = sheet.map_size_on(&maps, bounds.radius + lengths.length_m);
        }
    }
    let row = |(trial, cost): (&Trial<self_shadow::Configuration, _>, &self_shadow::Cost)| {
        let milliseconds = Spread::of(trial.milliseconds.iter().copied()).median;
        let shadows = &trial.configuration.shadows;
        let cost = self_shadow::Cost { milliseconds, ..*cost };
        Row {
            series: trial.configuration.series.into(),
            cells: self_shadow::cells(shadows, sheet.layers, &trial.measured, &cost),
            default: *shadows == ShadowParams::default(),
            command: command(args, subject, "self-shadow", trial.number),
        }
    };
    let layers = sheet.layers;
    Ok(Chart {
        topic: "self-shadow",
        title: format!(
            "Hair of {} on a flat sheet, {layers} layers: light between hairs by layer-wise maps",
            subject.name
        ),
        adapter: bench.adapter(),
        columns: self_shadow::COLUMNS.to_vec(),
        rows: trials.iter().zip(&costs).map(row).collect(),
        panels: self_shadow::PANELS.to_vec(),
    })
}

/// The topic `soft-shadow`.
pub fn soft_shadow_chart(args: &ChartArgs, subject: &Subject, output: &mut Output) -> Result<Chart, Failure> {
    let mut trials = trials::<_, soft_shadow::Measured>(args, soft_shadow::configurations())?;
    output.progress("baking");
    let mut recipe = subject.recipe.clone();
    // Formats that every adapter reads; shadows of the skin do not depend on them.
    recipe.pack.shell_format = ShellFormat::Rgba8;
    recipe.pack.direction_format = DirectionFormat::Rg8;
    let baked = pipeline::bake(&subject.file, &subject.name, &subject.model, &recipe, &subject.images, &mut |_| ())?;
    let skin = soft_shadow::Skin::new(&subject.model)?;
    let mut bench = LightBench::new(&subject.name, &baked.package)?;
    let lights = soft_shadow::lights();
    for (i, light) in lights.iter().enumerate() {
        output.progress_of(i, lights.len(), "light on the skin");
        let mut truths: Vec<(f32, Vec<f64>)> = Vec::new();
        for trial in &mut trials {
            let shadows = soft_shadow::runtime_settings(&trial.configuration);
            let penumbra = shadows.penumbra;
            if truths.iter().all(|(p, _)| *p != penumbra) {
                truths.push((penumbra, skin.truth(*light, penumbra)));
            }
            let Some((_, truth)) = truths.iter().find(|(p, _)| *p == penumbra) else { continue };
            let (maps, ms) = bench.draw(*light, shadows, PassId::ShadowWidth)?;
            let method = trial.configuration.method;
            let iterated = matches!(method, soft_shadow::Method::Iterated(_));
            let start = Instant::now();
            let fast = skin.fast(&maps, *light, method, shadows.shrink);
            // Distances that no pass of the runtime makes are made here, and this is what they cost.
            let ms = if iterated { ms + start.elapsed().as_secs_f64() * 1e3 } else { ms };
            trial.measured.add(&fast, truth);
            trial.milliseconds.push(ms);
        }
    }
    let row = |trial: &Trial<soft_shadow::Configuration, soft_shadow::Measured>| {
        let ms = Spread::of(trial.milliseconds.iter().copied()).median;
        let method = trial.configuration.method;
        let iterated = matches!(method, soft_shadow::Method::Iterated(_));
        let timing = if iterated { format!("{} and CPU", bench.clock_word()) } else { bench.clock_word().into() };
        Row {
            series: trial.configuration.series.into(),
            cells: soft_shadow::cells(&trial.configuration, &trial.measured, ms, &timing),
            default: trial.configuration == soft_shadow::configurations()[0],
            command: command(args, subject, "soft-shadow", trial.number),
        }
    };
    let triangles = subject.model.mesh.triangles.len();
    Ok(Chart {
        topic: "soft-shadow",
        title: format!("{}, {triangles} triangles: soft shadows on its skin against a disc light", subject.name),
        adapter: bench.adapter(),
        columns: soft_shadow::COLUMNS.to_vec(),
        rows: trials.iter().map(row).collect(),
        panels: soft_shadow::PANELS.to_vec(),
    })
}

/// Drawings of the maps under each light, of which the fastest counts; of all lights the median.
const DRAWINGS: usize = 3;

/// A package in the runtime's hands, for the sake of its shadow maps.
struct LightBench {
    scene: Scene,
    meter: Meter,
}

impl LightBench {
    fn new(name: &str, package: &[u8]) -> Result<Self, Failure> {
        let file = PackageFile { name: name.into(), bytes: package.to_vec() };
        let scene = Scene::new(&file, &View { size: (16, 16), ..View::default() }, Gpu::open)?;
        let meter = Meter::new(&scene.gpu);
        Ok(Self { scene, meter })
    }

    fn adapter(&self) -> String {
        let build = if cfg!(debug_assertions) { ", debug build" } else { "" };
        format!("{}{build}", self.scene.gpu.info.name)
    }

    /// Where the milliseconds come from, as `pelage bench` has it.
    fn clock_word(&self) -> &'static str {
        match self.meter.clock() {
            Clock::TimestampQuery => "timestamp-query",
            Clock::SubmitAndWait => "submit-and-wait",
        }
    }

    /// Draws the maps of `pass` and reads them back. The milliseconds are those of the fastest drawing but the first, in which pipelines are
    /// compiled: what else the machine does only adds.
    fn draw(&mut self, towards_light: Vec3, shadows: ShadowParams, pass: PassId) -> Result<(LightMaps, f64), Failure> {
        let params = &mut self.scene.params;
        params.light = Light::Directional { towards_light, color: Vec3::ONE };
        params.shadows = shadows;
        params.self_shadow = pass == PassId::LayerShadow;
        params.soft_shadow = pass == PassId::ShadowWidth;
        let (frame, _) = self.meter.prepared(&mut self.scene)?;
        let maps = frame.shadows().ok_or_else(|| lost("no shadow map was drawn"))?;
        let maps = read_maps(&self.scene.gpu, maps)?;
        // What a frame holds is not drawn over, but made anew.
        drop(frame);
        let index = PASSES.iter().position(|id| *id == pass).unwrap_or_default();
        let mut milliseconds = f64::INFINITY;
        for _ in 0..DRAWINGS {
            let (_, times) = self.meter.prepared(&mut self.scene)?;
            milliseconds = times.get(index).map_or(milliseconds, |ms| milliseconds.min(*ms));
        }
        Ok((maps, milliseconds))
    }
}

/// Copies the maps of a submitted frame into memory.
fn read_maps(gpu: &Gpu, maps: &ShadowMaps) -> Result<LightMaps, Failure> {
    let half = |bytes: &[u8]| half_to_f32(u16::from_le_bytes([bytes[0], bytes[1]]));
    let single = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let mut layers = Vec::new();
    let mut size = 0;
    if let Some(texture) = maps.layers() {
        size = texture.width();
        let count = texture.depth_or_array_layers();
        for layer in 0..count {
            let texels = read_texture(gpu, texture, layer)?;
            layers.push(texels.chunks_exact(2).map(half).collect());
        }
    }
    let mut width = Vec::new();
    if let Some(texture) = maps.width() {
        size = texture.width();
        let texels = read_texture(gpu, texture, 0)?;
        let texel = |t: &[u8]| [half(&t[..2]), half(&t[2..4]), half(&t[4..6]), half(&t[6..])];
        width = texels.chunks_exact(8).map(texel).collect();
    }
    let mut depths = [Vec::new(), Vec::new()];
    for (depths, texture) in depths.iter_mut().zip(maps.depths().into_iter().flatten()) {
        let texels = read_texture(gpu, texture, 0)?;
        *depths = texels.chunks_exact(4).map(single).collect();
    }
    Ok(LightMaps { view: *maps.view(), soft: maps.soft_shadow(), size, layers, width, depths })
}

/// IEEE 754 binary16 to binary32, exactly.
fn half_to_f32(bits: u16) -> f32 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1f), f32::from(bits & 0x3ff));
    let size = match exponent {
        0 => fraction * 2f32.powi(-24),
        31 if fraction == 0.0 => f32::INFINITY,
        31 => f32::NAN,
        _ => (1024.0 + fraction) * 2f32.powi(exponent - 25),
    };
    if bits >> 15 == 0 { size } else { -size }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_read() {
        for (bits, value) in [
            (0x0000, 0.0),
            (0x0001, 5.960_464_5e-8),
            (0x03ff, 6.097_555e-5),
            (0x0400, 6.103_515_6e-5),
            (0x3555, 0.333_251_95),
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (0x7c00, f32::INFINITY),
        ] {
            assert_eq!(half_to_f32(bits), value, "{bits:#x}");
        }
        assert!(half_to_f32(0x7e00).is_nan());
    }
}
