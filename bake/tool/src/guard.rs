//! Files on the command line that are read or written, for the guard against overwriting inputs.

use clap::builder::{PathBufValueParser, TryMapValueParser, TypedValueParser as _, ValueParserFactory};
use clap::{Arg, ArgMatches};
use pelage_bake::io_guard::{self, DeclaredFile};
use pelage_import::BakeError;
use std::any::TypeId;
use std::ffi::OsStr;
use std::ops::Deref;
use std::path::{Path, PathBuf};

/// File that a command writes. Arguments of this type are guarded; those of type [`PathBuf`] are inputs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OutputFile(PathBuf);

type Parser = TryMapValueParser<PathBufValueParser, fn(PathBuf) -> Result<OutputFile, String>>;

impl OutputFile {
    /// Returns the parser of an output that may be `-`, standard output.
    pub fn or_stdout() -> Parser {
        PathBufValueParser::new().try_map(|path| Ok(Self(path)))
    }
}

impl ValueParserFactory for OutputFile {
    type Parser = Parser;

    fn value_parser() -> Self::Parser {
        PathBufValueParser::new().try_map(|path| match path.to_str() {
            Some("-") => Err("cannot be written to standard output; expected a file name".into()),
            _ => Ok(Self(path)),
        })
    }
}

impl From<PathBuf> for OutputFile {
    fn from(path: PathBuf) -> Self {
        Self(path)
    }
}

impl Deref for OutputFile {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl AsRef<Path> for OutputFile {
    fn as_ref(&self) -> &Path {
        &self.0
    }
}

/// Files that a command line names.
#[derive(Clone, Debug, Default)]
pub struct DeclaredFiles {
    inputs: Vec<DeclaredFile>,
    outputs: Vec<DeclaredFile>,
}

impl DeclaredFiles {
    /// Collects the files from a parsed command line.
    pub fn of(command: &clap::Command, matches: &ArgMatches) -> Self {
        let mut files = Self::default();
        files.collect(command, matches);
        files
    }

    fn collect(&mut self, command: &clap::Command, matches: &ArgMatches) {
        for arg in command.get_arguments() {
            let kind = arg.get_value_parser().type_id();
            let list = if kind == TypeId::of::<OutputFile>() {
                &mut self.outputs
            } else if kind == TypeId::of::<PathBuf>() {
                &mut self.inputs
            } else {
                continue;
            };
            let values = matches.try_get_raw(arg.get_id().as_str()).ok().flatten().into_iter().flatten();
            let files = values.map(|path: &OsStr| DeclaredFile { role: role(arg), path: path.into() });
            // Global options are arguments of the subcommand as well.
            let new: Vec<DeclaredFile> = files.filter(|file| !list.contains(file)).collect();
            list.extend(new);
        }
        if let Some((name, matches)) = matches.subcommand()
            && let Some(command) = command.find_subcommand(name)
        {
            self.collect(command, matches);
        }
    }

    /// Starts guarding the command.
    ///
    /// Fails with [`BakeError::SameFile`] if an output is an input, or two outputs are the same file.
    pub fn guard(&self) -> Result<(), BakeError> {
        io_guard::start(&self.inputs, self.outputs.clone())
    }
}

/// Returns the name of an argument as on the command line: `--depfile`, `MODEL`.
fn role(arg: &Arg) -> String {
    let option = || arg.get_long().map(|long| format!("--{long}"));
    let names = || Some(arg.get_value_names()?.first()?.to_string());
    option().or_else(names).unwrap_or_else(|| arg.get_id().to_string())
}
