//! Fibre data for light paths.

use glam::DVec3;
use pelage_formats::meaning::scattering::{AzimuthalScattering, Fibre, LobeShape, colour};
use pelage_import::BakeError;

/// Scattering of light between hairs, modelled as fibres. Replaces Yang 2006, eq. (3), which treats each fibre alone.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueScattering {
    fibres: Vec<TrueFibre>,
    /// Runs of consecutive strands: name, index after the last strand, and index of the fibre. Strands after all runs
    /// have the first fibre.
    runs: Vec<(String, u32, usize)>,
    bounces: u32,
}

/// Fibre with data for near-field scattering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TrueFibre {
    pub(super) fibre: Fibre,
    /// Scale of the fibre's azimuthal logistic distribution, radians.
    pub(super) scale: f64,
    /// [`colour::depth`] and [`colour::medulla_absorption`]; expensive to compute.
    pub(super) depth: f64,
    pub(super) medulla_absorption: f64,
}

impl TrueFibre {
    /// Returns the absorption per radius of a hair of linear colour `color`.
    pub(super) fn absorption(&self, color: DVec3) -> [f64; 3] {
        colour::absorption_at(color.to_array(), self.depth).map(|sigma| sigma * self.medulla_absorption)
    }
}

impl TrueScattering {
    /// Default maximum number of bounces on hair and surface; enough for white fur.
    pub const BOUNCES: u32 = 64;

    /// Creates scattering with one fibre for all strands. Light hits hair or surface at most `bounces` times, at least
    /// 1. With 1, only direct light scattered by a single fibre counts.
    ///
    /// Fails with [`BakeError::Internal`] for a fibre without near-field scattering: it is smooth all around, or does
    /// not conserve energy.
    pub fn new(fibre: Fibre, bounces: u32) -> Result<Self, BakeError> {
        Ok(Self { fibres: vec![near(fibre)?], runs: Vec::new(), bounces: bounces.max(1) })
    }

    /// Adds a run named `name` with another fibre. It begins where the last run ends and stops before strand `end`.
    ///
    /// Fails like [`Self::new`].
    pub fn with_run(mut self, name: &str, end: u32, fibre: Fibre) -> Result<Self, BakeError> {
        self.runs.push((name.to_owned(), end, self.fibres.len()));
        self.fibres.push(near(fibre)?);
        Ok(self)
    }

    /// Sets the maximum number of bounces, at least 1.
    pub fn with_bounces(self, bounces: u32) -> Self {
        Self { bounces: bounces.max(1), ..self }
    }

    /// Returns the fibre of a strand.
    pub(super) fn of_strand(&self, strand: u32) -> &TrueFibre {
        let run = self.runs.partition_point(|(_, end, _)| *end <= strand);
        &self.fibres[self.runs.get(run).map_or(0, |(.., fibre)| *fibre)]
    }

    /// Returns the fibre of the strands in the run `name`, and the scale of its azimuthal logistic distribution,
    /// radians.
    pub fn of_group(&self, name: &str) -> (Fibre, f64) {
        let number = self.runs.iter().find(|(run, ..)| run == name).map_or(0, |(.., fibre)| *fibre);
        let TrueFibre { fibre, scale, .. } = self.fibres[number];
        (fibre, scale)
    }

    /// Returns the maximum number of bounces.
    pub fn bounces(&self) -> u32 {
        self.bounces
    }
}

fn near(fibre: Fibre) -> Result<TrueFibre, BakeError> {
    match (fibre.around, fibre.keeps) {
        (AzimuthalScattering::Rough(scale), LobeShape::Energy) => {
            let medulla_absorption = colour::medulla_absorption(&fibre.medulla, scale);
            Ok(TrueFibre { fibre, scale, depth: colour::depth(scale), medulla_absorption })
        }
        _ => Err(BakeError::Internal(
            "path tracing needs a fibre with azimuthal roughness that conserves \
             energy"
                .into(),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_formats::meaning::scattering::azimuthal::GlintShape;

    #[test]
    fn strands_have_the_fibre_of_their_run() {
        let of = |eta| Fibre { eta, ..Fibre::default() };
        let mixed = TrueScattering::new(of(1.5), 3).unwrap().with_run("coat", 2, of(1.6)).unwrap();
        let mixed = mixed.with_run("tail", 5, of(1.7)).unwrap();
        let found = [0, 1, 2, 4, 5, 9].map(|strand| mixed.of_strand(strand).fibre.eta);
        assert_eq!((found, mixed.bounces()), ([1.6, 1.6, 1.7, 1.7, 1.5, 1.5], 3));
        assert_eq!((mixed.of_group("tail").0.eta, mixed.of_group("mane").0.eta), (1.7, 1.5));
        let smooth = Fibre { around: AzimuthalScattering::Smooth(GlintShape::default()), ..Fibre::default() };
        assert!(TrueScattering::new(smooth, 1).is_err());
    }
}
