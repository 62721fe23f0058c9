//! `pelage chart stability`: the table of `bake/src/stability/`.

use super::driver::value;
use super::{ChartArgs, create, processor};
use crate::cli::exit::{Exit, Failure};
use crate::cli::output::Output;
use pelage_bake::chart::{self, Cell};
use pelage_bake::{io, stability};
use serde_json::{Map, Value, json};

/// Prints the table, each row driven here and now.
pub fn run(args: &ChartArgs, output: &mut Output) -> Result<Exit, Failure> {
    if args.model.is_some()
        || args.recipe.recipe.is_some()
        || !args.recipe.set.is_empty()
        || !args.rows.is_empty()
        || args.restart
    {
        return Err(Failure::Usage(
            "chart stability takes neither model nor recipe: its rows bring their own, and all of them are driven"
                .into(),
        ));
    }
    let (mut rows, mut lines, mut held) = (Vec::new(), Vec::new(), true);
    for (i, row) in stability::ROWS.iter().enumerate() {
        output.progress_of(i, stability::ROWS.len(), row.method);
        lines.push(format!("{}: {}", row.method, row.cliff));
        lines.push(format!("  naive: {}; ours: {}", row.naive, row.safe));
        for f in (row.drive)()? {
            let (naive, safe) = (Cell::Number(f.naive).text(), Cell::Number(f.safe).text());
            let word = if f.holds() { "holds" } else { "BROKEN" };
            lines.push(format!("  {}: {}: naive {naive}, ours {safe}, bound {}: {word}", f.case, f.measure, f.bound));
            held &= f.holds();
            let texts =
                [("series", row.method), ("cliff", row.cliff), ("naive_form", row.naive), ("safe_form", row.safe)];
            let mut cells: Vec<(&'static str, Cell)> = texts.map(|(name, text)| (name, Cell::Text(text.into()))).into();
            cells.extend([("case", Cell::Text(f.case.clone())), ("measure", Cell::Text(f.measure.into()))]);
            cells.extend([("naive", f.naive), ("safe", f.safe), ("bound", f.bound)].map(|(n, x)| (n, Cell::Number(x))));
            cells.push(("holds", Cell::Number(f64::from(u8::from(f.holds())))));
            rows.push(cells);
        }
    }
    let mut files = Vec::new();
    if let Some(folder) = &args.output {
        create(folder)?;
        let header = rows.first().into_iter().flatten().map(|(name, _)| (*name).to_owned()).collect();
        let table =
            std::iter::once(header).chain(rows.iter().map(|row| row.iter().map(|(_, cell)| cell.text()).collect()));
        let path = folder.join("stability.csv");
        io::write_atomic(&path, chart::csv(table).as_bytes())?;
        files.push(path.display().to_string());
        lines.push(path.display().to_string());
    }
    let object = |row: &Vec<(&'static str, Cell)>| {
        let mut object: Map<String, Value> = row.iter().map(|(name, cell)| ((*name).into(), value(cell))).collect();
        let held = object.get("holds").and_then(Value::as_f64) == Some(1.0);
        object.insert("holds".into(), json!(held));
        object.insert("command".into(), json!("pelage chart stability"));
        Value::Object(object)
    };
    let rows: Vec<Value> = rows.iter().map(object).collect();
    let json = json!({ "topic": "stability", "adapter": processor(), "files": files, "rows": rows });
    output.result(&lines.join("\n"), &json)?;
    Ok(if held { Exit::Done } else { Exit::Differences })
}
