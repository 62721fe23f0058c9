//! What `pelage herd` is told.

use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Bake, draw, trace, compare and chart many models, with Ninja or Slurm
///
/// A herd file names models, recipes, views and limits; `plan` says which commands that takes, and `run` runs those that are not done. bake/docs/herd.md is
/// about both.
#[derive(Debug, Args)]
pub struct HerdArgs {
    #[command(subcommand)]
    pub action: Action,
}

#[derive(Debug, Subcommand)]
pub enum Action {
    Plan(PlanArgs),
    Run(Box<RunArgs>),
    /// Write DIR/report.html of what became of a herd, and run nothing
    Report(HerdFiles),
}

// No comment of the documents: `flatten` would take it for the text of every action.
#[derive(Clone, Debug, Args)]
pub struct HerdFiles {
    /// What is wanted of which models
    #[arg(value_name = "HERD.toml")]
    pub herd: PathBuf,
    /// The folder that everything is written into, made where it is missing
    #[arg(long, short, value_name = "DIR")]
    pub output: PathBuf,
}

/// Say which commands a herd takes, one a line, and write them as DIR/build.ninja; --json says what each reads and writes, too
#[derive(Clone, Debug, Args)]
pub struct PlanArgs {
    #[command(flatten)]
    pub files: HerdFiles,
    /// Those alone that `run` would run now on this machine, as Ninja finds it. What is made of the files of one of them is among them, though it stays where
    /// they come out the same
    #[arg(long)]
    pub due: bool,
}

/// Run what is not done of a herd, go on after failures, and write DIR/report.html
#[derive(Clone, Debug, Args)]
pub struct RunArgs {
    #[command(flatten)]
    pub files: HerdFiles,
    /// What runs the commands: ninja, on this machine, or slurm, on a farm whose nodes share this file system
    #[arg(long, value_enum, default_value = "ninja")]
    pub engine: Engine,
    /// Commands at once, with ninja [default: one a core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub jobs: Option<u32>,
    /// Memory for all of them, with ninja, mebibytes [default: what is free]
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..))]
    pub memory: Option<u64>,
    /// How often a shard tries again what failed, with slurm
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(..=100))]
    pub retries: u32,
    /// Seconds of commands that a shard has, with slurm: a task of an array job
    #[arg(long, value_name = "S", default_value_t = 300.0, value_parser = crate::picture_args::positive)]
    pub shard_seconds: f64,
    /// A further option of sbatch, such as --sbatch=--partition=night; may be given several times
    #[arg(long, value_name = "OPTION", allow_hyphen_values = true)]
    pub sbatch: Vec<String>,
    /// Submit and do not wait, with slurm; `pelage herd report` then writes the page
    #[arg(long)]
    pub detach: bool,
}

/// What runs commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Engine {
    Ninja,
    Slurm,
}
