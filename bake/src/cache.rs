//! What commands have made, kept by the hash of everything that it depends on, in a folder that many may share.
//!
//! What a command will read is not known before it runs: a model names its images. But it is decided by its arguments and by what it has read before. So the
//! cache holds for each state, a hash of the tool, the arguments and all that was read so far, either what is asked for next or, where that was all, what was
//! made. Whoever looks something up walks from one to the next and reads what he is told to.
//!
//! Files appear when they are whole, and those of one name have the same content whoever writes them: nobody locks, and every file may be removed at any
//! time. What is missing or damaged is not found, and made again.

use crate::hexadecimal::{self, hex};
use crate::io::{digest, read_file, write_atomic};
use crate::traffic::{Asked, Digest, Traffic};
use pelage_import::BakeError;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest as _, Sha256};
use std::path::{Path, PathBuf};

/// A folder of what was made.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: PathBuf,
}

/// What a command has made and said.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// Its files.
    pub files: Vec<KeptFile>,
    /// How it ended.
    pub exit: u8,
    /// Its result for people.
    pub text: String,
    /// The same for scripts.
    pub json: Value,
    /// What it said on the way.
    pub notes: Vec<String>,
}

/// A file that a command has made.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeptFile {
    /// In which of the folders that it writes into.
    pub folder: usize,
    /// Its name there.
    pub name: String,
    /// As the command named it.
    pub shown: String,
    /// SHA-256, in hexadecimal.
    pub sha256: String,
}

/// What is known of a state.
#[derive(Serialize, Deserialize)]
enum Node {
    /// This file is read next, and no more of it than that.
    File { path: String, most: u64 },
    /// The machine is asked for this next.
    Machine { what: String },
    /// That was all.
    Made(Kept),
}

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// What was made.
    pub kept: Kept,
    /// The files that it depends on.
    pub read: Vec<PathBuf>,
}

/// States that one command goes through at most: it asks for one thing in each.
const MOST_STATES: usize = 100_000;

impl Cache {
    /// A cache in `folder`, which is made where something is kept.
    pub fn new(folder: &Path) -> Self {
        // Another layout gets another name.
        Self { folder: folder.join("v1") }
    }

    /// Stands for a build of the tool: the hash of its program, which is made once for each that is installed.
    ///
    /// # Errors
    ///
    /// [`BakeError::Io`] where the program cannot be read.
    pub fn tool(&self, program: &Path) -> Result<Digest, BakeError> {
        let fail = |source| BakeError::Io { path: program.to_owned(), action: "read", source };
        let found = std::fs::metadata(program).map_err(fail)?;
        let installed = format!("{} {} {:?}", program.display(), found.len(), found.modified().ok());
        let path = self.place("tools", &Sha256::digest(installed).into());
        if let Some(known) = std::fs::read_to_string(&path).ok().and_then(|text| from_hex(&text)) {
            return Ok(known);
        }
        let digest = digest(program, u64::MAX).map_err(fail)?;
        // Whoever cannot keep it makes it again.
        let _ = write(&path, hex(&digest).as_bytes());
        Ok(digest)
    }

    /// What a command with that key has made, from the files as they are now.
    ///
    /// * `key`: stands for the tool and the command's arguments
    /// * `machine`: what the machine answers
    pub fn find(&self, key: &Digest, machine: &mut dyn FnMut(&str) -> Option<String>) -> Option<Found> {
        let (mut state, mut read) = (*key, Vec::new());
        for _ in 0..MOST_STATES {
            let bytes = std::fs::read(self.place("states", &state)).ok()?;
            match serde_json::from_slice(&bytes).ok()? {
                Node::File { path, most } => {
                    let path = PathBuf::from(path);
                    let digest = digest_of(&path, most)?;
                    state = after_file(&state, digest.as_ref());
                    if digest.is_some() && !read.contains(&path) {
                        read.push(path);
                    }
                }
                Node::Machine { what } => state = after(&state, machine(&what)?.as_bytes()),
                Node::Made(kept) => return Some(Found { kept, read }),
            }
        }
        None
    }

    /// The bytes of a file that was kept; `None` where they are not there, or not whole.
    pub fn bytes(&self, file: &KeptFile) -> Option<Vec<u8>> {
        let digest = from_hex(&file.sha256)?;
        let bytes = std::fs::read(self.place("files", &digest)).ok()?;
        (Digest::from(Sha256::digest(&bytes)) == digest).then_some(bytes)
    }

    /// Keeps what a command with that key has made of what it has read.
    ///
    /// * `files`: where those of `kept` are
    ///
    /// # Errors
    ///
    /// [`BakeError::Io`]. What is there of it by then does no harm.
    pub fn keep(&self, key: &Digest, traffic: &Traffic, kept: &Kept, files: &[&Path]) -> Result<(), BakeError> {
        for (file, path) in kept.files.iter().zip(files) {
            let Some(digest) = from_hex(&file.sha256) else { continue };
            let place = self.place("files", &digest);
            if !place.exists() {
                write(&place, &read_file(path)?)?;
            }
        }
        let mut state = *key;
        for asked in &traffic.asked {
            let (node, next) = match asked {
                Asked::File { path, most, digest } => {
                    // What has no name in Unicode cannot be written into a node; such a command runs each time.
                    let Some(path) = path.to_str() else { return Ok(()) };
                    (Node::File { path: path.to_owned(), most: *most }, after_file(&state, digest.as_ref()))
                }
                Asked::Machine { what, answer } => {
                    (Node::Machine { what: (*what).to_owned() }, after(&state, answer.as_bytes()))
                }
            };
            self.put(&state, &node)?;
            state = next;
        }
        self.put(&state, &Node::Made(kept.clone()))
    }

    fn put(&self, state: &Digest, node: &Node) -> Result<(), BakeError> {
        let bytes = serde_json::to_vec(node).map_err(|error| BakeError::Internal(error.to_string()))?;
        let place = self.place("states", state);
        // The same state has the same node but for figures such as seconds, which are the first one's.
        if place.exists() { Ok(()) } else { write(&place, &bytes) }
    }

    /// Where something is: folders of a few hundred files each.
    fn place(&self, what: &str, digest: &Digest) -> PathBuf {
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

/// The digest of the first bytes of a file, `Some(None)` where nothing is there. `None` for what cannot be read twice.
fn digest_of(path: &Path, most: u64) -> Option<Option<Digest>> {
    let Ok(found) = std::fs::metadata(path) else { return Some(None) };
    if !found.is_file() {
        return None;
    }
    digest(path, most).ok().map(Some)
}

/// The state after something was learnt.
fn after(state: &Digest, learnt: &[u8]) -> Digest {
    Sha256::new().chain_update(state).chain_update(learnt).finalize().into()
}

fn after_file(state: &Digest, digest: Option<&Digest>) -> Digest {
    after(state, digest.map_or(b"nothing there".as_slice(), |digest| digest))
}

fn from_hex(text: &str) -> Option<Digest> {
    hexadecimal::from_hex(text)?.try_into().ok()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;
    use crate::traffic::Written;

    fn kept(name: &str, bytes: &[u8]) -> Kept {
        let file = KeptFile { folder: 0, name: name.into(), shown: name.into(), sha256: hex(&Sha256::digest(bytes)) };
        Kept { files: vec![file], exit: 0, text: "made".into(), json: Value::Null, notes: Vec::new() }
    }

    fn asked(path: &Path, most: u64) -> Asked {
        Asked::File { path: path.to_owned(), most, digest: digest_of(path, most).unwrap() }
    }

    #[test]
    fn what_was_made_is_found_while_everything_is_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("model"), "a model and more").unwrap();
        std::fs::write(path("out"), "made of it").unwrap();
        let cache = Cache::new(&path("cache"));
        let key = [7; 32];
        let traffic = Traffic {
            asked: vec![
                asked(&path("model"), 7),
                asked(&path("absent"), 0),
                Asked::Machine { what: "adapter", answer: "a".into() },
            ],
            written: vec![Written { path: path("out"), digest: Sha256::digest("made of it").into() }],
            in_part: false,
        };
        let made = kept("out", b"made of it");
        let answer = |machine: &str| {
            let found = cache.find(&key, &mut |what| (what == "adapter").then(|| machine.to_owned()));
            found.map(|found| (cache.bytes(&found.kept.files[0]), found))
        };
        assert!(answer("a").is_none());
        cache.keep(&key, &traffic, &made, &[&path("out")]).unwrap();
        let (bytes, found) = answer("a").unwrap();
        assert_eq!((bytes.as_deref(), &found.kept, found.read), (Some(&b"made of it"[..]), &made, vec![path("model")]));
        // Another machine, other bytes of those that were read, a file that was not there.
        assert!(answer("b").is_none());
        std::fs::write(path("model"), "a model and other bytes behind").unwrap();
        assert!(answer("a").is_some(), "no more than seven bytes were read");
        std::fs::write(path("model"), "b model").unwrap();
        assert!(answer("a").is_none());
        std::fs::write(path("model"), "a model").unwrap();
        std::fs::write(path("absent"), "").unwrap();
        assert!(answer("a").is_none());
        std::fs::remove_file(path("absent")).unwrap();
        assert!(cache.find(&[8; 32], &mut |_| Some("a".into())).is_none());
        // A file that is damaged is not handed out.
        let place = cache.place("files", &Sha256::digest("made of it").into());
        std::fs::write(&place, "made of If").unwrap();
        assert_eq!(answer("a").unwrap().0, None);
        std::fs::write(cache.place("states", &key), "{").unwrap();
        assert!(answer("a").is_none());
    }

    #[test]
    fn a_tool_is_hashed_once() {
        let folder = tempfile::tempdir().unwrap();
        let (program, cache) = (folder.path().join("tool"), Cache::new(&folder.path().join("cache")));
        std::fs::write(&program, "a program").unwrap();
        let digest: Digest = Sha256::digest("a program").into();
        assert_eq!((cache.tool(&program).unwrap(), cache.tool(&program).unwrap()), (digest, digest));
        assert!(cache.tool(&folder.path().join("none")).is_err());
        assert_eq!((from_hex(&hex(&digest)), from_hex("zz"), from_hex("")), (Some(digest), None, None));
    }
}
