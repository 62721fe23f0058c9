//! Estimates of the time and memory of commands: modelled before their first run, measured after it.

use super::kind::Kind;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Measured cost of the last run of each command, by task name.
pub type History = BTreeMap<String, CommandCost>;

/// Time and memory of a command.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CommandCost {
    /// Wall-clock time.
    pub seconds: f64,
    /// Peak memory.
    pub peak_bytes: u64,
}

const MIB: f64 = 1024.0 * 1024.0;

impl CommandCost {
    /// Estimates the cost of a command that has never run. The models are described in bake/docs/herd.md. They were
    /// measured with lavapipe on one core of a machine with two, and rounded up. The first run replaces the estimate
    /// with measured values.
    ///
    /// * `model_bytes`: size of the model file
    /// * `pixels`: number of pixels of all pictures
    /// * `samples`: number of samples of all pixels, millions
    pub fn estimate(kind: Kind, model_bytes: u64, pixels: f64, samples: f64) -> Self {
        let model = model_bytes as f64 / MIB;
        let (seconds, mib) = match kind {
            Kind::Bake => (1.0 + 2.0 * model, 200.0 + 40.0 * model),
            Kind::Inspect => (0.05, 60.0 + 4.0 * model),
            Kind::Render => (1.0 + 1e-6 * pixels, 300.0 + 10.0 * model + 1e-4 * pixels),
            Kind::Sequence => (1.0 + 1e-6 * pixels, 300.0 + 10.0 * model + 1e-5 * pixels),
            Kind::Truth | Kind::Part => (3.0 + model + 10.0 * samples, 700.0 + 60.0 * model + 5e-5 * pixels),
            Kind::Merge | Kind::Compare => (0.2 + 1e-6 * pixels, 80.0 + 5e-4 * pixels),
            Kind::Bench => (5.0, 400.0 + 10.0 * model),
            Kind::Chart | Kind::Rows => (120.0, 1500.0 + 60.0 * model),
        };
        Self { seconds, peak_bytes: (mib * MIB) as u64 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn estimates_grow_with_input_size() {
        let of = |kind, model, pixels, samples| CommandCost::estimate(kind, model, pixels, samples);
        assert!(of(Kind::Bake, 50 << 20, 0.0, 0.0).peak_bytes > 4 * of(Kind::Bake, 1 << 20, 0.0, 0.0).peak_bytes);
        assert!(of(Kind::Truth, 0, 1e6, 256.0).seconds > 100.0 * of(Kind::Truth, 0, 1e4, 0.1).seconds);
        assert!(of(Kind::Inspect, 0, 0.0, 0.0).seconds < of(Kind::Bake, 0, 0.0, 0.0).seconds);
    }
}
