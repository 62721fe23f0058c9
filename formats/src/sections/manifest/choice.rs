//! Record of a bake that chose its settings automatically.

use serde::{Deserialize, Serialize};

/// Record of a bake that chose its settings within limits: the limits, the trials, and the chosen settings.
///
/// Frame times depend on the machine. With a limit on them, the same inputs need not give the same bytes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Choice {
    /// Requested limits; at least one is set.
    pub limits: ChoiceLimits,
    /// Name of the limit that prevents cheaper or better settings: `max_error`, `max_frame_ms` or `max_bytes`, if it
    /// was set. Empty if no limit does.
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["", "max_error", "max_frame_ms", "max_bytes"])))]
    pub binding: String,
    /// Adapter on which frames were timed; empty if none were.
    pub adapter: String,
    /// Width of the images that were compared and timed, pixels, at least 1.
    pub width: u32,
    /// Height of the images that were compared and timed, pixels, at least 1.
    pub height: u32,
    /// Samples per pixel of the reference images; 0 if nothing was compared.
    pub samples: u32,
    /// Views, as arguments of `pelage render`.
    pub views: Vec<String>,
    /// All settings that were tried.
    pub trials: Vec<Trial>,
    /// Index into `trials` of the settings used in the package.
    pub chosen: u32,
    /// Index into `trials` of the cheapest settings with a smaller error than the chosen ones.
    pub next_better: Option<u32>,
    /// Index into `trials` of the most accurate settings that cost less than the chosen ones.
    pub next_cheaper: Option<u32>,
}

/// Limits of a [`Choice`], each at least 0; `None` if not set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ChoiceLimits {
    /// Maximum error against the reference images, measured as [`Trial::error`].
    pub max_error: Option<f64>,
    /// Maximum frame time, milliseconds.
    pub max_frame_ms: Option<f64>,
    /// Maximum size of the package, bytes.
    pub max_bytes: Option<u64>,
}

/// Settings tried for a [`Choice`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Trial {
    /// Settings in the recipe, each `key=value` as for `pelage bake --set`.
    pub settings: Vec<String>,
    /// Difference from the reference images; 0 if they are equal. It is a weighted sum of the mean FLIP, the lost
    /// outline and the lost contrast. The weights depend on the version of the tool. The earliest versions used the
    /// mean FLIP alone. `None` if nothing was compared.
    pub error: Option<f64>,
    /// Frame time, milliseconds, at least 0; `None` if nothing was timed.
    pub frame_ms: Option<f64>,
    /// Size of the package, bytes.
    pub bytes: u64,
    /// Whether the figures are predicted by a model instead of measured.
    pub predicted: bool,
}

impl Choice {
    /// Checks that every number is in its range and every index points into the trials.
    pub(super) fn check(&self) -> Result<(), String> {
        let number = |what: String, value: Option<f64>| match value.filter(|v| !(v.is_finite() && *v >= 0.0)) {
            Some(v) => Err(format!("choice.{what} is {v}, expected a finite number, at least 0")),
            None => Ok(()),
        };
        let limits = &self.limits;
        number("limits.max_error".into(), limits.max_error)?;
        number("limits.max_frame_ms".into(), limits.max_frame_ms)?;
        let given = [
            ("max_error", limits.max_error.is_some()),
            ("max_frame_ms", limits.max_frame_ms.is_some()),
            ("max_bytes", limits.max_bytes.is_some()),
        ];
        if !given.iter().any(|(_, given)| *given) {
            return Err("choice.limits sets no limit, expected at least one".into());
        }
        if !self.binding.is_empty() && !given.contains(&(self.binding.as_str(), true)) {
            let names: Vec<_> = given.iter().filter(|(_, given)| *given).map(|(name, _)| *name).collect();
            return Err(format!("choice.binding is {:?}, expected an empty string or one of {names:?}", self.binding));
        }
        if self.width == 0 || self.height == 0 {
            return Err(format!(
                "choice has a picture of {}x{} pixels, expected at least 1 each \
                 way",
                self.width, self.height
            ));
        }
        for (i, trial) in self.trials.iter().enumerate() {
            number(format!("trials[{i}].error"), trial.error)?;
            number(format!("trials[{i}].frame_ms"), trial.frame_ms)?;
        }
        let trials = self.trials.len();
        let indices =
            [("chosen", Some(self.chosen)), ("next_better", self.next_better), ("next_cheaper", self.next_cheaper)];
        match indices.iter().find(|(_, index)| index.is_some_and(|i| i as usize >= trials)) {
            Some((what, index)) => {
                Err(format!("choice.{what} is {}, expected less than the {trials} trials", index.unwrap_or_default()))
            }
            None => Ok(()),
        }
    }
}
