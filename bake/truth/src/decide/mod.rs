//! Search for bake settings: the number of layers, the tile size and the fins that a picture needs.
//!
//! The settings of a [`SettingSpace`] differ in cost and in error against the reference image. [`decide`] searches for
//! the cheapest that is accurate enough, or for the most accurate that is cheap enough, by [`Limits`]. To measure a
//! setting, the package is baked, rendered and compared, which takes seconds. A coarse model therefore suggests which
//! setting to measure next, and each measurement corrects the model. The model only decides which settings can be
//! skipped; the chosen setting was always measured.
//!
//! Among settings with equal frame times, the one with the smallest package is chosen.
//!
//! Times are noisy. Before the choice, all candidates are timed once more, in turns ([`Judge::retime`]). The choice is
//! on the Pareto front: of the measured settings within the limits, none is both more accurate and faster.
//!
//! The caller defines what is measured, and how ([`Judge`]). This module neither renders nor reads files.

mod model;
mod search;

pub use search::{decide, exhaustive};

use pelage_bake::recipe::Recipe;
use pelage_formats as formats;
use pelage_import::BakeError;

/// Limits on a picture's cost and error; `None` means no limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Maximum error against the reference images, as measured by the judge; above 0.
    pub max_error: Option<f64>,
    /// Maximum frame time, milliseconds.
    pub max_frame_ms: Option<f64>,
    /// Maximum size of the package, bytes.
    pub max_bytes: Option<u64>,
}

/// Quantities that can be limited, in the order of the fields of [`SettingFigures`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// Error against the reference images, as measured by the judge.
    Error,
    /// Frame time, milliseconds.
    FrameMs,
    /// Size of the package, bytes.
    Bytes,
}

impl Figure {
    /// All figures.
    pub const ALL: [Self; 3] = [Self::Error, Self::FrameMs, Self::Bytes];

    /// Returns the name of the figure's limit in a manifest.
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "max_error",
            Self::FrameMs => "max_frame_ms",
            Self::Bytes => "max_bytes",
        }
    }

    /// Returns the option of `pelage bake` that limits this figure.
    pub fn option(self) -> &'static str {
        match self {
            Self::Error => "--max-error",
            Self::FrameMs => "--max-frame-ms",
            Self::Bytes => "--max-bytes",
        }
    }
}

impl Limits {
    /// Returns whether there are no limits.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the limit of one figure.
    pub fn of(&self, figure: Figure) -> Option<f64> {
        match figure {
            Figure::Error => self.max_error,
            Figure::FrameMs => self.max_frame_ms,
            Figure::Bytes => self.max_bytes.map(|bytes| bytes as f64),
        }
    }

    /// Returns the largest relative excess of a figure over its limit. 0 or less if all limits are met, −1 without
    /// limits.
    fn excess(&self, figures: [f64; 3]) -> f64 {
        let beyond = |figure: Figure| self.of(figure).map(|limit| figures[figure as usize] / limit.max(1e-12) - 1.0);
        Figure::ALL.into_iter().filter_map(beyond).fold(-1.0, f64::max)
    }

    /// Returns the figures that exceed their limits.
    fn broken(&self, measured: &SettingFigures) -> impl Iterator<Item = Figure> + use<> {
        let (limits, figures) = (*self, measured.figures());
        let beyond = move |f: &Figure| limits.of(*f).is_some_and(|limit| figures[*f as usize] > limit);
        Figure::ALL.into_iter().filter(beyond)
    }

    /// Returns the figure to minimise: the frame time if the error is limited, else the error.
    fn objective(&self) -> Figure {
        if self.max_error.is_some() { Figure::FrameMs } else { Figure::Error }
    }
}

/// Settings that a bake may choose: the recipe keys of the shell method that affect frame time and package size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setting {
    /// `slice.layers`.
    pub layers: u32,
    /// `slice.tile_texels`.
    pub tile_texels: u32,
    /// `fins.enabled`.
    pub fins: bool,
}

impl Setting {
    /// Returns the settings of a recipe.
    pub fn of(recipe: &Recipe) -> Self {
        Self { layers: recipe.slice.layers, tile_texels: recipe.slice.tile_texels, fins: recipe.fins.enabled }
    }

    /// Returns a copy of the recipe with these settings.
    pub fn applied_to(&self, recipe: &Recipe) -> Recipe {
        let mut recipe = recipe.clone();
        recipe.slice.layers = self.layers;
        recipe.slice.tile_texels = self.tile_texels;
        recipe.fins.enabled = self.fins;
        recipe
    }

    /// Returns the settings as arguments of `--set`.
    pub fn set_arguments(&self) -> Vec<String> {
        vec![
            format!("slice.layers={}", self.layers),
            format!("slice.tile_texels={}", self.tile_texels),
            format!("fins.enabled={}", self.fins),
        ]
    }

    /// Returns whether the two settings are equal, or differ only in layers.
    fn differs_only_in_layers(&self, other: &Self) -> bool {
        (self.tile_texels, self.fins) == (other.tile_texels, other.fins)
    }
}

impl std::fmt::Display for Setting {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let fins = if self.fins { "with" } else { "without" };
        write!(f, "{} layers of {1}x{1} texels, {fins} fins", self.layers, self.tile_texels)
    }
}

/// Candidate settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SettingSpace {
    settings: Vec<Setting>,
    start: Setting,
}

/// Layer counts to try; each is 1.3 to 1.5 times the previous one.
pub const LAYERS: [u32; 9] = [4, 6, 8, 12, 16, 24, 32, 48, 64];
/// Tile sizes to try, texels.
pub const TILES: [u32; 5] = [32, 64, 128, 256, 512];

impl SettingSpace {
    /// Returns [`LAYERS`] × [`TILES`] × fins, and the recipe's own setting, from which the search starts. If the recipe
    /// has no fins, no candidate has fins.
    pub fn around(recipe: &Recipe) -> Self {
        let start = Setting::of(recipe);
        let mut settings = vec![start];
        for fins in [true, false] {
            for tile_texels in TILES {
                settings.extend(LAYERS.map(|layers| Setting { layers, tile_texels, fins }));
            }
        }
        settings.retain(|s| start.fins || !s.fins);
        let mut distinct: Vec<Setting> = Vec::new();
        for setting in settings {
            if !distinct.contains(&setting) {
                distinct.push(setting);
            }
        }
        Self { settings: distinct, start }
    }

    /// Keeps the settings with at most `layers` layers, rounded up to the next entry of [`LAYERS`]. Always keeps the
    /// start.
    pub fn up_to(mut self, layers: u32) -> Self {
        let most = LAYERS.into_iter().find(|tried| *tried >= layers).unwrap_or(u32::MAX);
        self.settings.retain(|setting| setting.layers <= most || *setting == self.start);
        self
    }

    /// Returns all settings, the start first.
    pub fn settings(&self) -> &[Setting] {
        &self.settings
    }
}

/// Measured figures of a setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SettingFigures {
    /// Error against the reference images, 0 for none; for `pelage bake` it is [`super::likeness`].
    pub error: f64,
    /// Frame time.
    pub frame: FrameTime,
    /// Size of the package, bytes.
    pub bytes: u64,
}

impl SettingFigures {
    /// Returns the figures in the order of [`Figure::ALL`].
    fn figures(&self) -> [f64; 3] {
        [self.error, self.frame.ms, self.bytes as f64]
    }
}

/// Frame time, milliseconds, with the spread of its measurements.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameTime {
    /// Median, used in comparisons.
    pub ms: f64,
    /// Lower quartile.
    pub low: f64,
    /// Upper quartile.
    pub high: f64,
}

impl FrameTime {
    /// Returns a time whose quartiles equal its median.
    pub const fn exactly(ms: f64) -> Self {
        Self { ms, low: ms, high: ms }
    }

    /// Computes median and quartiles of measurements, milliseconds; 0 if there are none.
    pub fn of(mut samples: Vec<f64>) -> Self {
        samples.sort_by(f64::total_cmp);
        let last = samples.len().saturating_sub(1);
        let at = |quarters: usize| samples.get((quarters * last + 2) / 4).copied().unwrap_or_default();
        Self { ms: at(2), low: at(1), high: at(3) }
    }
}

/// Backend that bakes, renders and compares settings.
pub trait Judge {
    /// Error of a measurement.
    type Error;

    /// Measures one setting.
    ///
    /// The judge defines the errors; an error ends the search.
    fn measure(&mut self, setting: &Setting) -> Result<SettingFigures, Self::Error>;

    /// Times the frames of several settings once more, in turns, so that other load on the machine affects all of them
    /// alike. Returns one time for each of `settings`, in their order.
    ///
    /// Fails with the errors of [`Self::measure`].
    fn retime(&mut self, settings: &[Setting]) -> Result<Vec<FrameTime>, Self::Error>;
}

/// A measured setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// Setting that was measured.
    pub setting: Setting,
    /// Result of the measurement.
    pub measured: SettingFigures,
}

/// Result of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// All measurements in order; the first is the recipe's own setting.
    pub trials: Vec<Trial>,
    /// Index into `trials` of the best setting that meets all limits. If no setting meets them, index of the nearest to
    /// them.
    pub chosen: usize,
    /// Whether the chosen setting meets all limits.
    pub meets: bool,
    /// Index into `trials` of the next more accurate setting: the fastest whose error is smaller than the chosen
    /// setting's by more than a hundredth. Settings that are also faster than the chosen one are excluded.
    pub next_better: Option<usize>,
    /// Index into `trials` of the next cheaper setting: the most accurate that is cheaper than the chosen one. Settings
    /// that are also more accurate than the chosen one are excluded.
    pub next_cheaper: Option<usize>,
    /// Binding limit: without it, a more accurate setting would have been chosen, or a cheaper one if the error is
    /// limited. Of all such settings, the one nearest to the limits exceeds this limit. `None` if no such setting was
    /// found.
    pub binding: Option<Figure>,
}

impl Decision {
    /// Returns the chosen setting with its figures.
    pub fn chosen(&self) -> &Trial {
        &self.trials[self.chosen]
    }

    /// Returns the record of the search for the manifest of the package.
    ///
    /// * `limits`: the limits of the search
    /// * `evidence`: the measurement method; trials, choice and limits are filled in
    pub fn evidence(&self, limits: &Limits, evidence: formats::Choice) -> formats::Choice {
        let trial = |t: &Trial| formats::Trial {
            settings: t.setting.set_arguments(),
            error: Some(t.measured.error),
            frame_ms: Some(t.measured.frame.ms),
            bytes: t.measured.bytes,
            predicted: false,
        };
        let index = |i: usize| i as u32;
        formats::Choice {
            limits: formats::ChoiceLimits {
                max_error: limits.max_error,
                max_frame_ms: limits.max_frame_ms,
                max_bytes: limits.max_bytes,
            },
            binding: self.binding.map_or_else(String::new, |figure| figure.name().into()),
            trials: self.trials.iter().map(trial).collect(),
            chosen: index(self.chosen),
            next_better: self.next_better.map(index),
            next_cheaper: self.next_cheaper.map(index),
            ..evidence
        }
    }
}

impl Limits {
    /// Checks that the limits are positive numbers.
    ///
    /// Fails with [`BakeError::Params`] if one is not.
    pub fn validate(&self) -> Result<(), BakeError> {
        for figure in Figure::ALL {
            if let Some(limit) = self.of(figure).filter(|limit| !(limit.is_finite() && *limit > 0.0)) {
                let reason = format!("found {limit}, expected a number above 0");
                return Err(BakeError::Params { what: figure.option(), reason });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
