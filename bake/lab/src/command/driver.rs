//! Common driver of all charts. Rows are measured one by one and saved at once; table and picture are written when all
//! rows are complete.

use super::args::{self, ChartArgs};
use super::journal::Rows;
use super::subject::Subject;
use crate::chart;
use crate::chart::{Cell, Chart, Panel, Row};
use pelage_bake::io;
use pelage_herd::shell_word;
use pelage_tool::exit::{Exit, Failure};
use pelage_tool::journal::Key;
use pelage_tool::machine::measured_on;
use pelage_tool::output::{Output, make_folder};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};
use std::path::Path;

/// Measured table, with the contents of the CSV file.
#[derive(Serialize, JsonSchema)]
pub struct ChartResult<R> {
    #[schemars(with = "args::Topic")]
    pub topic: &'static str,
    /// Adapter or processor of the measurement.
    pub adapter: String,
    /// Paths of the files written.
    pub files: Vec<String>,
    /// Rows of the table.
    pub rows: Vec<R>,
    /// With `--part`: numbers of the measured rows, which are in the journal and not in `rows`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured: Option<Vec<usize>>,
}

/// Configuration with its figures.
#[derive(Serialize, JsonSchema)]
pub struct MeasuredRow {
    /// Name of the varied setting.
    series: String,
    /// Whether this is the default configuration.
    default: bool,
    /// Command that reproduces the row.
    command: String,
    /// Parameters, errors and costs of the topic; null if they do not apply. `on_front`: whether the row is on the
    /// Pareto front.
    #[serde(flatten)]
    figures: Map<String, Value>,
}

/// Topic of a chart: its configurations, and how to measure a row.
///
/// Expensive results shared by many rows (truths, bakes) are created on first use and kept in the topic. If an
/// interrupted run is continued, only those still needed are created.
pub trait Topic {
    /// Returns the table without its figures.
    fn plan(&self) -> Plan;

    /// Measures row `index` of the plan, from 0, and returns a cell for each column. Errors must depend only on the
    /// row, so that a row measured alone has the same ones. Costs may vary with the machine's load.
    ///
    /// * `doing`: callback with the current activity, for the progress bar
    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure>;
}

/// Table without its figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Word after `pelage chart`.
    pub topic: &'static str,
    /// Title of the chart: what was measured, and on which glTF model.
    pub title: String,
    /// Adapter or device of the measurements.
    pub adapter: String,
    /// Names of the parameters, errors and costs.
    pub columns: Vec<&'static str>,
    /// Panels to draw; the first determines `on_front`.
    pub panels: Vec<Panel>,
    /// Configurations, in the order of the table.
    pub rows: Vec<PlannedRow>,
}

/// Configuration to measure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlannedRow {
    /// Name of the varied setting; rows of one series share a colour.
    pub series: String,
    /// Short value of the varied setting, shown beside its mark in the plot.
    pub label: String,
    /// Whether this is the default configuration.
    pub default: bool,
    /// Command that reproduces the figures, if it is another subcommand; `None` for `chart` restricted to this row.
    pub command: Option<String>,
}

/// Returns the value of `slot`, creating it first if the slot is empty.
pub fn get_or_make<T>(slot: &mut Option<T>, make: impl FnOnce() -> Result<T, Failure>) -> Result<&mut T, Failure> {
    let value = match slot.take() {
        Some(value) => value,
        None => make()?,
    };
    Ok(slot.insert(value))
}

/// Measures the requested rows, and writes the table and the picture.
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
        output.note(&format!("ignored {} rows measured with another model, recipe, tool or adapter", journal.others()));
    }
    for path in &args.from {
        let others = journal.take(path)?;
        if others > 0 {
            let file = path.display();
            output.note(&format!("{file}: ignored {others} rows measured with another model, recipe, tool or adapter"));
        }
    }
    let known = numbers.iter().filter(|n| journal.cells(**n).is_some()).count();
    if known > 0 {
        output.note(&format!(
            "{known} of {} rows exist from an earlier run; --restart measures them again",
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

/// Returns the hardware description of a measurement that uses no graphics adapter.
pub fn processor() -> String {
    measured_on(&format!("CPU, {} threads", rayon::current_num_threads()))
}

/// Returns the command that measures one row again. It writes to a separate folder, so that the whole table is
/// preserved.
fn command(subject: &Subject, folder: &Path, topic: &str, number: usize) -> String {
    let folder = shell_word(&folder.join(format!("row-{number}")).display().to_string());
    format!("pelage chart {topic}{} --rows {number} -o {folder} --json", subject.arguments)
}

/// Returns a key for everything but the row number that a row's figures depend on. It differs for a different tool,
/// model, recipe or adapter.
fn key(subject: &Subject, plan: &Plan) -> String {
    // The hash of the program file differs between builds, but not with the place where it is installed.
    let program = std::env::current_exe().and_then(|program| io::digest(&program, u64::MAX)).unwrap_or_default();
    let mut key = Key::of_version().with(program).with(&plan.adapter).with(&plan.title).with(subject.recipe.to_toml());
    for input in subject.model.inputs.iter().chain(&subject.images.inputs) {
        key = key.with(format!("{} {} {:?}", input.role, input.name, input.sha256));
    }
    key = plan.columns.iter().fold(key, Key::with);
    plan.rows.iter().fold(key, |key, row| key.with(format!("{} {}", row.series, row.label))).finish()
}

/// Writes table and picture, and reports their paths.
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

/// Converts a cell to JSON; empty cells and numbers that are not finite become null.
pub fn value(cell: &Cell) -> Value {
    match cell {
        Cell::Number(x) => (*x).into(),
        Cell::Text(text) => text.as_str().into(),
        Cell::Empty => Value::Null,
    }
}
