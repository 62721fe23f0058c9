//! Files that are watched for changes.
//!
//! Editors save by writing another file and giving it the old one's name, so what is watched are the folders, and what happens to other files there
//! is nobody's business here. Several changes within a moment are one. That somebody reads a file is told by some systems, too: what counts is whether
//! the file is another one.

use notify_debouncer_mini::notify::{RecommendedWatcher, RecursiveMode};
use notify_debouncer_mini::{Config, DebounceEventResult, Debouncer, new_debouncer_opt};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, SystemTime};

/// So long nothing may happen to a file before its change counts.
const QUIET: Duration = Duration::from_millis(80);

/// A file as it is: length and time of change, or that it is not there.
pub type Stamp = Option<(u64, SystemTime)>;

/// That of a file now.
pub fn stamp(file: &Path) -> Stamp {
    let data = file.metadata().ok()?;
    Some((data.len(), data.modified().unwrap_or(SystemTime::UNIX_EPOCH)))
}

/// Watches files and calls back when any of them changes.
pub struct Watch {
    debouncer: Debouncer<RecommendedWatcher>,
    folders: BTreeSet<PathBuf>,
    /// With what they were when they were last looked at.
    files: Arc<Mutex<BTreeMap<PathBuf, Stamp>>>,
}

impl Watch {
    /// Watches nothing yet. `changed` is called on a thread of its own.
    ///
    /// # Errors
    ///
    /// Why the system watches no files.
    pub fn new(changed: impl Fn() + Send + 'static) -> Result<Self, String> {
        let files = Arc::new(Mutex::new(BTreeMap::new()));
        let watched: Arc<Mutex<BTreeMap<PathBuf, Stamp>>> = files.clone();
        let handle = move |result: DebounceEventResult| {
            let Ok(events) = result else { return };
            let mut watched = watched.lock().unwrap_or_else(PoisonError::into_inner);
            let mut is_another = false;
            for event in events {
                if let Some(before) = watched.get_mut(&event.path) {
                    let now = stamp(&event.path);
                    is_another |= std::mem::replace(before, now) != now;
                }
            }
            drop(watched);
            if is_another {
                changed();
            }
        };
        // In a batch it would wait up to twice as long.
        let config = Config::default().with_timeout(QUIET).with_batch_mode(false);
        let debouncer =
            new_debouncer_opt::<_, RecommendedWatcher>(config, handle).map_err(|error| error.to_string())?;
        Ok(Self { debouncer, folders: BTreeSet::new(), files })
    }

    /// Watches these files and no others. Those in folders that do not exist are left out.
    pub fn set(&mut self, files: &[PathBuf]) {
        let files: BTreeSet<PathBuf> = files.iter().filter_map(|file| absolute(file)).collect();
        let folders: BTreeSet<PathBuf> = files.iter().filter_map(|file| file.parent()).map(Path::to_owned).collect();
        let watcher = self.debouncer.watcher();
        for gone in self.folders.difference(&folders) {
            // A folder that was removed is not watched any more in any case.
            let _ = watcher.unwatch(gone);
        }
        let new: Vec<&PathBuf> = folders.difference(&self.folders).collect();
        let refused: BTreeSet<PathBuf> =
            new.into_iter().filter(|new| watcher.watch(new, RecursiveMode::NonRecursive).is_err()).cloned().collect();
        self.folders = folders.difference(&refused).cloned().collect();
        let mut watched = self.files.lock().unwrap_or_else(PoisonError::into_inner);
        // One that is watched already may have changed since it was read: that is found when its change is told.
        let stamps = files.into_iter().map(|file| {
            let known = watched.get(&file).copied();
            let stamp = known.unwrap_or_else(|| stamp(&file));
            (file, stamp)
        });
        *watched = stamps.collect();
    }
}

/// The file's place in its folder's one true path, as the system tells of it.
fn absolute(file: &Path) -> Option<PathBuf> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Some(folder.canonicalize().ok()?.join(file.file_name()?))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;
    use std::sync::mpsc::channel;

    #[test]
    fn a_file_saved_under_its_name_is_a_change_and_its_neighbour_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let (file, neighbour) = (folder.path().join("a.toml"), folder.path().join("b.toml"));
        std::fs::write(&file, "1").unwrap();
        let (sender, changes) = channel();
        let mut watch = Watch::new(move || sender.send(()).unwrap_or_default()).unwrap();
        watch.set(&[file.clone(), folder.path().join("no-such-folder/c.png")]);
        let second = Duration::from_secs(10);

        std::fs::write(folder.path().join("a.toml.new"), "2").unwrap();
        std::fs::rename(folder.path().join("a.toml.new"), &file).unwrap();
        changes.recv_timeout(second).unwrap();

        std::fs::read(&file).unwrap();
        std::fs::write(&neighbour, "1").unwrap();
        assert!(changes.recv_timeout(5 * QUIET).is_err(), "a neighbour changed, and the file was read");

        watch.set(std::slice::from_ref(&neighbour));
        std::fs::remove_file(&neighbour).unwrap();
        changes.recv_timeout(second).unwrap();
    }
}
