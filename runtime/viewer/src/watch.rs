//! File watcher.
//!
//! A thread compares length and modification time of each file ten times a second. This also works in shared folders,
//! where the system reports no changes. It also works with editors that write a new file and rename it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, SystemTime};

/// Polling interval. A change is reported once the file is equal in two consecutive polls.
const INTERVAL: Duration = Duration::from_millis(100);

/// State of a file: length and modification time. `None` if the file does not exist.
pub type Stamp = Option<(u64, SystemTime)>;

/// Returns the current state of a file.
pub fn stamp(file: &Path) -> Stamp {
    let data = file.metadata().ok()?;
    Some((data.len(), data.modified().unwrap_or(SystemTime::UNIX_EPOCH)))
}

/// File watcher; calls a callback when a file changes.
pub struct Watch {
    files: Arc<Mutex<BTreeMap<PathBuf, Watched>>>,
    /// Channel whose closing, on drop, ends the thread.
    _open: Sender<()>,
}

struct Watched {
    /// State of the file when its last change was reported.
    reported: Stamp,
    /// State of the file at the last poll.
    seen: Stamp,
}

impl Watch {
    /// Creates a watcher without files. `changed` is called on a background thread.
    pub fn new(changed: impl Fn() + Send + 'static) -> Self {
        let files = Arc::new(Mutex::new(BTreeMap::new()));
        let (open, closed) = channel();
        let watched = files.clone();
        std::thread::spawn(move || {
            while closed.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
                if poll(&mut watched.lock().unwrap_or_else(PoisonError::into_inner)) {
                    changed();
                }
            }
        });
        Self { files, _open: open }
    }

    /// Replaces the watched files. A file that does not exist yet counts as changed when it appears.
    pub fn set(&mut self, files: &[PathBuf]) {
        let mut watched = self.files.lock().unwrap_or_else(PoisonError::into_inner);
        let mut before = std::mem::take(&mut *watched);
        // A file that is already watched keeps its previous stamp, because it may have changed since it was read.
        watched.extend(files.iter().map(|file| {
            let now = stamp(file);
            (file.clone(), before.remove(file).unwrap_or(Watched { reported: now, seen: now }))
        }));
    }
}

/// Returns whether any file has changed since its last report and is now completely written.
fn poll(files: &mut BTreeMap<PathBuf, Watched>) -> bool {
    let mut any = false;
    for (file, watched) in files {
        let now = stamp(file);
        if std::mem::replace(&mut watched.seen, now) == now && watched.reported != now {
            watched.reported = now;
            any = true;
        }
    }
    any
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;

    #[test]
    fn watch_reports_saves_of_the_file_and_ignores_its_neighbours() {
        let folder = tempfile::tempdir().unwrap();
        let (file, neighbour) = (folder.path().join("a.toml"), folder.path().join("b.toml"));
        std::fs::write(&file, "1").unwrap();
        let (sender, changes) = channel();
        let mut watch = Watch::new(move || sender.send(()).unwrap_or_default());
        watch.set(&[file.clone(), folder.path().join("no-such-folder/c.png")]);
        let second = Duration::from_secs(10);

        std::fs::write(folder.path().join("a.toml.new"), "22").unwrap();
        std::fs::rename(folder.path().join("a.toml.new"), &file).unwrap();
        changes.recv_timeout(second).unwrap();

        std::fs::read(&file).unwrap();
        std::fs::write(&neighbour, "1").unwrap();
        assert!(
            changes.recv_timeout(5 * INTERVAL).is_err(),
            "neither reads nor changes of other files may be reported"
        );

        watch.set(std::slice::from_ref(&neighbour));
        std::fs::remove_file(&neighbour).unwrap();
        changes.recv_timeout(second).unwrap();
    }
}
