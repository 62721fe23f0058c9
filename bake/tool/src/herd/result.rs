//! Results of `pelage herd`, as `--json` prints them.

use pelage_herd::{Kind, Row, Task};
use serde::Serialize;

/// Result of `plan`, of `run` and `report`, or of a submission to Slurm.
///
/// Exit code of `run`: that of the first command that failed; 7 if only comparisons exceeded their limit.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "action", rename_all = "lowercase")]
pub enum HerdResult<'a> {
    /// Plan of a herd.
    Plan {
        /// Absolute path of the folder in which commands run.
        folder: String,
        /// Ninja build file, relative to `folder`.
        ninja: String,
        /// Models, each in each of its variants.
        rows: &'a [Row],
        /// Commands, with the files that each reads and writes.
        tasks: Vec<PlannedTask<'a>>,
        /// Number and expected cost of the commands of each kind.
        kinds: Vec<KindSummary>,
        /// Number of concurrent commands on this machine.
        jobs: u32,
        /// Number of concurrent heavy commands on this machine.
        heavy_jobs: u32,
    },
    /// Outcome of a run.
    Run {
        /// Path of the report.
        report: String,
        /// Number of rows of the report.
        models: usize,
        /// Number of commands that were run.
        ran: usize,
        /// Number of commands that were run and were cache hits.
        cached: usize,
        tasks: HerdTasks,
        /// Commands that failed, then comparisons that exceeded their limit.
        failures: Vec<HerdFailure>,
    },
    /// Jobs submitted to Slurm.
    Submitted {
        /// Slurm job numbers.
        jobs_submitted: Vec<String>,
        /// Number of array tasks, each of which runs one shard.
        shards: usize,
        /// Number of commands.
        tasks: usize,
    },
}

/// A command of a plan.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PlannedTask<'a> {
    #[serde(flatten)]
    pub(super) task: &'a Task,
    /// Command line to run.
    pub(super) command: Vec<String>,
}

/// Number and expected cost of the commands of a kind.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct KindSummary {
    pub(super) kind: Kind,
    /// Number of commands.
    pub(super) tasks: usize,
    /// Expected total time, seconds.
    pub(super) seconds: f64,
    /// Expected peak memory of the largest command, bytes.
    pub(super) peak_bytes: u64,
}

/// Number of commands in each state.
#[derive(Clone, Copy, Debug, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HerdTasks {
    pub(super) all: usize,
    pub(super) done: usize,
    pub(super) failed: usize,
    /// Comparisons that exceeded their limit.
    pub(super) differ: usize,
    /// Commands that were not run, because one that they depend on failed.
    pub(super) missing: usize,
}

/// A command that failed, or a comparison that exceeded its limit.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HerdFailure {
    /// Name of the command.
    pub(super) task: String,
    pub(super) exit_code: u8,
    pub(super) message: String,
}
