//! Optional resources that tests require: an adapter, test data, a C compiler, a desktop, a browser, Ninja.
//!
//! A test requests its resource here and passes its own name. If the resource is missing, the test gets `None`, a
//! message is printed to stderr, and the test returns. Under `CI` a missing resource is a failure. Each answer is
//! written to the log named by `PELAGE_TEST_LOG`. `./run test` checks that log against [`register::REGISTER`] and fails
//! if a registered test is missing or an unregistered one appears.

pub mod register;

use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Optional resource that a test requires.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Need {
    /// An adapter that wgpu can open.
    Gpu,
    /// Shared test data: `PELAGE_DATA`, or `../shared/data` beside the repository.
    Data,
    /// C compiler: `CC`, or `cc`.
    Compiler,
    /// Virtual display and simulated input: `Xvfb` and `xdotool`.
    Desktop,
    /// Chromium and the web page built for it. The tests are in `runtime/web/tests` and write to the same log.
    Browser,
    /// Ninja, which runs herds.
    Ninja,
}

impl Need {
    /// All resources.
    pub const ALL: [Self; 6] = [Self::Gpu, Self::Data, Self::Compiler, Self::Desktop, Self::Browser, Self::Ninja];

    /// Returns the name used in the log and the register.
    pub fn name(self) -> &'static str {
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

/// Logs that the resource of a test is available.
///
/// # Panics
///
/// If the log cannot be written.
pub fn log_available(need: Need, test: &str, what: &str) {
    note("had", need, test, what);
}

/// Logs that the resource of a test is missing, and prints it to stderr.
///
/// # Panics
///
/// If the log cannot be written, or if `CI` is set, where no test may be skipped.
pub fn log_missing(need: Need, test: &str, why: &str) {
    note("lacked", need, test, why);
    // Writes to the handle, because the test harness would capture the output of `eprintln!`.
    let said = writeln!(std::io::stderr(), "SKIPPED: {test} ({why})");
    assert!(said.is_ok(), "stderr cannot be written");
    assert!(!is_ci(), "{test}: {why}; CI is set, so no test may be skipped");
}

fn note(how: &str, need: Need, test: &str, words: &str) {
    let Some(path) = std::env::var_os("PELAGE_TEST_LOG") else { return };
    // In append mode, a single write cannot be interleaved with lines of concurrent tests.
    let line = format!("{how}\t{}\t{test}\t{}\n", need.name(), words.replace(['\n', '\t'], " "));
    let written =
        OpenOptions::new().append(true).create(true).open(&path).and_then(|mut f| f.write_all(line.as_bytes()));
    written.unwrap_or_else(|e| panic!("{}: {e}", Path::new(&path).display()));
}

/// Returns whether this is a continuous integration run: `CI` is set and is not empty, `0` or `false`.
pub fn is_ci() -> bool {
    std::env::var("CI").is_ok_and(|v| !["", "0", "false"].contains(&v.as_str()))
}

/// Returns the expected path of the shared test data; it may not exist.
pub fn data_folder() -> PathBuf {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    std::env::var_os("PELAGE_DATA").map_or(beside, PathBuf::from)
}

/// Returns the path of the shared test data for the named test, or `None` with a message on stderr.
///
/// # Panics
///
/// Same as [`log_available`] and [`log_missing`].
pub fn data(test: &str) -> Option<PathBuf> {
    let path = data_folder();
    let words = path.display().to_string();
    if path.join("meshes").is_dir() && path.join("ktx2").is_dir() {
        log_available(Need::Data, test, &words);
        return Some(path);
    }
    log_missing(Need::Data, test, &format!("no test data at {words}"));
    None
}

/// Returns whether a program is on `PATH`.
pub fn is_installed(program: &str) -> bool {
    std::env::var_os("PATH").is_some_and(|path| std::env::split_paths(&path).any(|p| p.join(program).is_file()))
}

/// Returns whether Ninja is installed, and logs the answer for the named test.
///
/// # Panics
///
/// Same as [`log_available`] and [`log_missing`].
pub fn has_ninja(test: &str) -> bool {
    let there = is_installed("ninja");
    if there {
        log_available(Need::Ninja, test, "ninja");
    } else {
        log_missing(Need::Ninja, test, "ninja is not installed (Debian: apt-get install ninja-build)");
    }
    there
}

/// Returns whether the named GPU test should run: always, unless `PELAGE_NO_GPU=1` is set. The caller that opens the
/// device calls [`log_available`].
///
/// # Panics
///
/// Same as [`log_missing`].
pub fn gpu_is_wanted(test: &str) -> bool {
    let off = std::env::var("PELAGE_NO_GPU").is_ok_and(|v| v == "1");
    if off {
        log_missing(Need::Gpu, test, "PELAGE_NO_GPU=1");
    }
    !off
}
