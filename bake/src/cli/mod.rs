//! Subcommands, one file each, and what they share: exit codes ([`exit`]) and output ([`output`]).

mod bake;
#[cfg(feature = "preview")]
mod bench;
mod built_in;
mod chart;
mod commands_page;
mod compare;
#[cfg(feature = "preview")]
mod demo;
#[cfg(feature = "preview")]
mod doctor;
mod exit;
#[cfg(feature = "preview")]
mod export;
#[cfg(feature = "preview")]
mod ink_args;
mod inspect;
mod journal;
#[cfg(feature = "preview")]
mod limits;
mod mesh_glb;
mod output;
mod pack;
mod package_file;
#[cfg(feature = "preview")]
mod reference;
#[cfg(feature = "preview")]
mod render;
#[cfg(feature = "preview")]
mod scene_options;
#[cfg(feature = "preview")]
mod sequence;
#[cfg(feature = "preview")]
mod shell_judge;
#[cfg(feature = "preview")]
mod shoot;
#[cfg(feature = "preview")]
mod staged;
mod threads;
#[cfg(feature = "preview")]
mod truth;
mod unpack;
mod unpacked;
mod validate;
#[cfg(feature = "preview")]
mod view;
#[cfg(feature = "preview")]
mod view_args;
#[cfg(feature = "preview")]
mod words;

use clap::CommandFactory as _;
#[cfg(feature = "preview")]
use clap::FromArgMatches as _;
use clap::{Args, Parser, Subcommand};
use exit::{Exit, Failure};
use output::Output;
#[cfg(feature = "preview")]
use pelage_bake::BakeError;
#[cfg(feature = "preview")]
use render::{Line, RenderArgs};
#[cfg(feature = "preview")]
use std::ffi::OsString;
use std::panic::{self, AssertUnwindSafe};

/// Real-time fur for glTF characters: bake a model into a package, look into packages, draw them.
#[derive(Debug, Parser)]
#[command(name = "pelage", version, after_help = Exit::summary())]
struct Cli {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    command: Command,
}

/// Options of every subcommand.
#[derive(Clone, Copy, Debug, Default, Args)]
struct Global {
    /// No progress and no notes on stderr, only errors
    #[arg(long, short, global = true)]
    quiet: bool,
    /// Print exactly one JSON object on stdout instead of text (schemas: bake/src/cli/schema/)
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    #[cfg(feature = "preview")]
    Demo(demo::DemoArgs),
    Bake(bake::BakeArgs),
    Inspect(inspect::InspectArgs),
    Validate(validate::ValidateArgs),
    Unpack(unpack::UnpackArgs),
    Pack(pack::PackArgs),
    #[cfg(feature = "preview")]
    Render(render::RenderArgs),
    #[cfg(feature = "preview")]
    Bench(bench::BenchArgs),
    #[cfg(feature = "preview")]
    Reference(reference::ReferenceArgs),
    #[cfg(feature = "preview")]
    Export(export::ExportArgs),
    Chart(chart::ChartArgs),
    CommandsPage(commands_page::CommandsPageArgs),
    Compare(compare::CompareArgs),
    #[cfg(feature = "preview")]
    Doctor(doctor::DoctorArgs),
}

impl Command {
    fn run(self, output: &mut Output) -> Result<Exit, Failure> {
        match self {
            #[cfg(feature = "preview")]
            Self::Demo(args) => demo::run(&args, output),
            Self::Bake(args) => bake::run(&args, output),
            Self::Inspect(args) => inspect::run(&args, output),
            Self::Validate(args) => validate::run(&args, output),
            Self::Unpack(args) => unpack::run(&args, output),
            Self::Pack(args) => pack::run(&args, output),
            #[cfg(feature = "preview")]
            Self::Render(args) => render::run(&args, &Line { again, option: render_option }, output),
            #[cfg(feature = "preview")]
            Self::Bench(args) => bench::run(&args, output),
            #[cfg(feature = "preview")]
            Self::Reference(args) => reference::run(&args, output),
            #[cfg(feature = "preview")]
            Self::Export(args) => export::run(&args, output),
            Self::Chart(args) => chart::run(&args, output),
            Self::CommandsPage(_) => commands_page::run(Cli::command(), output),
            Self::Compare(args) => compare::run(&args, output),
            #[cfg(feature = "preview")]
            Self::Doctor(args) => doctor::run(&args, output),
        }
    }
}

/// Runs the command line of this process.
pub fn main() -> std::process::ExitCode {
    install_panic_hook();
    let exit = match Cli::try_parse() {
        Ok(cli) => {
            let mut output = Output::new(cli.global.quiet, cli.global.json);
            let result = catch(|| cli.command.run(&mut output));
            finish(result, &mut output)
        }
        Err(error) => usage(&error),
    };
    exit.into()
}

/// What this process was asked to draw, with `options` for what the command line does not say itself.
#[cfg(feature = "preview")]
fn again(options: &[String]) -> Result<RenderArgs, Failure> {
    let mut words: Vec<OsString> = std::env::args_os().collect();
    // What may stand before the subcommand begins with a dash and has no value.
    let dashed = |word: &OsString| word.to_string_lossy().starts_with('-');
    let after = words.iter().skip(1).take_while(|word| dashed(word)).count() + 2;
    let after = after.min(words.len());
    words.splice(after..after, options.iter().map(OsString::from));
    // The last of several counts, and the user's come last.
    let matches = Cli::command().args_override_self(true).try_get_matches_from(words);
    let cli = matches.and_then(|matches| Cli::from_arg_matches(&matches));
    match cli.map_err(|error| Failure::Usage(first_line(&error)))?.command {
        Command::Render(args) => Ok(args),
        other => Err(BakeError::Internal(format!("{other:?} was asked for a picture")).into()),
    }
}

/// Checks one option of `pelage render`, such as `--size=834x424`; what is wrong with it, in words.
#[cfg(feature = "preview")]
fn render_option(option: &str) -> Result<(), String> {
    let parsed = Cli::try_parse_from(["pelage", "render", "scene.toml", "-o", "picture.png", option]);
    parsed.map(drop).map_err(|error| {
        let message = error.to_string();
        let advice = message.lines().map(str::trim).find(|line| line.starts_with("tip:") || line.starts_with('['));
        advice.map_or_else(|| first_line(&error), |advice| format!("{} {advice}", first_line(&error)))
    })
}

/// What clap found wrong, without its advice.
fn first_line(error: &clap::Error) -> String {
    let message = error.to_string();
    let first = message.lines().next().unwrap_or_default();
    first.strip_prefix("error: ").unwrap_or(first).to_owned()
}

/// Runs `body`; a panic in it is an internal error that the hook has reported already.
fn catch(body: impl FnOnce() -> Result<Exit, Failure>) -> Result<Exit, Failure> {
    panic::catch_unwind(AssertUnwindSafe(body)).unwrap_or(Err(Failure::Panicked))
}

/// Reports a failure and says how the process ends.
fn finish(result: Result<Exit, Failure>, output: &mut Output) -> Exit {
    match result {
        Ok(exit) => exit,
        Err(failure) => {
            let exit = failure.exit();
            output.failure(exit, &failure);
            exit
        }
    }
}

/// Help, version, or a command line that clap refuses. Its own exit code for the last is 2, ours is 1.
fn usage(error: &clap::Error) -> Exit {
    if !error.use_stderr() {
        return match error.print() {
            Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Exit::FileSystem,
            _ => Exit::Done,
        };
    }
    // With stderr closed there is nobody to tell.
    let _ = error.print();
    if std::env::args_os().any(|arg| arg == "--json") {
        Output::new(true, true).error_object(Exit::Usage, &first_line(error));
    }
    Exit::Usage
}

/// One line instead of a backtrace: where it happened and what to do about it.
fn install_panic_hook() {
    panic::set_hook(Box::new(|info| {
        let payload = info.payload();
        let text = payload.downcast_ref::<&str>().copied().or(payload.downcast_ref::<String>().map(String::as_str));
        let what = text.unwrap_or("no message");
        let place = info.location().map(ToString::to_string).unwrap_or_default();
        let version = env!("CARGO_PKG_VERSION");
        output::to_stderr(&format!(
            "error: internal error in pelage {version} at {place}: {what}; please report it with the command and its input\n"
        ));
    }));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_panic_ends_with_exit_code_5() {
        let result = catch(|| panic!("on purpose"));
        assert_eq!(finish(result, &mut Output::new(true, false)), Exit::Internal);
    }
}
