//! `pelage chart environment`: light that a fibre scatters from environment maps, by the method used in frames and by
//! other methods, compared with integrating the map itself.

use super::driver::{Plan, PlannedRow, Topic};
use super::environment_fit::{names, skies};
use crate::chart::Cell;
use crate::chart::environment::{
    COLUMNS, EnvironmentConfiguration, EnvironmentTruth, PANELS, cells, configurations, measure_map, measure_single,
};
use crate::chart::skies::NamedSky;
use pelage_tool::exit::Failure;
use pelage_tool::machine::measured_on;
use std::path::PathBuf;

/// Topic `environment`.
pub struct EnvironmentTopic {
    configurations: Vec<EnvironmentConfiguration>,
    skies: Vec<NamedSky>,
    /// Truth for each environment map, computed when a row needs it.
    truths: Vec<Option<EnvironmentTruth>>,
}

impl EnvironmentTopic {
    /// Reads the environment maps and lists the configurations.
    pub fn new(files: &[PathBuf]) -> Result<Self, Failure> {
        let skies = skies(files)?;
        let truths = skies.iter().map(|_| None).collect();
        Ok(Self { configurations: configurations(skies.len()), skies, truths })
    }
}

impl Topic for EnvironmentTopic {
    fn plan(&self) -> Plan {
        let row = |configuration: &EnvironmentConfiguration| {
            let (series, label) = configuration.labels();
            PlannedRow { series: series.into(), label, default: configuration.is_default(), command: None }
        };
        Plan {
            topic: "environment",
            title: format!(
                "Sky light scattered by three fibres, against the sum over all directions: {}",
                names(&self.skies)
            ),
            adapter: measured_on("CPU, one thread"),
            columns: COLUMNS.to_vec(),
            panels: PANELS.to_vec(),
            rows: self.configurations.iter().map(row).collect(),
        }
    }

    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure> {
        let configuration = self.configurations[index];
        let (name, off) = match configuration {
            EnvironmentConfiguration::Sky(number, form) => {
                let sky = &self.skies[number];
                let truth = self.truths[number].get_or_insert_with(|| {
                    doing("truth");
                    EnvironmentTruth::new(sky)
                });
                doing("comparing");
                (sky.name.as_str(), measure_map(form, sky, truth))
            }
            EnvironmentConfiguration::Single(width, form) => {
                doing("comparing");
                ("", measure_single(form, width))
            }
        };
        Ok(cells(&configuration, name, &off))
    }
}
