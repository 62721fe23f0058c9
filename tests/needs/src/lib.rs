//! What tests need that a machine may lack: an adapter, test data, a C compiler, a browser, Ninja.
//!
//! A test asks here, by its name. It gets what it needs, or `None` with a loud word, and returns; under `CI` what is missing
//! is a failure. Whatever the answer, it goes into the log that `PELAGE_TEST_LOG` names, and `./run test` holds the log
//! against [`register::REGISTER`]: a test that vanishes, or that nobody listed, fails the gate.

pub mod register;

use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// What a test needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Need {
    /// An adapter that wgpu can open.
    Gpu,
    /// The shared test data: `PELAGE_DATA`, or `../shared/data` beside the repository.
    Data,
    /// A C compiler: `CC`, or `cc`.
    Compiler,
    /// A screen without glass, and hands for it: `Xvfb` and `xdotool`.
    Desktop,
    /// Chromium, and the page that is built for it: tests in `runtime/web/tests`, which write the same log.
    Browser,
    /// Ninja, which runs herds.
    Ninja,
}

impl Need {
    /// All needs.
    pub const ALL: [Self; 6] = [Self::Gpu, Self::Data, Self::Compiler, Self::Desktop, Self::Browser, Self::Ninja];

    /// Its word in log and register.
    pub fn word(self) -> &'static str {
        match self {
            Self::Gpu => "gpu",
            Self::Data => "data",
            Self::Compiler => "compiler",
            Self::Desktop => "desktop",
            Self::Browser => "browser",
            Self::Ninja => "ninja",
        }
    }
}

/// Notes that a test had what it needs.
///
/// # Panics
///
/// Where the log cannot be written.
pub fn had(need: Need, test: &str, what: &str) {
    note("had", need, test, what);
}

/// Notes that a test goes without what it needs, on stderr as well.
///
/// # Panics
///
/// Where the log cannot be written, and wherever `CI` is set: nothing may be left out there.
pub fn lacked(need: Need, test: &str, why: &str) {
    note("lacked", need, test, why);
    // Written to the handle: the harness captures only the print macros.
    let said = writeln!(std::io::stderr(), "SKIPPED: {test} ({why})");
    assert!(said.is_ok(), "stderr cannot be written");
    assert!(!is_ci(), "{test}: {why}; CI is set, and nothing is skipped there");
}

fn note(how: &str, need: Need, test: &str, words: &str) {
    let Some(path) = std::env::var_os("PELAGE_TEST_LOG") else { return };
    // One write in append mode, so that lines of tests that run side by side stay whole.
    let line = format!("{how}\t{}\t{test}\t{}\n", need.word(), words.replace(['\n', '\t'], " "));
    let written =
        OpenOptions::new().append(true).create(true).open(&path).and_then(|mut f| f.write_all(line.as_bytes()));
    written.unwrap_or_else(|e| panic!("{}: {e}", Path::new(&path).display()));
}

/// Whether this is a run for continuous integration: `CI` is set, and neither empty, `0` nor `false`.
pub fn is_ci() -> bool {
    std::env::var("CI").is_ok_and(|v| !["", "0", "false"].contains(&v.as_str()))
}

/// Where the shared test data should lie; nothing may be there.
pub fn data_folder() -> PathBuf {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    std::env::var_os("PELAGE_DATA").map_or(beside, PathBuf::from)
}

/// The shared test data for the test of that name, or `None` with a loud word.
///
/// # Panics
///
/// As [`had`] and [`lacked`].
pub fn data(test: &str) -> Option<PathBuf> {
    let path = data_folder();
    let words = path.display().to_string();
    if path.join("meshes").is_dir() && path.join("ktx2").is_dir() {
        had(Need::Data, test, &words);
        return Some(path);
    }
    lacked(Need::Data, test, &format!("no test data at {words}"));
    None
}

/// Whether a program is where the shell would find it.
pub fn is_installed(program: &str) -> bool {
    std::env::var_os("PATH").is_some_and(|path| std::env::split_paths(&path).any(|p| p.join(program).is_file()))
}

/// Whether the test of that name has Ninja; where not, it has said so.
///
/// # Panics
///
/// As [`had`] and [`lacked`].
pub fn ninja(test: &str) -> bool {
    let there = is_installed("ninja");
    if there {
        had(Need::Ninja, test, "ninja");
    } else {
        lacked(Need::Ninja, test, "ninja is not installed (Debian: apt-get install ninja-build)");
    }
    there
}

/// Whether the GPU test of that name is wanted: unless `PELAGE_NO_GPU=1` says by name that GPU tests are left out. Who opens the
/// device says [`had`].
///
/// # Panics
///
/// As [`lacked`].
pub fn gpu_is_wanted(test: &str) -> bool {
    let off = std::env::var("PELAGE_NO_GPU").is_ok_and(|v| v == "1");
    if off {
        lacked(Need::Gpu, test, "PELAGE_NO_GPU=1");
    }
    !off
}
