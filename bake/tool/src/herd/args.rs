//! Arguments of `pelage herd`.

use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Bake, draw, trace, compare and chart many models, with Ninja or Slurm
///
/// A herd file names models, recipes, views and limits. `plan` prints the necessary commands, `run` runs those that are
/// not up to date. Both are documented in bake/docs/herd.md.
#[derive(Debug, Args)]
pub struct HerdArgs {
    #[command(subcommand)]
    pub action: Action,
}

#[derive(Debug, Subcommand)]
pub enum Action {
    Plan(PlanArgs),
    Run(Box<RunArgs>),
    /// Write DIR/report.html from existing results, without running anything
    Report(HerdFiles),
}

// Has no doc comment, because `flatten` would use it as the help text of every action.
#[derive(Clone, Debug, Args)]
pub struct HerdFiles {
    /// Herd file
    #[arg(value_name = "HERD.toml")]
    pub herd: PathBuf,
    /// Output folder; created if missing
    #[arg(long, short, value_name = "DIR")]
    pub output: PathBuf,
}

/// Print the commands of a herd, one per line, and write them as DIR/build.ninja; --json adds what each reads and
/// writes
#[derive(Clone, Debug, Args)]
pub struct PlanArgs {
    #[command(flatten)]
    pub files: HerdFiles,
    /// Print only the commands that `run` would run now on this machine, according to Ninja. Includes commands that
    /// depend on these, although Ninja skips them if their inputs come out unchanged
    #[arg(long)]
    pub due: bool,
}

/// Run the commands of a herd that are not up to date, continue after failures, and write DIR/report.html
#[derive(Clone, Debug, Args)]
pub struct RunArgs {
    #[command(flatten)]
    pub files: HerdFiles,
    /// Engine that runs the commands: ninja on this machine, or slurm on a cluster whose nodes share this file system
    #[arg(long, value_enum, default_value = "ninja")]
    pub engine: Engine,
    /// Number of concurrent commands, with ninja [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub jobs: Option<u32>,
    /// Total memory of concurrent commands, with ninja, MiB [default: free memory]
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..))]
    pub memory: Option<u64>,
    /// Number of times that a shard retries failed commands, with slurm
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(..=100))]
    pub retries: u32,
    /// Seconds of work per shard, with slurm; a shard is one task of an array job
    #[arg(long, value_name = "S", default_value_t = 300.0, value_parser = crate::picture_args::positive)]
    pub shard_seconds: f64,
    /// Additional option of sbatch, such as --sbatch=--partition=night; may be repeated
    #[arg(long, value_name = "OPTION", allow_hyphen_values = true)]
    pub sbatch: Vec<String>,
    /// Submit without waiting, with slurm; `pelage herd report` then writes the report
    #[arg(long)]
    pub detach: bool,
}

/// Engine that runs commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Engine {
    Ninja,
    Slurm,
}
