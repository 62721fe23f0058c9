//! Contents of a herd file.

use super::model_file::{ModelFile, NAME};
use super::pattern::{Patterns, base};
use pelage_import::BakeError;
use pelage_stage::{StageError, TomlText};
use serde::{Deserialize, Deserializer};
use std::collections::{BTreeMap, BTreeSet};

/// Parsed herd file: which outputs to make from which models.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HerdFile {
    /// Title of the HTML report.
    pub title: Option<String>,
    /// Models; at least one.
    #[serde(default, rename = "model")]
    pub models: Vec<ModelRule>,
    /// Rules that select the recipe of each model.
    #[serde(default, rename = "recipe")]
    pub recipes: Vec<RecipeRule>,
    /// Variants, for models that are baked more than once.
    #[serde(default, rename = "variant")]
    pub variants: Vec<Variant>,
    /// Pictures to draw of each package.
    #[serde(default, rename = "view")]
    pub views: Vec<ViewRule>,
    /// Charts of speed against accuracy.
    #[serde(default, rename = "chart")]
    pub charts: Vec<Chart>,
    /// Picture sequences to draw of each package.
    #[serde(default, rename = "sequence")]
    pub sequences: Vec<Sequence>,
    /// Compiled patterns of all tables.
    #[serde(skip)]
    pub rules: Rules,
}

/// List of strings, written in TOML as one string or as an array.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Words(pub Vec<String>);

impl<'de> Deserialize<'de> for Words {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "expected a pattern, or a list of patterns")]
        enum Either {
            One(String),
            Many(Vec<String>),
        }
        Ok(Self(match Either::deserialize(deserializer)? {
            Either::One(word) => vec![word],
            Either::Many(words) => words,
        }))
    }
}

/// Returns the pattern `**`, which matches all models.
fn all() -> Words {
    Words(vec!["**".into()])
}

/// `[[model]]`: models on disk.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelRule {
    /// Patterns of model paths, relative to the herd file's folder.
    pub files: Words,
    /// Patterns of files to exclude.
    #[serde(default)]
    pub except: Words,
    /// Whether the models may reference files outside their own folders.
    #[serde(default)]
    pub allow_outside: bool,
}

/// `[[recipe]]`: a rule that selects and changes the recipe of matching models. If several rules match a model, the
/// file of the last one is used, and the changes of all are applied in order.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecipeRule {
    /// Patterns of the models that the rule applies to.
    #[serde(default = "all")]
    pub models: Words,
    /// Recipe file, relative to the herd file's folder. `{name}` is replaced by the stem of the model's file name. A
    /// file with `{name}` is used only if it exists.
    pub file: Option<String>,
    /// Recipe keys to change, and their new values.
    #[serde(default)]
    pub set: toml::Table,
}

/// `[[variant]]`: variant of a bake. A model is baked once for each variant that it matches, or once if it matches
/// none.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Variant {
    /// Name of the variant, used in the names of its packages.
    pub name: String,
    /// Patterns of the models that the variant applies to.
    #[serde(default = "all")]
    pub models: Words,
    /// Recipe file that replaces the file chosen by the `[[recipe]]` rules.
    pub file: Option<String>,
    /// Recipe changes, applied after those of the `[[recipe]]` rules.
    #[serde(default)]
    pub set: toml::Table,
}

/// `[[view]]`: a picture of each package.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewRule {
    /// Name of the view, used in the names of its pictures.
    pub name: String,
    /// Patterns of the models to draw.
    #[serde(default = "all")]
    pub models: Words,
    /// Size in pixels: `"256x256"`.
    pub size: Option<String>,
    /// Camera, as in `--camera`; by default the camera frames the model.
    pub camera: Option<String>,
    /// Orbit, as in `--orbit`.
    pub orbit: Option<String>,
    /// Target, as in `--look-at`.
    pub look_at: Option<String>,
    /// Look file, relative to the herd file's folder.
    pub look: Option<String>,
    /// Look keys to change, and their new values.
    #[serde(default)]
    pub set: toml::Table,
    /// Name of the animation clip.
    pub clip: Option<String>,
    /// Time in the clip, seconds.
    pub time: Option<f64>,
    /// Number of frames that `bench` times; no benchmark without it.
    pub bench: Option<u32>,
    /// Options of the ray-traced reference image that this view is compared with.
    pub truth: Option<TruthOptions>,
}

/// `[view.truth]`: traces a reference image of the view and compares the rendered picture with it.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TruthOptions {
    /// Samples per pixel.
    pub samples: Option<u32>,
    /// Number of parts that the reference image is divided into, each traced by its own command.
    pub parts: Option<u32>,
    /// Fibre model, as in `--fibre`.
    pub fibre: Option<String>,
    /// Maximum number of bounces, as in `--bounces`.
    pub bounces: Option<u32>,
    /// Largest accepted mean FLIP between the picture and the reference image.
    pub max_flip: Option<f64>,
}

/// `[[chart]]`: a chart for each matching model, or one chart without a model.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chart {
    /// Topic, as in `pelage chart`.
    pub topic: String,
    /// Patterns of the models to chart; `None` makes one chart without a model.
    pub models: Option<Words>,
    /// Number of commands among which the rows of the chart are divided.
    pub shares: Option<u32>,
}

/// `[[sequence]]`: a sequence of numbered pictures of each package.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sequence {
    /// Name of the sequence and of its folder.
    pub name: String,
    /// Patterns of the models to draw.
    #[serde(default = "all")]
    pub models: Words,
    /// Name of the view whose look and camera are used.
    pub view: Option<String>,
    /// Name of the animation clip; overrides the clip of the view.
    pub clip: Option<String>,
    /// Number of pictures.
    pub frames: u32,
    /// Pictures per second.
    pub fps: Option<u32>,
    /// Number of commands among which the pictures are divided.
    pub shares: Option<u32>,
    /// Whether the camera makes one full turn over the sequence.
    #[serde(default)]
    pub auto_rotate: bool,
    /// Whether the light makes one full turn over the sequence.
    #[serde(default)]
    pub turn_light: bool,
}

/// Largest number of parts or shares. With more, the start-up of the commands would take most of the time.
const MOST_SHARES: u32 = 1000;

/// Key in the herd file, and the error found there.
pub(super) type Fault = (String, String);

impl HerdFile {
    /// Parses a herd file. [`Self::read`] also validates the values that are passed to commands.
    ///
    /// Fails with [`BakeError::Input`] with line and key for invalid or contradictory content.
    pub fn parse(source: TomlText<'_>) -> Result<Self, BakeError> {
        let mut file: Self = source.parse().map_err(input)?;
        let fault = |(key, reason): Fault| Self::fault(source, &key, reason);
        file.names_fault().map_or(Ok(()), |found| Err(fault(found)))?;
        file.rules = Rules::of(&file).map_err(fault)?;
        file.numbers_fault().map_or(Ok(file), |found| Err(fault(found)))
    }

    /// Creates an error for a key of the file, with its line number.
    pub fn fault(source: TomlText<'_>, key: &str, reason: String) -> BakeError {
        input(source.fault(key, reason))
    }

    /// Returns warnings about unused entries: patterns that match no model, and recipe files with `{name}` that match
    /// none.
    ///
    /// * `source`: source of the herd file, for messages
    /// * `models`: models that were found
    /// * `is_file`: returns whether a file exists, relative to the herd file's folder
    pub fn unused_entries(
        &self,
        source: TomlText<'_>,
        models: &[ModelFile],
        is_file: &dyn Fn(&str) -> bool,
    ) -> Vec<String> {
        let rules = &self.rules;
        let fits = |patterns: &Patterns| models.iter().any(|model| patterns.fits(&model.path));
        let all = [
            ("model", "files", rules.models.iter().map(Some).collect::<Vec<_>>()),
            ("recipe", "models", rules.recipes.iter().map(Some).collect()),
            ("variant", "models", rules.variants.iter().map(Some).collect()),
            ("view", "models", rules.views.iter().map(Some).collect()),
            ("chart", "models", rules.charts.iter().map(Option::as_ref).collect()),
            ("sequence", "models", rules.sequences.iter().map(Some).collect()),
        ];
        let mut idle: Vec<Fault> = Vec::new();
        for (table, key, rules) in all {
            let of_table = rules.into_iter().enumerate().filter(|(_, rule)| rule.is_some_and(|rule| !fits(rule)));
            idle.extend(of_table.map(|(i, _)| (format!("{table}[{i}].{key}"), "matches no model".to_owned())));
        }
        for (key, file, patterns) in self.recipe_files().filter(|(_, file, _)| file.contains(NAME)) {
            let mut named =
                models.iter().filter(|model| patterns.fits(&model.path)).map(|model| model.expand_name(file));
            let Some(first) = named.next() else { continue };
            if !is_file(&first) && !named.any(|file| is_file(&file)) {
                idle.push((key, format!("no model has such a recipe file; for the first model it would be {first:?}")));
            }
        }
        idle.into_iter().map(|(key, reason)| Self::fault(source, &key, reason).to_string()).collect()
    }

    /// Returns the recipe files of all rules, each with its key in the herd file and the patterns of its models.
    pub fn recipe_files(&self) -> impl Iterator<Item = (String, &String, &Patterns)> {
        let rules = self.recipes.iter().map(|rule| &rule.file).zip(&self.rules.recipes).enumerate();
        let variants = self.variants.iter().map(|variant| &variant.file).zip(&self.rules.variants).enumerate();
        let rules = rules.map(|(i, named)| (format!("recipe[{i}].file"), named));
        let all = rules.chain(variants.map(|(i, named)| (format!("variant[{i}].file"), named)));
        all.filter_map(|(key, (file, patterns))| Some((key, file.as_ref()?, patterns)))
    }

    /// Returns the key and error of the first invalid name.
    fn names_fault(&self) -> Option<Fault> {
        if self.models.is_empty() {
            return Some(("".into(), "found no models, expected [[model]] with files = \"animals/**/*.glb\"".into()));
        }
        let names = |key: &str, names: Vec<&str>| {
            let mut known = BTreeSet::new();
            names.into_iter().enumerate().find_map(|(i, name)| {
                let place = format!("{key}[{i}].name");
                if name.is_empty() || name.starts_with('.') || name.contains(['/', '\\', ':', '%']) {
                    return Some((
                        place,
                        format!("found {name:?}, expected a file name without a leading . and without / \\ : %"),
                    ));
                }
                (!known.insert(name)).then(|| (place, format!("found {name:?} twice, expected unique names")))
            })
        };
        names("variant", self.variants.iter().map(|v| v.name.as_str()).collect())
            .or_else(|| names("view", self.views.iter().map(|v| v.name.as_str()).collect()))
            .or_else(|| names("sequence", self.sequences.iter().map(|s| s.name.as_str()).collect()))
    }

    /// Returns the key and error of the first invalid number or unknown view.
    fn numbers_fault(&self) -> Option<Fault> {
        let views: Vec<&str> = self.views.iter().map(|view| view.name.as_str()).collect();
        let shares = |key: String, shares: Option<u32>| {
            let wrong = shares.filter(|n| !(1..=MOST_SHARES).contains(n))?;
            Some((key, format!("found {wrong}, expected 1 to {MOST_SHARES}")))
        };
        for (i, view) in self.views.iter().enumerate() {
            if let Some(truth) = &view.truth
                && let fault @ Some(_) = shares(format!("view[{i}].truth.parts"), truth.parts)
            {
                return fault;
            }
        }
        for (i, chart) in self.charts.iter().enumerate() {
            if let fault @ Some(_) = shares(format!("chart[{i}].shares"), chart.shares) {
                return fault;
            }
        }
        for (i, sequence) in self.sequences.iter().enumerate() {
            let most = sequence.frames;
            if !(1..=100_000).contains(&most) {
                return Some((format!("sequence[{i}].frames"), format!("found {most}, expected 1 to 100000 pictures")));
            }
            if let Some(wrong) = sequence.shares.filter(|n| !(1..=most.min(MOST_SHARES)).contains(n)) {
                let most = most.min(MOST_SHARES);
                return Some((format!("sequence[{i}].shares"), format!("found {wrong}, expected 1 to {most}")));
            }
            if let Some(wrong) = sequence.view.as_deref().filter(|name| !views.contains(name)) {
                let reason = format!("found {wrong:?}, expected one of the views: {}", views.join(", "));
                return Some((format!("sequence[{i}].view"), reason));
            }
        }
        None
    }

    /// Returns the folders to search for models, relative to the herd file's folder. Each is mapped to the key of the
    /// first patterns that need it.
    pub fn folders(&self) -> BTreeMap<String, String> {
        let of = |(i, models): (usize, &ModelRule)| {
            models.files.0.iter().map(|pattern| (base(pattern), format!("model[{i}].files"))).collect::<Vec<_>>()
        };
        // Later entries of a map replace earlier ones; the reversed order keeps the first key of a folder.
        self.models.iter().enumerate().rev().flat_map(of).collect()
    }
}

/// Compiled patterns of a herd file, for matching many paths.
#[derive(Clone, Debug, Default)]
pub struct Rules {
    models: Vec<Patterns>,
    pub(super) recipes: Vec<Patterns>,
    pub(super) variants: Vec<Patterns>,
    pub(super) views: Vec<Patterns>,
    /// Patterns of each chart; `None` for a chart without a model.
    pub(super) charts: Vec<Option<Patterns>>,
    pub(super) sequences: Vec<Patterns>,
}

impl Rules {
    /// Compiles the patterns of a file, or returns the key and error of the first invalid one.
    fn of(file: &HerdFile) -> Result<Self, Fault> {
        let rules = |table: &str, words: Vec<&Words>| {
            let patterns = |(i, words): (usize, &Words)| patterns(format!("{table}[{i}].models"), words);
            words.into_iter().enumerate().map(patterns).collect::<Result<Vec<_>, _>>()
        };
        let models = |(i, models): (usize, &ModelRule)| {
            let found = patterns(format!("model[{i}].files"), &models.files)?;
            found.excluding(&models.except.0).map_err(|reason| (format!("model[{i}].except"), reason))
        };
        let chart = |(i, chart): (usize, &Chart)| {
            chart.models.as_ref().map(|words| patterns(format!("chart[{i}].models"), words)).transpose()
        };
        Ok(Self {
            models: file.models.iter().enumerate().map(models).collect::<Result<_, _>>()?,
            recipes: rules("recipe", file.recipes.iter().map(|recipe| &recipe.models).collect())?,
            variants: rules("variant", file.variants.iter().map(|variant| &variant.models).collect())?,
            views: rules("view", file.views.iter().map(|view| &view.models).collect())?,
            charts: file.charts.iter().enumerate().map(chart).collect::<Result<_, _>>()?,
            sequences: rules("sequence", file.sequences.iter().map(|sequence| &sequence.models).collect())?,
        })
    }

    /// Returns the index of the `[[model]]` that a path belongs to, if any.
    pub fn model(&self, path: &str) -> Option<usize> {
        self.models.iter().position(|patterns| patterns.fits(path))
    }
}

/// Compiles a list of patterns, which must not be empty.
fn patterns(key: String, words: &Words) -> Result<Patterns, Fault> {
    if words.0.is_empty() {
        return Err((key, "found no pattern, expected at least one".into()));
    }
    Patterns::new(&words.0).map_err(|reason| (key, reason))
}

/// Returns the items of `all` whose patterns match a path.
pub(super) fn fitting<'a, T>(
    all: &'a [T],
    rules: &'a [Patterns],
    path: &'a str,
) -> impl DoubleEndedIterator<Item = &'a T> {
    all.iter().zip(rules).filter(|(_, patterns)| patterns.fits(path)).map(|(one, _)| one)
}

fn input(error: StageError) -> BakeError {
    match error {
        StageError::Input { file, place, reason } => BakeError::Input { file, place, reason },
        other => BakeError::Internal(other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn herd_file_is_parsed() {
        let text = r##"
            [[model]]
            files = "a/*.glb"
            [[recipe]]
            models = ["*fox*", "*wolf*"]
            file = "fox.toml"
            set = { "hair.length_m" = 0.02, slice = { layers = 12 }, "color.tip" = "#ffffff" }
            [[view]]
            name = "front"
            truth = { samples = 4, parts = 2, max_flip = 0.1 }
            [[sequence]]
            name = "turn"
            view = "front"
            frames = 8
            shares = 2
        "##;
        let file = HerdFile::parse(TomlText::new("h.toml", text)).unwrap();
        assert_eq!(file.recipes[0].models.0, ["*fox*", "*wolf*"]);
        assert_eq!(file.views[0].models, all());
        assert_eq!(file.folders().into_iter().collect::<Vec<_>>(), [("a".to_owned(), "model[0].files".to_owned())]);
        let rules = &file.rules;
        assert_eq!((rules.model("a/fox.glb"), rules.model("a/fox.obj")), (Some(0), None));
    }

    #[test]
    fn herd_file_errors_name_the_line() {
        for (text, message) in [
            ("", "h.toml: whole file: found no models"),
            ("[[model]]\nfile = \"a\"", "h.toml: line 2, model[0].file: unknown field"),
            ("[[model]]\nfiles = 3", "line 2, model[0].files: expected a pattern, or a list of patterns"),
            ("[[model]]\nfiles = \"a[\"", "line 2, model[0].files: \"a[\""),
            ("[[model]]\nfiles = []", "found no pattern"),
            ("[[model]]\nfiles = \"*\"\n[[view]]\nname = \"a/b\"", "line 4, view[0].name: found \"a/b\""),
            ("[[model]]\nfiles = \"*\"\n[[view]]\nname = \"a\"\n[[view]]\nname = \"a\"", "line 6, view[1].name"),
            ("[[model]]\nfiles = \"*\"\n[[view]]\nname = \"a\"\ntruth.parts = 0", "truth.parts: found 0, expected 1"),
            ("[[model]]\nfiles = \"*\"\n[[sequence]]\nname = \"s\"\nframes = 0", "sequence[0].frames: found 0"),
            (
                "[[model]]\nfiles = \"*\"\n[[sequence]]\nname = \"s\"\nframes = 2\nshares = 3",
                "sequence[0].shares: found 3, expected 1 to 2",
            ),
            (
                "[[model]]\nfiles = \"*\"\n[[sequence]]\nname = \"s\"\nframes = 2\nview = \"x\"",
                "sequence[0].view: found \"x\"",
            ),
        ] {
            let error = HerdFile::parse(TomlText::new("h.toml", text)).unwrap_err().to_string();
            assert!(error.contains(message), "{text}: {error}");
        }
    }

    #[test]
    fn unused_entries_are_reported() {
        let text = r#"
            [[model]]
            files = ["*.glb", "*.obj"]
            [[model]]
            files = "*.gltf"
            [[recipe]]
            file = "{name}.toml"
            [[recipe]]
            models = "fox*"
            file = "r/{name}.toml"
            [[recipe]]
            models = ["wolf*", "bear*"]
            [[view]]
            name = "front"
            [[chart]]
            topic = "shells"
        "#;
        let file = HerdFile::parse(TomlText::new("h.toml", text)).unwrap();
        let models = ["fox.glb", "hare.obj"].map(|path| ModelFile { path: path.into(), bytes: 1 });
        let idle = file.unused_entries(TomlText::new("h.toml", text), &models, &|file| file == "hare.toml");
        let expected = [
            "h.toml: line 5, model[1].files: matches no model",
            "h.toml: line 12, recipe[2].models: matches no model",
            "h.toml: line 10, recipe[1].file: no model has such a recipe file; \
             for the first model it would be \"r/fox.toml\"",
        ];
        assert_eq!(idle, expected);
    }
}
