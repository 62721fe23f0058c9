//! Many models at once: what a herd file asks for, as a graph of commands for engines that people already run.
//!
//! Nothing here runs anything. [`file`](HerdFile) reads what is wanted, [`plan`](Plan) says which commands that takes, what each reads and writes and how
//! much memory it may need, [`ninja`] and [`slurm`] write it down for those engines, and [`report`](Report) puts what became of it on one page.

mod estimate;
mod file;
mod found;
mod kind;
pub mod ninja;
mod pattern;
mod plan;
mod report;
mod shell;
pub mod slurm;
mod words;

pub use estimate::{History, Known};
pub use file::{Chart, HerdFile, Models, RecipeRule, Rules, Sequence, Truth, Variant, View, Words};
pub use found::{Found, NAME};
pub use kind::Kind;
pub use pattern::Patterns;
pub use plan::{Plan, Row, Task, Told, plan};
pub use report::{Became, Report, State};
pub use shell::{shell_line, shell_word};
pub use words::Judge;
