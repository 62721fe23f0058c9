//! Batch processing of many models: turns a herd file into a graph of commands for existing execution engines.
//!
//! Nothing here runs a command. [`file`](HerdFile) reads the request, [`plan`](Plan) computes the commands with their
//! inputs, outputs and expected memory. [`ninja`] and [`slurm`] write the plan for those engines, and
//! [`report`](Report) summarises the results on one page.

mod estimate;
mod file;
mod model_file;
mod kind;
pub mod ninja;
mod pattern;
mod plan;
mod report;
mod shell;
pub mod slurm;
mod arguments;

pub use estimate::{History, CommandCost};
pub use file::{Chart, HerdFile, ModelRule, RecipeRule, Rules, Sequence, TruthOptions, Variant, View, Words};
pub use model_file::{ModelFile, NAME};
pub use kind::Kind;
pub use pattern::Patterns;
pub use plan::{Plan, Row, Task, PlanInput, plan};
pub use report::{CommandOutcome, Report, State};
pub use shell::{shell_line, shell_word};
pub use arguments::ArgumentValidators;
