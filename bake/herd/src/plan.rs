//! Commands of a herd with their inputs and outputs.

use super::arguments::{Word, sets};
use super::estimate::{CommandCost, History};
use super::file::{Chart, HerdFile, Sequence, TruthOptions, Variant, ViewRule, fitting};
use super::kind::Kind;
use super::model_file::{ModelFile, NAME};
use pelage_import::BakeError;
use pelage_stage::TomlText;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Input of a plan.
#[derive(Clone, Copy)]
pub struct PlanInput<'a> {
    /// Name and text of the herd file, for messages.
    pub source: TomlText<'a>,
    /// Parsed herd file.
    pub file: &'a HerdFile,
    /// Models, in the order of their paths.
    pub models: &'a [ModelFile],
    /// Output folder, relative to the herd file's folder.
    pub out: &'a str,
    /// Keys of looks without effect on a reference image, such as `fur.layers`.
    pub only_drawn: &'a [&'a str],
    /// Measured cost of earlier runs, by task name.
    pub history: &'a History,
    /// Returns whether a file exists, relative to the herd file's folder.
    pub is_file: &'a dyn Fn(&str) -> bool,
}

/// Command of a herd, with its inputs and outputs.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Task {
    /// Unique name.
    pub name: String,
    /// Kind of command.
    pub kind: Kind,
    /// Index of its [`Row`] in the plan; `None` for a chart without a model.
    pub row: Option<usize>,
    /// Name of the view that it draws or traces, if any.
    pub view: Option<String>,
    /// Command-line arguments after `pelage`.
    pub words: Vec<String>,
    /// Input files that are known in advance. The depfile lists further files that the command reads.
    pub inputs: Vec<String>,
    /// Output files.
    pub outputs: Vec<String>,
    /// File for the command's JSON record.
    pub record: String,
    /// Depfile: lists all files that the command has read.
    pub depfile: Option<String>,
    /// Whether the task is part of a job that is divided among several machines.
    #[serde(skip)]
    pub part: bool,
    /// Expected time and memory.
    pub expected: CommandCost,
}

impl Task {
    /// Returns the full command line, with the options `--record`, `--depfile` and `--cache` where they apply.
    /// Benchmarks, chart rows and `inspect` are never cached.
    pub fn command(&self, cache: Option<&str>) -> Vec<String> {
        let mut words = vec!["pelage".to_owned()];
        words.extend(self.words.iter().cloned());
        words.push("--quiet".into());
        let options = [("--depfile", self.depfile.as_deref()), ("--record", Some(self.record.as_str()))];
        let cache = cache.filter(|_| self.is_cacheable());
        for (option, value) in options.into_iter().chain([("--cache", cache)]) {
            words.extend(value.into_iter().flat_map(|value| [option.to_owned(), value.to_owned()]));
        }
        words
    }

    fn is_cacheable(&self) -> bool {
        !matches!(self.kind, Kind::Inspect | Kind::Bench | Kind::Chart | Kind::Rows)
    }
}

/// Model in one variant; a row of the report.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Row {
    /// Name of the model.
    pub name: String,
    /// Name of the variant; `None` for a model without variants.
    pub variant: Option<String>,
    /// Path of the model, relative to the herd file's folder.
    pub model: String,
    /// Path of the recipe file, if any.
    pub recipe: Option<String>,
    /// Path of the package.
    pub package: String,
}

/// Plan of a herd: rows of the report, and the commands to run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Plan {
    /// Output folder, relative to the herd file's folder.
    pub out: String,
    /// Rows of the report: models, each in each of its variants.
    pub rows: Vec<Row>,
    /// Commands, in dependency order.
    pub tasks: Vec<Task>,
}

impl Plan {
    /// Returns the folder for internal files of a herd with the output folder `out`.
    pub fn own_folder(out: &str) -> String {
        join(out, ".herd")
    }

    /// Returns a file's path relative to the output folder.
    pub fn inside<'a>(&self, file: &'a str) -> &'a str {
        file.strip_prefix(self.out.as_str()).unwrap_or(file).trim_start_matches('/')
    }

    /// Returns, for each output file, the index of the task that makes it.
    pub fn makers(&self) -> BTreeMap<&str, usize> {
        self.tasks.iter().enumerate().flat_map(|(i, task)| task.outputs.iter().map(move |o| (o.as_str(), i))).collect()
    }
}

pub(super) fn join(folder: &str, name: &str) -> String {
    if folder.is_empty() || folder == "." {
        name.to_owned()
    } else {
        format!("{}/{name}", folder.trim_end_matches('/'))
    }
}

/// Plans the commands of a herd.
///
/// Fails with [`BakeError::Input`] in the herd file if no model matches, or two outputs have the same name.
pub fn plan(input: &PlanInput<'_>) -> Result<Plan, BakeError> {
    if input.models.is_empty() {
        return Err(fault(input, "model", "no file matches these patterns, expected at least one model".into()));
    }
    let names = names(input.models);
    let mut plan = Plan { out: input.out.to_owned(), ..Plan::default() };
    let mut packages: BTreeMap<String, String> = BTreeMap::new();
    for (model, name) in input.models.iter().zip(&names) {
        let variants: Vec<&Variant> = fitting(&input.file.variants, &input.file.rules.variants, &model.path).collect();
        let variants: Vec<Option<&Variant>> =
            if variants.is_empty() { vec![None] } else { variants.into_iter().map(Some).collect() };
        for variant in variants {
            let called = variant.map_or_else(|| name.clone(), |variant| format!("{name}.{}", variant.name));
            if let Some(other) = packages.insert(called.clone(), model.path.clone()) {
                let reason =
                    format!("{} and {other} would both be named {called:?}, expected unique names", model.path);
                return Err(fault(input, "model", reason));
            }
            Planner { input, plan: &mut plan, model, called: &called }.model(name, variant);
        }
    }
    for chart in input.file.charts.iter().filter(|chart| chart.models.is_none()) {
        let model = &ModelFile::default();
        Planner { input, plan: &mut plan, model, called: "" }.chart(chart, None);
    }
    let (mut makers, mut names) = (BTreeMap::new(), BTreeSet::new());
    for task in &plan.tasks {
        if !names.insert(task.name.as_str()) {
            let reason = format!("two commands would both be named {:?}, expected unique names", task.name);
            return Err(fault(input, "", reason));
        }
        for output in task.outputs.iter().chain([&task.record]) {
            if let Some(other) = makers.insert(output.as_str(), task.name.as_str()) {
                let reason = format!("{:?} and {other:?} would both write {output}, expected unique names", task.name);
                return Err(fault(input, "", reason));
            }
        }
    }
    Ok(plan)
}

fn fault(input: &PlanInput<'_>, key: &str, reason: String) -> BakeError {
    HerdFile::fault(input.source, key, reason)
}

/// Returns a unique name for each model: its path without leading components such as `..`. The extension is removed if
/// the name remains unique.
fn names(models: &[ModelFile]) -> Vec<String> {
    let inside = |path: &str| {
        let steps: Vec<&str> = path.split('/').filter(|step| !matches!(*step, "" | "." | "..")).collect();
        steps.join("/")
    };
    let stem = |path: &str| Path::new(&inside(path)).with_extension("").to_string_lossy().into_owned();
    let mut count: BTreeMap<String, usize> = BTreeMap::new();
    models.iter().for_each(|model| *count.entry(stem(&model.path)).or_default() += 1);
    models.iter().map(|m| Some(stem(&m.path)).filter(|s| count[s] == 1).unwrap_or_else(|| inside(&m.path))).collect()
}

/// Creates the tasks of one model in one variant.
struct Planner<'a, 'p> {
    input: &'a PlanInput<'a>,
    plan: &'p mut Plan,
    model: &'a ModelFile,
    /// Prefix of the names of all output files.
    called: &'a str,
}

/// Model that a chart is made of, and the arguments to bake it.
struct ChartInput<'a> {
    row: usize,
    /// Paths of the model and recipe files.
    inputs: &'a [String],
    /// Command-line arguments that select and change the recipe.
    making: &'a [String],
}

/// Task whose record and depfile have not been named yet.
#[derive(Default)]
struct Draft {
    kind: Kind,
    name: String,
    view: Option<String>,
    words: Vec<String>,
    inputs: Vec<String>,
    outputs: Vec<String>,
    /// Base path of the task's record and depfile in the herd's internal folder.
    place: String,
    /// Whether the command may read files that are not known in advance; it then gets a depfile.
    finds_more: bool,
    /// Whether the task is part of a job that is divided among several machines.
    part: bool,
    pixels: f64,
    samples: f64,
}

fn words(words: &[&str]) -> Vec<String> {
    words.iter().map(|word| (*word).to_owned()).collect()
}

/// Returns the command-line arguments of `words`, without their keys.
fn options(words: Vec<Word>) -> impl Iterator<Item = String> {
    words.into_iter().map(|(_, word)| word)
}

/// Returns the number of pixels of a size such as `256x256`, or of the default size.
fn pixels(size: Option<&str>) -> f64 {
    let sides = size.and_then(|size| size.split_once(['x', 'X']));
    let sides = sides.and_then(|(w, h)| Some(w.trim().parse::<f64>().ok()? * h.trim().parse::<f64>().ok()?));
    sides.unwrap_or(834.0 * 424.0)
}

impl Planner<'_, '_> {
    fn out(&self, name: &str) -> String {
        join(self.input.out, name)
    }

    fn add(&mut self, draft: Draft, row: Option<usize>) {
        let own = Plan::own_folder(self.input.out);
        let guess = || CommandCost::estimate(draft.kind, self.model.bytes, draft.pixels, draft.samples);
        let expected = self.input.history.get(&draft.name).copied().unwrap_or_else(guess);
        self.plan.tasks.push(Task {
            kind: draft.kind,
            row,
            view: draft.view,
            words: draft.words,
            inputs: draft.inputs,
            outputs: draft.outputs,
            record: format!("{own}/records/{}.json", draft.place),
            part: draft.part,
            depfile: draft.finds_more.then(|| format!("{own}/deps/{}.d", draft.place)),
            expected,
            name: draft.name,
        });
    }

    fn model(&mut self, name: &str, variant: Option<&Variant>) {
        let (called, path) = (self.called, self.model.path.as_str());
        let input = self.input;
        let rules = || fitting(&input.file.recipes, &input.file.rules.recipes, path);
        let named = |file: &String| self.recipe_file(file);
        let of_rules = || rules().filter_map(|rule| rule.file.as_ref().and_then(named)).next_back();
        let recipe = variant.and_then(|variant| variant.file.as_ref().and_then(named)).or_else(of_rules);
        let package = self.out(&format!("packages/{called}.pelage"));
        let mut making: Vec<String> = recipe.iter().flat_map(|recipe| words(&["--recipe", recipe])).collect();
        making.extend(rules().map(|rule| &rule.set).chain(variant.map(|variant| &variant.set)).flat_map(sets));
        if input.file.rules.model(path).is_some_and(|models| input.file.models[models].allow_outside) {
            making.push("--allow-outside".into());
        }
        let mut bake = words(&["bake", path, "-o", &package]);
        bake.extend(making.iter().cloned());
        // Several commands run at once, so each bake uses one thread.
        bake.extend(words(&["--threads", "1"]));
        let inputs: Vec<String> = [path.to_owned()].into_iter().chain(recipe.clone()).collect();
        let row = self.plan.rows.len();
        self.plan.rows.push(Row {
            name: name.to_owned(),
            variant: variant.map(|variant| variant.name.clone()),
            model: path.to_owned(),
            recipe,
            package: package.clone(),
        });
        let baked = Draft {
            kind: Kind::Bake,
            name: format!("bake {called}"),
            words: bake,
            inputs: inputs.clone(),
            outputs: vec![package.clone()],
            place: format!("packages/{called}"),
            finds_more: true,
            ..Draft::default()
        };
        self.add(baked, Some(row));
        let inspected = Draft {
            kind: Kind::Inspect,
            name: format!("inspect {called}"),
            words: words(&["inspect", &package]),
            inputs: vec![package.clone()],
            place: format!("inspect/{called}"),
            ..Draft::default()
        };
        self.add(inspected, Some(row));
        for view in fitting(&input.file.views, &input.file.rules.views, path) {
            self.view(view, row, &package);
        }
        for sequence in fitting(&input.file.sequences, &input.file.rules.sequences, path) {
            self.sequence(sequence, row, &package);
        }
        for (chart, patterns) in input.file.charts.iter().zip(&input.file.rules.charts) {
            if patterns.as_ref().is_some_and(|patterns| patterns.fits(path)) {
                self.chart(chart, Some(&ChartInput { row, inputs: &inputs, making: &making }));
            }
        }
    }

    /// Resolves a recipe file. If [`NAME`] occurs in it, the model's name replaces it, and the file must exist.
    fn recipe_file(&self, file: &str) -> Option<String> {
        if !file.contains(NAME) {
            return Some(file.to_owned());
        }
        Some(self.model.expand_name(file)).filter(|file| (self.input.is_file)(file))
    }

    /// Returns the input files of a picture that are known in advance: the package and the look file.
    fn view_inputs(view: &ViewRule, package: &str) -> Vec<String> {
        [package.to_owned()].into_iter().chain(view.look.clone()).collect()
    }

    fn view(&mut self, view: &ViewRule, row: usize, package: &str) {
        let called = self.called;
        let draft = |kind, what: &str, place: &str| Draft {
            kind,
            name: format!("{what} {called} {}", view.name),
            view: Some(view.name.clone()),
            inputs: Self::view_inputs(view, package),
            place: format!("{place}/{called}.{}", view.name),
            pixels: pixels(view.size.as_deref()),
            ..Draft::default()
        };
        let picture = self.out(&format!("pictures/{called}.{}.png", view.name));
        let mut command = words(&["render", package, "-o", &picture]);
        command.extend(options(view.words()));
        let drawn = draft(Kind::Render, "draw", "pictures");
        let outputs = vec![picture.clone()];
        self.add(Draft { words: command, outputs, finds_more: true, ..drawn }, Some(row));
        if let Some(frames) = view.bench {
            let mut command = words(&["bench", package, "--frames", &frames.to_string()]);
            command.extend(options(view.words()));
            self.add(Draft { words: command, ..draft(Kind::Bench, "time", "bench") }, Some(row));
        }
        let Some(truth) = &view.truth else { return };
        let traced = self.truth(view, truth, row, package);
        let compared = draft(Kind::Compare, "compare", "differences");
        let map = self.out(&format!("{}.png", compared.place));
        let mut command = words(&["compare", &picture, &traced, "-o", &map]);
        command.extend(truth.max_flip.map(|most| format!("--max-flip={most}")));
        self.add(Draft { words: command, inputs: vec![picture, traced], outputs: vec![map], ..compared }, Some(row));
    }

    /// Adds the tasks that trace the reference image of a view, whole or in parts. Returns its file.
    fn truth(&mut self, view: &ViewRule, truth: &TruthOptions, row: usize, package: &str) -> String {
        let (input, called) = (self.input, self.called);
        let place = format!("truths/{called}.{}", view.name);
        let picture = self.out(&format!("{place}.png"));
        let command = |output: &str| {
            let mut command = words(&["reference", package, "-o", output]);
            command.extend(options(view.reference_words(input.only_drawn)));
            command.extend(options(truth.words()));
            command.extend(words(&["--threads", "1"]));
            command
        };
        let parts = truth.parts.unwrap_or(1);
        let pixels = pixels(view.size.as_deref());
        let draft = |kind, what: &str| Draft {
            kind,
            name: format!("{what} {called} {}", view.name),
            view: Some(view.name.clone()),
            inputs: Self::view_inputs(view, package),
            outputs: vec![picture.clone()],
            place: place.clone(),
            pixels,
            ..Draft::default()
        };
        let samples = 1e-6 * pixels * f64::from(truth.samples.unwrap_or(64)) / f64::from(parts);
        let traced = || Draft { finds_more: true, samples, ..draft(Kind::Truth, "trace") };
        if parts == 1 {
            self.add(Draft { words: command(&picture), ..traced() }, Some(row));
            return picture;
        }
        let mut files = Vec::new();
        for part in 1..=parts {
            let traced = traced();
            let place = format!("{place}.parts/{part}");
            let file = self.out(&format!("{place}.part"));
            let mut words = command(&file);
            words.push(format!("--part={part}/{parts}"));
            let (name, outputs) = (format!("{} {part}/{parts}", traced.name), vec![file.clone()]);
            let traced = Draft { kind: Kind::Part, part: true, name, words, outputs, place, ..traced };
            self.add(traced, Some(row));
            files.push(file);
        }
        let mut words = words(&["merge", "-o", &picture]);
        words.extend(files.iter().cloned());
        self.add(Draft { words, inputs: files, ..draft(Kind::Merge, "merge") }, Some(row));
        picture
    }

    fn sequence(&mut self, sequence: &Sequence, row: usize, package: &str) {
        let named = sequence.view.as_deref();
        let view = self.input.file.views.iter().find(|view| Some(view.name.as_str()) == named).cloned();
        let mut view = view.unwrap_or_default();
        view.clip = sequence.clip.clone().or(view.clip);
        let folder = format!("sequences/{}.{}", self.called, sequence.name);
        let pattern = self.out(&format!("{folder}/%04d.png"));
        let (count, shares) = (sequence.frames, sequence.shares.unwrap_or(1));
        for share in 0..shares {
            // The pictures are distributed evenly: shares differ by at most one picture.
            let at = |share: u32| (u64::from(count) * u64::from(share) / u64::from(shares)) as u32;
            let (first, end) = (at(share), at(share + 1));
            let mut command = words(&["render", package, "-o", &pattern]);
            command.extend(options(view.words()));
            command.push(format!("--frames={first}..{end}/{count}"));
            command.extend(options(sequence.words()));
            let flags = [("--auto-rotate", sequence.auto_rotate), ("--turn-light", sequence.turn_light)];
            command.extend(flags.iter().filter(|(_, on)| *on).map(|(flag, _)| (*flag).to_owned()));
            let pictures = (first..end).map(|i| self.out(&format!("{folder}/{i:04}.png"))).collect();
            let draft = Draft {
                kind: Kind::Sequence,
                name: format!("sequence {} {} {first}..{end}", self.called, sequence.name),
                view: Some(sequence.name.clone()),
                words: command,
                inputs: Self::view_inputs(&view, package),
                outputs: pictures,
                place: format!("{folder}/{first}"),
                finds_more: true,
                part: shares > 1,
                pixels: pixels(view.size.as_deref()) * f64::from(end - first),
                ..Draft::default()
            };
            self.add(draft, Some(row));
        }
    }

    fn chart(&mut self, chart: &Chart, of: Option<&ChartInput<'_>>) {
        let topic = chart.topic.as_str();
        let folder = if of.is_some() { format!("charts/{}", self.called) } else { "charts".to_owned() };
        let row = of.map(|of| of.row);
        let inputs = of.map_or(&[][..], |of| of.inputs);
        let command = |folder: &str| {
            let mut command = words(&["chart", topic]);
            command.extend(inputs.first().cloned());
            command.extend(of.map_or(&[][..], |of| of.making).iter().cloned());
            command.extend(words(&["-o", folder]));
            command
        };
        let draft = || Draft {
            kind: Kind::Chart,
            name: format!("chart {topic} {}", self.called).trim_end().to_owned(),
            view: Some(topic.to_owned()),
            inputs: inputs.to_vec(),
            place: format!("{folder}/{topic}"),
            finds_more: true,
            ..Draft::default()
        };
        let mut whole = draft();
        let outputs = ["csv", "svg"].map(|extension| self.out(&format!("{}.{extension}", whole.place)));
        (whole.words, whole.outputs) = (command(&self.out(&folder)), outputs.into());
        let shares = chart.shares.unwrap_or(1);
        let mut rows = Vec::new();
        for share in (1..=shares).filter(|_| shares > 1) {
            let place = format!("{}.parts/{share}", whole.place);
            let mut words = command(&self.out(&place));
            words.extend([format!("--rows={share}/{shares}"), "--part".into()]);
            let file = self.out(&format!("{place}/{topic}.rows.jsonl"));
            whole.words.push(format!("--from={file}"));
            whole.inputs.push(file.clone());
            let name = format!("{} {share}/{shares}", whole.name);
            rows.push(Draft { kind: Kind::Rows, part: true, name, words, outputs: vec![file], place, ..draft() });
        }
        rows.into_iter().chain([whole]).for_each(|draft| self.add(draft, row));
    }
}
