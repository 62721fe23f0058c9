//! `pelage bake` with limits: the search of `pelage_truth::decide` over pictures of this machine's adapter.

use super::exit::Failure;
use super::machine::measured_on;
use super::output::{Output, human_bytes};
use super::shell_judge::{ShellJudge, Source};
use pelage_bake::recipe::Recipe;
use pelage_formats::Choice;
use pelage_import::BakeError;
use pelage_stage::{Gpu, LookDetail};
use pelage_truth::decide;
use pelage_truth::decide::{Decision, Figure, FrameTime, Judge, Limits, Measured, Setting, Space, Trial};
use pelage_truth::likeness::Likeness;
use serde::Serialize;
use std::fmt::Write as _;

/// What the evidence may add to a package, bytes: part of every measured size, so that a package with it keeps its limit.
const EVIDENCE_BYTES: u64 = 16 << 10;

/// Figures of a trial.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Judged {
    /// Mean FLIP against the true pictures, 0 to 1.
    pub flip: f64,
    /// Mean absolute difference of coverage within the height of the fur of the true outline, 0 to 1.
    pub outline: f64,
    /// Ratio of local contrast to the contrast of the true pictures, above 0.
    pub contrast: f64,
    /// Lower and upper quartile of the frame time, milliseconds; equal if the frame was timed once.
    pub frame_ms_quartiles: [f64; 2],
}

/// What was chosen, and why.
pub struct Chosen {
    /// The recipe with the chosen setting.
    pub recipe: Recipe,
    /// For the manifest.
    pub choice: Choice,
    /// What the package does not keep of the trials, for scripts: one of each, in their order.
    pub judged: Vec<Judged>,
    /// For people.
    pub text: String,
}

/// Chooses the setting that `limits` ask for. Where their bytes hold none with single strands, it is chosen among those without.
///
/// # Errors
///
/// [`BakeError::Input`], exit code 3, where no setting meets them; it names the nearest.
pub fn choose(
    file: &str,
    source: Source<'_>,
    recipe: &Recipe,
    limits: &Limits,
    exhaustive: bool,
    output: &mut Output,
) -> Result<Chosen, Failure> {
    limits.validate()?;
    recipe.validate()?;
    let gpu = Gpu::open()?;
    // As applications draw by default: a setting with more layers than the fur has pixels costs bytes alone.
    let judge = ShellJudge::new(source, recipe, &gpu, LookDetail::Auto, &mut |what| output.progress(what))?;
    let adapter = measured_on(&gpu.info.name);
    // The true pictures are the same with single strands and without.
    let of = |recipe: &Recipe, output: &mut Output| search(&judge, &adapter, recipe, limits, exhaustive, output);
    let found = of(recipe, output)?;
    if found.decision.meets || found.decision.binding != Some(Figure::Bytes) || !recipe.strands.enabled {
        return found.chosen(file, limits, false);
    }
    let mut without = recipe.clone();
    without.strands.enabled = false;
    of(&without, output)?.chosen(file, limits, true)
}

/// What a search found.
struct Found {
    recipe: Recipe,
    decision: Decision,
    /// One of each trial.
    likenesses: Vec<Likeness>,
    /// Of the evidence, what does not depend on the trials.
    evidence: Choice,
    /// Of all settings there are.
    settings: usize,
}

fn search(
    judge: &ShellJudge<'_>,
    adapter: &str,
    recipe: &Recipe,
    limits: &Limits,
    exhaustive: bool,
    output: &mut Output,
) -> Result<Found, Failure> {
    let space = Space::around(recipe).up_to(judge.most_layers(recipe));
    let mut counted = Counted { judge, recipe, output, likenesses: Vec::new() };
    let decision = if exhaustive {
        decide::exhaustive(&space, limits, &mut counted)?
    } else {
        decide::decide(&space, limits, &mut counted)?
    };
    let evidence = Choice {
        adapter: adapter.to_owned(),
        width: recipe.judge.width,
        height: recipe.judge.height,
        samples: recipe.judge.samples,
        views: judge.view_words(),
        ..Choice::default()
    };
    // Trials are in the order in which they were measured.
    let likenesses = counted.likenesses;
    Ok(Found { recipe: recipe.clone(), decision, likenesses, evidence, settings: space.settings().len() })
}

impl Found {
    /// What becomes of the bake; `left_out`: it has no strands because of the limits.
    fn chosen(self, file: &str, limits: &Limits, left_out: bool) -> Result<Chosen, Failure> {
        let Self { recipe, decision, likenesses, evidence, settings } = self;
        let mut text = describe(&decision, &likenesses, limits, &evidence.adapter, settings);
        if left_out {
            text.push_str(
                "\nwithout single strands (--set strands.enabled=false): with them --max-bytes cannot be met",
            );
        }
        if !decision.meets {
            return Err(BakeError::Input { file: file.into(), place: asked(limits), reason: text }.into());
        }
        Ok(Chosen {
            recipe: decision.chosen().setting.applied_to(&recipe),
            choice: decision.evidence(limits, evidence),
            judged: decision.trials.iter().zip(&likenesses).map(judged).collect(),
            text,
        })
    }
}

/// The judge with a progress display.
struct Counted<'a, 'o> {
    judge: &'a ShellJudge<'a>,
    recipe: &'a Recipe,
    output: &'o mut Output,
    /// Of what was measured, in its order.
    likenesses: Vec<Likeness>,
}

impl Judge for Counted<'_, '_> {
    type Error = Failure;

    fn measure(&mut self, setting: &Setting) -> Result<Measured, Failure> {
        self.output.progress(&setting.to_string());
        let (m, likeness) = self.judge.measure(&setting.applied_to(self.recipe))?;
        self.likenesses.push(likeness);
        let frame = FrameTime::exactly(m.frame_ms);
        Ok(Measured { error: likeness.error, frame, bytes: m.package_bytes + EVIDENCE_BYTES })
    }

    fn time_again(&mut self, settings: &[Setting]) -> Result<Vec<FrameTime>, Failure> {
        self.output.progress(&format!("timing {} settings again", settings.len()));
        let recipes: Vec<Recipe> = settings.iter().map(|setting| setting.applied_to(self.recipe)).collect();
        self.judge.time_in_turns(&recipes)
    }
}

/// Returns the figures of a trial that the package does not keep.
fn judged((trial, likeness): (&Trial, &Likeness)) -> Judged {
    let FrameTime { low, high, .. } = trial.measured.frame;
    let Likeness { flip, outline, contrast, .. } = *likeness;
    Judged { flip, outline, contrast, frame_ms_quartiles: [low, high] }
}

/// The limits as they were given.
fn asked(limits: &Limits) -> String {
    let words = Figure::ALL.iter().filter_map(|f| Some(format!("{} {}", f.option(), limits.of(*f)?)));
    words.collect::<Vec<_>>().join(" ")
}

fn describe(decision: &Decision, likenesses: &[Likeness], limits: &Limits, adapter: &str, settings: usize) -> String {
    let trial = |i: usize| {
        let (t, likeness) = (&decision.trials[i], likenesses.get(i).copied().unwrap_or(Likeness::SAME));
        let (m, size) = (&t.measured, human_bytes(t.measured.bytes));
        let FrameTime { ms, low, high } = m.frame;
        let spread = if high > low { format!(" ({low:.1} to {high:.1})") } else { String::new() };
        format!(
            "{}: error {:.4} (FLIP {:.4}, outline off by {:.3}, contrast {:.2} of the truth's), frame {ms:.1} ms{spread}, at most {size}",
            t.setting, m.error, likeness.flip, likeness.outline, likeness.contrast
        )
    };
    let mut text = String::new();
    let mut line = |args: std::fmt::Arguments<'_>| {
        let _ = writeln!(text, "{args}");
    };
    let word = if decision.meets { "chosen" } else { "found no setting within the limits, nearest" };
    line(format_args!("{word}: {}", trial(decision.chosen)));
    line(format_args!("  (--set {})", decision.chosen().setting.words().join(" --set ")));
    match decision.binding {
        Some(figure) if decision.meets => line(format_args!("{} binds", figure.option())),
        Some(figure) => line(format_args!("{} cannot be met", figure.option())),
        None => line(format_args!("no limit binds: what lies beyond them is no gain")),
    }
    let neighbours = [("next better", decision.next_better), ("next cheaper", decision.next_cheaper)];
    for (what, index) in neighbours {
        match index {
            Some(i) => line(format_args!("{what}: {}", trial(i))),
            None => line(format_args!("{what}: none")),
        }
    }
    line(format_args!(
        "measured {} of {settings} settings on {}; asked: {}",
        decision.trials.len(),
        adapter,
        asked(limits)
    ));
    text.trim_end().to_owned()
}
