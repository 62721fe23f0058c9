//! `pelage chart surface`: the `surface` stage of the bake, repeated for timing.

use super::driver::{Plan, PlannedRow, Topic, processor};
use super::subject::{Subject, set_words};
use crate::chart::{Cell, surface};
use pelage_bake::pipeline::{self, BakeInput};
use pelage_herd::shell_word;
use pelage_tool::exit::Failure;
use std::time::Instant;

/// Number of runs per configuration, of which the median counts.
const RUNS: usize = 3;
/// Total duration after which no further run begins, seconds.
const LONG_S: f64 = 1.0;

/// Topic `surface`.
pub struct SurfaceTopic<'a> {
    subject: &'a Subject,
    configurations: Vec<surface::SurfaceConfiguration>,
}

impl<'a> SurfaceTopic<'a> {
    /// Lists the configurations.
    pub fn new(subject: &'a Subject) -> Result<Self, Failure> {
        Ok(Self { subject, configurations: surface::configurations(&subject.recipe, &subject.model)? })
    }
}

impl Topic for SurfaceTopic<'_> {
    fn plan(&self) -> Plan {
        let subject = self.subject;
        let row = |configuration: &surface::SurfaceConfiguration| {
            let sets = set_words(subject.sets.iter().chain(&configuration.sets));
            PlannedRow {
                series: configuration.series.into(),
                label: configuration.label.clone(),
                default: configuration.sets.is_empty(),
                command: Some(format!("{}{sets} -o {}.pelage --json", subject.command, shell_word(&subject.name))),
            }
        };
        let triangles = subject.model.mesh.triangles.len();
        Plan {
            topic: "surface",
            title: format!("{}, {triangles} triangles: distortion against seam length", subject.name),
            adapter: processor(),
            columns: surface::COLUMNS.to_vec(),
            panels: surface::PANELS.to_vec(),
            rows: self.configurations.iter().map(row).collect(),
        }
    }

    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure> {
        let recipe = &self.configurations[index].recipe;
        let Subject { file, model, images, .. } = self.subject;
        doing("mapping the tile onto the surface");
        let (mut seconds, mut measures) = (Vec::new(), None);
        while seconds.len() < RUNS && seconds.iter().sum::<f64>() < LONG_S {
            let begun = Instant::now();
            let laid = pipeline::lay_out_model(&BakeInput::new(file, file, recipe, images), model)?;
            seconds.push(begun.elapsed().as_secs_f64());
            measures = Some(laid.surface.measures);
        }
        seconds.sort_by(f64::total_cmp);
        Ok(surface::cells(recipe, &measures.unwrap_or_default(), seconds[seconds.len() / 2]))
    }
}
