//! `pelage bake` with limits: runs the search of `pelage_truth::decide` on pictures that this machine's adapter draws.

use super::exit::Failure;
use super::machine::measured_on;
use super::output::{Output, human_bytes};
use super::shell_judge::{Baker, ShellJudge};
use pelage_bake::recipe::Recipe;
use pelage_formats::Choice;
use pelage_import::BakeError;
use pelage_stage::{Gpu, LookDetail};
use pelage_truth::decide::{
    self, Decision, Figure, FrameTime, Judge, Limits, Setting, SettingFigures, SettingSpace, Trial,
};
use pelage_truth::likeness::Likeness;
use serde::Serialize;
use std::fmt::Write as _;

/// Bytes reserved in a package for the evidence of the choice. They are added to every measured size, so that the limit
/// also holds with the evidence.
const EVIDENCE_BYTES: u64 = 16 << 10;

/// Figures of a trial.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TrialFigures {
    /// Mean FLIP against the reference images, 0 to 1.
    pub flip: f64,
    /// Mean absolute difference of coverage, within one fur height of the outline in the reference images, 0 to 1.
    pub outline: f64,
    /// Local contrast divided by that of the reference images, above 0.
    pub contrast: f64,
    /// Lower and upper quartile of the frame time, milliseconds; equal if the frame was timed once.
    pub frame_ms_quartiles: [f64; 2],
}

/// Chosen setting and its explanation.
pub struct ChosenSetting {
    /// The recipe with the chosen setting.
    pub recipe: Recipe,
    /// Evidence of the choice, for the manifest.
    pub choice: Choice,
    /// Figures of each trial that the package does not store, in the order of the trials.
    pub judged: Vec<TrialFigures>,
    /// Explanation for people.
    pub text: String,
}

/// Chooses the setting that meets `limits`. If the size limit excludes all settings with individual strands, searches
/// those without.
///
/// Fails with [`BakeError::Input`], exit code 3, if no setting meets the limits; the message names the nearest.
pub fn choose(
    file: &str,
    baker: Baker<'_>,
    recipe: &Recipe,
    limits: &Limits,
    exhaustive: bool,
    output: &mut Output,
) -> Result<ChosenSetting, Failure> {
    limits.validate()?;
    recipe.validate()?;
    let gpu = Gpu::open()?;
    // The pictures use automatic detail, the default of applications. Layers beyond the fur's height in pixels then
    // only increase the size.
    let judge = ShellJudge::new(baker, recipe, &gpu, LookDetail::Auto, &mut |what| output.progress(what))?;
    let adapter = measured_on(&gpu.info.name);
    // The reference images do not depend on individual strands, so the same judge is used for both searches.
    let of = |recipe: &Recipe, output: &mut Output| search(&judge, &adapter, recipe, limits, exhaustive, output);
    let found = of(recipe, output)?;
    if found.decision.meets || found.decision.binding != Some(Figure::Bytes) || !recipe.strands.enabled {
        return found.chosen(file, limits, false);
    }
    let mut without = recipe.clone();
    without.strands.enabled = false;
    of(&without, output)?.chosen(file, limits, true)
}

/// Result of a search.
struct SearchResult {
    recipe: Recipe,
    decision: Decision,
    /// Comparison of each trial with the reference images.
    likenesses: Vec<Likeness>,
    /// Evidence for the manifest, without the trials.
    evidence: Choice,
    /// Number of settings in the search space.
    settings: usize,
}

fn search(
    judge: &ShellJudge<'_>,
    adapter: &str,
    recipe: &Recipe,
    limits: &Limits,
    exhaustive: bool,
    output: &mut Output,
) -> Result<SearchResult, Failure> {
    let space = SettingSpace::around(recipe).up_to(judge.most_layers(recipe));
    let mut counted = CountingJudge { judge, recipe, output, likenesses: Vec::new() };
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
    // Comparisons are in the order of the trials.
    let likenesses = counted.likenesses;
    Ok(SearchResult { recipe: recipe.clone(), decision, likenesses, evidence, settings: space.settings().len() })
}

impl SearchResult {
    /// Converts the result for the bake. `left_out`: individual strands were disabled to meet the limits.
    fn chosen(self, file: &str, limits: &Limits, left_out: bool) -> Result<ChosenSetting, Failure> {
        let Self { recipe, decision, likenesses, evidence, settings } = self;
        let mut text = describe(&decision, &likenesses, limits, &evidence.adapter, settings);
        if left_out {
            text.push_str(
                "\nsingle strands were left out (--set strands.enabled=false): with them --max-bytes cannot be met",
            );
        }
        if !decision.meets {
            return Err(BakeError::Input { file: file.into(), place: asked(limits), reason: text }.into());
        }
        Ok(ChosenSetting {
            recipe: decision.chosen().setting.applied_to(&recipe),
            choice: decision.evidence(limits, evidence),
            judged: decision.trials.iter().zip(&likenesses).map(judged).collect(),
            text,
        })
    }
}

/// Judge that counts trials and shows the progress.
struct CountingJudge<'a, 'o> {
    judge: &'a ShellJudge<'a>,
    recipe: &'a Recipe,
    output: &'o mut Output,
    /// Comparison of each trial, in the order of measurement.
    likenesses: Vec<Likeness>,
}

impl Judge for CountingJudge<'_, '_> {
    type Error = Failure;

    fn measure(&mut self, setting: &Setting) -> Result<SettingFigures, Failure> {
        self.output.progress(&setting.to_string());
        let (m, likeness) = self.judge.measure(&setting.applied_to(self.recipe))?;
        self.likenesses.push(likeness);
        let frame = FrameTime::exactly(m.frame_ms);
        Ok(SettingFigures { error: likeness.error, frame, bytes: m.package_bytes + EVIDENCE_BYTES })
    }

    fn retime(&mut self, settings: &[Setting]) -> Result<Vec<FrameTime>, Failure> {
        self.output.progress(&format!("timing {} settings again", settings.len()));
        let recipes: Vec<Recipe> = settings.iter().map(|setting| setting.applied_to(self.recipe)).collect();
        self.judge.time_in_turns(&recipes)
    }
}

/// Returns the figures of a trial that the package does not store.
fn judged((trial, likeness): (&Trial, &Likeness)) -> TrialFigures {
    let FrameTime { low, high, .. } = trial.measured.frame;
    let Likeness { flip, outline, contrast, .. } = *likeness;
    TrialFigures { flip, outline, contrast, frame_ms_quartiles: [low, high] }
}

/// Returns the limits as written on the command line.
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
            "{}: error {:.4} (FLIP {:.4}, outline off by {:.3}, contrast {:.2} of the reference's), \
             frame {ms:.1} ms{spread}, at most {size}",
            t.setting, m.error, likeness.flip, likeness.outline, likeness.contrast
        )
    };
    let mut text = String::new();
    let mut line = |args: std::fmt::Arguments<'_>| {
        let _ = writeln!(text, "{args}");
    };
    let word = if decision.meets { "chosen" } else { "found no setting within the limits, nearest" };
    line(format_args!("{word}: {}", trial(decision.chosen)));
    line(format_args!("  (--set {})", decision.chosen().setting.set_arguments().join(" --set ")));
    match decision.binding {
        Some(figure) if decision.meets => line(format_args!("{} binds", figure.option())),
        Some(figure) => line(format_args!("{} cannot be met", figure.option())),
        None => line(format_args!("no limit binds: no better or cheaper setting was found beyond the limits")),
    }
    let neighbours = [("next better", decision.next_better), ("next cheaper", decision.next_cheaper)];
    for (what, index) in neighbours {
        match index {
            Some(i) => line(format_args!("{what}: {}", trial(i))),
            None => line(format_args!("{what}: none")),
        }
    }
    line(format_args!(
        "measured {} of {settings} settings on {}; limits: {}",
        decision.trials.len(),
        adapter,
        asked(limits)
    ));
    text.trim_end().to_owned()
}
