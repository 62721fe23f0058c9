//! Content-addressed cache of command results, in a folder that several processes may share.
//!
//! The files that a command reads are not known in advance, because a model names its images. But each file is
//! determined by the arguments and by the files read before. A state is a hash of the tool, the arguments and
//! everything read so far. For each state, the cache holds either the next input to read or the result. A lookup
//! follows these states and reads each input on the way.
//!
//! Files are written atomically, and files of the same name have the same content. So no locks are needed, and any file
//! may be removed at any time. Missing or damaged files count as cache misses.

use crate::hexadecimal::{self, hex};
use crate::io::{digest, read_file, write_atomic};
use crate::io_guard;
use crate::io_trace::{Digest, IoTrace, TracedInput};
use pelage_import::BakeError;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest as _, Sha256};
use std::path::{Path, PathBuf};

/// Cache folder.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: PathBuf,
}

/// Cached result of a command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CommandResult {
    /// Output files.
    pub files: Vec<CachedFile>,
    /// Exit code.
    pub exit: u8,
    /// Result as text for people.
    pub text: String,
    /// Result as JSON for scripts.
    pub json: Value,
    /// Messages that the command printed while it ran.
    pub notes: Vec<String>,
}

/// Output file of a command.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CachedFile {
    /// Index of the output folder that contains the file.
    pub folder: usize,
    /// File name within that folder.
    pub name: String,
    /// Path as the user gave it.
    pub shown: String,
    /// SHA-256 of the contents, in hexadecimal.
    pub sha256: String,
}

/// Cache entry for one state.
#[derive(Serialize, Deserialize)]
enum Node {
    /// File to read next, up to `most` bytes.
    File { path: String, most: u64 },
    /// Property of the machine to query next.
    Machine { what: String },
    /// Result; nothing more is read.
    Made(CommandResult),
}

/// Cache hit.
#[derive(Clone, Debug, PartialEq)]
pub struct CacheHit {
    /// Cached result.
    pub kept: CommandResult,
    /// Files on which the result depends.
    pub read: Vec<PathBuf>,
}

/// Maximum number of states per command; each state reads one input.
const MOST_STATES: usize = 100_000;

impl Cache {
    /// Opens a cache in `folder`, which is created when the first result is stored.
    pub fn new(folder: &Path) -> Self {
        // Bump when the layout changes.
        Self { folder: folder.join("v1") }
    }

    /// Returns the hash of the tool's executable, which identifies the build. The hash is computed once for each path,
    /// size and modification time of the executable, and stored in the cache.
    ///
    /// Fails with [`BakeError::Io`] if the executable cannot be read.
    pub fn tool_hash(&self, program: &Path) -> Result<Digest, BakeError> {
        let fail = |source| BakeError::Io { path: program.to_owned(), action: "read", source };
        let found = std::fs::metadata(program).map_err(fail)?;
        let installed = format!("{} {} {:?}", program.display(), found.len(), found.modified().ok());
        let path = self.entry_path("tools", &Sha256::digest(installed).into());
        if let Some(known) = std::fs::read_to_string(&path).ok().and_then(|text| from_hex(&text)) {
            return Ok(known);
        }
        let digest = digest(program, u64::MAX).map_err(fail)?;
        // If writing fails, the hash is computed again next time.
        let _ = write(&path, hex(&digest).as_bytes());
        Ok(digest)
    }

    /// Looks up the result of a command for the current contents of its input files.
    ///
    /// * `key`: hash of the tool and the command's arguments
    /// * `machine`: answers queries about the machine
    pub fn lookup(&self, key: &Digest, machine: &mut dyn FnMut(&str) -> Option<String>) -> Option<CacheHit> {
        let (mut state, mut read) = (*key, Vec::new());
        for _ in 0..MOST_STATES {
            let bytes = std::fs::read(self.entry_path("states", &state)).ok()?;
            match serde_json::from_slice(&bytes).ok()? {
                Node::File { path, most } => {
                    let path = PathBuf::from(path);
                    let digest = digest_of(&path, most)?;
                    io_guard::record_read(&path, || "an input".to_owned());
                    state = next_state_of_file(&state, digest.as_ref());
                    if digest.is_some() && !read.contains(&path) {
                        read.push(path);
                    }
                }
                Node::Machine { what } => state = next_state(&state, machine(&what)?.as_bytes()),
                Node::Made(kept) => return Some(CacheHit { kept, read }),
            }
        }
        None
    }

    /// Returns the contents of a cached file, or `None` if the file is missing or damaged.
    pub fn read(&self, file: &CachedFile) -> Option<Vec<u8>> {
        let digest = from_hex(&file.sha256)?;
        let bytes = std::fs::read(self.entry_path("files", &digest)).ok()?;
        (Digest::from(Sha256::digest(&bytes)) == digest).then_some(bytes)
    }

    /// Stores the result of a command together with the inputs that it read.
    ///
    /// * `files`: paths of the files in `kept`
    ///
    /// Fails with [`BakeError::Io`]. Entries written before the error are harmless.
    pub fn store(
        &self,
        key: &Digest,
        traffic: &IoTrace,
        kept: &CommandResult,
        files: &[&Path],
    ) -> Result<(), BakeError> {
        for (file, path) in kept.files.iter().zip(files) {
            let Some(digest) = from_hex(&file.sha256) else { continue };
            let place = self.entry_path("files", &digest);
            if !place.exists() {
                write(&place, &read_file(path)?)?;
            }
        }
        let mut state = *key;
        for asked in &traffic.asked {
            let (node, next) = match asked {
                TracedInput::File { path, most, digest } => {
                    // A node cannot store a path that is not valid Unicode; such commands are never cached.
                    let Some(path) = path.to_str() else { return Ok(()) };
                    (Node::File { path: path.to_owned(), most: *most }, next_state_of_file(&state, digest.as_ref()))
                }
                TracedInput::Machine { what, answer } => {
                    (Node::Machine { what: (*what).to_owned() }, next_state(&state, answer.as_bytes()))
                }
            };
            self.put(&state, &node)?;
            state = next;
        }
        self.put(&state, &Node::Made(kept.clone()))
    }

    fn put(&self, state: &Digest, node: &Node) -> Result<(), BakeError> {
        let bytes = serde_json::to_vec(node).map_err(|error| BakeError::Internal(error.to_string()))?;
        let place = self.entry_path("states", state);
        // Entries for the same state differ at most in figures such as run times, so an existing entry is kept.
        if place.exists() { Ok(()) } else { write(&place, &bytes) }
    }

    /// Returns the path of an entry, spread over 256 subfolders.
    fn entry_path(&self, what: &str, digest: &Digest) -> PathBuf {
        let name = hex(digest);
        let (folder, name) = name.split_at(2);
        self.folder.join(what).join(folder).join(name)
    }
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), BakeError> {
    if let Some(folder) = path.parent() {
        let fail = |source| BakeError::Io { path: folder.to_owned(), action: "create", source };
        std::fs::create_dir_all(folder).map_err(fail)?;
    }
    write_atomic(path, bytes)
}

/// Returns the hash of the first `most` bytes of a file. Returns `Some(None)` if the file does not exist, and `None` if
/// it is not a regular file or cannot be read.
fn digest_of(path: &Path, most: u64) -> Option<Option<Digest>> {
    let Ok(found) = std::fs::metadata(path) else { return Some(None) };
    if !found.is_file() {
        return None;
    }
    digest(path, most).ok().map(Some)
}

/// Returns the state after another input was read.
fn next_state(state: &Digest, learnt: &[u8]) -> Digest {
    Sha256::new().chain_update(state).chain_update(learnt).finalize().into()
}

fn next_state_of_file(state: &Digest, digest: Option<&Digest>) -> Digest {
    next_state(state, digest.map_or(b"nothing there".as_slice(), |digest| digest))
}

fn from_hex(text: &str) -> Option<Digest> {
    hexadecimal::from_hex(text)?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io_trace::TracedOutput;

    fn kept(name: &str, bytes: &[u8]) -> CommandResult {
        let file = CachedFile { folder: 0, name: name.into(), shown: name.into(), sha256: hex(&Sha256::digest(bytes)) };
        CommandResult { files: vec![file], exit: 0, text: "made".into(), json: Value::Null, notes: Vec::new() }
    }

    fn asked(path: &Path, most: u64) -> TracedInput {
        TracedInput::File { path: path.to_owned(), most, digest: digest_of(path, most).unwrap() }
    }

    #[test]
    fn cache_hits_require_unchanged_files() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("model"), "a model and more").unwrap();
        std::fs::write(path("out"), "made of it").unwrap();
        let cache = Cache::new(&path("cache"));
        let key = [7; 32];
        let traffic = IoTrace {
            asked: vec![
                asked(&path("model"), 7),
                asked(&path("absent"), 0),
                TracedInput::Machine { what: "adapter", answer: "a".into() },
            ],
            written: vec![TracedOutput { path: path("out"), digest: Sha256::digest("made of it").into() }],
            in_part: false,
        };
        let made = kept("out", b"made of it");
        let answer = |machine: &str| {
            let found = cache.lookup(&key, &mut |what| (what == "adapter").then(|| machine.to_owned()));
            found.map(|found| (cache.read(&found.kept.files[0]), found))
        };
        assert!(answer("a").is_none());
        cache.store(&key, &traffic, &made, &[&path("out")]).unwrap();
        let (bytes, found) = answer("a").unwrap();
        assert_eq!((bytes.as_deref(), &found.kept, found.read), (Some(&b"made of it"[..]), &made, vec![path("model")]));
        // A lookup misses if the machine differs, if the bytes that were read have changed, or if an absent file now
        // exists.
        assert!(answer("b").is_none());
        std::fs::write(path("model"), "a model and other bytes behind").unwrap();
        assert!(answer("a").is_some(), "no more than seven bytes were read");
        std::fs::write(path("model"), "b model").unwrap();
        assert!(answer("a").is_none());
        std::fs::write(path("model"), "a model").unwrap();
        std::fs::write(path("absent"), "").unwrap();
        assert!(answer("a").is_none());
        std::fs::remove_file(path("absent")).unwrap();
        assert!(cache.lookup(&[8; 32], &mut |_| Some("a".into())).is_none());
        // Damaged files are not returned.
        let place = cache.entry_path("files", &Sha256::digest("made of it").into());
        std::fs::write(&place, "made of If").unwrap();
        assert_eq!(answer("a").unwrap().0, None);
        std::fs::write(cache.entry_path("states", &key), "{").unwrap();
        assert!(answer("a").is_none());
    }

    #[test]
    fn a_tool_is_hashed_once() {
        let folder = tempfile::tempdir().unwrap();
        let (program, cache) = (folder.path().join("tool"), Cache::new(&folder.path().join("cache")));
        std::fs::write(&program, "a program").unwrap();
        let digest: Digest = Sha256::digest("a program").into();
        assert_eq!((cache.tool_hash(&program).unwrap(), cache.tool_hash(&program).unwrap()), (digest, digest));
        assert!(cache.tool_hash(&folder.path().join("none")).is_err());
        assert_eq!((from_hex(&hex(&digest)), from_hex("zz"), from_hex("")), (Some(digest), None, None));
    }
}
