//! What all charts share: rows are measured one by one, each is noted down at once, and the table and its picture are
//! written when all are there.

use super::args::{self, ChartArgs};
use super::journal::Rows;
use super::subject::Subject;
use crate::chart;
use crate::chart::{Cell, Chart, Panel, Row};
use pelage_bake::io;
use pelage_herd::shell_word;
use pelage_tool::exit::{Exit, Failure};
use pelage_tool::journal::Key;
use pelage_tool::output::{Output, make_folder};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};
use std::path::Path;

/// Table that was measured, as in the CSV file.
#[derive(Serialize, JsonSchema)]
pub struct ChartResult<R> {
    #[schemars(with = "args::Topic")]
    pub topic: &'static str,
    /// Adapter or processor that it was measured on.
    pub adapter: String,
    /// Paths of the files written.
    pub files: Vec<String>,
    /// Rows of the table.
    pub rows: Vec<R>,
    /// With `--part`, numbers of the rows that were measured, which are in the file and not in `rows`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured: Option<Vec<usize>>,
}

/// A configuration and its figures.
#[derive(Serialize, JsonSchema)]
pub struct MeasuredRow {
    /// Name of what is varied.
    series: String,
    /// Whether it is the default configuration.
    default: bool,
    /// Command that reproduces the row.
    command: String,
    /// Knobs, errors and costs of the topic, null if they do not apply. `on_front`: whether no row is better in both.
    #[serde(flatten)]
    figures: Map<String, Value>,
}

/// A topic: what could be measured, and how a row of it is.
///
/// What is dear and the same for many rows (truths, bakes) is made when a row first asks for it and kept in the topic,
/// so that a run which goes on where another was killed makes only what is still needed.
pub trait Topic {
    /// The table before anything is measured.
    fn plan(&self) -> Plan;

    /// Measures row `index` of the plan, from 0: a cell for each column. Nothing else may change the errors among them,
    /// so that a row measured alone has the same; costs may vary with what else the machine does.
    ///
    /// * `doing`: told what is going on, for the progress bar
    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure>;
}

/// A table without its figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The word after `pelage chart`.
    pub topic: &'static str,
    /// What is seen, and of which model.
    pub title: String,
    /// What it is measured on.
    pub adapter: String,
    /// Names of the knobs, errors and costs.
    pub columns: Vec<&'static str>,
    /// What to draw; the first panel decides `on_front`.
    pub panels: Vec<Panel>,
    /// The configurations, in the order of the table.
    pub rows: Vec<PlannedRow>,
}

/// A configuration to measure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlannedRow {
    /// What is varied; rows of one series share a colour.
    pub series: String,
    /// The value of what is varied, short: it stands beside the mark.
    pub label: String,
    /// Whether it is what a user gets without asking.
    pub default: bool,
    /// What reproduces its figures, where that is another subcommand; else it is this one, asked for the row alone.
    pub command: Option<String>,
}

/// What `slot` holds, made now where it is empty.
pub fn once<T>(slot: &mut Option<T>, make: impl FnOnce() -> Result<T, Failure>) -> Result<&mut T, Failure> {
    let value = match slot.take() {
        Some(value) => value,
        None => make()?,
    };
    Ok(slot.insert(value))
}

/// Measures what the arguments ask for, and writes table and picture.
pub fn run(
    args: &ChartArgs,
    subject: &Subject,
    folder: &Path,
    topic: &mut dyn Topic,
    output: &mut Output,
) -> Result<Exit, Failure> {
    let plan = topic.plan();
    let numbers: Vec<usize> = args.numbers(plan.rows.len())?.collect();
    make_folder(folder)?;
    let mut journal = Rows::open(folder, plan.topic, &key(subject, &plan), args.restart)?;
    if journal.others() > 0 {
        output.note(&format!("{} rows of another model, recipe, tool or adapter do not count", journal.others()));
    }
    for path in &args.from {
        let others = journal.take(path)?;
        if others > 0 {
            let file = path.display();
            output.note(&format!("{file}: {others} rows of another model, recipe, tool or adapter do not count"));
        }
    }
    let known = numbers.iter().filter(|n| journal.cells(**n).is_some()).count();
    if known > 0 {
        output.note(&format!(
            "{known} of {} rows are there from a run before; --restart measures them anew",
            numbers.len()
        ));
    }
    let mut rows = Vec::new();
    for (done, number) in numbers.iter().enumerate() {
        let planned = &plan.rows[number - 1];
        let cells = match journal.cells(*number) {
            Some(cells) => cells,
            None => {
                let name = if planned.label.is_empty() {
                    planned.series.clone()
                } else {
                    format!("{} {}", planned.series, planned.label)
                };
                let mut doing = |what: &str| output.progress_of(done, numbers.len(), &format!("{name}: {what}"));
                doing("begins");
                let cells = topic.measure(number - 1, &mut doing)?;
                journal.add(*number, &cells)?;
                cells
            }
        };
        rows.push(Row {
            series: planned.series.clone(),
            label: planned.label.clone(),
            cells,
            default: planned.default,
            command: planned.command.clone().unwrap_or_else(|| command(subject, folder, plan.topic, *number)),
        });
    }
    if args.part {
        let file = journal.path().display().to_string();
        let files = vec![file.clone()];
        let Plan { topic, adapter, .. } = plan;
        let result = ChartResult::<MeasuredRow> { topic, adapter, files, rows: Vec::new(), measured: Some(numbers) };
        output.result(&file, &result)?;
        return Ok(Exit::Done);
    }
    let Plan { topic, title, adapter, columns, panels, .. } = plan;
    let exit = write(&Chart { topic, title, adapter, columns, rows, panels }, folder, output)?;
    journal.finish(&numbers)?;
    Ok(exit)
}

/// The command that measures one row again, into a folder of its own: the whole table stays.
fn command(subject: &Subject, folder: &Path, topic: &str, number: usize) -> String {
    let folder = shell_word(&folder.join(format!("row-{number}")).display().to_string());
    format!("pelage chart {topic}{} --rows {number} -o {folder} --json", subject.arguments)
}

/// Stands for everything that a row's figures depend on beside its number: another tool, model, recipe or adapter gives
/// another key.
fn key(subject: &Subject, plan: &Plan) -> String {
    let mut key = Key::of_program().and(&plan.adapter).and(&plan.title).and(subject.recipe.to_toml());
    for input in subject.model.inputs.iter().chain(&subject.images.inputs) {
        key = key.and(format!("{} {} {:?}", input.role, input.name, input.sha256));
    }
    key = plan.columns.iter().fold(key, Key::and);
    plan.rows.iter().fold(key, |key, row| key.and(format!("{} {}", row.series, row.label))).finish()
}

/// Writes table and picture, and says where they are.
fn write(chart: &Chart, folder: &Path, output: &mut Output) -> Result<Exit, Failure> {
    let svg = chart::svg(chart)?;
    let path = |extension: &str| folder.join(format!("{}.{extension}", chart.topic));
    let files = [(path("csv"), chart.csv()), (path("svg"), svg)];
    for (path, text) in &files {
        io::write_atomic(path, text.as_bytes())?;
    }
    let files: Vec<String> = files.iter().map(|(path, _)| path.display().to_string()).collect();
    let text = files.join("\n");
    let (topic, adapter) = (chart.topic, chart.adapter.clone());
    output.result(&text, &ChartResult { topic, adapter, files, rows: rows(chart), measured: None })?;
    Ok(Exit::Done)
}

/// Builds the rows of the result.
fn rows(chart: &Chart) -> Vec<MeasuredRow> {
    let fronts = chart.fronts();
    let row = |(i, row): (usize, &Row)| {
        let cells = chart.columns.iter().zip(&row.cells).map(|(column, cell)| ((*column).into(), value(cell)));
        let fronts = fronts.iter().map(|(name, front)| (name.clone(), front[i].into()));
        MeasuredRow {
            series: row.series.clone(),
            default: row.default,
            command: row.command.clone(),
            figures: cells.chain(fronts).collect(),
        }
    };
    chart.rows.iter().enumerate().map(row).collect()
}

/// A figure as JSON; what is not a number is null.
pub fn value(cell: &Cell) -> Value {
    match cell {
        Cell::Number(x) => (*x).into(),
        Cell::Text(text) => text.as_str().into(),
        Cell::Empty => Value::Null,
    }
}
