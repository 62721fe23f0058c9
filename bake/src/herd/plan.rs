//! The commands that a herd takes, and what each reads and writes.

use super::estimate::{History, Known};
use super::file::{Chart, HerdFile, Rules, Sequence, Truth, Variant, View, assignments, fitting};
use super::kind::Kind;
use crate::BakeError;
use serde::Serialize;
use std::collections::BTreeMap;

/// A model on disk.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// From the herd file's folder, with slashes.
    pub path: String,
    /// Of the file.
    pub bytes: u64,
}

/// What a plan is made of.
#[derive(Clone, Copy)]
pub struct Told<'a> {
    /// The herd file's name, for messages.
    pub name: &'a str,
    /// What it says.
    pub file: &'a HerdFile,
    /// Its patterns.
    pub rules: &'a Rules,
    /// The models, in the order of their paths.
    pub models: &'a [Found],
    /// The folder that everything is written into, from the herd file's.
    pub out: &'a str,
    /// Keys of looks that mean nothing to a truth, such as `fur.layers`.
    pub only_drawn: &'a [&'a str],
    /// What commands have needed before.
    pub history: &'a History,
    /// Whether a file is there, from the herd file's folder.
    pub is_file: &'a dyn Fn(&str) -> bool,
}

/// A command, and what it depends on.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Task {
    /// What it is called.
    pub name: String,
    /// What it does.
    pub kind: Kind,
    /// Number of the row that it belongs to; `None` for a chart without a model.
    pub row: Option<usize>,
    /// The view that it is of.
    pub view: Option<String>,
    /// After `pelage`.
    pub words: Vec<String>,
    /// Files that it reads; it may find more, and names them in its depfile.
    pub inputs: Vec<String>,
    /// Files that it writes.
    pub outputs: Vec<String>,
    /// Where it says what became of it.
    pub record: String,
    /// Where it names all that it has read.
    pub depfile: Option<String>,
    /// What it is expected to need.
    pub expected: Known,
}

impl Task {
    /// All words of its command, with those that builds want. Timings are never kept.
    pub fn command(&self, cache: Option<&str>) -> Vec<String> {
        let mut words = vec!["pelage".to_owned()];
        words.extend(self.words.iter().cloned());
        words.push("--quiet".into());
        let options = [("--depfile", self.depfile.as_deref()), ("--record", Some(self.record.as_str()))];
        let cache = cache.filter(|_| self.may_be_kept());
        for (option, value) in options.into_iter().chain([("--cache", cache)]) {
            words.extend(value.into_iter().flat_map(|value| [option.to_owned(), value.to_owned()]));
        }
        words
    }

    fn may_be_kept(&self) -> bool {
        !matches!(self.kind, Kind::Inspect | Kind::Bench | Kind::Chart | Kind::Rows)
    }
}

/// A model in one variant: a row of the report.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Row {
    /// The model's name.
    pub name: String,
    /// The variant.
    pub variant: Option<String>,
    /// The model, from the herd file's folder.
    pub model: String,
    /// Its recipe.
    pub recipe: Option<String>,
    /// Where its package is.
    pub package: String,
}

/// All of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Plan {
    /// The folder that everything is written into, from the herd file's.
    pub out: String,
    /// The models.
    pub rows: Vec<Row>,
    /// The commands; what one reads is made by one before it.
    pub tasks: Vec<Task>,
}

impl Plan {
    /// Where a herd keeps what is nobody's result.
    pub fn own_folder(out: &str) -> String {
        join(out, ".herd")
    }

    /// Which task makes each file.
    pub fn makers(&self) -> BTreeMap<&str, usize> {
        self.tasks.iter().enumerate().flat_map(|(i, task)| task.outputs.iter().map(move |o| (o.as_str(), i))).collect()
    }
}

/// Stands for the name of a model's file, without its extension, in the name of a recipe.
pub const NAME: &str = "{name}";

/// A path below another.
pub(super) fn join(folder: &str, name: &str) -> String {
    if folder.is_empty() || folder == "." {
        name.to_owned()
    } else {
        format!("{}/{name}", folder.trim_end_matches('/'))
    }
}

/// Says which commands a herd takes.
///
/// # Errors
///
/// [`BakeError::Input`] in the herd file: no model fits, or two of one name.
pub fn plan(told: &Told<'_>) -> Result<Plan, BakeError> {
    if told.models.is_empty() {
        return Err(fault(told, "model", "no file fits these patterns, expected at least one model".into()));
    }
    let names = names(told.models);
    let mut plan = Plan { out: told.out.to_owned(), ..Plan::default() };
    let mut packages: BTreeMap<String, String> = BTreeMap::new();
    for (model, name) in told.models.iter().zip(&names) {
        let variants: Vec<&Variant> = fitting(&told.file.variants, &told.rules.variants, &model.path).collect();
        let variants: Vec<Option<&Variant>> =
            if variants.is_empty() { vec![None] } else { variants.into_iter().map(Some).collect() };
        for variant in variants {
            let called = variant.map_or_else(|| name.clone(), |variant| format!("{name}.{}", variant.name));
            if let Some(other) = packages.insert(called.clone(), model.path.clone()) {
                let reason = format!("{} and {other} would both be {called:?}, expected other names", model.path);
                return Err(fault(told, "model", reason));
            }
            Planner { told, plan: &mut plan, model, called: &called }.model(name, variant);
        }
    }
    for chart in told.file.charts.iter().filter(|chart| chart.models.is_none()) {
        let model = &Found::default();
        Planner { told, plan: &mut plan, model, called: "" }.chart(chart, None);
    }
    let mut makers = BTreeMap::new();
    for task in &plan.tasks {
        for output in task.outputs.iter().chain([&task.record]) {
            if let Some(other) = makers.insert(output.as_str(), task.name.as_str()) {
                let reason = format!("{:?} and {other:?} would both write {output}, expected other names", task.name);
                return Err(fault(told, "whole file", reason));
            }
        }
    }
    Ok(plan)
}

fn fault(told: &Told<'_>, place: &str, reason: String) -> BakeError {
    BakeError::Input { file: told.name.to_owned(), place: place.to_owned(), reason }
}

/// Names of models: their paths without what leads out of the herd's folder, and without extensions where these do not tell models apart.
fn names(models: &[Found]) -> Vec<String> {
    let inside = |path: &str| {
        let steps: Vec<&str> = path.split('/').filter(|step| !matches!(*step, "" | "." | "..")).collect();
        steps.join("/")
    };
    let stem = |path: &str| {
        let path = inside(path);
        let name = path.rfind('/').map_or(0, |slash| slash + 1);
        match path[name..].rfind('.') {
            Some(dot) if dot > 0 => path[..name + dot].to_owned(),
            _ => path,
        }
    };
    let mut count: BTreeMap<String, usize> = BTreeMap::new();
    models.iter().for_each(|model| *count.entry(stem(&model.path)).or_default() += 1);
    models.iter().map(|m| Some(stem(&m.path)).filter(|s| count[s] == 1).unwrap_or_else(|| inside(&m.path))).collect()
}

/// Adds the tasks of one model in one variant.
struct Planner<'a, 'p> {
    told: &'a Told<'a>,
    plan: &'p mut Plan,
    model: &'a Found,
    /// What its files are called.
    called: &'a str,
}

/// A task before its record and depfile have names.
struct Draft {
    kind: Kind,
    name: String,
    view: Option<String>,
    words: Vec<String>,
    inputs: Vec<String>,
    outputs: Vec<String>,
    /// Stands for it among the herd's own files.
    place: String,
    /// Whether it may read files that nobody knows yet.
    finds_more: bool,
    pixels: f64,
    samples: f64,
}

fn words(words: &[&str]) -> Vec<String> {
    words.iter().map(|word| (*word).to_owned()).collect()
}

/// Pixels of a size such as `256x256`; those of the default where there is none.
fn pixels(size: Option<&str>) -> f64 {
    let sides = size.and_then(|size| size.split_once(['x', 'X']));
    let sides = sides.and_then(|(w, h)| Some(w.trim().parse::<f64>().ok()? * h.trim().parse::<f64>().ok()?));
    sides.unwrap_or(834.0 * 424.0)
}

impl Planner<'_, '_> {
    fn out(&self, name: &str) -> String {
        join(self.told.out, name)
    }

    fn add(&mut self, draft: Draft, row: Option<usize>) {
        let own = Plan::own_folder(self.told.out);
        let guess = || Known::guess(draft.kind, self.model.bytes, draft.pixels, draft.samples);
        let expected = self.told.history.get(&draft.name).copied().unwrap_or_else(guess);
        self.plan.tasks.push(Task {
            kind: draft.kind,
            row,
            view: draft.view,
            words: draft.words,
            inputs: draft.inputs,
            outputs: draft.outputs,
            record: format!("{own}/records/{}.json", draft.place),
            depfile: draft.finds_more.then(|| format!("{own}/deps/{}.d", draft.place)),
            expected,
            name: draft.name,
        });
    }

    fn model(&mut self, name: &str, variant: Option<&Variant>) {
        let (called, path) = (self.called, self.model.path.as_str());
        let told = self.told;
        let rules = || fitting(&told.file.recipes, &told.rules.recipes, path);
        let named = |file: &String| self.recipe_file(file);
        let of_rules = || rules().filter_map(|rule| rule.file.as_ref().and_then(named)).next_back();
        let recipe = variant.and_then(|variant| variant.file.as_ref().and_then(named)).or_else(of_rules);
        let package = self.out(&format!("packages/{called}.pelage"));
        let mut bake = words(&["bake", path, "-o", &package]);
        bake.extend(recipe.iter().flat_map(|recipe| words(&["--recipe", recipe])));
        let sets = rules().map(|rule| &rule.set).chain(variant.map(|variant| &variant.set));
        bake.extend(sets.flat_map(assignments).flat_map(|set| words(&["--set", &set])));
        if told.rules.model(path).is_some_and(|models| told.file.models[models].allow_outside) {
            bake.push("--allow-outside".into());
        }
        // Cores are for several commands at once.
        bake.extend(words(&["--threads", "1"]));
        let inputs = [path.to_owned()].into_iter().chain(recipe.clone()).collect();
        let (row, first) = (self.plan.rows.len(), self.plan.tasks.len());
        self.plan.rows.push(Row {
            name: name.to_owned(),
            variant: variant.map(|variant| variant.name.clone()),
            model: path.to_owned(),
            recipe,
            package: package.clone(),
        });
        let draft = |kind, what: &str, words, inputs, outputs: Vec<String>, place: &str| Draft {
            kind,
            name: format!("{what} {called}"),
            view: None,
            words,
            inputs,
            outputs,
            place: place.to_owned(),
            finds_more: false,
            pixels: 0.0,
            samples: 0.0,
        };
        let baked = draft(Kind::Bake, "bake", bake, inputs, vec![package.clone()], &format!("packages/{called}"));
        self.add(Draft { finds_more: true, ..baked }, Some(row));
        let look = draft(
            Kind::Inspect,
            "inspect",
            words(&["inspect", &package]),
            vec![package.clone()],
            Vec::new(),
            &format!("inspect/{called}"),
        );
        self.add(look, Some(row));
        for view in fitting(&told.file.views, &told.rules.views, path) {
            self.view(view, row, &package);
        }
        for sequence in fitting(&told.file.sequences, &told.rules.sequences, path) {
            self.sequence(sequence, row, &package);
        }
        for (chart, patterns) in told.file.charts.iter().zip(&told.rules.charts) {
            if patterns.as_ref().is_some_and(|patterns| patterns.fits(path)) {
                self.chart(chart, Some((row, first)));
            }
        }
    }

    /// A recipe by its name, in which [`NAME`] stands for the model's: then it counts where there is such a file.
    fn recipe_file(&self, file: &str) -> Option<String> {
        if !file.contains(NAME) {
            return Some(file.to_owned());
        }
        let name = self.model.path.rsplit('/').next().unwrap_or_default();
        let stem = name.rfind('.').filter(|dot| *dot > 0).map_or(name, |dot| &name[..dot]);
        Some(file.replace(NAME, stem)).filter(|file| (self.told.is_file)(file))
    }

    /// The options of a view; `truth` leaves out what means nothing to it.
    fn options(told: &Told<'_>, view: &View, truth: bool) -> Vec<String> {
        let mut options = Vec::new();
        let mut option = |name: &str, value: &Option<String>| {
            options.extend(value.iter().map(|value| format!("--{name}={value}")));
        };
        option("size", &view.size);
        option("camera", &view.camera);
        option("orbit", &view.orbit);
        option("look-at", &view.look_at);
        option("look", &view.look);
        option("clip", &view.clip);
        option("time", &view.time.map(|time| time.to_string()));
        let drawn = |set: &String| set.split('=').next().is_some_and(|key| told.only_drawn.contains(&key));
        let sets = assignments(&view.set).into_iter().filter(|set| !truth || !drawn(set));
        options.extend(sets.map(|set| format!("--look={set}")));
        options
    }

    fn view(&mut self, view: &View, row: usize, package: &str) {
        let called = self.called;
        let pixels = pixels(view.size.as_deref());
        let place = format!("pictures/{called}.{}", view.name);
        let picture = self.out(&format!("{place}.png"));
        let reads = |more: &[String]| {
            let looks = view.look.iter().cloned();
            [package.to_owned()].into_iter().chain(looks).chain(more.iter().cloned()).collect::<Vec<_>>()
        };
        let mut command = words(&["render", package, "-o", &picture]);
        command.extend(Self::options(self.told, view, false));
        let draft = |kind, what: &str, words, inputs, outputs, place: &str| Draft {
            kind,
            name: format!("{what} {called} {}", view.name),
            view: Some(view.name.clone()),
            words,
            inputs,
            outputs,
            place: place.to_owned(),
            finds_more: false,
            pixels,
            samples: 0.0,
        };
        let drawn = draft(Kind::Render, "draw", command, reads(&[]), vec![picture.clone()], &place);
        self.add(Draft { finds_more: true, ..drawn }, Some(row));
        if let Some(frames) = view.bench {
            let mut command = words(&["bench", package, "--frames", &frames.to_string()]);
            command.extend(Self::options(self.told, view, false));
            let place = format!("bench/{called}.{}", view.name);
            self.add(draft(Kind::Bench, "time", command, reads(&[]), Vec::new(), &place), Some(row));
        }
        let Some(truth) = &view.truth else { return };
        let traced = self.truth(view, truth, row, package, &reads(&[]));
        let place = format!("differences/{called}.{}", view.name);
        let map = self.out(&format!("{place}.png"));
        let mut command = words(&["compare", &picture, &traced, "-o", &map]);
        command.extend(truth.max_flip.map(|most| format!("--max-flip={most}")));
        let inputs = vec![picture, traced];
        self.add(draft(Kind::Compare, "compare", command, inputs, vec![map], &place), Some(row));
    }

    /// The true picture of a view, in one piece or in parts; its file.
    fn truth(&mut self, view: &View, truth: &Truth, row: usize, package: &str, inputs: &[String]) -> String {
        let called = self.called;
        let pixels = pixels(view.size.as_deref());
        let place = format!("truths/{called}.{}", view.name);
        let picture = self.out(&format!("{place}.png"));
        let told = self.told;
        let command = |output: &str| {
            let mut command = words(&["reference", package, "-o", output]);
            command.extend(Self::options(told, view, true));
            command.extend(truth.samples.map(|n| format!("--spp={n}")));
            command.extend(truth.fibre.iter().map(|fibre| format!("--fibre={fibre}")));
            command.extend(truth.bounces.map(|n| format!("--bounces={n}")));
            command.extend(words(&["--threads", "1"]));
            command
        };
        let parts = truth.parts.unwrap_or(1);
        let samples = 1e-6 * pixels * f64::from(truth.samples.unwrap_or(64)) / f64::from(parts);
        let draft = |kind, name, words, inputs, output: &str, place: &str| Draft {
            kind,
            name,
            view: Some(view.name.clone()),
            words,
            inputs,
            outputs: vec![output.to_owned()],
            place: place.to_owned(),
            finds_more: true,
            pixels,
            samples,
        };
        let named = |what: &str| format!("{what} {called} {}", view.name);
        if parts == 1 {
            let whole = draft(Kind::Truth, named("trace"), command(&picture), inputs.to_vec(), &picture, &place);
            self.add(whole, Some(row));
            return picture;
        }
        let mut files = Vec::new();
        for part in 1..=parts {
            let place = format!("{place}.parts/{part}");
            let file = self.out(&format!("{place}.part"));
            let mut words = command(&file);
            words.push(format!("--part={part}/{parts}"));
            let name = format!("{} {part}/{parts}", named("trace"));
            self.add(draft(Kind::Part, name, words, inputs.to_vec(), &file, &place), Some(row));
            files.push(file);
        }
        let mut words = words(&["merge", "-o", &picture]);
        words.extend(files.iter().cloned());
        let merged = draft(Kind::Merge, named("merge"), words, files, &picture, &place);
        self.add(Draft { finds_more: false, samples: 0.0, ..merged }, Some(row));
        picture
    }

    fn sequence(&mut self, sequence: &Sequence, row: usize, package: &str) {
        let named = sequence.view.as_deref();
        let view = self.told.file.views.iter().find(|view| Some(view.name.as_str()) == named).cloned();
        let mut view = view.unwrap_or_default();
        view.clip = sequence.clip.clone().or(view.clip);
        let folder = format!("sequences/{}.{}", self.called, sequence.name);
        let pattern = self.out(&format!("{folder}/%04d.png"));
        let (count, shares) = (sequence.frames, sequence.shares.unwrap_or(1));
        for share in 0..shares {
            // As even as whole pictures can be.
            let at = |share: u32| (u64::from(count) * u64::from(share) / u64::from(shares)) as u32;
            let (first, end) = (at(share), at(share + 1));
            let mut command = words(&["render", package, "-o", &pattern]);
            command.extend(Self::options(self.told, &view, false));
            command.push(format!("--frames={first}..{end}/{count}"));
            command.extend(sequence.fps.map(|fps| format!("--fps={fps}")));
            let flags = [("--auto-rotate", sequence.auto_rotate), ("--turn-light", sequence.turn_light)];
            command.extend(flags.iter().filter(|(_, on)| *on).map(|(flag, _)| (*flag).to_owned()));
            let pictures = (first..end).map(|i| self.out(&format!("{folder}/{i:04}.png"))).collect();
            let draft = Draft {
                kind: Kind::Sequence,
                name: format!("sequence {} {} {first}..{end}", self.called, sequence.name),
                view: Some(sequence.name.clone()),
                words: command,
                inputs: [package.to_owned()].into_iter().chain(view.look.clone()).collect(),
                outputs: pictures,
                place: format!("{folder}/{first}"),
                finds_more: true,
                pixels: pixels(view.size.as_deref()) * f64::from(end - first),
                samples: 0.0,
            };
            self.add(draft, Some(row));
        }
    }

    /// * `of`: row of a model, and the number of its bake, whose recipe the chart has
    fn chart(&mut self, chart: &Chart, of: Option<(usize, usize)>) {
        let topic = chart.topic.as_str();
        let folder = if of.is_some() { format!("charts/{}", self.called) } else { "charts".to_owned() };
        let (row, bake) = (of.map(|(row, _)| row), of.map(|(_, bake)| &self.plan.tasks[bake]));
        let recipe: Vec<String> = bake.map_or_else(Vec::new, |bake| {
            let pairs = bake.words.windows(2).filter(|pair| matches!(pair[0].as_str(), "--recipe" | "--set"));
            let outside = bake.words.iter().filter(|word| *word == "--allow-outside").cloned();
            pairs.flatten().cloned().chain(outside).collect()
        });
        let inputs: Vec<String> = bake.map_or_else(Vec::new, |bake| bake.inputs.clone());
        let command = |folder: &str| {
            let mut command = words(&["chart", topic]);
            command.extend(inputs.first().cloned());
            command.extend(recipe.iter().cloned());
            command.extend(words(&["-o", folder]));
            command
        };
        let name = format!("chart {topic} {}", self.called).trim_end().to_owned();
        let draft = |kind, name, words, inputs, outputs, place| Draft {
            kind,
            name,
            view: Some(topic.to_owned()),
            words,
            inputs,
            outputs,
            place,
            finds_more: true,
            pixels: 0.0,
            samples: 0.0,
        };
        let shares = chart.shares.unwrap_or(1);
        let (mut whole, mut files) = (command(&self.out(&folder)), Vec::new());
        for share in (1..=shares).filter(|_| shares > 1) {
            let place = format!("{folder}/{topic}.parts/{share}");
            let mut words = command(&self.out(&place));
            words.extend([format!("--rows={share}/{shares}"), "--part".into()]);
            let file = self.out(&format!("{place}/{topic}.rows.jsonl"));
            let name = format!("{name} {share}/{shares}");
            self.add(draft(Kind::Rows, name, words, inputs.clone(), vec![file.clone()], place), row);
            whole.push(format!("--from={file}"));
            files.push(file);
        }
        let outputs = ["csv", "svg"].map(|extension| self.out(&format!("{folder}/{topic}.{extension}"))).into();
        let inputs = inputs.iter().cloned().chain(files).collect();
        self.add(draft(Kind::Chart, name, whole, inputs, outputs, format!("{folder}/{topic}")), row);
    }
}
