//! One case: files in an otherwise empty folder, what is run on them, and what must hold of what comes out.

use std::path::Path;

/// Something in the folder of a case.
#[derive(Clone, Debug)]
pub enum Entry {
    /// A file with its bytes; folders above it are made.
    File(String, Vec<u8>),
    /// An empty folder.
    Folder(String),
    /// A symbolic link with that target.
    Link(String, String),
}

impl Entry {
    /// A file.
    pub fn file(name: &str, bytes: impl Into<Vec<u8>>) -> Self {
        Self::File(name.into(), bytes.into())
    }

    /// Its path in the folder.
    pub fn name(&self) -> &str {
        match self {
            Self::File(name, _) | Self::Folder(name) | Self::Link(name, _) => name,
        }
    }

    /// Puts it into a folder.
    ///
    /// # Errors
    ///
    /// Where the system refuses.
    pub fn put(&self, folder: &Path) -> std::io::Result<()> {
        let path = folder.join(self.name());
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent)?;
        }
        match self {
            Self::File(_, bytes) => std::fs::write(path, bytes),
            Self::Folder(_) => std::fs::create_dir_all(path),
            #[cfg(unix)]
            Self::Link(_, target) => std::os::unix::fs::symlink(target, path),
            // A file that says where it should lead: as good a fault as a link.
            #[cfg(not(unix))]
            Self::Link(_, target) => std::fs::write(path, target),
        }
    }
}

/// What must hold of what a command made, where it exits with 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Then {
    /// Nothing further.
    Nothing,
    /// It is a package, which `pelage validate` finds sound.
    Validates,
    /// It is a folder, which `pelage pack` makes the very same package of.
    PacksBack,
}

/// A run of `pelage`.
#[derive(Clone, Debug)]
pub struct Step {
    /// Its arguments.
    pub args: Vec<String>,
    /// What it writes, in the case's folder; it must be there exactly if the exit code is 0.
    pub makes: Option<&'static str>,
    /// What must hold of that.
    pub then: Then,
}

impl Step {
    /// A command that writes nothing.
    pub fn reads(args: &[&str]) -> Self {
        Self { args: args.iter().map(|a| (*a).to_owned()).collect(), makes: None, then: Then::Nothing }
    }

    /// A command that writes `output`.
    pub fn makes(args: &[&str], output: &'static str, then: Then) -> Self {
        Self { makes: Some(output), then, ..Self::reads(args) }
    }
}

/// Files, and what is run on them.
#[derive(Clone, Debug)]
pub struct Case {
    /// What was changed, for people.
    pub what: String,
    /// What lies in the folder. A later entry takes the place of an earlier one of its name.
    pub entries: Vec<Entry>,
    /// What is run, one after the other.
    pub steps: Vec<Step>,
    /// The entry that is a package: it is looked at within this process as well.
    pub package: Option<&'static str>,
}

impl Case {
    /// A case of those entries over those of its base.
    pub fn new(what: String, base: &[Entry], entries: Vec<Entry>, steps: Vec<Step>) -> Self {
        let stays = |old: &&Entry| !entries.iter().any(|new| new.name() == old.name());
        let all = base.iter().filter(stays).cloned().chain(entries.iter().cloned()).collect();
        Self { what, entries: all, steps, package: None }
    }

    /// Puts its files into a folder, in place of what there is.
    ///
    /// # Errors
    ///
    /// Where the system refuses.
    pub fn lay(&self, folder: &Path) -> std::io::Result<()> {
        if folder.exists() {
            std::fs::remove_dir_all(folder)?;
        }
        std::fs::create_dir_all(folder)?;
        self.entries.iter().try_for_each(|entry| entry.put(folder))
    }
}
