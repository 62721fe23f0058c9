//! Lock of a herd's output folder: one run at a time.

use super::on_disk::Herd;
use super::paths::io_error;
use crate::exit::Failure;
use crate::output::make_folder;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Error, ErrorKind, Read as _, Seek as _, Write as _};
use std::path::PathBuf;
use std::process::Stdio;

/// Locked file in the herd's internal folder. It contains the number of the process that runs commands.
#[derive(Debug)]
pub struct RunLock {
    file: File,
    path: PathBuf,
}

impl RunLock {
    /// Locks the output folder of a herd.
    ///
    /// Fails with [`Failure::Bake`] if another process has locked it, or the file cannot be written.
    pub fn new(herd: &Herd) -> Result<Self, Failure> {
        let folder = herd.path(&herd.internal_folder());
        make_folder(&folder)?;
        let path = folder.join("lock");
        let fail = |source| io_error(&path, "lock", source);
        let opened = OpenOptions::new().create(true).truncate(false).read(true).write(true).open(&path);
        let mut file = opened.map_err(fail)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut owner = String::new();
                // Without the number, the message is still right.
                let _ = file.read_to_string(&mut owner);
                return Err(fail(Error::new(ErrorKind::ResourceBusy, busy(owner.trim()))));
            }
            // Some network file systems have no locks. Runs there are not protected from each other.
            Err(TryLockError::Error(source)) if source.kind() == ErrorKind::Unsupported => {}
            Err(TryLockError::Error(source)) => return Err(fail(source)),
        }
        let mut lock = Self { file, path };
        lock.set_owner(std::process::id())?;
        Ok(lock)
    }

    /// Sets the number of the process that runs commands.
    pub fn set_owner(&mut self, process: u32) -> Result<(), Failure> {
        let file = &mut self.file;
        let written = file.set_len(0).and_then(|()| file.rewind()).and_then(|()| writeln!(file, "{process}"));
        written.map_err(|source| io_error(&self.path, "write", source))
    }

    /// Returns the lock as standard input of a child process. The folder then stays locked until the child ends, even
    /// if this process is killed. The child must not read its input.
    pub fn to_stdin(&self) -> Result<Stdio, Failure> {
        self.file.try_clone().map(Stdio::from).map_err(|source| io_error(&self.path, "lock", source))
    }
}

fn busy(owner: &str) -> String {
    let process = if owner.is_empty() { String::new() } else { format!(", process {owner},") };
    format!(
        "another run{process} is at work in this folder: `pelage herd run`, or the Ninja of one that was killed; \
         wait until it ends, or end it"
    )
}
