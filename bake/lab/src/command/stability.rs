//! `pelage chart stability`: the table of `bake/lab/src/stability/`, computed on this machine.

use super::args::ChartArgs;
use super::driver::{ChartResult, processor};
use crate::chart;
use crate::chart::Cell;
use crate::stability::{DRAWN_ROWS, Finding, ROWS, Row};
use pelage_bake::io;
use pelage_tool::exit::{Exit, Failure};
use pelage_tool::output::{Output, make_folder};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeSet;

/// Numerical failure of a method, tested in one case.
#[derive(Serialize, JsonSchema)]
pub struct StabilityRow {
    /// Name of the method.
    series: &'static str,
    /// Description of the failure.
    cliff: &'static str,
    /// Description of the naive form of the method.
    naive_form: &'static str,
    /// Description of pelage's form of the method.
    safe_form: &'static str,
    /// Name of the case.
    case: String,
    /// Name of the error measure.
    measure: &'static str,
    /// Adapter or processor that ran the row.
    adapter: String,
    /// Error of the naive form; null if it is not finite.
    #[schemars(with = "Option<f64>")]
    naive: f64,
    /// Error of pelage's form; null if it is not finite.
    #[schemars(with = "Option<f64>")]
    safe: f64,
    /// Bound on the error of pelage's form.
    bound: f64,
    /// Whether the error of pelage's form stays within the bound.
    holds: bool,
    /// Command that reproduces the row.
    command: &'static str,
}

impl StabilityRow {
    const HEADER: [&str; 11] =
        ["series", "cliff", "naive_form", "safe_form", "case", "measure", "adapter", "naive", "safe", "bound", "holds"];

    fn cells(&self) -> Vec<String> {
        let texts = [self.series, self.cliff, self.naive_form, self.safe_form, &self.case, self.measure, &self.adapter];
        let numbers = [self.naive, self.safe, self.bound, f64::from(u8::from(self.holds))];
        let numbers = numbers.map(|x| Cell::Number(x).text());
        texts.map(str::to_owned).into_iter().chain(numbers).collect()
    }
}

/// Results so far.
#[derive(Default)]
struct Table {
    rows: Vec<StabilityRow>,
    lines: Vec<String>,
    broken: bool,
}

impl Table {
    fn add<D>(&mut self, row: &Row<D>, adapter: &str, findings: &[Finding]) {
        self.lines.push(format!("{}: {}", row.method, row.cliff));
        self.lines.push(format!("  naive: {}; ours: {}", row.naive, row.safe));
        for f in findings {
            let (naive, safe, bound) =
                (Cell::Number(f.naive).text(), Cell::Number(f.safe).text(), Cell::Number(f.bound).text());
            let word = if f.holds() { "holds" } else { "BROKEN" };
            self.lines.push(format!("  {}: {}: naive {naive}, ours {safe}, bound {bound}: {word}", f.case, f.measure));
            self.broken |= !f.holds();
            self.rows.push(StabilityRow {
                series: row.method,
                cliff: row.cliff,
                naive_form: row.naive,
                safe_form: row.safe,
                case: f.case.clone(),
                measure: f.measure,
                adapter: adapter.to_owned(),
                naive: f.naive,
                safe: f.safe,
                bound: f.bound,
                holds: f.holds(),
                command: "pelage chart stability",
            });
        }
    }
}

/// Prints the table. Without an adapter, prints the rows that need none, and returns a failure that says what is
/// missing.
pub fn run(args: &ChartArgs, output: &mut Output) -> Result<Exit, Failure> {
    if args.model.is_some()
        || args.recipe.recipe.is_some()
        || !args.recipe.set.is_empty()
        || args.restart
        || args.part
        || !args.from.is_empty()
    {
        return Err(Failure::Usage("chart stability takes neither model nor recipe: its inputs are built in".into()));
    }
    let mut table = Table::default();
    let numbers: BTreeSet<usize> = args.numbers(ROWS.len() + DRAWN_ROWS.len())?.collect();
    for (i, row) in ROWS.iter().enumerate().filter(|(i, _)| numbers.contains(&(i + 1))) {
        output.progress_of(i, ROWS.len() + 1, row.method);
        table.add(row, &processor(), &(row.drive)()?);
    }
    let drawn = DRAWN_ROWS.iter().enumerate().filter(|(i, _)| numbers.contains(&(ROWS.len() + i + 1)));
    let drawn: Vec<_> = drawn.map(|(_, row)| row).collect();
    let undriven = if drawn.is_empty() { Ok(()) } else { drawn::add(&mut table, &drawn, output) };
    let no_adapter = match undriven {
        Err(failure @ Failure::NoAdapter(_)) => Some(failure),
        other => other.map(|()| None)?,
    };
    report(args, table.lines, table.rows, output)?;
    match no_adapter {
        Some(failure) => Err(failure),
        None => Ok(if table.broken { Exit::Differences } else { Exit::Done }),
    }
}

fn report(
    args: &ChartArgs,
    mut lines: Vec<String>,
    rows: Vec<StabilityRow>,
    output: &mut Output,
) -> Result<(), Failure> {
    let mut files = Vec::new();
    if let Some(folder) = &args.output {
        make_folder(folder)?;
        let header = StabilityRow::HEADER.map(str::to_owned).to_vec();
        let table = std::iter::once(header).chain(rows.iter().map(StabilityRow::cells));
        let path = folder.join("stability.csv");
        io::write_atomic(&path, chart::csv(table).as_bytes())?;
        files.push(path.display().to_string());
        lines.push(path.display().to_string());
    }
    let result = ChartResult { topic: "stability", adapter: processor(), files, rows, measured: None };
    output.result(&lines.join("\n"), &result)
}

/// Rows that require rendered pictures.
mod drawn {
    use super::Table;
    use crate::stability::{Drawing, DrawnRowTest, Row};
    use half::f16;
    use pelage_import::BakeError;
    use pelage_runtime::{Instance, Renderer, wgpu};
    use pelage_stage::{Canvas, CanvasOptions, Gpu};
    use pelage_tool::exit::Failure;
    use pelage_tool::machine::measured_on;
    use pelage_tool::output::Output;

    pub fn add(table: &mut Table, rows: &[&Row<DrawnRowTest>], output: &mut Output) -> Result<(), Failure> {
        let gpu = Gpu::open()?;
        for row in rows {
            output.progress_of(super::ROWS.len(), super::ROWS.len() + 1, row.method);
            let mut draw = |drawing: &Drawing<'_>| {
                texels(&gpu, drawing).map_err(|failure| BakeError::Internal(failure.to_string()))
            };
            table.add(row, &measured_on(&gpu.info.name), &(row.drive)(&mut draw)?);
        }
        Ok(())
    }

    /// Returns every pixel of a drawing as 16-bit floats, because 8 bits would lose the contribution of thin layers.
    fn texels(gpu: &Gpu, drawing: &Drawing<'_>) -> Result<Vec<[f32; 4]>, Failure> {
        let fault = |error| BakeError::Internal(format!("cannot draw the row's package: {error}"));
        let options = CanvasOptions { color_format: wgpu::TextureFormat::Rgba16Float, ..CanvasOptions::default() };
        let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options.renderer()).map_err(fault)?;
        let model = renderer.load_bytes(drawing.package).map_err(fault)?;
        let instance = Instance::new(0, &model).at(drawing.at);
        let canvas = Canvas::new(gpu, drawing.size, &options);
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let frame = renderer.prepare(&mut encoder, drawing.params, [&instance]).map_err(fault)?;
        let mut pass = canvas.pass(&mut encoder, "silhouette", Some(wgpu::Color::TRANSPARENT));
        drawing.passes.iter().for_each(|id| frame.draw_pass(*id, &mut pass));
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        let texels = canvas.texels(gpu)?;
        let texel = |t: &[u8]| [0, 2, 4, 6].map(|i| f16::from_le_bytes([t[i], t[i + 1]]).to_f32());
        Ok(texels.chunks_exact(8).map(texel).collect())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

    use super::{Finding, Row, Table};

    #[test]
    fn each_finding_is_printed_with_its_verdict() {
        let row = Row { method: "method", cliff: "a cliff", naive: "falls", safe: "stops", drive: () };
        let finding = |case: &str, safe| Finding {
            case: case.into(),
            measure: "steps",
            naive: 9.0,
            safe,
            bound: 1.0,
            fails_above: 1.0,
        };
        let mut table = Table::default();
        table.add(&row, "here", &[finding("by day", 0.5)]);
        let expected =
            ["method: a cliff", "  naive: falls; ours: stops", "  by day: steps: naive 9, ours 0.5, bound 1: holds"];
        assert_eq!((table.lines.as_slice(), table.broken), (expected.map(String::from).as_slice(), false));
        table.add(&row, "here", &[finding("by night", 2.0)]);
        assert_eq!(table.lines.last().unwrap(), "  by night: steps: naive 9, ours 2, bound 1: BROKEN");
        assert!(table.broken && table.rows.len() == 2);
    }
}
