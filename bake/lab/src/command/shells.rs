//! `pelage chart shells`: shells and fins with many settings, compared with the true strands.

use super::driver::{Plan, PlannedRow, Topic, get_or_make};
use super::subject::Subject;
use crate::chart::{Cell, shells};
use pelage_bake::recipe::Recipe;
use pelage_stage::{Gpu, LookDetail};
use pelage_tool::exit::Failure;
use pelage_tool::machine::measured_on;
use pelage_tool::shell_judge::ShellJudge;

/// Topic `shells`.
pub struct ShellsTopic<'a> {
    subject: &'a Subject,
    configurations: Vec<shells::ShellsConfiguration>,
    gpu: Gpu,
    /// Judge with the reference images.
    judge: Option<ShellJudge<'a>>,
}

impl<'a> ShellsTopic<'a> {
    /// Lists the configurations and opens the adapter.
    pub fn new(subject: &'a Subject) -> Result<Self, Failure> {
        let configurations = shells::configurations(&subject.recipe)?;
        Ok(Self { subject, configurations, gpu: Gpu::open()?, judge: None })
    }
}

impl Topic for ShellsTopic<'_> {
    fn plan(&self) -> Plan {
        let row = |configuration: &shells::ShellsConfiguration| PlannedRow {
            series: configuration.series.clone(),
            label: configuration.label.clone(),
            default: configuration.default,
            command: None,
        };
        let (name, judge) = (&self.subject.name, &self.subject.recipe.judge);
        Plan {
            topic: "shells",
            title: format!("{name}, {}x{} pixels: shells and fins against the true strands", judge.width, judge.height),
            adapter: measured_on(&self.gpu.info.name),
            columns: shells::COLUMNS.to_vec(),
            panels: shells::PANELS.to_vec(),
            rows: self.configurations.iter().map(row).collect(),
        }
    }

    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure> {
        let (subject, gpu) = (self.subject, &self.gpu);
        let judge = get_or_make(&mut self.judge, || {
            let baker = Box::new(move |recipe: &Recipe| subject.bake(recipe));
            ShellJudge::new(baker, &subject.recipe, gpu, LookDetail::Full, doing)
        })?;
        let configuration = &self.configurations[index];
        doing("baking and drawing");
        let (measured, _) = judge.measure(&configuration.recipe)?;
        Ok(shells::cells(&configuration.recipe, &measured, judge.timing()))
    }
}
