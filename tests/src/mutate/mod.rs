//! Mutation run: runs the real binary on tens of thousands of damaged inputs. Each is judged by exit code, output and
//! files left behind.
//!
//! A case depends only on the seed, its kind and its number. Each of these is a fault of a command:
//!
//! * It panics, is ended by a signal, or exits with a code other than 0, 1, 2, 3 and 7.
//! * It takes longer than [`judge::SECONDS`], also when run alone, or holds more memory than [`judge::BYTES`].
//! * It exits with 0, but its output is missing or is a package that `pelage validate` rejects.
//! * It exits with another code and leaves something behind, prints no message, or, with code 3, names no file.
//!
//! Each of these is a fault that a package reveals:
//!
//! * The formats crate panics on the package, or cannot write it again although it is valid.
//! * `validate --json` finds nothing that prevents drawing, but the runtime does not load the package; or the reverse.
//! * `unpack` succeeds, but `pack` does not make the same bytes from the result.

pub mod assemble;
pub mod bases;
pub mod case;
pub mod change;
mod child;
mod compressed_models;
mod folders;
mod guides;
mod hair_files;
mod images;
pub mod judge;
mod models;
mod packages;
mod random;
mod settings_files;

use anyhow::Context as _;
use bases::Bases;
use case::Case;
use judge::{CaseRunner, Loader, Outcome};
use random::Random;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Kind of input.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Name for `--only`.
    pub name: &'static str,
    /// Percentage of all cases.
    pub share: u64,
    make: fn(&Bases, u64, &mut Random) -> Case,
}

/// All kinds.
pub const KINDS: [Kind; 7] = [
    Kind { name: "packages", share: 36, make: packages::case },
    Kind { name: "folders", share: 18, make: folders::case },
    Kind { name: "models", share: 18, make: models::case },
    Kind { name: "packed", share: 6, make: compressed_models::case },
    Kind { name: "texts", share: 9, make: settings_files::case },
    Kind { name: "images", share: 7, make: images::case },
    Kind { name: "guides", share: 6, make: guides::case },
];

/// Cases to run, and the number to run at once.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Index of the kind and number of each case.
    pub cases: Vec<(usize, u64)>,
    /// Number of cases to run at once.
    pub jobs: usize,
}

impl Plan {
    /// Plans a total of `cases` cases, divided among the kinds by their percentages.
    pub fn all(seed: u64, cases: u64, jobs: usize) -> Self {
        let of_kind = |(kind, k): (usize, &Kind)| (0..(cases * k.share).div_ceil(100)).map(move |i| (kind, i));
        Self { seed, cases: KINDS.iter().enumerate().flat_map(of_kind).collect(), jobs }
    }

    /// Plans the given cases of one kind.
    pub fn only(seed: u64, kind: usize, cases: std::ops::Range<u64>, jobs: usize) -> Self {
        Self { seed, cases: cases.map(|i| (kind, i)).collect(), jobs }
    }
}

/// Results of all cases of a kind.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Number of cases run.
    pub cases: u64,
    /// Number of runs for each command and exit code; the keys are like `bake 3`.
    pub exits: BTreeMap<String, u64>,
    /// Cases that reveal faults: number, description, and the faults.
    pub faults: Vec<(u64, String, Vec<String>)>,
    /// Duration of the longest command, seconds.
    pub seconds: f64,
    /// Peak memory of any command, bytes.
    pub peak: u64,
}

impl Tally {
    fn add(&mut self, index: u64, what: &str, outcome: &Outcome) {
        self.cases += 1;
        for (exit, count) in &outcome.exits {
            *self.exits.entry(exit.clone()).or_default() += count;
        }
        self.seconds = self.seconds.max(outcome.seconds);
        self.peak = self.peak.max(outcome.peak);
        if !outcome.faults.is_empty() {
            self.faults.push((index, what.to_owned(), outcome.faults.clone()));
        }
    }
}

/// Results of a run.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Results per kind, in the order of [`KINDS`].
    pub tallies: [Tally; KINDS.len()],
    /// Total duration, seconds.
    pub seconds: f64,
    /// Skipped kinds, with the reason.
    pub left_out: Vec<String>,
}

impl Report {
    /// Returns the number of cases that reveal a fault.
    pub fn faulty(&self) -> usize {
        self.tallies.iter().map(|tally| tally.faults.len()).sum()
    }

    /// Formats a table with a row per kind, followed by a list of faults. Each fault is listed once, with its frequency
    /// and the first case that reveals it.
    pub fn text(&self, seed: u64) -> String {
        let mut out =
            "| kind | cases | exits | faults | longest, s | peak, MiB |\n|---|---|---|---|---|---|\n".to_owned();
        let kinds = || KINDS.iter().zip(&self.tallies).filter(|(_, tally)| tally.cases > 0);
        for (kind, tally) in kinds() {
            let exits: Vec<String> = tally.exits.iter().map(|(exit, count)| format!("{exit}: {count}")).collect();
            let (cases, faults, seconds, peak) = (tally.cases, tally.faults.len(), tally.seconds, tally.peak >> 20);
            let _ =
                writeln!(out, "| {} | {cases} | {} | {faults} | {seconds:.1} | {peak} |", kind.name, exits.join(", "));
        }
        let cases: u64 = self.tallies.iter().map(|tally| tally.cases).sum();
        let _ = writeln!(out, "\n{cases} cases in {:.0} s, {} with faults", self.seconds, self.faulty());
        for words in &self.left_out {
            let _ = writeln!(out, "left out: {words}");
        }
        for (kind, tally) in kinds() {
            let mut classes: BTreeMap<String, (u64, u64, &str, &str)> = BTreeMap::new();
            for (index, what, faults) in &tally.faults {
                for fault in faults {
                    // Digits are removed, so that faults that differ only in numbers count as the same.
                    let class: String = fault.chars().filter(|c| !c.is_ascii_digit()).take(160).collect();
                    classes.entry(class).or_insert((0, *index, what, fault)).0 += 1;
                }
            }
            for (count, index, what, fault) in classes.values() {
                let _ = writeln!(
                    out,
                    "\n{count} × {}: {fault}\n    {what}\n    --seed {seed} --only {}:{index}",
                    kind.name, kind.name
                );
            }
        }
        out
    }
}

/// Runs the cases of a plan.
///
/// * `loader`: runtime that must load packages; `None` skips loading and drawing
/// * `keep`: folder for the inputs of cases with faults, each in a subfolder with its commands
///
/// # Errors
///
/// If a valid input cannot be created, files cannot be written, or processes cannot be started.
///
/// # Panics
///
/// If a case cannot be created, which is a fault of this chore.
pub fn run(plan: &Plan, loader: Option<&Loader>, keep: Option<&Path>) -> anyhow::Result<Report> {
    let begun = Instant::now();
    let bases = Bases::make().context("cannot create the valid inputs")?;
    let mut report = Report::default();
    let packed = KINDS.iter().position(|kind| kind.name == "packed");
    let mut cases = plan.cases.clone();
    if bases.packed.is_empty() {
        cases.retain(|(kind, _)| Some(*kind) != packed);
        report.left_out.push("packed: the test data are missing".into());
    }
    let next = AtomicUsize::new(0);
    let outcomes = Mutex::new(Vec::new());
    let work = || -> anyhow::Result<()> {
        let bench = CaseRunner::new()?;
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            let Some((kind, index)) = cases.get(at) else { break };
            if at > 0 && at.is_multiple_of(2000) {
                let seconds = begun.elapsed().as_secs();
                // Progress is printed, because a run takes a quarter of an hour.
                eprintln!("{at} of {} cases after {seconds} s, now {}", cases.len(), KINDS[*kind].name);
            }
            let case = make(plan.seed, *kind, *index, &bases);
            let outcome = bench.judge(&case, loader)?;
            let mut outcomes = outcomes.lock().unwrap_or_else(PoisonError::into_inner);
            outcomes.push((*kind, *index, case.what, outcome));
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..plan.jobs.max(1)).map(|_| scope.spawn(work)).collect();
        workers.into_iter().try_for_each(|w| w.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    })?;
    let mut outcomes = outcomes.into_inner().unwrap_or_else(PoisonError::into_inner);
    outcomes.sort_by_key(|(kind, index, ..)| (*kind, *index));
    let bench = CaseRunner::new()?;
    for (kind, index, what, mut outcome) in outcomes {
        let case = || make(plan.seed, kind, index, &bases);
        if outcome.slow {
            // The machine may have been busy, so a slow case is run again.
            outcome = bench.judge(&case(), loader)?;
        }
        if let Some(keep) = keep.filter(|_| !outcome.faults.is_empty()) {
            self::keep(&case(), &outcome, &keep.join(format!("{}-{index}", KINDS[kind].name)))?;
        }
        report.tallies[kind].add(index, &what, &outcome);
    }
    report.seconds = begun.elapsed().as_secs_f64();
    Ok(report)
}

fn make(seed: u64, kind: usize, index: u64, bases: &Bases) -> Case {
    (KINDS[kind].make)(bases, index, &mut Random::for_case(seed, kind as u64, index))
}

/// Writes the files of a case into its own subfolder, with the commands to run there.
fn keep(case: &Case, outcome: &Outcome, folder: &Path) -> anyhow::Result<()> {
    case.write_into(folder)?;
    let mut text = format!("# {}\n", case.what.replace('\n', " "));
    for fault in &outcome.faults {
        let _ = writeln!(text, "# {}", fault.replace('\n', " "));
    }
    for step in &case.steps {
        let _ = writeln!(text, "pelage {}", step.args.join(" "));
    }
    std::fs::write(folder.join("commands.txt"), text)?;
    Ok(())
}
