//! Runs the real binary on tens of thousands of damaged inputs: `chores mutate [--seed N] [--cases N] [--only
//! KIND[:NUMBER]] [--jobs N] [--out DIR] [--no-gpu]`.
//!
//! Prints the exit codes of the commands and every fault with its case; exits with 1 if there is a fault. The defaults
//! are 24 000 cases of seed 1, two at a time; this takes about a quarter of an hour. `--only models` runs the cases of
//! one kind, `--only models:17` a single one. `--out` keeps the cases that show faults. Packages are also loaded in the
//! runtime, on wgpu's preferred device; `--no-gpu` skips that and all drawing. `pelage_tests::mutate` defines what
//! counts as a fault. The run writes many temporary files and is faster with `TMPDIR` in memory.

use anyhow::{Context as _, bail};
use pelage_tests::mutate::judge::Loader;
use pelage_tests::mutate::{self, KINDS, Plan};
use std::path::PathBuf;
use std::process::ExitCode;

pub fn run(arguments: &[String]) -> anyhow::Result<ExitCode> {
    let (mut seed, mut cases, mut jobs, mut gpu) = (1, 24_000, 2, true);
    let (mut only, mut out) = (None, None);
    let mut arguments = arguments.iter().cloned();
    while let Some(name) = arguments.next() {
        if name == "--no-gpu" {
            gpu = false;
            continue;
        }
        let value = arguments.next().with_context(|| format!("{name}: expected a value"))?;
        match name.as_str() {
            "--seed" => seed = value.parse().context("--seed")?,
            "--cases" => cases = value.parse().context("--cases")?,
            "--jobs" => jobs = value.parse().context("--jobs")?,
            "--only" => only = Some(value),
            "--out" => out = Some(PathBuf::from(value)),
            _ => bail!("{name}: expected --seed, --cases, --only, --jobs, --out or --no-gpu"),
        }
    }
    let plan = match &only {
        None => Plan::all(seed, cases, jobs),
        Some(only) => {
            let (name, number) = only.split_once(':').map_or((only.as_str(), None), |(name, n)| (name, Some(n)));
            let names = KINDS.map(|kind| kind.name).join(", ");
            let kind = KINDS.iter().position(|kind| kind.name == name);
            let kind = kind.with_context(|| format!("--only {name}: expected one of {names}"))?;
            let range = match number {
                None => 0..cases,
                Some(number) => number.parse::<u64>().map(|n| n..n + 1).context("--only")?,
            };
            Plan::only(seed, kind, range, jobs)
        }
    };
    // Panics are caught and reported as faults, so the hook's messages are suppressed.
    std::panic::set_hook(Box::new(|_| ()));
    let loader =
        if gpu { Some(Loader::open().context("no adapter; --no-gpu skips drawing and loading")?) } else { None };
    let report = mutate::run(&plan, loader.as_ref(), out.as_deref())?;
    print!("{}", report.text(seed));
    Ok(if report.faulty() == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
