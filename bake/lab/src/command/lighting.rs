//! `pelage chart lighting`: light per pixel and per vertex, with several direction textures.

use super::driver::{Plan, PlannedRow, Topic};
use super::subject::Subject;
use crate::chart::{Cell, lighting};
use pelage_bake::pipeline::{self, BakeInput};
use pelage_bake::stages::groom::{self, Lengths};
use pelage_import::mesh::RestPose;
use pelage_runtime::{LightingStage, PassId};
use pelage_stage::{Gpu, LookLighting, LookSelfShadow, Meter, NamedPackage, Spread};
use pelage_tool::exit::Failure;
use pelage_tool::machine::measured_on;
use pelage_tool::stages::stage_of;
use pelage_tool::view::PictureView;

/// Number of timed frames per configuration. The fastest counts, because other load only adds time.
const FRAMES: usize = 9;
/// Number of frames before the timed ones, in which pipelines and caches settle.
const WARM_UP: usize = 1;

/// Topic `lighting`.
pub struct LightingTopic<'a> {
    subject: &'a Subject,
    configurations: Vec<lighting::LightingConfiguration>,
    lengths: Lengths,
    gpu: Gpu,
}

impl<'a> LightingTopic<'a> {
    /// Lists the configurations and opens the adapter.
    pub fn new(subject: &'a Subject) -> Result<Self, Failure> {
        let configurations = lighting::configurations(&subject.recipe)?;
        let bounds = groom::bounds(&RestPose::of(&subject.model.mesh, subject.model.animation.as_ref()));
        let lengths = Lengths::resolve(&subject.recipe, &bounds);
        Ok(Self { subject, configurations, lengths, gpu: Gpu::open()? })
    }
}

impl Topic for LightingTopic<'_> {
    fn plan(&self) -> Plan {
        let row = |configuration: &lighting::LightingConfiguration| PlannedRow {
            series: configuration.series.into(),
            label: configuration.label.clone(),
            default: configuration.lighting == LightingStage::default() && configuration.sets.is_empty(),
            command: None,
        };
        let (name, layers) = (&self.subject.name, self.subject.recipe.slice.layers);
        Plan {
            topic: "lighting",
            title: format!("Hair of {name}, {layers} layers: lighting from stored hair directions"),
            adapter: measured_on(&self.gpu.info.name),
            columns: lighting::COLUMNS.to_vec(),
            panels: lighting::PANELS.to_vec(),
            rows: self.configurations.iter().map(row).collect(),
        }
    }

    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure> {
        let configuration = &self.configurations[index];
        let Subject { file, name, model, images, .. } = self.subject;
        doing("baking");
        let baked = pipeline::bake(&BakeInput::new(file, name, &configuration.recipe, images), model, &mut |_| ())?;
        let file = NamedPackage { name: name.clone(), bytes: baked.package.into() };
        // Shadows are off, because they cost the same for any shading direction.
        let view = PictureView::default().with(|look| {
            look.shadow.self_shadow = LookSelfShadow::Off;
            look.shadow.soft_shadow = false;
            look.study.lighting = match configuration.lighting {
                LightingStage::Pixel => LookLighting::Pixel,
                LightingStage::Vertex => LookLighting::Vertex,
            };
        });
        let mut scene = stage_of(&file, &view, || Ok(self.gpu.clone()))?;
        doing("directions");
        let measured = lighting::measure(configuration, self.lengths)?;
        doing("frames");
        let meter = Meter::new(&self.gpu);
        let mut milliseconds = Vec::new();
        for frame in 0..WARM_UP + FRAMES {
            let times = meter.measure(&mut scene)?;
            if frame >= WARM_UP {
                milliseconds.push(times.of(PassId::SHELLS));
            }
        }
        Ok(lighting::cells(configuration, &measured, Spread::of(milliseconds).min, meter.clock().word()))
    }
}
