//! Exit codes. Errors are converted to exit codes only in this file.

use pelage_import::BakeError;
use pelage_stage::StageError;
use std::process::ExitCode;

/// Exit codes of `pelage`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Success. Also used if the reader of stdout has closed it.
    Done = 0,
    /// Invalid command line.
    Usage = 1,
    /// File system error.
    FileSystem = 2,
    /// Invalid model, recipe, package or folder.
    BadInput = 3,
    /// No usable graphics adapter.
    NoAdapter = 4,
    /// Bug in pelage.
    Internal = 5,
    /// Faults found by `validate`, differences found by a comparison, or a limit exceeded in `chart stability`.
    Differences = 7,
}

impl Exit {
    /// All exit codes, each with a word for the help text, and its meaning.
    pub const ALL: [(Self, &str, &str); 7] = [
        (Self::Done, "done", "Success, or the reader of standard output closed it."),
        (Self::Usage, "usage", "The command line is invalid."),
        (Self::FileSystem, "file system", "A file or folder cannot be read, written or created."),
        (
            Self::BadInput,
            "bad input",
            "A model, recipe, look, scene, package or folder is invalid. The message names the file, the place in it, \
             what was found and what was expected.",
        ),
        (
            Self::NoAdapter,
            "no usable graphics adapter",
            "No usable graphics adapter, or for `view` no screen. The message says what to install.",
        ),
        (Self::Internal, "internal error", "A bug in pelage. Please report it."),
        (
            Self::Differences,
            "differences or faults found",
            "`validate` found faults, or `compare` or `chart stability` found a value beyond its limit.",
        ),
    ];

    /// Returns the variant with a code.
    pub fn of(code: u8) -> Option<Self> {
        Self::ALL.iter().map(|(exit, ..)| *exit).find(|exit| *exit as u8 == code)
    }

    /// Returns one line that lists all codes, for the end of the help text.
    pub fn summary() -> String {
        let codes = Self::ALL.map(|(exit, word, _)| format!("{} {word}", exit as u8));
        format!("Exit codes: {}.", codes.join("; "))
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Error of a subcommand.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// Options that contradict each other or the package, which clap cannot detect.
    #[error("{0}")]
    Usage(String),
    /// Error of the library.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// No usable graphics adapter; the text lists what was tried.
    #[error("no usable graphics adapter: {0}\n{NO_ADAPTER_HELP}")]
    NoAdapter(String),
    /// No display for a window; the text says what is required.
    #[cfg(feature = "view")]
    #[error("{0}")]
    NoWindow(String),
    /// Writing to stdout failed.
    #[error("standard output: cannot write: {0}")]
    Stdout(std::io::Error),
    /// Panic, already reported by the panic hook.
    #[error("internal error")]
    Panicked,
}

/// Installation advice for [`Failure::NoAdapter`].
const NO_ADAPTER_HELP: &str = "\
pelage draws with Vulkan, Metal or Direct3D 12. Install your graphics card's driver, or a software one:
  Debian, Ubuntu: apt-get install mesa-vulkan-drivers
  Fedora: dnf install mesa-vulkan-drivers
  Arch: pacman -S vulkan-swrast
  Alpine: apk add mesa-vulkan-swrast
If VK_DRIVER_FILES or VK_ICD_FILENAMES is set, check that it names a driver that exists.";

impl From<StageError> for Failure {
    fn from(error: StageError) -> Self {
        match error {
            StageError::Input { file, place, reason } => BakeError::Input { file, place, reason }.into(),
            StageError::Package { file, source } => BakeError::Package { file, source }.into(),
            // Requests to a stage have the names of command-line options.
            StageError::Request { what, reason } => Self::Usage(format!("--{what}: {reason}")),
            StageError::Params(text) => Self::Usage(text),
            StageError::NoAdapter(text) => Self::NoAdapter(text),
            StageError::Internal(text) => BakeError::Internal(text).into(),
            other => BakeError::Internal(other.to_string()).into(),
        }
    }
}

impl Failure {
    /// Returns the exit code, as documented in `bake/docs/commands.md`.
    pub fn exit(&self) -> Exit {
        match self {
            Self::Usage(_) => Exit::Usage,
            Self::Bake(error) => match error {
                BakeError::Io { .. } => Exit::FileSystem,
                BakeError::SameFile { .. } => Exit::Usage,
                BakeError::Input { .. } | BakeError::Package { .. } | BakeError::Params { .. } => Exit::BadInput,
                // Includes `Internal` and all future variants.
                _ => Exit::Internal,
            },
            Self::NoAdapter(_) => Exit::NoAdapter,
            #[cfg(feature = "view")]
            Self::NoWindow(_) => Exit::NoAdapter,
            Self::Stdout(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Exit::Done,
            Self::Stdout(_) => Exit::FileSystem,
            Self::Panicked => Exit::Internal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Error, ErrorKind};

    #[test]
    fn every_failure_has_its_code() {
        let io = |kind| BakeError::Io { path: "a".into(), action: "read", source: Error::from(kind) };
        let input = BakeError::Input { file: "a".into(), place: "byte 1".into(), reason: "b".into() };
        for (failure, code) in [
            (Failure::Usage("a".into()), 1),
            (io(ErrorKind::NotFound).into(), 2),
            (input.into(), 3),
            (BakeError::SameFile { written: "-o a".into(), other: "a".into() }.into(), 1),
            (BakeError::Params { what: "a", reason: "b".into() }.into(), 3),
            (Failure::NoAdapter("a".into()), 4),
            (BakeError::Internal("a".into()).into(), 5),
            (Failure::Panicked, 5),
            (Failure::Stdout(ErrorKind::BrokenPipe.into()), 0),
            (Failure::Stdout(ErrorKind::StorageFull.into()), 2),
        ] {
            assert_eq!(failure.exit() as u8, code, "{failure:?}");
        }
    }

    #[test]
    fn missing_adapter_message_names_the_driver_packages() {
        let message = Failure::NoAdapter("none found".into()).to_string();
        assert!(message.contains("mesa-vulkan-drivers") && message.contains("none found"));
    }
}
