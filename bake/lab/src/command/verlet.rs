//! `pelage chart verlet`: guides simulated by each method on one core, compared with their equations.

use super::driver::{Plan, PlannedRow, Topic};
use crate::chart::Cell;
use crate::chart::verlet::{
    COLUMNS, Guide, MotionDeviation, MotionForm, PANELS, POINTS, SECONDS, Scene, VerletConfiguration, cells,
    configurations,
};
use crate::truth::TrueMotion;
use pelage_tool::exit::Failure;
use pelage_tool::machine::measured_on;
use std::hint::black_box;
use std::time::Instant;

/// Minimum number of turns in which a method is timed; each covers all scenes. The fastest counts, because other load
/// only adds time and misses some of the short turns.
const FEWEST_TURNS: usize = 5;
/// Minimum total duration of the turns, seconds.
const TIMED_S: f64 = 0.3;

/// Topic `verlet`.
pub struct VerletTopic {
    configurations: Vec<VerletConfiguration>,
    /// Truths of all scenes by number of points, computed when a row needs them.
    truths: Vec<(usize, Vec<TrueMotion>)>,
}

impl VerletTopic {
    /// Lists the configurations.
    pub fn new() -> Self {
        Self { configurations: configurations(), truths: Vec::new() }
    }
}

impl Topic for VerletTopic {
    fn plan(&self) -> Plan {
        let row = |configuration: &VerletConfiguration| PlannedRow {
            series: configuration.series.into(),
            label: configuration.label.clone(),
            default: configuration.default,
            command: None,
        };
        let points = POINTS.map(|points| points.to_string()).join(", ");
        Plan {
            topic: "verlet",
            title: format!("Motion of guides with {points} points: turning head, gallop and gusts, {SECONDS} s each"),
            adapter: measured_on("CPU, one thread"),
            columns: COLUMNS.to_vec(),
            panels: PANELS.to_vec(),
            rows: self.configurations.iter().map(row).collect(),
        }
    }

    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure> {
        let configuration = &self.configurations[index];
        let guide = Guide::new(configuration.points);
        let at = match self.truths.iter().position(|(points, _)| *points == configuration.points) {
            Some(at) => at,
            None => {
                doing("truth");
                let truths = Scene::ALL.map(|scene| guide.truth(scene, false)).into();
                self.truths.push((configuration.points, truths));
                self.truths.len() - 1
            }
        };
        let truths = &self.truths[at].1;
        doing("moving");
        let off = [0, 1, 2].map(|i| MotionDeviation::of(&guide, &configuration.form, Scene::ALL[i], &truths[i].places));
        let nanoseconds =
            (configuration.form != MotionForm::Straight).then(|| nanoseconds(&guide, &configuration.form));
        Ok(cells(configuration, &off, nanoseconds, truths))
    }
}

/// Returns the nanoseconds per guide and simulated second, over all scenes, on this core.
fn nanoseconds(guide: &Guide, form: &MotionForm) -> f64 {
    let (begun, mut turns, mut fastest) = (Instant::now(), 0, f64::INFINITY);
    while turns < FEWEST_TURNS || begun.elapsed().as_secs_f64() < TIMED_S {
        let turn = Instant::now();
        for scene in Scene::ALL {
            guide.run(form, scene, &mut |places| {
                black_box(places);
            });
        }
        fastest = fastest.min(turn.elapsed().as_secs_f64());
        turns += 1;
    }
    fastest * 1e9 / f64::from(SECONDS * Scene::ALL.len() as u32)
}
