//! `pelage chart lighting`: light per pixel and per vertex, by several direction textures.

use super::chart::{ChartArgs, Subject};
use super::chart_light::command;
use super::exit::Failure;
use super::gpu::Gpu;
use super::measure::{Clock, Meter, PASSES, Spread};
use super::output::Output;
use super::package_file::PackageFile;
use super::scene::{Scene, Terms, View};
use pelage_bake::chart::{Chart, Row, lighting};
use pelage_bake::groom::{self, Lengths};
use pelage_bake::mesh::RestPose;
use pelage_bake::pipeline;
use pelage_runtime::{Lighting, PassId};

/// Timed frames of each configuration, of which the fastest counts, since what else the machine does only adds; and those before them in which pipelines and caches settle.
const FRAMES: usize = 9;
const WARM_UP: usize = 1;

/// The topic `lighting`.
pub fn lighting_chart(args: &ChartArgs, subject: &Subject, output: &mut Output) -> Result<Chart, Failure> {
    let configurations = lighting::configurations(&subject.recipe)?;
    let numbers: Vec<usize> = args.numbers(configurations.len())?.collect();
    let bounds = groom::bounds(&RestPose::of(&subject.model.mesh, subject.model.animation.as_ref()));
    let lengths = Lengths::resolve(subject.recipe.hair.length_m, subject.recipe.surface.tile_size_m, &bounds);
    let gpu = Gpu::open()?;
    let meter = Meter::new(&gpu);
    let mut trials = Vec::new();
    for (i, number) in numbers.iter().enumerate() {
        let configuration = &configurations[number - 1];
        output.progress_of(i, numbers.len(), "baking");
        let Subject { file, name, model, images, .. } = subject;
        let baked = pipeline::bake(file, name, model, &configuration.recipe, images, &mut |_| ())?;
        let file = PackageFile { name: subject.name.clone(), bytes: baked.package };
        // Shadows cost the same whatever direction the light is computed with.
        let terms = Terms { self_shadow: false, soft_shadow: false, ..View::default().terms };
        let view = View { lighting: configuration.lighting, terms, ..View::default() };
        let scene = Scene::new(&file, &view, || Ok(gpu.clone()))?;
        trials.push((*number, configuration, lighting::measure(configuration, lengths)?, scene, Vec::new()));
    }
    // In turn, so that what else the machine does falls on all alike.
    let shells = PASSES.iter().position(|id| *id == PassId::Shells);
    for frame in 0..WARM_UP + FRAMES {
        output.progress_of(frame, WARM_UP + FRAMES, "frames");
        for (.., scene, milliseconds) in &mut trials {
            let times = meter.measure(scene)?;
            if frame >= WARM_UP {
                milliseconds.extend(shells.map(|pass| times.passes[pass]));
            }
        }
    }
    let timing = match meter.clock() {
        Clock::TimestampQuery => "timestamp-query",
        Clock::SubmitAndWait => "submit-and-wait",
    };
    let rows = trials.into_iter().map(|(number, configuration, measured, _, milliseconds)| Row {
        series: configuration.series.into(),
        cells: lighting::cells(configuration, &measured, Spread::of(milliseconds).min, timing),
        default: configuration.lighting == Lighting::default() && configuration.sets.is_empty(),
        command: command(args, subject, "lighting", number),
    });
    let build = if cfg!(debug_assertions) { ", debug build" } else { "" };
    let layers = subject.recipe.slice.layers;
    Ok(Chart {
        topic: "lighting",
        title: format!("Hair of {}, {layers} layers: light by the direction of its hairs", subject.name),
        adapter: format!("{}{build}", gpu.info.name),
        columns: lighting::COLUMNS.to_vec(),
        rows: rows.collect(),
        panels: lighting::PANELS.to_vec(),
    })
}
