//! Markdown page about the command line, and JSON schemas of the results of `--json`, generated from their definitions.
//! This is a hidden subcommand, because only the binary has these definitions.

use clap::{Arg, ArgAction, Command};
use pelage_params::wrap;
use pelage_tool::exit::{Exit, Failure};
use pelage_tool::output::Output;
use pelage_tool::{LABORATORY, ResultSchema};
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};

/// Print bake/docs/commands.md; with --json also bake/docs/schemas.json
#[derive(Clone, Copy, Debug, clap::Args)]
#[command(hide = true)]
pub struct CommandsPageArgs {}

/// Writes the page of `command` and the schemas of all `results`.
pub fn run(mut command: Command, results: Vec<ResultSchema>, output: &mut Output) -> Result<Exit, Failure> {
    let text = page(&mut command);
    output.result(text.trim_end(), &json!({ "page": text, "schemas": schemas(results) }))?;
    Ok(Exit::Done)
}

/// Returns the JSON schemas of the commands' results by command name; shared types are in `$defs`.
fn schemas(mut results: Vec<ResultSchema>) -> Value {
    results.sort_by_key(|(name, _)| *name);
    let mut generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
    let mut all = Map::new();
    all.insert("$schema".into(), generator.settings().meta_schema.as_deref().into());
    all.extend(results.iter().map(|(name, make)| ((*name).into(), make(&mut generator).to_value())));
    all.insert("$defs".into(), generator.take_definitions(true).into());
    all.into()
}

/// Text before the subcommands.
const INTRODUCTION: [&str; 2] = [
    "One binary, `pelage`. Results go to standard output, progress and notes to standard error. \
     A command that fails leaves no half-written file: outputs appear under their names once they are complete. \
     A closed standard output (broken pipe) is not an error.",
    "This page is generated from the definition of the command line by `cargo run --bin chores write-docs`.",
];

fn page(command: &mut Command) -> String {
    command.build();
    let [first, second] = INTRODUCTION.map(|paragraph| wrap("", paragraph));
    let mut text = format!("# Command reference\n\n{first}\n\n{second}\n\n## Exit codes\n\n");
    for (exit, _, meaning) in Exit::ALL {
        text += &item("", &format!("**{}**: {meaning}", exit as u8));
    }
    let subcommands: Vec<_> =
        command.get_subcommands().filter(|c| !c.is_hide_set() && c.get_name() != "help").collect();
    text += "\n## Subcommands\n\n";
    for sub in &subcommands {
        let name = sub.get_name();
        text += &item("", &format!("[`pelage {name}`](#pelage-{name}): {}", single_line(sub.get_about())));
    }
    let everywhere: Vec<_> = command.get_arguments().filter(|arg| arg.is_global_set()).collect();
    text += "\n## Options of every subcommand\n\n";
    text.extend(everywhere.iter().map(|arg| entry(arg)));
    let shared = shared_arguments(&subcommands);
    text += &format!("\n## {SHARED_TITLE}\n\n{}\n\n", wrap("", SHARED_TEXT));
    text += &entries(&shared);
    for sub in subcommands {
        text += &section(sub, "", &shared);
        let actions = sub.get_subcommands().filter(|c| !c.is_hide_set() && c.get_name() != "help");
        text.extend(actions.map(|action| section(action, &format!("{} ", sub.get_name()), &shared)));
    }
    text
}

/// Commands whose common options are listed once.
const PICTURE_COMMANDS: [&str; 4] = ["render", "bench", "view", "reference"];

/// Number of `PICTURE_COMMANDS` that must have an option in common for it to be listed once.
const SHARED_BY: usize = 3;

const SHARED_TITLE: &str = "Options of every picture";
const SHARED_TEXT: &str =
    "Commands that draw have these options in common. The section of a command names those that it lacks.";

/// Returns the options that at least [`SHARED_BY`] of [`PICTURE_COMMANDS`] have with the same help text. Their order is
/// that of the first such command.
fn shared_arguments<'a>(subcommands: &[&'a Command]) -> Vec<&'a Arg> {
    let draws = |command: &&&'a Command| PICTURE_COMMANDS.contains(&command.get_name());
    let all = || subcommands.iter().filter(draws).flat_map(|command| listed(command));
    let mut shared: Vec<&Arg> = Vec::new();
    for arg in all() {
        let text = entry(arg);
        if all().filter(|other| entry(other) == text).count() >= SHARED_BY && !contains(shared.iter().copied(), arg) {
            shared.push(arg);
        }
    }
    shared
}

/// Returns whether an argument has the same text as one of `arguments`.
fn contains<'a>(mut arguments: impl Iterator<Item = &'a Arg>, arg: &Arg) -> bool {
    let text = entry(arg);
    arguments.any(|other| entry(other) == text)
}

/// Returns the arguments of a command that the page lists.
fn listed(command: &Command) -> impl Iterator<Item = &Arg> {
    command.get_arguments().filter(|arg| !arg.is_hide_set() && !arg.is_global_set() && is_ours(arg))
}

/// Formats arguments as a list; those under a heading come last, each heading once.
fn entries(arguments: &[&Arg]) -> String {
    let mut headings: Vec<Option<&str>> = vec![None];
    headings.extend(arguments.iter().map(|arg| arg.get_help_heading()));
    let place = |arg: &&Arg| headings.iter().position(|heading| *heading == arg.get_help_heading());
    let mut arguments = arguments.to_vec();
    arguments.sort_by_key(place);
    let mut text = String::new();
    let mut heading = None;
    for arg in arguments {
        if arg.get_help_heading() != heading {
            heading = arg.get_help_heading();
            text += &format!("\n### {}\n\n", heading.unwrap_or_default());
        }
        text += &entry(arg);
    }
    text
}

/// Returns the section of a command. `above` is the parent command, with a trailing space. Options in `shared` are not
/// repeated.
fn section(command: &Command, above: &str, shared: &[&Arg]) -> String {
    let mut text = format!("\n## `pelage {above}{}`\n", command.get_name());
    let about = command.get_long_about().or(command.get_about());
    let about = about.map(ToString::to_string).unwrap_or_default();
    for paragraph in about.split("\n\n") {
        text += &format!("\n{}\n", wrap("", &paragraph.split_whitespace().collect::<Vec<_>>().join(" ")));
    }
    text += &format!("\n```\n{}\n```\n\n", synopsis(command, above));
    let (has, lacks): (Vec<&Arg>, Vec<&Arg>) = shared.iter().partition(|arg| contains(listed(command), arg));
    let repeats = has.len() > lacks.len();
    let others: Vec<&Arg> = listed(command).filter(|arg| !repeats || !contains(shared.iter().copied(), arg)).collect();
    text += &entries(&others);
    if repeats {
        let lacks: Vec<_> = lacks.iter().map(|arg| format!("`{}`", typed_form(arg, false))).collect();
        let except = if lacks.is_empty() { String::new() } else { format!(", except {}", lacks.join(", ")) };
        text += &format!(
            "\n{}\n",
            wrap("", &format!("Also the [options of every picture](#options-of-every-picture){except}."))
        );
    }
    text
}

/// Returns false for arguments that clap adds to every command, and for those of the laboratory.
fn is_ours(arg: &Arg) -> bool {
    arg.get_help_heading() != Some(LABORATORY)
        && !matches!(
            arg.get_action(),
            ArgAction::Help | ArgAction::HelpLong | ArgAction::HelpShort | ArgAction::Version
        )
}

/// Returns the usage line: required arguments, and a placeholder if there are options.
fn synopsis(command: &Command, above: &str) -> String {
    let required = command.get_arguments().filter(|arg| arg.is_required_set());
    let (places, options): (Vec<_>, Vec<_>) = required.partition(|arg| arg.is_positional());
    let words = options.into_iter().chain(places).map(|arg| typed_form(arg, false));
    let words: Vec<_> = [command.get_name().to_owned()].into_iter().chain(words).collect();
    let action = if command.has_subcommands() { " ACTION" } else { "" };
    format!("pelage {above}{}{action} [OPTIONS]", words.join(" "))
}

/// Formats an argument as typed, such as `--output <PNG>`; `with_short` includes its short form: `-o, --output <PNG>`.
fn typed_form(arg: &Arg, with_short: bool) -> String {
    let short = arg.get_short().filter(|_| with_short).map(|c| format!("-{c}"));
    let names: Vec<_> = short.into_iter().chain(arg.get_long().map(|l| format!("--{l}"))).collect();
    let takes = arg.get_action().takes_values();
    let values = arg.get_value_names().filter(|_| takes).into_iter().flatten().map(|name| format!("<{name}>"));
    let names = names.join(", ");
    [names].into_iter().filter(|names| !names.is_empty()).chain(values).collect::<Vec<_>>().join(" ")
}

fn entry(arg: &Arg) -> String {
    let takes = arg.get_action().takes_values();
    let help = arg.get_long_help().or(arg.get_help());
    let default: Vec<_> = arg.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
    let default =
        if takes && !default.is_empty() { format!(" [default: {}]", default.join(" ")) } else { String::new() };
    let mut text = item("", &format!("`{}`: {}{default}", typed_form(arg, true), single_line(help)));
    for value in arg.get_possible_values().iter().filter(|value| takes && !value.is_hide_set()) {
        let meaning = single_line(value.get_help());
        let colon = if meaning.is_empty() { "" } else { ": " };
        text += &item("  ", &format!("`{}`{colon}{meaning}", value.get_name()));
    }
    text
}

/// Formats a list item.
fn item(indent: &str, text: &str) -> String {
    format!("{indent}- {}\n", wrap(&format!("{indent}  "), text))
}

/// Returns a help text on one line, with paragraphs joined as sentences.
fn single_line(text: Option<&clap::builder::StyledStr>) -> String {
    let text = text.map(ToString::to_string).unwrap_or_default();
    let paragraphs = text.split("\n\n").map(|paragraph| paragraph.split_whitespace().collect::<Vec<_>>().join(" "));
    paragraphs.collect::<Vec<_>>().join(". ").replace(".. ", ". ")
}
