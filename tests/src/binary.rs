//! Runs the real binaries `pelage` and `pelage-lab` in fresh folders.

use std::ffi::OsStr;
use std::hash::{Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

/// Returns the path of the `pelage` binary in this build's profile. It is built with cargo once per test process,
/// because cargo itself builds binaries only for tests of the same package.
///
/// # Panics
///
/// If cargo cannot build the binary, without which the tests are meaningless.
pub fn pelage() -> PathBuf {
    folder().join(format!("pelage{}", std::env::consts::EXE_SUFFIX))
}

/// Returns the path of the `pelage-lab` binary: `pelage` with the subcommand `chart`.
///
/// # Panics
///
/// Same as [`pelage`].
pub fn lab() -> PathBuf {
    folder().join(format!("pelage-lab{}", std::env::consts::EXE_SUFFIX))
}

/// Returns the folder of both binaries, and builds them on the first call.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let test = std::env::current_exe().unwrap_or_else(|e| panic!("the path of the test is unknown: {e}"));
        // The running program is `<target>/<profile>/deps/<test>` or `<target>/<profile>/<chore>`.
        let folder = test.ancestors().skip(1).find(|f| f.file_name() != Some(OsStr::new("deps")));
        let folder = folder.unwrap_or_else(|| panic!("{} has no profile folder", test.display()));
        let profile = match folder.file_name().and_then(OsStr::to_str) {
            Some("debug") | None => "dev",
            Some(name) => name,
        };
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let output = Command::new(cargo)
            // The whole workspace and one small test are selected, so that the features match those of `cargo test
            // --workspace`. Only pelage itself is then left to compile.
            .args([
                "build",
                "--workspace",
                "--bin",
                "pelage",
                "--bin",
                "pelage-lab",
                "--test",
                "formats",
                "--profile",
                profile,
            ])
            // `tests/timed.sh` sets this variable for the test harness; with it, build scripts would run again.
            .env_remove("RUSTC_BOOTSTRAP")
            .current_dir(workspace())
            .output()
            .unwrap_or_else(|e| panic!("cargo cannot be run: {e}"));
        assert!(output.status.success(), "building pelage: {}", String::from_utf8_lossy(&output.stderr));
        folder.to_owned()
    })
}

/// Returns the folder of shared test packages beside the binary. It is emptied if the binary is newer.
fn fixtures() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = pelage().with_file_name("fixtures");
        let changed = |path: &Path| path.metadata().and_then(|found| found.modified());
        if changed(&folder).is_ok_and(|folder| changed(&pelage()).is_ok_and(|binary| binary > folder)) {
            std::fs::remove_dir_all(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
        }
        std::fs::create_dir_all(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
        folder
    })
}

/// Returns the folder of the workspace's `Cargo.toml`.
pub fn workspace() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."))
}

/// Appends all files below a folder to `out`, ordered by name.
///
/// # Panics
///
/// If a folder cannot be read.
pub fn walk(folder: &Path, out: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut entries: Vec<_> =
        entries.map(|e| e.unwrap_or_else(|e| panic!("{}: {e}", folder.display())).path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            walk(&path, out);
        } else {
            out.push(path);
        }
    }
}

/// Output of a finished process.
#[derive(Debug)]
pub struct Run {
    /// Exit code; `None` if the process was ended by a signal.
    pub code: Option<i32>,
    /// Complete stdout.
    pub stdout: String,
    /// Complete stderr.
    pub stderr: String,
}

/// Temporary folder in which `pelage` runs; removed when dropped.
#[derive(Debug)]
pub struct Sandbox {
    folder: tempfile::TempDir,
    program: fn() -> PathBuf,
}

impl Default for Sandbox {
    fn default() -> Self {
        Self::new()
    }
}

impl Sandbox {
    /// Creates the folder.
    ///
    /// # Panics
    ///
    /// If the folder cannot be created.
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap_or_else(|e| panic!("no temporary folder: {e}"));
        Self { folder, program: pelage }
    }

    /// Returns the sandbox, changed to run `pelage-lab`.
    #[must_use]
    pub fn with_lab(self) -> Self {
        Self { program: lab, ..self }
    }

    /// Returns the path of the folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Writes a file, and creates its parent folders.
    ///
    /// # Panics
    ///
    /// If the file cannot be written.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path().join(name);
        let written = path.parent().map_or(Ok(()), std::fs::create_dir_all).and_then(|()| std::fs::write(&path, bytes));
        written.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        path
    }

    /// Reads a file.
    ///
    /// # Panics
    ///
    /// If it cannot be read.
    #[track_caller]
    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Returns the entries of the folder; see [`files`].
    pub fn files(&self) -> Vec<String> {
        files(self.path())
    }

    /// Returns a command that runs `pelage` in this folder, with empty stdin.
    pub fn command(&self, args: &[impl AsRef<OsStr>]) -> Command {
        let mut command = Command::new((self.program)());
        command.args(args).current_dir(self.path()).stdin(Stdio::null());
        // Mesa's device selection looks for a display in the folder that this variable names. If the variable is unset,
        // as in a container, it prints "error:" lines to stderr.
        command.env("XDG_RUNTIME_DIR", self.path());
        command
    }

    /// Bakes a package into this folder, for tests whose subject is not the bake. `args` are those of `pelage bake`.
    ///
    /// The command's cache reuses a bake with the same tool, files, settings and package name. Concurrent requests for
    /// the same package wait for the first.
    ///
    /// # Panics
    ///
    /// If the bake fails.
    pub fn fixture(&self, args: &[impl AsRef<OsStr>]) {
        let args: Vec<&OsStr> = args.iter().map(AsRef::as_ref).collect();
        let mut hasher = std::hash::DefaultHasher::new();
        args.hash(&mut hasher);
        let lock = fixtures().join(format!("{:016x}.lock", hasher.finish()));
        let locked = std::fs::File::create(&lock).and_then(|file| file.lock().map(|()| file));
        let _locked = locked.unwrap_or_else(|e| panic!("{}: {e}", lock.display()));
        let run = self.run(&[&["bake".as_ref(), "--cache".as_ref(), fixtures().as_os_str()], &args[..]].concat());
        assert_eq!(run.code, Some(0), "{args:?}: {run:?}");
    }

    /// Runs `pelage` in this folder. `pelage` must not panic, whatever its input.
    ///
    /// # Panics
    ///
    /// If the binary cannot be started, or its stderr mentions a panic or an internal error.
    pub fn run(&self, args: &[impl AsRef<OsStr>]) -> Run {
        run_to_end(self.command(args))
    }
}

/// Runs a command to completion.
///
/// # Panics
///
/// Same as [`Sandbox::run`].
pub fn run_to_end(mut command: Command) -> Run {
    let output = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    let run = Run {
        code: output.status.code(),
        stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
        stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
    };
    assert!(!run.stderr.contains("panicked") && !run.stderr.contains("internal error"), "{command:?}: {run:?}");
    run
}

/// Returns the relative paths of everything in a folder, sorted. Folders end in `/`; links to folders count as files.
pub fn files(folder: &Path) -> Vec<String> {
    fn list(folder: &Path, prefix: &str, out: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let mut name = format!("{prefix}{}", entry.file_name().to_string_lossy());
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                name.push('/');
                list(&entry.path(), &name, out);
            }
            out.push(name);
        }
    }
    let mut out = Vec::new();
    list(folder, "", &mut out);
    out.sort();
    out
}
