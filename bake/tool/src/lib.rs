//! Command line of pelage: one file per subcommand, with shared exit codes and output.
//!
//! The tool is a library so that the laboratory (`bake/lab`) can add `chart` to the command line. The items are not a
//! public API.

mod anatomy;
mod backdrop;
#[doc(hidden)]
pub mod bake;
mod bench;
#[doc(hidden)]
pub mod built_in;
mod camera_args;
mod compare;
mod demo;
mod doctor;
mod doctor_trial;
mod empty_picture;
mod environment;
#[doc(hidden)]
pub mod exit;
mod export;
mod groom;
mod guard;
#[cfg(feature = "herd")]
mod herd;
mod inspect;
#[doc(hidden)]
pub mod job;
#[doc(hidden)]
pub mod journal;
mod limits;
mod look_args;
#[doc(hidden)]
pub mod machine;
#[cfg(feature = "manual")]
mod manual;
mod material_color;
mod merge;
#[doc(hidden)]
pub mod mesh_glb;
#[doc(hidden)]
pub mod output;
mod pack;
#[doc(hidden)]
pub mod package_file;
mod paint_mesh;
mod picture_args;
mod picture_series;
mod progress;
mod reference;
mod render;
mod scene;
#[cfg(feature = "schema")]
mod schemas;
mod seal;
mod sequence;
#[doc(hidden)]
pub mod share;
#[doc(hidden)]
pub mod shell_judge;
mod sky;
mod stage_times;
#[doc(hidden)]
pub mod stages;
mod svg;
mod threads;
#[doc(hidden)]
pub mod truth;
mod unpack;
mod unpacked;
mod validate;
#[doc(hidden)]
pub mod view;
mod view_args;
#[cfg(feature = "view")]
mod window;
mod write_recipe;

use clap::error::{ContextKind, ContextValue};
use clap::{Args, CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use exit::{Exit, Failure};
use guard::DeclaredFiles;
use output::Output;
use pelage_bake::temp_files;
use std::panic::{self, AssertUnwindSafe};
use std::path::Path;

#[doc(hidden)]
pub use look_args::LABORATORY;
#[cfg(feature = "schema")]
#[doc(hidden)]
pub use schemas::{ResultSchema, results};

/// Real-time fur for glTF characters: bake a model into a package, inspect packages, draw them.
#[derive(Debug, Parser)]
#[command(name = "pelage", version, after_help = Exit::summary())]
struct Cli<C: Commands> {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    command: C,
}

/// Set of subcommands of a binary.
pub trait Commands: Subcommand {
    /// Runs a subcommand.
    ///
    /// Fails with the failure that determines the exit code.
    fn run(&self, invocation: &Invocation<'_>, output: &mut Output) -> Result<Exit, Failure>;

    /// Returns the description for the cache; `None` for a subcommand that is not cached.
    fn job(&self) -> Option<job::Job>;
}

/// Context that a subcommand runs in.
pub struct Invocation<'a> {
    /// Cache folder, from `--cache`.
    #[doc(hidden)]
    pub cache: Option<&'a Path>,
    /// Returns the error message if a command line is rejected.
    #[doc(hidden)]
    pub refusal: fn(&[String]) -> Option<String>,
    /// Returns the clap definition of all subcommands.
    #[doc(hidden)]
    pub definition: fn() -> clap::Command,
}

/// Options that every subcommand has.
#[derive(Clone, Debug, Default, Args)]
struct Global {
    /// Print only errors, and the object of --json
    #[arg(long, short, global = true, display_order = 900)]
    quiet: bool,
    /// Print exactly one JSON object on stdout instead of text (schemas: bake/docs/schemas.json)
    #[arg(long, global = true, display_order = 900)]
    json: bool,
    #[command(flatten)]
    job: job::JobArgs,
}

/// Subcommands of `pelage`.
#[derive(Debug, Subcommand)]
#[allow(missing_docs, reason = "clap shows the doc comment of each struct of arguments")]
pub enum Command {
    Demo(demo::DemoArgs),
    Bake(bake::BakeArgs),
    Inspect(inspect::InspectArgs),
    Validate(validate::ValidateArgs),
    Unpack(unpack::UnpackArgs),
    Pack(pack::PackArgs),
    Render(render::RenderArgs),
    Bench(bench::BenchArgs),
    #[cfg(feature = "view")]
    View(window::WindowArgs),
    Reference(reference::ReferenceArgs),
    Merge(merge::MergeArgs),
    Export(export::ExportArgs),
    Groom(groom::GroomArgs),
    Sky(sky::SkyArgs),
    Compare(compare::CompareArgs),
    Doctor(doctor::DoctorArgs),
    #[cfg(feature = "herd")]
    Herd(herd::HerdArgs),
    #[cfg(feature = "manual")]
    Manual(manual::ManualArgs),
}

impl Commands for Command {
    #[cfg_attr(not(feature = "herd"), allow(unused_variables, reason = "only the herd command reads the invocation"))]
    fn run(&self, invocation: &Invocation<'_>, output: &mut Output) -> Result<Exit, Failure> {
        match self {
            Self::Demo(args) => demo::run(args, output),
            Self::Bake(args) => bake::run(args, output),
            Self::Inspect(args) => inspect::run(args, output),
            Self::Validate(args) => validate::run(args, output),
            Self::Unpack(args) => unpack::run(args, output),
            Self::Pack(args) => pack::run(args, output),
            Self::Render(args) => render::run(args, output),
            Self::Bench(args) => bench::run(args, output),
            #[cfg(feature = "view")]
            Self::View(args) => window::run(args, output),
            Self::Reference(args) => reference::run(args, output),
            Self::Merge(args) => merge::run(args, output),
            Self::Export(args) => export::run(args, output),
            Self::Groom(args) => groom::run(args, output),
            Self::Sky(args) => sky::run(args, output),
            Self::Compare(args) => compare::run(args, output),
            Self::Doctor(args) => doctor::run(args, output),
            #[cfg(feature = "manual")]
            Self::Manual(args) => manual::run(args, (invocation.definition)(), output),
            #[cfg(feature = "herd")]
            Self::Herd(args) => herd::run(args, invocation.cache, &invocation.refusal, output),
        }
    }

    fn job(&self) -> Option<job::Job> {
        match self {
            Self::Bake(args) => args.job(),
            Self::Render(args) => args.job(),
            Self::Reference(args) => args.job(),
            Self::Merge(args) => args.job(),
            Self::Compare(args) => args.job(),
            Self::Sky(args) => args.job(),
            _ => None,
        }
    }
}

/// Runs the command line of this process.
pub fn run<C: Commands>() -> std::process::ExitCode {
    #[cfg(target_os = "linux")]
    restart_with_xdg_runtime_dir();
    install_panic_hook();
    install_signal_handler();
    let exit = match parse::<C>() {
        Ok((cli, files)) => {
            let mut output = Output::new(cli.global.quiet, cli.global.json);
            let job = cli.command.job();
            let definition = Cli::<C>::command;
            let invocation = Invocation { cache: cli.global.job.cache(), refusal: refusal::<C>, definition };
            let run = |output: &mut Output| catch(|| cli.command.run(&invocation, output));
            let result = job::run(&cli.global.job, &files, job.as_ref(), run, &mut output);
            finish(result, &mut output)
        }
        Err(error) => usage(&error),
    };
    exit.into()
}

/// Parses the command line of this process; also returns the files that it names.
fn parse<C: Commands>() -> Result<(Cli<C>, DeclaredFiles), clap::Error> {
    let mut command = Cli::<C>::command();
    let matches = command.try_get_matches_from_mut(std::env::args_os())?;
    let cli = Cli::from_arg_matches(&matches).map_err(|error| error.format(&mut command))?;
    Ok((cli, DeclaredFiles::of(&command, &matches)))
}

/// Sets `XDG_RUNTIME_DIR` and restarts the process if the variable is missing. Mesa looks there for a Wayland display
/// whenever it opens an adapter, and prints a complaint to stderr if the variable is missing. If the restart fails, the
/// process continues.
#[cfg(target_os = "linux")]
fn restart_with_xdg_runtime_dir() {
    use std::os::unix::process::CommandExt as _;
    const NAME: &str = "XDG_RUNTIME_DIR";
    // The folder contains no displays. Mesa requires an absolute path. Once the variable is set, the process does not
    // restart again.
    const NOWHERE: &str = "/nonexistent";
    if std::env::var_os(NAME).is_some_and(|folder| Path::new(&folder).is_absolute()) {
        return;
    }
    let Ok(program) = std::env::current_exe() else { return };
    let mut arguments = std::env::args_os();
    let mut command = std::process::Command::new(program);
    if let Some(name) = arguments.next() {
        command.arg0(name);
    }
    let _ = command.args(arguments).env(NAME, NOWHERE).exec();
}

/// Returns clap's message in one line: the error and the expected value, without advice.
fn one_line_message(error: &clap::Error) -> String {
    let message = error.to_string();
    let lines = message.lines().take_while(|line| !line.trim().is_empty());
    let line = lines.map(str::trim).collect::<Vec<_>>().join(" ");
    let line = line.strip_prefix("error: ").unwrap_or(&line);
    hint(error).map_or_else(|| line.to_owned(), |hint| format!("{line}; {hint}"))
}

/// Returns a hint if the subcommand exists only in another build.
fn hint(error: &clap::Error) -> Option<&'static str> {
    match error.get(ContextKind::InvalidSubcommand) {
        Some(ContextValue::String(name)) => match name.as_str() {
            "chart" => Some("it is part of pelage-lab: ./run chart"),
            "herd" | "view" => Some("this build leaves it out; in a clone: cargo install --locked --path bake/tool"),
            _ => None,
        },
        _ => None,
    }
}

/// Returns the error message if a command line is rejected.
fn refusal<C: Commands>(words: &[String]) -> Option<String> {
    let error = Cli::<C>::try_parse_from(words).err()?;
    error.use_stderr().then(|| one_line_message(&error))
}

/// Runs `body`, and converts a panic to an internal error, which the panic hook has already reported.
fn catch(body: impl FnOnce() -> Result<Exit, Failure>) -> Result<Exit, Failure> {
    panic::catch_unwind(AssertUnwindSafe(body)).unwrap_or(Err(Failure::Panicked))
}

/// Reports a failure, if any, and returns the exit code.
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

/// Prints help, version or clap's error. For an error the exit code is 1, although clap uses 2.
fn usage(error: &clap::Error) -> Exit {
    if !error.use_stderr() {
        return match error.print() {
            Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Exit::FileSystem,
            _ => Exit::Done,
        };
    }
    // If stderr is closed, the error cannot be reported.
    let _ = error.print();
    if let Some(hint) = hint(error) {
        output::to_stderr(&format!("note: {hint}\n"));
    }
    if std::env::args_os().any(|arg| arg == "--json") {
        Output::new(true, true).error_object(Exit::Usage, &one_line_message(error));
    }
    if let Err(unwritten) = job::record_refusal(&one_line_message(error)) {
        output::to_stderr(&format!("error: {unwritten}\n"));
    }
    Exit::Usage
}

/// Installs a handler for INT, TERM and HUP. It removes temporary files and exits with 128 plus the number of INT.
fn install_signal_handler() {
    // If the system rejects the handler, signals end the process by default.
    let _ = ctrlc::set_handler(|| {
        let _nothing_is_finished_any_more = temp_files::remove_all();
        std::process::exit(130);
    });
}

/// Installs a panic hook that prints one line instead of a backtrace: the location and what to do.
fn install_panic_hook() {
    panic::set_hook(Box::new(|info| {
        let payload = info.payload();
        let text = payload.downcast_ref::<&str>().copied().or(payload.downcast_ref::<String>().map(String::as_str));
        let what = text.unwrap_or("no message");
        let place = info.location().map(ToString::to_string).unwrap_or_default();
        let version = env!("CARGO_PKG_VERSION");
        output::to_stderr(&format!(
            "error: internal error in pelage {version} at {place}: {what}; \
             please report it with the command and its input\n"
        ));
    }));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::<Command>::command().debug_assert();
    }

    #[test]
    fn a_panic_ends_with_exit_code_5() {
        let result = catch(|| panic!("on purpose"));
        assert_eq!(finish(result, &mut Output::new(true, false)), Exit::Internal);
    }
}
