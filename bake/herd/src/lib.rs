//! Batch processing of many models: turns a herd file into a graph of commands for existing execution engines.
//!
//! Nothing here runs a command. [`file`](HerdFile) reads the request, [`plan`](Plan) computes the commands with their
//! inputs, outputs and expected memory. [`ninja`] and [`slurm`] write the plan for those engines, and
//! [`report`](Report) summarises the results on one page.

mod arguments;
mod estimate;
mod file;
mod kind;
mod model_file;
pub mod ninja;
mod pattern;
mod plan;
mod report;
mod shell;
pub mod slurm;

pub use arguments::ArgumentValidators;
pub use estimate::{CommandCost, History};
pub use file::{Chart, HerdFile, ModelRule, RecipeRule, Rules, Sequence, TruthOptions, Variant, ViewRule, Words};
pub use kind::Kind;
pub use model_file::{ModelFile, NAME};
pub use pattern::Patterns;
pub use plan::{Plan, PlanInput, Row, Task, plan};
pub use report::{CommandOutcome, Report, State};
pub use shell::{shell_line, shell_word};
