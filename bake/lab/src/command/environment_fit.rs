//! `pelage chart environment-fit`: few lights, compared with the environment maps that they approximate.

use super::driver::{Plan, PlannedRow, Topic};
use crate::chart::Cell;
use crate::chart::environment_fit::{COLUMNS, LOBES, PANELS, cells, fit, true_irradiance};
use crate::chart::skies::{NamedSky, painted};
use glam::DVec3;
use pelage_bake::environment_file::EnvironmentFile;
use pelage_import::BakeError;
use pelage_stage::sky::FitParams;
use pelage_tool::exit::Failure;
use pelage_tool::machine::measured_on;
use std::path::PathBuf;
use std::time::Instant;

/// Loads the environment maps in `files`, or returns the painted ones if there are none.
pub(super) fn skies(files: &[PathBuf]) -> Result<Vec<NamedSky>, Failure> {
    if files.is_empty() {
        return Ok(painted()?);
    }
    let read = |path: &PathBuf| match EnvironmentFile::read(path)? {
        EnvironmentFile::Panorama(panorama) => {
            Ok(NamedSky { name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), panorama })
        }
        EnvironmentFile::Lights(_) => Err(BakeError::Input {
            file: path.display().to_string(),
            place: "whole file".into(),
            reason: "holds fitted lights, expected a panorama (.hdr, .exr) to compare them with".into(),
        }
        .into()),
    };
    files.iter().map(read).collect()
}

/// Topic `environment-fit`.
pub struct EnvironmentFitTopic {
    skies: Vec<NamedSky>,
    /// Irradiance under each environment map, computed when a row needs it.
    truths: Vec<Option<Vec<DVec3>>>,
}

impl EnvironmentFitTopic {
    /// Reads the environment maps.
    pub fn new(files: &[PathBuf]) -> Result<Self, Failure> {
        let skies = skies(files)?;
        Ok(Self { truths: vec![None; skies.len()], skies })
    }
}

impl Topic for EnvironmentFitTopic {
    fn plan(&self) -> Plan {
        let rows = self.skies.iter().flat_map(|sky| LOBES.map(|lobes| (sky, lobes)));
        let row = |(sky, lobes): (&NamedSky, usize)| PlannedRow {
            series: sky.name.clone(),
            label: lobes.to_string(),
            default: lobes == FitParams::default().lobes,
            command: None,
        };
        Plan {
            topic: "environment-fit",
            title: format!("Environment maps fitted by 0 to 32 lobes and a sun: {}", names(&self.skies)),
            adapter: measured_on("CPU"),
            columns: COLUMNS.to_vec(),
            panels: PANELS.to_vec(),
            rows: rows.map(row).collect(),
        }
    }

    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure> {
        let (number, lobes) = (index / LOBES.len(), LOBES[index % LOBES.len()]);
        let sky = &self.skies[number];
        let truth = self.truths[number].get_or_insert_with(|| {
            doing("truth");
            true_irradiance(&sky.panorama)
        });
        doing("fitting");
        let begun = Instant::now();
        let fitted = fit(sky, lobes);
        Ok(cells(sky, lobes, &fitted, truth, begun.elapsed().as_secs_f64()))
    }
}

/// Returns the names of `skies`, separated by commas.
pub(super) fn names(skies: &[NamedSky]) -> String {
    skies.iter().map(|sky| sky.name.as_str()).collect::<Vec<_>>().join(", ")
}
