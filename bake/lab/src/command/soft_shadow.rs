//! `pelage chart soft-shadow`: shadow-width maps, rendered by the adapter, compared with a disc light.

use super::driver::{Plan, PlannedRow, Topic, get_or_make};
use super::light_bench::LightBench;
use super::subject::Subject;
use crate::chart::Cell;
use crate::chart::soft_shadow::{
    COLUMNS, Method, PANELS, SampledSurface, SoftShadowConfiguration, SoftShadowErrors, cells, configurations, lights,
    runtime_settings,
};
use pelage_bake::pipeline::{self, BakeInput};
use pelage_bake::recipe::{DirectionFormat, ShellFormat};
use pelage_runtime::PassId;
use pelage_stage::{Gpu, Spread};
use pelage_tool::exit::Failure;
use pelage_tool::machine::measured_on;
use std::time::Instant;

/// Topic `soft-shadow`.
pub struct SoftShadowTopic<'a> {
    subject: &'a Subject,
    configurations: Vec<SoftShadowConfiguration>,
    gpu: Gpu,
    /// Mesh surface, and benchmark with the model loaded.
    shared: Option<(SampledSurface, LightBench)>,
    /// Fraction of each light visible from the surface points, for each penumbra.
    truths: Vec<(f32, Vec<Vec<f64>>)>,
}

impl<'a> SoftShadowTopic<'a> {
    /// Lists the configurations and opens the adapter.
    pub fn new(subject: &'a Subject) -> Result<Self, Failure> {
        Ok(Self { subject, configurations: configurations(), gpu: Gpu::open()?, shared: None, truths: Vec::new() })
    }
}

impl Topic for SoftShadowTopic<'_> {
    fn plan(&self) -> Plan {
        let row = |configuration: &SoftShadowConfiguration| PlannedRow {
            series: configuration.series.into(),
            label: configuration.label.clone(),
            default: *configuration == self.configurations[0],
            command: None,
        };
        let triangles = self.subject.model.mesh.triangles.len();
        Plan {
            topic: "soft-shadow",
            title: format!(
                "{}, {triangles} triangles: soft shadows on the skin against a traced disc light",
                self.subject.name
            ),
            adapter: measured_on(&self.gpu.info.name),
            columns: COLUMNS.to_vec(),
            panels: PANELS.to_vec(),
            rows: self.configurations.iter().map(row).collect(),
        }
    }

    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure> {
        let (skin, bench) = get_or_make(&mut self.shared, || {
            doing("baking");
            let Subject { file, name, model, images, .. } = self.subject;
            let mut recipe = self.subject.recipe.clone();
            // Every adapter reads these formats; shadows of the mesh surface do not depend on them.
            recipe.pack.shell_format = ShellFormat::Rgba8;
            recipe.pack.direction_format = DirectionFormat::Rg8;
            let baked = pipeline::bake(&BakeInput::new(file, name, &recipe, images), model, &mut |_| ())?;
            Ok((SampledSurface::new(model)?, LightBench::new(name, &baked.package, &self.gpu)?))
        })?;
        let configuration = &self.configurations[index];
        let (shadows, study) = runtime_settings(configuration);
        let known = self.truths.iter().position(|(penumbra, _)| *penumbra == shadows.penumbra);
        let known = known.unwrap_or_else(|| {
            doing("true light");
            let truths = lights().into_iter().map(|light| skin.truth(light, shadows.penumbra)).collect();
            self.truths.push((shadows.penumbra, truths));
            self.truths.len() - 1
        });
        let iterated = matches!(configuration.method, Method::Iterated(_));
        let (mut measured, mut milliseconds) = (SoftShadowErrors::default(), Vec::new());
        for (light, truth) in lights().into_iter().zip(&self.truths[known].1) {
            doing("light on the skin");
            let (maps, ms) = bench.draw(light, (shadows, study), PassId::SHADOW_WIDTH)?;
            let start = Instant::now();
            let fast = skin.by_method(&maps, light, configuration.method, shadows.shrink);
            // The runtime has no pass for iterated distances. They are computed here, and their time is added.
            milliseconds.push(if iterated { ms + start.elapsed().as_secs_f64() * 1e3 } else { ms });
            measured.add(&fast, truth);
        }
        let timing = if iterated { format!("{} and CPU", bench.clock_word()) } else { bench.clock_word().into() };
        Ok(cells(configuration, &measured, Spread::of(milliseconds).median, &timing))
    }
}
