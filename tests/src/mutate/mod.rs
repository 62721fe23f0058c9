//! The mutation run: tens of thousands of damaged inputs through the real binary, each judged by how the binary ends and what it leaves behind.
//!
//! A case is made from the seed, its kind and its number alone. It is a fault of pelage where a command
//!
//! * panics, is ended by a signal, or exits with another code than 0, 1, 2, 3 and 7,
//! * takes longer than [`judge::SECONDS`], also by itself, or holds more memory than [`judge::BYTES`],
//! * exits with 0 and its output is missing, or a package that `pelage validate` finds faults in,
//! * exits with another code and leaves something behind, or says nothing, or, with 3, names no file;
//!
//! and of a package, where
//!
//! * the formats panic on it, or cannot write a valid one again,
//! * `validate --json` finds nothing that stops drawing, and the runtime does not load it, or the other way round,
//! * `unpack` takes it apart, and `pack` does not make the same bytes of it.

pub mod bases;
pub mod case;
pub mod change;
mod child;
mod folders;
mod guides;
mod hair_files;
mod images;
pub mod judge;
pub mod lay_out;
mod models;
mod packages;
mod packed;
mod random;
mod texts;

use anyhow::Context as _;
use bases::Bases;
use case::Case;
use judge::{Bench, Loader, Outcome};
use random::Random;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// A kind of input.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// As `--only` names it.
    pub name: &'static str,
    /// Its share of all cases, per cent.
    pub share: u64,
    make: fn(&Bases, u64, &mut Random) -> Case,
}

/// All kinds.
pub const KINDS: [Kind; 7] = [
    Kind { name: "packages", share: 36, make: packages::case },
    Kind { name: "folders", share: 18, make: folders::case },
    Kind { name: "models", share: 18, make: models::case },
    Kind { name: "packed", share: 6, make: packed::case },
    Kind { name: "texts", share: 9, make: texts::case },
    Kind { name: "images", share: 7, make: images::case },
    Kind { name: "guides", share: 6, make: guides::case },
];

/// Which cases are run, and how.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Seed of everything random.
    pub seed: u64,
    /// Kind and number of each case.
    pub cases: Vec<(usize, u64)>,
    /// Cases at a time.
    pub jobs: usize,
}

impl Plan {
    /// So many cases in all, each kind with its share.
    pub fn all(seed: u64, cases: u64, jobs: usize) -> Self {
        let of_kind = |(kind, k): (usize, &Kind)| (0..(cases * k.share).div_ceil(100)).map(move |i| (kind, i));
        Self { seed, cases: KINDS.iter().enumerate().flat_map(of_kind).collect(), jobs }
    }

    /// So many cases of one kind.
    pub fn only(seed: u64, kind: usize, cases: std::ops::Range<u64>, jobs: usize) -> Self {
        Self { seed, cases: cases.map(|i| (kind, i)).collect(), jobs }
    }
}

/// What came of the cases of a kind.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Cases that were run.
    pub cases: u64,
    /// How often each command ended with each code: `bake 3`.
    pub exits: BTreeMap<String, u64>,
    /// Number and description of each case that shows a fault, with its faults.
    pub faults: Vec<(u64, String, Vec<String>)>,
    /// The longest command, seconds.
    pub seconds: f64,
    /// The most memory of a command, bytes.
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

/// What came of a run.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// In the order of [`KINDS`].
    pub tallies: [Tally; KINDS.len()],
    /// How long all of it took, seconds.
    pub seconds: f64,
    /// Kinds that were left out, with the reason.
    pub left_out: Vec<String>,
}

impl Report {
    /// Cases that show a fault.
    pub fn faulty(&self) -> usize {
        self.tallies.iter().map(|tally| tally.faults.len()).sum()
    }

    /// A table with a row for each kind, and below it each fault once, with how often it was found and the first case that shows it.
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
                    // Numbers differ from case to case.
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
/// * `loader`: the runtime that packages must load in; `None` leaves that out, and all drawing
/// * `keep`: where inputs that show a fault are kept, each in a folder with the commands
///
/// # Errors
///
/// Where a base cannot be made, or the system refuses files or processes.
///
/// # Panics
///
/// Where a case cannot be made, which is a fault of this chore.
pub fn run(plan: &Plan, loader: Option<&Loader>, keep: Option<&Path>) -> anyhow::Result<Report> {
    let begun = Instant::now();
    let bases = Bases::make().context("the bases")?;
    let mut report = Report::default();
    let packed = KINDS.iter().position(|kind| kind.name == "packed");
    let mut cases = plan.cases.clone();
    if bases.packed.is_empty() {
        cases.retain(|(kind, _)| Some(*kind) != packed);
        report.left_out.push("packed: there is no test data".into());
    }
    let next = AtomicUsize::new(0);
    let outcomes = Mutex::new(Vec::new());
    let work = || -> anyhow::Result<()> {
        let bench = Bench::new()?;
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            let Some((kind, index)) = cases.get(at) else { break };
            if at > 0 && at.is_multiple_of(2000) {
                let seconds = begun.elapsed().as_secs();
                // Whoever waits for a quarter of an hour wants to see it pass.
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
    let bench = Bench::new()?;
    for (kind, index, what, mut outcome) in outcomes {
        let case = || make(plan.seed, kind, index, &bases);
        if outcome.slow {
            // The machine had other things to do, or so we give it the benefit of the doubt.
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
    (KINDS[kind].make)(bases, index, &mut Random::of_case(seed, kind as u64, index))
}

/// Puts the files of a case into a folder of its own, with what to run there.
fn keep(case: &Case, outcome: &Outcome, folder: &Path) -> anyhow::Result<()> {
    case.lay(folder)?;
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
