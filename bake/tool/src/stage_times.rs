//! Durations of the stages of a bake and of their steps.

use pelage_bake::pipeline::{Output, STAGES, STEPS, StepEvent};
use serde::Serialize;
use std::time::Instant;

/// Duration of a stage.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StageTime {
    /// Name of the stage.
    pub name: &'static str,
    /// Sum of the durations of its steps. Steps of different stages run at the same time, so that all stages together
    /// may take longer than the bake. A step that waits for its threads may contain another.
    pub seconds: f64,
    /// Steps, each named after its output. A stage outside the bake itself has none.
    pub steps: Vec<StepTime>,
}

/// Duration of a step.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StepTime {
    name: String,
    seconds: f64,
}

/// Stopwatch for stages and steps.
#[derive(Debug, Default)]
pub struct StageTimes {
    /// Stages that have begun, in order.
    stages: Vec<StageTime>,
    /// Running steps and stages outside the bake: name of the stage, output, and beginning.
    running: Vec<(&'static str, Option<Output>, Instant)>,
}

impl StageTimes {
    /// Begins a stage outside the bake. It ends when the next stage begins.
    pub fn begin(&mut self, stage: &'static str) {
        self.begin_step(stage, None);
    }

    /// Records an event of a bake.
    pub fn on_event(&mut self, event: StepEvent) {
        match event {
            StepEvent::Begins(step) => self.begin_step(step.stage, Some(step.makes)),
            StepEvent::Ends(step) => self.end(Some(step.makes)),
        }
    }

    fn begin_step(&mut self, stage: &'static str, makes: Option<Output>) {
        self.end(None);
        self.running.push((stage, makes, Instant::now()));
        if !self.stages.iter().any(|known| known.name == stage) {
            self.stages.push(StageTime { name: stage, seconds: 0.0, steps: Vec::new() });
        }
    }

    fn end(&mut self, makes: Option<Output>) {
        for (name, _, begun) in self.running.extract_if(.., |(_, of, _)| *of == makes) {
            let seconds = begun.elapsed().as_secs_f64();
            if let Some(stage) = self.stages.iter_mut().find(|stage| stage.name == name) {
                stage.seconds += seconds;
                stage.steps.extend(makes.map(|makes| StepTime { name: snake_case(makes), seconds }));
            }
        }
    }

    /// Returns the names of the running stages, in the order in which they began.
    pub fn running(&self) -> Vec<&'static str> {
        let runs = |stage: &StageTime| self.running.iter().any(|(name, ..)| *name == stage.name);
        self.stages.iter().filter(|stage| runs(stage)).map(|stage| stage.name).collect()
    }

    /// Ends a stage outside the bake, and returns the times: first those of stages outside the bake, then those of
    /// [`STAGES`] and their steps in order.
    pub fn finish(mut self) -> Vec<StageTime> {
        self.end(None);
        self.stages.sort_by_key(|stage| STAGES.iter().position(|name| *name == stage.name));
        let place = |step: &StepTime| STEPS.iter().position(|known| snake_case(known.makes) == step.name);
        self.stages.iter_mut().for_each(|stage| stage.steps.sort_by_key(place));
        self.stages
    }
}

/// Returns the name of an output in lower case, with underscores between words.
fn snake_case(output: Output) -> String {
    let mut name = String::new();
    for (i, letter) in format!("{output:?}").chars().enumerate() {
        if letter.is_uppercase() && i > 0 {
            name.push('_');
        }
        name.extend(letter.to_lowercase());
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_bake::pipeline::STEPS;

    #[test]
    fn steps_that_overlap_are_timed_separately() {
        let mut times = StageTimes::default();
        times.begin("import");
        assert_eq!(times.running(), ["import"]);
        let [slice, groom, single] = [Output::Shells, Output::Groomed, Output::Single]
            .map(|output| STEPS.iter().find(|step| step.makes == output).expect("every output has a step"));
        for event in [StepEvent::Begins(slice), StepEvent::Begins(groom), StepEvent::Begins(single)] {
            times.on_event(event);
        }
        assert_eq!(times.running(), ["slice", "groom"], "import has ended");
        times.on_event(StepEvent::Ends(single));
        assert_eq!(times.running(), ["slice", "groom"], "another step of the stage runs");
        times.on_event(StepEvent::Ends(slice));
        times.on_event(StepEvent::Ends(groom));
        let times = times.finish();
        let steps = |stage: &StageTime| stage.steps.iter().map(|step| step.name.clone()).collect::<Vec<_>>();
        assert_eq!(times.iter().map(|stage| stage.name).collect::<Vec<_>>(), ["import", "slice", "groom"]);
        assert_eq!(times.iter().map(steps).collect::<Vec<_>>(), [vec![], vec!["shells", "single"], vec!["groomed"]]);
        assert!(times[1].seconds >= times[1].steps[0].seconds && times[0].seconds > 0.0);
    }
}
