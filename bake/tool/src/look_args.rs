//! Look options of the command line: `--look`, and a flag for each look key that has a short form.

use super::exit::Failure;
use clap::builder::{PossibleValue, PossibleValuesParser, ValueParser};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use pelage_bake::io::read_text;
use pelage_import::BakeError;
use pelage_params::Control;
use pelage_stage::{BUILT_IN_LOOKS, Look, ParamError, SAMPLES, SHORT_FORMS, ShortForm};
use std::path::Path;

/// Look options of the command line.
#[derive(Clone, Debug, Default)]
pub struct LookArgs {
    /// Values of `--look`, in order.
    looks: Vec<String>,
    /// Short forms that were given, with their values.
    flags: Vec<(&'static ShortForm, String)>,
}

impl LookArgs {
    /// Applies the options to `look`: first the values of `--look` in order, then the flags.
    ///
    /// Fails for an unreadable or invalid look file.
    pub fn apply(&self, look: &mut Look) -> Result<(), Failure> {
        for word in &self.looks {
            match apply_word(word, look) {
                Some(applied) => applied.map_err(|error| input("--look", error))?,
                None if !word.contains(['.', '/', '\\']) && !Path::new(word).exists() => {
                    return Err(Failure::Usage(format!(
                        "--look {word}: found neither a file nor a style, expected a file, key=value or one of {}",
                        style_names()
                    )));
                }
                None => read(Path::new(word), look)?,
            }
        }
        for (short, word) in &self.flags {
            short.apply(look, word).map_err(|error| input(&format!("--{}", short.flag), error))?;
        }
        Ok(())
    }

    /// Returns the look that results from flags and `key=value` alone, without look files.
    pub fn typed(&self) -> Look {
        let mut look = Look::default();
        // Parsing has already validated all values.
        self.looks.iter().for_each(|word| drop(apply_word(word, &mut look)));
        self.flags.iter().for_each(|(short, word)| drop(short.apply(&mut look, word)));
        look
    }

    /// Returns true if the flag named `flag` was given.
    pub fn has(&self, flag: &str) -> bool {
        self.flags.iter().any(|(short, _)| short.flag == flag)
    }
}

/// Option `--samples` of the commands that draw with an adapter. `reference` has its own, with a larger range.
#[derive(Clone, Debug, Args)]
pub struct SamplesArgs {
    #[arg(
        long,
        value_name = SAMPLES.value_name,
        allow_hyphen_values = true,
        help = "Samples per pixel: 4 smooths edges and thin hair, 1 costs less than half [default: 4, bench: 1]",
        help_heading = PICTURE,
        hide_short_help = true,
        value_parser = parser(&SAMPLES)
    )]
    samples: Option<String>,
}

impl SamplesArgs {
    /// Applies the option to `look`.
    ///
    /// Fails for a number other than 1 or 4.
    pub fn apply(&self, look: &mut Look) -> Result<(), Failure> {
        let Some(word) = &self.samples else { return Ok(()) };
        SAMPLES.apply(look, word).map_err(|error| Failure::Usage(format!("--samples: {}", error.reason)))
    }
}

fn read(path: &Path, look: &mut Look) -> Result<(), Failure> {
    let text = read_text(path, LOOK)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    look.read_in(folder, &text).map_err(|error| input(&path.display().to_string(), error).into())
}

/// Description of a look file, for messages.
pub const LOOK: &str = "a look in TOML";

fn input(file: &str, error: ParamError) -> BakeError {
    BakeError::Input { file: file.to_owned(), place: error.location(), reason: error.reason }
}

/// Applies a value of `--look` that is an assignment or the name of a built-in look; `None` for a file name.
fn apply_word(word: &str, look: &mut Look) -> Option<Result<(), ParamError>> {
    if is_assignment(word) {
        return Some(look.set(word));
    }
    BUILT_IN_LOOKS.iter().find(|style| style.name == word).map(|style| look.read(style.text))
}

/// Returns true for an assignment `key=value`, false for a file name.
fn is_assignment(word: &str) -> bool {
    let key = word.split_once('=').map(|(key, _)| key.trim());
    key.is_some_and(|key| key.chars().all(|c| c.is_ascii_alphanumeric() || c == '.' || c == '_'))
}

/// Help heading of the flags that only the laboratory's build has.
pub const LABORATORY: &str = "Laboratory";

/// Flags that the short help lists, with their places among its options.
const COMMON: [(&str, usize); 5] = [("size", 2), ("style", 3), ("light", 6), ("environment", 7), ("background", 8)];

/// Help heading of the flags for the picture as a whole.
const PICTURE: &str = "Picture";

/// Returns the help heading of the flags for a look key, which depends on its table.
fn heading(key: &str) -> &'static str {
    match key.split_once('.').map_or(key, |(table, _)| table) {
        "light" => "Light",
        "environment" => "Environment",
        "fur" => "Fur",
        "shadow" => "Shadows",
        "motion" => "Motion",
        "ink" | "brush" => "Ink style",
        "study" => LABORATORY,
        _ => PICTURE,
    }
}

/// Creates the argument of a short form, with meaning, range and default of its knob.
fn argument(short: &'static ShortForm) -> Arg {
    let arg = Arg::new(short.flag)
        .long(short.flag)
        .value_name(short.value_name)
        .allow_hyphen_values(true)
        .action(if short.repeats { ArgAction::Append } else { ArgAction::Set });
    let arg = match COMMON.iter().find(|(flag, _)| *flag == short.flag) {
        Some((_, order)) => arg.display_order(*order).help(help(short, true)).long_help(help(short, false)),
        None => arg.help(help(short, false)).help_heading(heading(short.key)).hide_short_help(true),
    };
    // A build without the published formulas still accepts their flags, so that the error can name the build that has
    // them.
    let arg = arg.hide(short.knob().is_none());
    let arg = if short.flag == "light" { arg.conflicts_with("point-light") } else { arg };
    arg.value_parser(parser(short))
}

/// Returns the help text of a short form: the meaning of its knob, or only its first sentence if `is_brief`, and
/// details that clap does not show.
fn help(short: &ShortForm, is_brief: bool) -> String {
    let Some(knob) = short.knob() else { return String::new() };
    let mut help = knob.doc.split_whitespace().collect::<Vec<_>>().join(" ");
    if let Some(end) = help.find(". ").filter(|_| is_brief) {
        help.truncate(end);
    }
    if help.ends_with('.') {
        help.pop();
    }
    let control = (knob.control)();
    let default = knob.value(&Look::default()).map(|value| match control {
        Control::Toggle => if value == "true" { "on" } else { "off" }.to_owned(),
        _ => value.trim_matches('"').to_owned(),
    });
    let range = match control {
        Control::Number { least, most, whole: true, .. } => Some(format!("{least}..={most}")),
        // The knob holds an f32, so further digits are meaningless.
        Control::Number { least, most, .. } => Some(format!("{}..={}", least as f32, most as f32)),
        _ => None,
    };
    let default = default.filter(|value| value != "[]").map(|value| format!("default: {value}"));
    let mut notes: Vec<_> = range.into_iter().chain(default).collect();
    if short.repeats {
        notes = vec!["may be given again".to_owned()];
    }
    if !notes.is_empty() {
        help += &format!(" [{}]", notes.join("; "));
    }
    help
}

/// Creates a parser of the values of a short form's knob.
pub fn parser(short: &'static ShortForm) -> ValueParser {
    match short.knob().map(|knob| (knob.control)()) {
        Some(Control::Toggle) => PossibleValuesParser::new(["on", "off"]).into(),
        Some(Control::Choice(choices)) => {
            let value = |choice: &pelage_params::Choice| {
                let meaning = choice.doc.split_whitespace().collect::<Vec<_>>().join(" ");
                PossibleValue::new(choice.word).help(meaning.trim_end_matches('.').to_owned()).aliases(choice.was)
            };
            PossibleValuesParser::new(choices.iter().map(value)).into()
        }
        _ => ValueParser::new(move |word: &str| -> Result<String, String> {
            let checked = short.apply(&mut Look::default(), word);
            checked.map(|()| word.to_owned()).map_err(|error| error.reason)
        }),
    }
}

/// Validates a value of `--look`: an assignment is parsed, a file name is accepted.
fn validate_look_value(word: &str) -> Result<String, String> {
    apply_word(word, &mut Look::default()).transpose().map_err(|error| error.to_string())?;
    Ok(word.to_owned())
}

/// Returns the names of the built-in looks, as in a sentence.
fn style_names() -> String {
    BUILT_IN_LOOKS.map(|style| style.name).join(", ")
}

/// Returns the help of `--look`, with a line for each built-in look.
fn long_help() -> String {
    let styles = BUILT_IN_LOOKS.map(|style| format!("{}: {}", style.name, style.about));
    format!(
        "Look of the picture: a file, a style of ink painting, or one key such as shadow.penumbra=0.3 \
         (bake/docs/look.md lists them); later ones override earlier ones, and flags override all [may be given \
         again]\n\nStyles of ink painting:\n{}",
        styles.join("\n").trim_end_matches('.')
    )
}

impl Args for LookArgs {
    fn augment_args(command: Command) -> Command {
        let look = Arg::new("look")
            .long("look")
            .value_name("L.toml|NAME|KEY=VALUE")
            .action(ArgAction::Append)
            .value_parser(validate_look_value)
            .help_heading(PICTURE)
            .hide_short_help(true)
            .help(format!(
                "Look of the picture: a file, a style of ink painting ({}), or one key such as shadow.penumbra=0.3 \
                 (bake/docs/look.md lists them); later ones override earlier ones, and flags override all [may be \
                 given again]",
                style_names()
            ))
            .long_help(long_help());
        command.arg(look).args(SHORT_FORMS.iter().map(argument))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for LookArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = |id: &str| matches.get_many::<String>(id).into_iter().flatten().cloned().collect::<Vec<_>>();
        let flags = SHORT_FORMS.iter().flat_map(|short| given(short.flag).into_iter().map(move |word| (short, word)));
        Ok(Self { looks: given("look"), flags: flags.collect() })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{CommandFactory as _, Parser};
    use pelage_stage::{FillLight, LookDetail, LookStyle};

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        look: LookArgs,
    }

    fn parse(line: &str) -> Result<Look, String> {
        let words = ["pelage"].into_iter().chain(line.split_whitespace());
        let args = Line::try_parse_from(words).map_err(|error| error.to_string())?.look;
        let mut look = Look::default();
        args.apply(&mut look).map_err(|error| error.to_string())?;
        Ok(look)
    }

    #[test]
    fn flags_override_looks_in_any_order() {
        assert_eq!(parse("").unwrap(), Look::default());
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("l.toml");
        std::fs::write(&file, "[shadow]\npenumbra = 0.5\ndensity = 2\n[fur]\nlayers = 3\n").unwrap();
        let line = format!("--penumbra 0.2 --look shadow.density=1.5 --look {} --look fur.layers=5", file.display());
        let look = parse(&line).unwrap();
        assert_eq!((look.shadow.penumbra, look.shadow.density, look.fur.layers), (0.2, 2.0, Some(5)));
        std::fs::write(&file, "[shadow]\npenumbr = 0.5\n").unwrap();
        let error = parse(&format!("--look {}", file.display())).unwrap_err();
        assert!(
            error.contains("l.toml: line 2, shadow.penumbr: unknown key; did you mean shadow.penumbra?"),
            "{error}"
        );
        assert!(parse("--look none.toml").unwrap_err().contains("none.toml: cannot read"));
        assert!(parse("--look light.fill=1,0,0 --fill-light 0,1,0").is_ok_and(|look| look.light.fill.len() == 2));
    }

    #[test]
    fn look_options_are_parsed_and_errors_reported() {
        let look =
            parse("--size 64X32 --style bare --light -1,2,3.5 --fins off --detail auto --fill-light -2,0,0/0.25")
                .unwrap();
        assert_eq!((look.picture.style, look.fur.fins, look.fur.detail), (LookStyle::Bare, false, LookDetail::Auto));
        assert_eq!(look.light.direction, [-1.0, 2.0, 3.5]);
        assert_eq!(look.light.fill, [FillLight { direction: [-2.0, 0.0, 0.0], strength: 0.25 }]);
        for (line, message) in [
            ("--size 0x0", "each from 1 to 8192"),
            ("--light 0,0,0", "a direction that is not zero"),
            ("--light 0,1,0 --point-light 0,1,0", "cannot be used with"),
            ("--shadow-density 5", "found 5, expected a number 0..=4"),
            ("--penumbra=-1", "expected a number 0..=2"),
            ("--penumbra 1 --penumbra 2", "cannot be used multiple times"),
            ("--style fluffy", "fur, ink, bare"),
            ("--fins maybe", "on, off"),
            ("--detail coarse", "\"full\", \"auto\" or a level"),
            ("--look shadow.penumbr=1", "shadow.penumbr: unknown key; did you mean shadow.penumbra?"),
            ("--look shadow.penumbra=9", "shadow.penumbra: found 9, expected a number 0..=2"),
            ("--look oil", "--look oil: found neither a file nor a style"),
        ] {
            let error = parse(line).unwrap_err();
            assert!(error.contains(message), "{line}: {error}");
        }
    }

    #[test]
    fn help_has_meaning_range_and_default_of_the_knob() {
        let help = Line::command().term_width(500).render_long_help().to_string();
        for part in [
            "0 gives hard shadows [0..=2; default: 0.15]",
            "[0.15..=1; default: 0.64]",
            "[default: 834x424]",
            "by means of a shadow-width map [default: on]",
            "Method for the self-shadow of hair [default: auto]",
            "Rendering style [default: fur]",
        ] {
            assert!(help.contains(part), "{part}\n{help}");
        }
        for style in BUILT_IN_LOOKS {
            assert!(help.contains(&format!("{}: {}", style.name, style.about.trim_end_matches('.'))), "{help}");
        }
        // The laboratory's options are there if this is built together with it.
        let is_heading = |line: &&str| line.ends_with(':') && !line.starts_with(' ') && *line != "Laboratory:";
        let headings: Vec<&str> = help.lines().filter(is_heading).collect();
        assert_eq!(
            headings,
            ["Options:", "Picture:", "Light:", "Environment:", "Fur:", "Shadows:", "Motion:", "Ink style:"]
        );
        let brief = Line::command().term_width(500).render_help().to_string();
        let flags: Vec<&str> = brief.split("--").skip(1).filter_map(|rest| rest.split(' ').next()).take(6).collect();
        assert_eq!(flags, ["size", "style", "light", "environment", "background", "help"], "{brief}");
        assert!(brief.contains("Rendering style [default: fur] [possible values: fur, ink, bare]"), "{brief}");
    }
}
