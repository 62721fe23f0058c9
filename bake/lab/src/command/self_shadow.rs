//! `pelage chart self-shadow`: baked visibility, and layer-wise shadow maps rendered by the adapter, compared with the
//! slow truths.

use super::driver::{Plan, PlannedRow, Topic, get_or_make};
use super::light_bench::LightBench;
use super::subject::Subject;
use crate::chart::Cell;
use crate::chart::self_shadow::{
    COLUMNS, Cost, MapCost, PANELS, SelfShadowErrors, Sheet, Slant, TransmittanceTruth, cells, slants,
};
use crate::chart::self_shadow_forms::{SelfShadowConfiguration, SelfShadowForm, configurations};
use pelage_bake::stages::groom::{self, Lengths};
use pelage_formats::Bounds;
use pelage_import::mesh::RestPose;
use pelage_runtime::{PassId, Study};
use pelage_stage::{Gpu, Spread};
use pelage_tool::exit::Failure;
use pelage_tool::machine::measured_on;

/// Topic `self-shadow`.
pub struct SelfShadowTopic<'a> {
    subject: &'a Subject,
    configurations: Vec<SelfShadowConfiguration>,
    bounds: Bounds,
    lengths: Lengths,
    gpu: Gpu,
    shared: Option<Shared>,
}

/// Data that all rows need.
struct Shared {
    sheet: Sheet,
    /// Benchmark with the sheet loaded.
    bench: LightBench,
    truths: Vec<(Slant, TransmittanceTruth)>,
}

impl<'a> SelfShadowTopic<'a> {
    /// Lists the configurations and opens the adapter.
    pub fn new(subject: &'a Subject) -> Result<Self, Failure> {
        let bounds = groom::bounds(&RestPose::of(&subject.model.mesh, subject.model.animation.as_ref()));
        let recipe = &subject.recipe;
        let lengths = Lengths::resolve(recipe, &bounds);
        let configurations = configurations(recipe);
        Ok(Self { subject, configurations, bounds, lengths, gpu: Gpu::open()?, shared: None })
    }
}

impl Topic for SelfShadowTopic<'_> {
    fn plan(&self) -> Plan {
        let row = |configuration: &SelfShadowConfiguration| PlannedRow {
            series: configuration.series.into(),
            label: configuration.label.clone(),
            default: *configuration == self.configurations[0],
            command: None,
        };
        let (name, layers) = (&self.subject.name, self.subject.recipe.slice.layers);
        Plan {
            topic: "self-shadow",
            title: format!("Hair of {name} on a flat sheet, {layers} layers: shadows between hairs"),
            adapter: measured_on(&self.gpu.info.name),
            columns: COLUMNS.to_vec(),
            panels: PANELS.to_vec(),
            rows: self.configurations.iter().map(row).collect(),
        }
    }

    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure> {
        let Shared { sheet, bench, truths } = get_or_make(&mut self.shared, || {
            doing("growing a sheet of hair");
            let sheet = Sheet::new(&self.subject.recipe, self.lengths)?;
            let bench = LightBench::new("sheet", &sheet.package, &self.gpu)?;
            let slants = slants();
            let truth = |(i, slant): (usize, Slant)| {
                doing(&format!("reference light {} of {}", i + 1, slants.len()));
                (slant, sheet.truth(&slant))
            };
            let truths = slants.iter().copied().enumerate().map(truth).collect();
            Ok(Shared { sheet, bench, truths })
        })?;
        let form = self.configurations[index].form;
        let mut measured = SelfShadowErrors::default();
        let cost = match form {
            SelfShadowForm::Baked { blocks, directions } => {
                doing("baking");
                let mut seconds = f64::INFINITY;
                let mut bake = |blocks| {
                    let (visibility, taken) = sheet.visibility(blocks, directions)?;
                    // Blocks are encoded later, so every bake does the same work here. The fastest counts, because
                    // other load only adds time.
                    seconds = seconds.min(taken);
                    Ok::<_, Failure>(visibility)
                };
                let (visibility, plain) = (bake(blocks)?, bake(None)?);
                for (slant, truth) in truths {
                    let found = sheet.transmittance_by_visibility(&visibility, slant, truth);
                    measured.add(slant, &found, form.density(), truth);
                    if blocks.is_some() {
                        measured.add_blocks(&found, &sheet.transmittance_by_visibility(&plain, slant, truth), truth);
                    }
                }
                Cost { bytes: visibility.bytes, visibility_seconds: Some(seconds), ..Cost::default() }
            }
            SelfShadowForm::Maps { shadows, slant: slant_form } => {
                let study = Study::default().with(|study| study.light_slant = slant_form);
                let mut of_maps = MapCost { timing: bench.clock_word(), ..MapCost::default() };
                let (mut milliseconds, mut bytes) = (Vec::new(), 0);
                for (i, (slant, truth)) in truths.iter().enumerate() {
                    doing(&format!("light {} of {}", i + 1, truths.len()));
                    let towards_light = sheet.to_world(slant.light_ts);
                    let (maps, ms) = bench.draw(towards_light, (shadows, study), PassId::LAYER_SHADOW)?;
                    let found = sheet.transmittance_by_maps(&maps, slant, (&shadows, slant_form), truth);
                    measured.add(slant, &found, form.density(), truth);
                    milliseconds.push(ms);
                    bytes = maps.layer_bytes();
                    of_maps.texels_per_hair_texel = sheet.map_texels_per_hair_texel(&maps);
                    of_maps.map_size_on_model = sheet.map_size_on(&maps, self.bounds.radius + self.lengths.length_m);
                }
                let milliseconds = Spread::of(milliseconds).median;
                Cost { milliseconds, bytes, maps: Some(of_maps), visibility_seconds: None }
            }
        };
        Ok(cells(&form, sheet.layers, &measured, &cost))
    }
}
