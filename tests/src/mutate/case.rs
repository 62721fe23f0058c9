//! Case of the mutation run: files in an otherwise empty folder, the commands to run on them, and the requirements on
//! their output.

use std::path::Path;

/// Entry in the folder of a case.
#[derive(Clone, Debug)]
pub enum Entry {
    /// File with its contents; parent folders are created.
    File(String, Vec<u8>),
    /// Empty folder.
    Folder(String),
    /// Symbolic link, and its target.
    Link(String, String),
}

impl Entry {
    /// Returns an [`Entry::File`].
    pub fn file(name: &str, bytes: impl Into<Vec<u8>>) -> Self {
        Self::File(name.into(), bytes.into())
    }

    /// Returns the path of the entry, relative to the folder.
    pub fn name(&self) -> &str {
        match self {
            Self::File(name, _) | Self::Folder(name) | Self::Link(name, _) => name,
        }
    }

    /// Writes the entry into a folder.
    ///
    /// # Errors
    ///
    /// If the entry cannot be written.
    pub fn write(&self, folder: &Path) -> std::io::Result<()> {
        let path = folder.join(self.name());
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent)?;
        }
        match self {
            Self::File(_, bytes) => std::fs::write(path, bytes),
            Self::Folder(_) => std::fs::create_dir_all(path),
            #[cfg(unix)]
            Self::Link(_, target) => std::os::unix::fs::symlink(target, path),
            // Without symbolic links, a file with the link's target as its text is written instead, which is invalid as
            // well.
            #[cfg(not(unix))]
            Self::Link(_, target) => std::fs::write(path, target),
        }
    }
}

/// Requirement on the output of a command that exits with 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputCheck {
    /// No requirement.
    Nothing,
    /// The output is a package that `pelage validate` accepts.
    Validates,
    /// The output is a folder from which `pelage pack` makes an identical package.
    PacksBack,
}

/// Command of a case: one run of `pelage`.
#[derive(Clone, Debug)]
pub struct Step {
    /// Command-line arguments.
    pub args: Vec<String>,
    /// Name of the output in the case's folder. It must exist if and only if the exit code is 0.
    pub makes: Option<&'static str>,
    /// Requirement on the output.
    pub then: OutputCheck,
}

impl Step {
    /// Creates a command without an output file.
    pub fn reads(args: &[&str]) -> Self {
        Self { args: args.iter().map(|a| (*a).to_owned()).collect(), makes: None, then: OutputCheck::Nothing }
    }

    /// Creates a command that writes `output`.
    pub fn makes(args: &[&str], output: &'static str, then: OutputCheck) -> Self {
        Self { makes: Some(output), then, ..Self::reads(args) }
    }
}

/// Files, and the commands run on them.
#[derive(Clone, Debug)]
pub struct Case {
    /// Description of the damage, for messages.
    pub what: String,
    /// Contents of the folder. An entry replaces earlier entries of the same name.
    pub entries: Vec<Entry>,
    /// Commands, in order.
    pub steps: Vec<Step>,
    /// Name of the package, if any, that is also checked in the process of the mutation run.
    pub package: Option<&'static str>,
}

impl Case {
    /// Creates a case from the entries of `base`, some of which `entries` replace.
    pub fn new(what: String, base: &[Entry], entries: Vec<Entry>, steps: Vec<Step>) -> Self {
        let stays = |old: &&Entry| !entries.iter().any(|new| new.name() == old.name());
        let all = base.iter().filter(stays).cloned().chain(entries.iter().cloned()).collect();
        Self { what, entries: all, steps, package: None }
    }

    /// Replaces the contents of a folder with the files of the case.
    ///
    /// # Errors
    ///
    /// If a file cannot be removed or written.
    pub fn write_into(&self, folder: &Path) -> std::io::Result<()> {
        if folder.exists() {
            std::fs::remove_dir_all(folder)?;
        }
        std::fs::create_dir_all(folder)?;
        self.entries.iter().try_for_each(|entry| entry.write(folder))
    }
}
