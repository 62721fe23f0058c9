//! `pelage bake` with limits: the search of `pelage_bake::judge::decide` over pictures of this machine's adapter.

use super::chart::measured_on;
use super::exit::Failure;
use super::output::{Output, human_bytes};
use super::shell_judge::{ShellJudge, Source};
use pelage_bake::BakeError;
use pelage_bake::judge::decide::{self, Decision, Judge, Limits, Measured, Setting, Space, Trial};
use pelage_bake::recipe::Recipe;
use pelage_formats::Choice;
use pelage_stage::Gpu;
use std::fmt::Write as _;

/// What the evidence may add to a package, bytes: part of every measured size, so that a package with it keeps its limit.
const EVIDENCE_BYTES: u64 = 16 << 10;

/// What was chosen, and why.
pub struct Chosen {
    /// The recipe with the chosen setting.
    pub recipe: Recipe,
    /// For the manifest.
    pub choice: Choice,
    /// For people.
    pub text: String,
}

/// Chooses the setting that `limits` ask for.
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
    let adapter = measured_on(&gpu.info.name);
    let judge = ShellJudge::new(source, recipe, &gpu, &mut |what| output.progress(what))?;
    let space = Space::around(recipe);
    let mut counted = Counted { judge: &judge, recipe, output };
    let decision = if exhaustive {
        decide::exhaustive(&space, limits, &mut counted)?
    } else {
        decide::decide(&space, limits, &mut counted)?
    };
    let text = describe(&decision, limits, &adapter, space.settings().len());
    if !decision.meets {
        return Err(BakeError::Input { file: file.into(), place: asked(limits), reason: text }.into());
    }
    let evidence = Choice {
        adapter: adapter.clone(),
        width: recipe.judge.width,
        height: recipe.judge.height,
        samples: recipe.judge.samples,
        views: judge.view_words(),
        ..Choice::default()
    };
    Ok(Chosen {
        recipe: decision.chosen().setting.applied_to(recipe),
        choice: decision.evidence(limits, evidence),
        text,
    })
}

/// The judge with a progress display.
struct Counted<'a, 'o> {
    judge: &'a ShellJudge<'a>,
    recipe: &'a Recipe,
    output: &'o mut Output,
}

impl Judge for Counted<'_, '_> {
    type Error = Failure;

    fn measure(&mut self, setting: &Setting) -> Result<Measured, Failure> {
        self.output.progress(&setting.to_string());
        let m = self.judge.measure(&setting.applied_to(self.recipe))?;
        Ok(Measured { error: m.flip, frame_ms: m.frame_ms, bytes: m.package_bytes + EVIDENCE_BYTES })
    }
}

/// The limits as they were given.
fn asked(limits: &Limits) -> String {
    let words = decide::Figure::ALL.iter().filter_map(|f| Some(format!("{} {}", f.option(), limits.of(*f)?)));
    words.collect::<Vec<_>>().join(" ")
}

fn describe(decision: &Decision, limits: &Limits, adapter: &str, settings: usize) -> String {
    let trial = |t: &Trial| {
        let m = &t.measured;
        let size = human_bytes(m.bytes);
        format!("{}: error {:.4}, frame {:.1} ms, at most {size}", t.setting, m.error, m.frame_ms)
    };
    let mut text = String::new();
    let mut line = |args: std::fmt::Arguments<'_>| {
        let _ = writeln!(text, "{args}");
    };
    let word = if decision.meets { "chosen" } else { "found no setting within the limits, nearest" };
    line(format_args!("{word}: {}", trial(decision.chosen())));
    line(format_args!("  (--set {})", decision.chosen().setting.words().join(" --set ")));
    match decision.binding {
        Some(figure) if decision.meets => line(format_args!("{} binds", figure.option())),
        Some(figure) => line(format_args!("{} cannot be met", figure.option())),
        None => line(format_args!("no limit binds: what lies beyond them is no gain")),
    }
    let neighbours = [("next better", decision.next_better), ("next cheaper", decision.next_cheaper)];
    for (what, index) in neighbours {
        match index.map(|i| &decision.trials[i]) {
            Some(t) => line(format_args!("{what}: {}", trial(t))),
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
