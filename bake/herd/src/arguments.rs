//! Converts the tables of a herd file to command-line arguments, and validates them.

use super::file::{Fault, HerdFile, Sequence, TruthOptions, ViewRule};
use pelage_import::BakeError;
use pelage_stage::TomlText;

/// Validators of command-line arguments.
#[derive(Clone, Copy)]
pub struct ArgumentValidators<'a> {
    /// Look keys without effect on a reference image, such as `fur.layers`.
    pub only_drawn: &'a [&'a str],
    /// Returns the error message if `pelage` rejects a command line.
    pub refusal: &'a dyn Fn(&[String]) -> Option<String>,
    /// Returns the error message if `bake --set` rejects an assignment.
    pub recipe: &'a dyn Fn(&str) -> Option<String>,
}

/// Table key and the command-line argument made from it.
pub(super) type Word = (String, String);

fn word(key: &str, option: &str, value: Option<impl ToString>) -> Option<Word> {
    value.map(|value| (key.to_owned(), format!("--{option}={}", value.to_string())))
}

impl ViewRule {
    /// Returns the arguments for `render`.
    pub(super) fn words(&self) -> Vec<Word> {
        let words = [
            word("size", "size", self.size.as_ref()),
            word("camera", "camera", self.camera.as_ref()),
            word("orbit", "orbit", self.orbit.as_ref()),
            word("look_at", "look-at", self.look_at.as_ref()),
            word("look", "look", self.look.as_ref()),
            word("clip", "clip", self.clip.as_ref()),
            word("time", "time", self.time),
        ];
        let sets =
            assignments(&self.set).into_iter().map(|set| (format!("set.{}", key_of(&set)), format!("--look={set}")));
        words.into_iter().flatten().chain(sets).collect()
    }

    /// Returns [`Self::words`] without the look keys that have no effect on a reference image.
    pub(super) fn reference_words(&self, only_drawn: &[&str]) -> Vec<Word> {
        let drawn = |word: &Word| word.0.strip_prefix("set.").is_some_and(|key| only_drawn.contains(&key));
        self.words().into_iter().filter(|word| !drawn(word)).collect()
    }
}

impl TruthOptions {
    /// Returns the arguments for `reference`.
    pub(super) fn words(&self) -> Vec<Word> {
        let words = [
            word("samples", "samples", self.samples),
            word("fibre", "fibre", self.fibre.as_ref()),
            word("bounces", "bounces", self.bounces),
        ];
        words.into_iter().flatten().collect()
    }
}

impl Sequence {
    /// Returns the arguments for `render` that a sequence adds to those of its view.
    pub(super) fn words(&self) -> Vec<Word> {
        word("fps", "fps", self.fps).into_iter().collect()
    }
}

/// Returns the `--set` arguments for `bake` from a table of recipe keys.
pub(super) fn sets(table: &toml::Table) -> impl Iterator<Item = String> {
    assignments(table).into_iter().flat_map(|set| ["--set".to_owned(), set])
}

/// Flattens a table to command-line assignments, such as `hair.length_m=0.02`.
fn assignments(table: &toml::Table) -> Vec<String> {
    fn add(prefix: &str, table: &toml::Table, all: &mut Vec<String>) {
        for (key, value) in table {
            let key = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
            match value {
                toml::Value::Table(inner) => add(&key, inner, all),
                // Command-line assignments contain strings without quotes.
                toml::Value::String(word) => all.push(format!("{key}={word}")),
                other => all.push(format!("{key}={other}")),
            }
        }
    }
    let mut all = Vec::new();
    add("", table, &mut all);
    // The order of a TOML table depends on how the crate was built, so the assignments are sorted.
    all.sort();
    all
}

fn key_of(assignment: &str) -> &str {
    assignment.split('=').next().unwrap_or(assignment)
}

impl HerdFile {
    /// Reads a herd file, and validates its values with the commands that they are passed to.
    ///
    /// Fails like [`Self::parse`]; also with [`BakeError::Input`], line and key for values that a command would reject.
    pub fn read(source: TomlText<'_>, judge: &ArgumentValidators<'_>) -> Result<Self, BakeError> {
        let file = Self::parse(source)?;
        let fault = file.words_fault(judge);
        fault.map_or(Ok(file), |(key, reason)| Err(Self::fault(source, &key, reason)))
    }

    /// Returns the key and error of the first value that a command would reject.
    fn words_fault(&self, judge: &ArgumentValidators<'_>) -> Option<Fault> {
        let recipes = self.recipes.iter().enumerate().map(|(i, rule)| (format!("recipe[{i}]"), &rule.set));
        let variants = self.variants.iter().enumerate().map(|(i, variant)| (format!("variant[{i}]"), &variant.set));
        let mut sets = recipes.chain(variants);
        sets.find_map(|(place, set)| recipe_fault(&place, set, judge))
            .or_else(|| self.trials(judge.only_drawn).into_iter().find_map(|trial| trial.fault(judge.refusal)))
    }

    /// Returns command lines to validate, which together contain every value that the command-line parser can check.
    fn trials(&self, only_drawn: &[&str]) -> Vec<Trial> {
        let render = ["render", "a.pelage", "-o", "a.png"];
        let reference = ["reference", "a.pelage", "-o", "a.png"];
        let mut trials = Vec::new();
        for (i, view) in self.views.iter().enumerate() {
            let place = format!("view[{i}]");
            trials.push(Trial::new(&render, &place, view.words()));
            let frames = word("bench", "frames", view.bench).into_iter().collect();
            trials.push(Trial::new(&["bench", "a.pelage"], &place, frames));
            let Some(truth) = &view.truth else { continue };
            trials.push(Trial::new(&reference, &place, view.reference_words(only_drawn)));
            let place = format!("{place}.truth");
            trials.push(Trial::new(&reference, &place, truth.words()));
            let limit = word("max_flip", "max-flip", truth.max_flip).into_iter().collect();
            trials.push(Trial::new(&["compare", "a.png", "b.png"], &place, limit));
        }
        for (i, sequence) in self.sequences.iter().enumerate() {
            trials.push(Trial::new(&render, &format!("sequence[{i}]"), sequence.words()));
        }
        for (i, chart) in self.charts.iter().enumerate() {
            let topic = vec![("topic".to_owned(), chart.topic.clone())];
            trials.push(Trial::new(&["chart"], &format!("chart[{i}]"), topic));
        }
        trials
    }
}

/// Command line that validates values of one table.
struct Trial {
    command: Vec<String>,
    /// Key of the table that the values come from.
    place: String,
    words: Vec<Word>,
}

impl Trial {
    fn new(command: &[&str], place: &str, words: Vec<Word>) -> Self {
        let command = ["pelage"].iter().chain(command).map(|word| (*word).to_owned()).collect();
        Self { command, place: place.to_owned(), words }
    }

    fn fault(&self, refusal: &dyn Fn(&[String]) -> Option<String>) -> Option<Fault> {
        let Self { command, place, words } = self;
        let refused = |words: &[Word]| {
            let words = words.iter().map(|(_, word)| word.clone());
            refusal(&command.iter().cloned().chain(words).collect::<Vec<_>>())
        };
        let alone = |word: &Word| refused(std::slice::from_ref(word)).map(|why| (format!("{place}.{}", word.0), why));
        // Almost all values are valid, so all of a table are checked with one command line first.
        let together = refused(words)?;
        Some(words.iter().find_map(alone).unwrap_or_else(|| (place.clone(), together)))
    }
}

/// Returns the first recipe key that is unknown or has an invalid value.
fn recipe_fault(place: &str, set: &toml::Table, judge: &ArgumentValidators<'_>) -> Option<Fault> {
    assignments(set).iter().find_map(|set| Some((format!("{place}.set.{}", key_of(set)), (judge.recipe)(set)?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_become_command_line_arguments() {
        let table = toml::toml! { "hair.length_m" = 0.02
        slice = { layers = 12 }
        "color.tip" = "#ffffff" };
        let expected = ["color.tip=#ffffff", "hair.length_m=0.02", "slice.layers=12"];
        assert_eq!(assignments(&table), expected);
        let view = ViewRule {
            size: Some("8x8".into()),
            time: Some(-0.5),
            set: toml::toml! { fur = { layers = 3 } },
            ..ViewRule::default()
        };
        let words = |words: Vec<Word>| words.into_iter().map(|(_, word)| word).collect::<Vec<_>>();
        assert_eq!(words(view.words()), ["--size=8x8", "--time=-0.5", "--look=fur.layers=3"]);
        assert_eq!(words(view.reference_words(&["fur.layers"])), ["--size=8x8", "--time=-0.5"]);
    }

    #[test]
    fn rejected_values_are_reported_by_key_and_combinations_by_table() {
        let view = ViewRule { size: Some("8".into()), orbit: Some("1,2".into()), ..ViewRule::default() };
        let file = HerdFile { views: vec![view], ..HerdFile::default() };
        let fault = |refused: &'static [&'static str]| {
            let has = |words: &[String]| refused.iter().all(|word| words.iter().any(|w| w == word));
            let refusal = |words: &[String]| has(words).then(|| "no".to_owned());
            file.words_fault(&ArgumentValidators { only_drawn: &[], refusal: &refusal, recipe: &|_| None })
        };
        assert_eq!(fault(&["--orbit=1,2"]), Some(("view[0].orbit".into(), "no".into())));
        assert_eq!(fault(&["--orbit=1,2", "--size=8"]), Some(("view[0]".into(), "no".into())));
        assert_eq!(fault(&["--camera=1,2"]), None);
    }

    #[test]
    fn arguments_a_command_would_refuse_are_reported_with_their_line() {
        let refusal = |words: &[String]| words.contains(&"--size=96".to_owned()).then(|| "no size".to_owned());
        let recipe = |set: &str| set.contains("lenght").then(|| "no key".to_owned());
        let judge = ArgumentValidators { only_drawn: &[], refusal: &refusal, recipe: &recipe };
        for (text, message) in [
            ("[[view]]\nname = \"a\"\nsize = \"96\"", "h.toml: line 5, view[0].size: no size"),
            (
                "[[recipe]]\n[recipe.set]\n\"hair.density\" = 9\n\"hair.lenght_m\" = 1",
                "h.toml: line 6, recipe[0].set.hair.lenght_m: no key",
            ),
            (
                "[[variant]]\nname = \"a\"\nset = { hair = { lenght_m = -1 } }",
                "h.toml: line 5, variant[0].set.hair.lenght_m: no key",
            ),
        ] {
            let text = format!("[[model]]\nfiles = \"*\"\n{text}");
            assert_eq!(HerdFile::read(TomlText::new("h.toml", &text), &judge).unwrap_err().to_string(), message);
        }
    }
}
