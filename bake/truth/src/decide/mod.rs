//! A bake that decides: which layers, tile and fins a picture needs, and no more.
//!
//! The settings of a [`Space`] differ in what they cost and in how far their picture is from the true one. [`decide`] looks for the cheapest that
//! is true enough, or for the truest that is cheap enough, by [`Limits`]. Measuring a setting means baking, drawing and comparing it, which takes
//! seconds; so a coarse model says which setting to measure next, and each measurement corrects the model. What is chosen was always
//! measured: the model only decides what need not be.
//!
//! Frames that take as long as each other are told apart by the size of their packages.
//!
//! Times are noisy. What may be chosen is timed once more, in turns ([`Judge::time_again`]), before the choice; and what is chosen is on the front: of
//! the measured settings within the limits none is both truer and faster.
//!
//! What is measured, and how, is the caller's matter ([`Judge`]): this module neither draws nor reads files.

mod model;
mod search;

pub use search::{decide, exhaustive};

use pelage_bake::recipe::Recipe;
use pelage_formats as formats;
use pelage_import::BakeError;

/// What a picture may cost and how far it may be from the truth; `None` where it does not matter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Largest error against the true pictures, as the judge measures it; above 0.
    pub max_error: Option<f64>,
    /// Longest frame, milliseconds.
    pub max_frame_ms: Option<f64>,
    /// Largest package, bytes.
    pub max_bytes: Option<u64>,
}

/// What a limit is about. The order is that of [`Measured`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// The judge's error against the true pictures.
    Error,
    /// Milliseconds of a frame.
    FrameMs,
    /// Bytes of the package.
    Bytes,
}

impl Figure {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Error, Self::FrameMs, Self::Bytes];

    /// Its limit's name in a manifest.
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "max_error",
            Self::FrameMs => "max_frame_ms",
            Self::Bytes => "max_bytes",
        }
    }

    /// The option of `pelage bake` that limits it.
    pub fn option(self) -> &'static str {
        match self {
            Self::Error => "--max-error",
            Self::FrameMs => "--max-frame-ms",
            Self::Bytes => "--max-bytes",
        }
    }
}

impl Limits {
    /// Whether nothing is limited.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The limit of one figure.
    pub fn of(&self, figure: Figure) -> Option<f64> {
        match figure {
            Figure::Error => self.max_error,
            Figure::FrameMs => self.max_frame_ms,
            Figure::Bytes => self.max_bytes.map(|bytes| bytes as f64),
        }
    }

    /// How far the worst figure is beyond its limit, as a share of the limit; 0 and less where all are met. Without any limit −1.
    fn excess(&self, figures: [f64; 3]) -> f64 {
        let beyond = |figure: Figure| self.of(figure).map(|limit| figures[figure as usize] / limit.max(1e-12) - 1.0);
        Figure::ALL.into_iter().filter_map(beyond).fold(-1.0, f64::max)
    }

    /// The figures that are beyond their limits.
    fn broken(&self, measured: &Measured) -> impl Iterator<Item = Figure> + use<> {
        let (limits, figures) = (*self, measured.figures());
        let beyond = move |f: &Figure| limits.of(*f).is_some_and(|limit| figures[*f as usize] > limit);
        Figure::ALL.into_iter().filter(beyond)
    }

    /// What is made as small as can be: the frame where the error has a limit, else the error.
    fn objective(&self) -> Figure {
        if self.max_error.is_some() { Figure::FrameMs } else { Figure::Error }
    }
}

/// What a bake may choose: the knobs of the shell method that cost frame time and bytes.
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
    /// What a recipe says.
    pub fn of(recipe: &Recipe) -> Self {
        Self { layers: recipe.slice.layers, tile_texels: recipe.slice.tile_texels, fins: recipe.fins.enabled }
    }

    /// The recipe with these values.
    pub fn applied_to(&self, recipe: &Recipe) -> Recipe {
        let mut recipe = recipe.clone();
        recipe.slice.layers = self.layers;
        recipe.slice.tile_texels = self.tile_texels;
        recipe.fins.enabled = self.fins;
        recipe
    }

    /// The same as arguments of `--set`.
    pub fn words(&self) -> Vec<String> {
        vec![
            format!("slice.layers={}", self.layers),
            format!("slice.tile_texels={}", self.tile_texels),
            format!("fins.enabled={}", self.fins),
        ]
    }

    /// Whether both differ in nothing but layers.
    fn is_beside(&self, other: &Self) -> bool {
        (self.tile_texels, self.fins) == (other.tile_texels, other.fins)
    }
}

impl std::fmt::Display for Setting {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let fins = if self.fins { "with" } else { "without" };
        write!(f, "{} layers of {1}x{1} texels, {fins} fins", self.layers, self.tile_texels)
    }
}

/// The settings to choose from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Space {
    settings: Vec<Setting>,
    start: Setting,
}

/// Layers that are tried: each step is about a third more.
pub const LAYERS: [u32; 9] = [4, 6, 8, 12, 16, 24, 32, 48, 64];
/// Tiles that are tried, texels.
pub const TILES: [u32; 5] = [32, 64, 128, 256, 512];

impl Space {
    /// [`LAYERS`] × [`TILES`] × fins, and the recipe's own setting, from which the search starts. A recipe without fins gets none.
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

    /// Those of at most so many layers, and the next finer ones; the start in any case.
    pub fn up_to(mut self, layers: u32) -> Self {
        let most = LAYERS.into_iter().find(|tried| *tried >= layers).unwrap_or(u32::MAX);
        self.settings.retain(|setting| setting.layers <= most || *setting == self.start);
        self
    }

    /// All of them, the start first.
    pub fn settings(&self) -> &[Setting] {
        &self.settings
    }
}

/// What a setting turned out to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// How far its pictures are from the true ones, 0 for none; of `pelage bake` it is [`super::likeness`].
    pub error: f64,
    /// How long a frame takes.
    pub frame: FrameTime,
    /// Size of the package, bytes.
    pub bytes: u64,
}

impl Measured {
    /// In the order of [`Figure::ALL`].
    fn figures(&self) -> [f64; 3] {
        [self.error, self.frame.ms, self.bytes as f64]
    }
}

/// Milliseconds of a frame, and how far measurements of it lie apart.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameTime {
    /// The median, which counts.
    pub ms: f64,
    /// Lower quartile.
    pub low: f64,
    /// Upper quartile.
    pub high: f64,
}

impl FrameTime {
    /// A time that is known without a spread.
    pub const fn exactly(ms: f64) -> Self {
        Self { ms, low: ms, high: ms }
    }

    /// Median and quartiles of measurements, milliseconds; 0 without any.
    pub fn of(mut samples: Vec<f64>) -> Self {
        samples.sort_by(f64::total_cmp);
        let last = samples.len().saturating_sub(1);
        let at = |quarters: usize| samples.get((quarters * last + 2) / 4).copied().unwrap_or_default();
        Self { ms: at(2), low: at(1), high: at(3) }
    }
}

/// Bakes, draws and compares settings.
pub trait Judge {
    /// What goes wrong while it does.
    type Error;

    /// Measures one setting.
    ///
    /// # Errors
    ///
    /// As the judge says; the search ends with it.
    fn measure(&mut self, setting: &Setting) -> Result<Measured, Self::Error>;

    /// Times the frames of settings once more, in turns, so that whatever else the machine does falls on all of them alike: one time for each of
    /// `settings`, in their order.
    ///
    /// # Errors
    ///
    /// As [`Self::measure`].
    fn time_again(&mut self, settings: &[Setting]) -> Result<Vec<FrameTime>, Self::Error>;
}

/// A setting that was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// What.
    pub setting: Setting,
    /// With what result.
    pub measured: Measured,
}

/// The outcome of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// All measurements, in their order; the first is the recipe's own setting.
    pub trials: Vec<Trial>,
    /// The best that meets all limits, or the nearest where none does: index into `trials`.
    pub chosen: usize,
    /// Whether it meets all limits.
    pub meets: bool,
    /// The cheapest of the measured settings that are better than the chosen one by more than a hundredth of its error; none that is faster too.
    pub next_better: Option<usize>,
    /// The best of the measured settings that are cheaper; none that is better too.
    pub next_cheaper: Option<usize>,
    /// The limit without which another setting had been chosen: the one that the nearest better (or, where the error is limited, cheaper) setting
    /// breaks. `None` where nothing was found beyond the limits that would be better or cheaper.
    pub binding: Option<Figure>,
}

impl Decision {
    /// The chosen setting with its figures.
    pub fn chosen(&self) -> &Trial {
        &self.trials[self.chosen]
    }

    /// What was measured, for the manifest of the package.
    ///
    /// * `limits`: what was asked
    /// * `evidence`: how it was measured; its trials, choice and limits are filled in
    pub fn evidence(&self, limits: &Limits, evidence: formats::Choice) -> formats::Choice {
        let trial = |t: &Trial| formats::Trial {
            settings: t.setting.words(),
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
    /// Checks that limits can be met at all.
    ///
    /// # Errors
    ///
    /// [`BakeError::Params`] for limits that are not positive numbers.
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
