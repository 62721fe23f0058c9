//! `pelage chart self-shadow`: layer-wise shadow maps, drawn by the adapter, against the slow truths.

use super::driver::{Plan, PlannedRow, Topic, once};
use super::light_bench::LightBench;
use super::machine::measured_on;
use super::subject::Subject;
use crate::cli::exit::Failure;
use pelage_bake::judge::chart::Cell;
use pelage_bake::judge::chart::self_shadow::{
    COLUMNS, Configuration, Cost, Measured, PANELS, Sheet, Slant, Truth, cells, configurations, slants,
};
use pelage_bake::mesh::RestPose;
use pelage_bake::stages::groom::{self, Lengths};
use pelage_formats::Bounds;
use pelage_runtime::{PassId, Study};
use pelage_stage::{Gpu, Spread};

/// The topic.
pub struct SelfShadowTopic<'a> {
    subject: &'a Subject,
    configurations: Vec<Configuration>,
    bounds: Bounds,
    lengths: Lengths,
    gpu: Gpu,
    shared: Option<Shared>,
}

/// What all rows need.
struct Shared {
    sheet: Sheet,
    /// The sheet in the runtime's hands.
    bench: LightBench,
    truths: Vec<(Slant, Truth)>,
}

impl<'a> SelfShadowTopic<'a> {
    /// Lists the configurations and opens the adapter.
    pub fn new(subject: &'a Subject) -> Result<Self, Failure> {
        let bounds = groom::bounds(&RestPose::of(&subject.model.mesh, subject.model.animation.as_ref()));
        let recipe = &subject.recipe;
        let lengths = Lengths::resolve(recipe.hair.length_m, recipe.surface.tile_size_m, &bounds);
        let configurations = configurations(recipe.slice.layers);
        Ok(Self { subject, configurations, bounds, lengths, gpu: Gpu::open()?, shared: None })
    }
}

impl Topic for SelfShadowTopic<'_> {
    fn plan(&self) -> Plan {
        let row = |configuration: &Configuration| PlannedRow {
            series: configuration.series.into(),
            label: configuration.label.clone(),
            default: configuration.is_default(),
            command: None,
        };
        let (name, layers) = (&self.subject.name, self.subject.recipe.slice.layers);
        Plan {
            topic: "self-shadow",
            title: format!("Hair of {name} on a flat sheet, {layers} layers: light between hairs by layer-wise maps"),
            adapter: measured_on(&self.gpu.info.name),
            columns: COLUMNS.to_vec(),
            panels: PANELS.to_vec(),
            rows: self.configurations.iter().map(row).collect(),
        }
    }

    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure> {
        let Shared { sheet, bench, truths } = once(&mut self.shared, || {
            doing("growing a sheet of hair");
            let sheet = Sheet::new(&self.subject.recipe, self.lengths)?;
            let bench = LightBench::new("sheet", &sheet.package, &self.gpu)?;
            let slants = slants();
            let truth = |(i, slant): (usize, Slant)| {
                doing(&format!("true light {} of {}", i + 1, slants.len()));
                (slant, sheet.truth(&slant))
            };
            let truths = slants.iter().copied().enumerate().map(truth).collect();
            Ok(Shared { sheet, bench, truths })
        })?;
        let (shadows, slant_form) = (self.configurations[index].shadows, self.configurations[index].slant);
        let study = Study::default().with(|study| study.light_slant = slant_form);
        let mut measured = Measured::default();
        let mut cost = Cost { timing: bench.clock_word(), ..Cost::default() };
        let mut milliseconds = Vec::new();
        for (i, (slant, truth)) in truths.iter().enumerate() {
            doing(&format!("light {} of {}", i + 1, truths.len()));
            let (maps, ms) = bench.draw(sheet.to_world(slant.light_ts), (shadows, study), PassId::LAYER_SHADOW)?;
            measured.add(slant, &sheet.fast(&maps, slant, (&shadows, slant_form), truth), shadows.density, truth);
            milliseconds.push(ms);
            cost.texels_per_hair_texel = sheet.map_texels_per_hair_texel(&maps);
            cost.map_size_on_model = sheet.map_size_on(&maps, self.bounds.radius + self.lengths.length_m);
        }
        cost.milliseconds = Spread::of(milliseconds).median;
        Ok(cells((&shadows, slant_form), sheet.layers, &measured, &cost))
    }
}
