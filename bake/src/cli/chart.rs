//! `pelage chart`: what accuracy costs, as a table and a picture.

use super::bake::RecipeArgs;
use super::built_in::HARE;
use super::exit::{Exit, Failure};
use super::output::Output;
use clap::ValueEnum as _;
use pelage_bake::chart::{self, Cell, Chart, Row, surface};
use pelage_bake::groom::MapImages;
use pelage_bake::import::ImportOptions;
use pelage_bake::mesh::Model;
use pelage_bake::recipe::Recipe;
use pelage_bake::{BakeError, io, pipeline, stability};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Chart speed against accuracy: CSV and SVG with a row for each configuration
#[derive(Clone, Debug, clap::Args)]
pub struct ChartArgs {
    /// What to measure
    #[arg(value_name = "TOPIC", value_enum)]
    topic: Topic,
    /// The model: .glb, .gltf or .obj; by default the built-in hare
    #[arg(value_name = "MODEL")]
    model: Option<PathBuf>,
    /// Folder for TOPIC.csv and TOPIC.svg, made where it is missing; stability needs none, and draws no picture
    #[arg(long, short, value_name = "DIR")]
    pub(super) output: Option<PathBuf>,
    /// Measure these rows only, by their number in the whole table, from 1; where a row's command says so, it gives that row again
    #[arg(long, value_name = "N,N..", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..))]
    rows: Vec<u32>,
    #[command(flatten)]
    recipe: RecipeArgs,
}

impl ChartArgs {
    /// Numbers of the rows to measure, of `count` that there are.
    pub(super) fn numbers(&self, count: usize) -> Result<impl Iterator<Item = usize> + use<>, Failure> {
        if let Some(row) = self.rows.iter().find(|row| **row as usize > count) {
            return Err(Failure::Usage(format!("--rows {row}: the table has {count} rows")));
        }
        let rows: Vec<usize> = self.rows.iter().map(|row| *row as usize).collect();
        Ok((1..=count).filter(move |number| rows.is_empty() || rows.contains(number)))
    }
}

/// What can be charted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Topic {
    /// Lapped patches: what fewer seams cost in distortion and seconds
    Surface,
    /// Light per pixel and per vertex: the direction it is computed with against the strand's own, and what that costs
    Lighting,
    /// Layer-wise shadow maps: what light they let between hairs, against the true way of the light, and what they cost
    SelfShadow,
    /// Shadow-width maps: the soft shadows they make, against a light that is a disc, and what they cost
    SoftShadow,
    /// Where methods fail: the naive form's error beside ours and its bound; exit code 7 where a bound is broken
    Stability,
}

/// Measures a topic on a model.
type Measure = fn(&ChartArgs, &Subject, &mut Output) -> Result<Chart, Failure>;

/// Runs the subcommand.
pub fn run(args: &ChartArgs, output: &mut Output) -> Result<Exit, Failure> {
    let measure: Measure = match args.topic {
        Topic::Stability => return stability_table(args, output),
        Topic::Surface => surface_chart,
        #[cfg(feature = "preview")]
        Topic::Lighting => super::chart_lighting::lighting_chart,
        #[cfg(feature = "preview")]
        Topic::SelfShadow => super::chart_light::self_shadow_chart,
        #[cfg(feature = "preview")]
        Topic::SoftShadow => super::chart_light::soft_shadow_chart,
        #[cfg(not(feature = "preview"))]
        Topic::Lighting | Topic::SelfShadow | Topic::SoftShadow => |_, _, _| {
            Err(Failure::Usage(
                "light is drawn by the runtime, and this build is without it (feature `preview`)".into(),
            ))
        },
    };
    let name = args.topic.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned());
    let needs = || Failure::Usage(format!("chart {name} needs -o DIR, to put table and picture there"));
    let folder = args.output.as_deref().ok_or_else(needs)?;
    let chart = measure(args, &subject(args)?, output)?;
    write(&chart, folder, output)
}

/// The table of `bake/src/stability/`, each row driven here and now.
fn stability_table(args: &ChartArgs, output: &mut Output) -> Result<Exit, Failure> {
    if args.model.is_some() || args.recipe.recipe.is_some() || !args.recipe.set.is_empty() || !args.rows.is_empty() {
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

fn create(folder: &Path) -> Result<(), BakeError> {
    std::fs::create_dir_all(folder).map_err(|source| BakeError::Io {
        path: folder.to_owned(),
        action: "create",
        source,
    })
}

fn value(cell: &Cell) -> Value {
    match cell {
        Cell::Number(x) => json!(x),
        Cell::Text(text) => json!(text),
        Cell::Empty => Value::Null,
    }
}

/// A model with its recipe, the `pelage bake` that would read both, and what `pelage chart` was given to do so.
pub(super) struct Subject {
    pub(super) file: String,
    pub(super) name: String,
    pub(super) model: Model,
    pub(super) recipe: Recipe,
    pub(super) images: MapImages,
    command: String,
    #[cfg_attr(
        not(feature = "preview"),
        expect(dead_code, reason = "only charts of the runtime name `pelage chart` in their rows")
    )]
    pub(super) arguments: String,
}

fn subject(args: &ChartArgs) -> Result<Subject, Failure> {
    let sets: String = args.recipe.set.iter().map(|set| format!(" --set {}", shell_word(set))).collect();
    if let Some(path) = &args.model {
        let (recipe, _) = args.recipe.read()?;
        let model = io::read_model(path, &ImportOptions { unit_m: recipe.model.unit_m })?;
        let mut files = format!(" {}", shell_word(&path.display().to_string()));
        if let Some(recipe) = &args.recipe.recipe {
            files += &format!(" --recipe {}", shell_word(&recipe.display().to_string()));
        }
        let (command, arguments) = (format!("pelage bake{files}"), files + &sets);
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let (file, images) = (path.display().to_string(), args.recipe.images(&recipe)?);
        return Ok(Subject { file, name, model, recipe, images, command, arguments });
    }
    if args.recipe.recipe.is_some() {
        return Err(Failure::Usage("--recipe needs a MODEL: the built-in hare has its own".into()));
    }
    let mut recipe = HARE.recipe()?;
    args.recipe.set.iter().try_for_each(|assignment| recipe.set(assignment))?;
    let command = format!("pelage bake assets/models/{0}.glb --recipe assets/recipes/{0}.toml", HARE.name);
    let (file, name, images) = (HARE.file(), HARE.name.into(), args.recipe.images(&recipe)?);
    Ok(Subject { file, name, model: HARE.import(&recipe)?, recipe, images, command, arguments: sets })
}

/// A word as a shell reads it.
pub(super) fn shell_word(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

/// Runs of one configuration, of which the median counts; long ones are run once.
const RUNS: usize = 3;
const LONG_S: f64 = 1.0;

fn surface_chart(args: &ChartArgs, subject: &Subject, output: &mut Output) -> Result<Chart, Failure> {
    let configurations = surface::configurations(&subject.recipe, &subject.model)?;
    let mut rows = Vec::new();
    for number in args.numbers(configurations.len())? {
        let configuration = &configurations[number - 1];
        output.progress_of(number - 1, configurations.len(), configuration.series);
        let (mut seconds, mut measures) = (Vec::new(), None);
        while seconds.len() < RUNS && seconds.iter().sum::<f64>() < LONG_S {
            let begun = Instant::now();
            let (file, model, recipe) = (&subject.file, &subject.model, &configuration.recipe);
            let laid = pipeline::lay(file, model, recipe, &subject.images, &mut Vec::new())?;
            seconds.push(begun.elapsed().as_secs_f64());
            measures = Some(laid.surface.measures);
        }
        seconds.sort_by(f64::total_cmp);
        let sets = args.recipe.set.iter().chain(&configuration.sets);
        let sets: String = sets.map(|set| format!(" --set {}", shell_word(set))).collect();
        rows.push(Row {
            series: configuration.series.into(),
            cells: surface::cells(&configuration.recipe, &measures.unwrap_or_default(), seconds[seconds.len() / 2]),
            default: configuration.sets.is_empty(),
            command: format!("{}{sets} -o {}.pelage --json", subject.command, shell_word(&subject.name)),
        });
    }
    let triangles = subject.model.mesh.triangles.len();
    Ok(Chart {
        topic: "surface",
        title: format!("{}, {triangles} triangles: what fewer seams cost in distortion", subject.name),
        adapter: processor(),
        columns: surface::COLUMNS.to_vec(),
        rows,
        panels: surface::PANELS.to_vec(),
    })
}

/// What measures that need no graphics adapter run on. A debug build says so: its seconds mean little.
fn processor() -> String {
    let build = if cfg!(debug_assertions) { ", debug build" } else { "" };
    format!("CPU, {} threads{build}", rayon::current_num_threads())
}

/// Writes table and picture, and says where they are.
fn write(chart: &Chart, folder: &Path, output: &mut Output) -> Result<Exit, Failure> {
    let svg = chart::svg(chart)?;
    create(folder)?;
    let path = |extension: &str| folder.join(format!("{}.{extension}", chart.topic));
    let files = [(path("csv"), chart.csv()), (path("svg"), svg)];
    for (path, text) in &files {
        io::write_atomic(path, text.as_bytes())?;
    }
    let files: Vec<String> = files.iter().map(|(path, _)| path.display().to_string()).collect();
    let value = json!({
        "topic": chart.topic,
        "adapter": chart.adapter,
        "files": files,
        "rows": rows(chart),
    });
    output.result(&files.join("\n"), &value)?;
    Ok(Exit::Done)
}

fn rows(chart: &Chart) -> Vec<Value> {
    let fronts: Vec<_> = chart.front_columns().zip(chart.panels.iter().map(|p| chart.on_front(p))).collect();
    let row = |(i, row): (usize, &Row)| {
        let mut object = Map::new();
        object.insert("series".into(), json!(row.series));
        for (column, cell) in chart.columns.iter().zip(&row.cells) {
            object.insert((*column).into(), value(cell));
        }
        object.insert("default".into(), json!(row.default));
        for (name, front) in &fronts {
            object.insert(name.clone(), json!(front[i]));
        }
        object.insert("command".into(), json!(row.command));
        Value::Object(object)
    };
    chart.rows.iter().enumerate().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_survive_a_shell() {
        for (word, expected) in [
            ("a/b-c.glb", "a/b-c.glb"),
            ("my fox.glb", "'my fox.glb'"),
            ("it's", r"'it'\''s'"),
            ("", "''"),
            ("a[1]", "'a[1]'"),
        ] {
            assert_eq!(shell_word(word), expected);
        }
    }
}
