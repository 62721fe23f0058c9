//! Tests of `pelage view` with the real binary, on a virtual display (Xvfb) with simulated input (xdotool).

use crate::binary::pelage;
use pelage_needs::Need;
use serde_json::Value;
use std::ffi::OsStr;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Timeout for any single step. A bake is slow while compilers use the cores.
const PATIENCE: Duration = Duration::from_secs(90);

/// Virtual display; closed when dropped.
#[derive(Debug)]
pub struct Desktop {
    server: Child,
    display: String,
}

impl Drop for Desktop {
    fn drop(&mut self) {
        // The server may already have exited, so errors are ignored.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

impl Desktop {
    /// Opens a display for the named test. If the tools are missing, returns `None` and prints a message to stderr.
    ///
    /// # Panics
    ///
    /// If the server starts but does not report its display; under `CI`, if the tools are missing.
    pub fn open(test: &str) -> Option<Self> {
        for tool in ["Xvfb", "xdotool"] {
            if !pelage_needs::is_installed(tool) {
                pelage_needs::log_missing(
                    Need::Desktop,
                    test,
                    &format!("{tool} is not installed (Debian: apt-get install xvfb xdotool)"),
                );
                return None;
            }
        }
        let desktop = Self::start();
        pelage_needs::log_available(Need::Desktop, test, &format!("Xvfb {}", desktop.display));
        Some(desktop)
    }

    /// Starts a display of 1600 × 1000 pixels.
    ///
    /// # Panics
    ///
    /// Same as [`Self::open`].
    pub fn start() -> Self {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1600x1000x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap_or_else(|e| panic!("Xvfb: {e}"));
        let mut line = String::new();
        let said = server.stdout.take().map(|out| BufReader::new(out).read_line(&mut line));
        assert!(said.is_some_and(|read| read.is_ok()) && !line.trim().is_empty(), "Xvfb does not report its display");
        Self { server, display: format!(":{}", line.trim()) }
    }

    /// Opens `pelage view` with the given arguments. The window saves its files in `folder`.
    ///
    /// # Panics
    ///
    /// If the binary cannot be started.
    pub fn view(&self, folder: &Path, args: &[impl AsRef<OsStr>]) -> ViewerWindow<'_> {
        let events = folder.join("events.jsonl");
        // The event file of an earlier window is removed.
        let _ = std::fs::remove_file(&events);
        let mut command = Command::new(pelage());
        command.arg("view").args(args).arg("--events").arg(&events).current_dir(folder);
        command.env("DISPLAY", &self.display).env_remove("WAYLAND_DISPLAY").env("XDG_RUNTIME_DIR", folder);
        let errors =
            std::fs::File::create(folder.join("errors.txt")).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
        let child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(errors).spawn();
        let child = child.unwrap_or_else(|e| panic!("{command:?}: {e}"));
        ViewerWindow { desktop: self, child, events, read: 0, errors: folder.join("errors.txt") }
    }
}

/// Open window of `pelage view`; closed when dropped.
#[derive(Debug)]
pub struct ViewerWindow<'a> {
    desktop: &'a Desktop,
    child: Child,
    events: PathBuf,
    /// Number of lines read from the event file.
    read: usize,
    errors: PathBuf,
}

impl Drop for ViewerWindow<'_> {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl ViewerWindow<'_> {
    /// Waits for the next event with the given name, and skips all events before it.
    ///
    /// # Panics
    ///
    /// If the event does not arrive, or the window has closed.
    pub fn wait_for(&mut self, name: &str) -> Value {
        self.wait_for_any(&[name])
    }

    /// Waits for the next event with one of the given names; see [`Self::wait_for`].
    ///
    /// # Panics
    ///
    /// Same as [`Self::wait_for`].
    pub fn wait_for_any(&mut self, names: &[&str]) -> Value {
        let began = Instant::now();
        while began.elapsed() < PATIENCE {
            let text = std::fs::read_to_string(&self.events).unwrap_or_default();
            let whole = text.rfind('\n').map_or("", |end| &text[..end]);
            for line in whole.lines().skip(self.read) {
                self.read += 1;
                let event: Value = serde_json::from_str(line).unwrap_or_else(|e| panic!("{line}: {e}"));
                if names.iter().any(|name| event["event"] == *name) {
                    return event;
                }
            }
            self.assert_alive();
            std::thread::sleep(Duration::from_millis(15));
        }
        panic!(
            "none of the events {names:?} arrived; events so far: {}",
            std::fs::read_to_string(&self.events).unwrap_or_default()
        );
    }

    /// Asserts that the window is open and that its stderr mentions no panic.
    ///
    /// # Panics
    ///
    /// If this is not the case; the message contains the stderr.
    pub fn assert_alive(&mut self) {
        let ended = self.child.try_wait().unwrap_or_else(|e| panic!("{e}"));
        let said = || std::fs::read_to_string(&self.errors).unwrap_or_default();
        assert!(ended.is_none(), "the window has closed ({ended:?}): {}", said());
        assert!(!said().contains("panicked") && !said().contains("internal error"), "{}", said());
    }

    /// Skips all events that have been written so far.
    pub fn skip_events(&mut self) {
        self.read = std::fs::read_to_string(&self.events).unwrap_or_default().lines().count();
    }

    /// Runs xdotool with the given arguments and returns its stdout.
    ///
    /// # Panics
    ///
    /// If xdotool fails.
    pub fn xdotool(&self, words: &[&str]) -> String {
        let mut command = Command::new("xdotool");
        command.args(words).env("DISPLAY", &self.desktop.display);
        let output = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
        assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).trim().to_owned()
    }

    /// Gives the window the keyboard focus, because the display has no window manager that would do so. Returns the
    /// window's id.
    ///
    /// # Panics
    ///
    /// If the window is not found.
    pub fn focus(&self) -> String {
        let found = self.xdotool(&["search", "--sync", "--onlyvisible", "--name", "pelage$"]);
        let window = found.lines().next().unwrap_or_else(|| panic!("no window")).to_owned();
        self.xdotool(&["windowfocus", "--sync", &window]);
        window
    }

    /// Presses a key.
    ///
    /// # Panics
    ///
    /// If xdotool fails.
    pub fn key(&self, key: &str) {
        self.xdotool(&["key", key]);
    }

    /// Drags with the mouse button `button` between two screen positions, in steps.
    ///
    /// # Panics
    ///
    /// If xdotool fails.
    pub fn drag(&self, button: &str, from: (i32, i32), to: (i32, i32)) {
        let words = |at: (i32, i32)| (at.0.to_string(), at.1.to_string());
        let (x, y) = words(from);
        self.xdotool(&["mousemove", &x, &y, "mousedown", button]);
        for step in 1..=4 {
            let (x, y) = words((from.0 + (to.0 - from.0) * step / 4, from.1 + (to.1 - from.1) * step / 4));
            self.xdotool(&["mousemove", &x, &y]);
            std::thread::sleep(Duration::from_millis(40));
        }
        self.xdotool(&["mouseup", button]);
    }

    /// Presses a key that saves a file, and returns the path of the file.
    ///
    /// # Panics
    ///
    /// If the file is not saved.
    pub fn save(&mut self, key: &str) -> PathBuf {
        self.skip_events();
        self.key(key);
        let saved = self.wait_for_any(&["saved", "not saved"]);
        assert_eq!(saved["event"], "saved", "{saved}");
        let folder = self.events.parent().unwrap_or(Path::new("."));
        folder.join(saved["file"].as_str().unwrap_or_default())
    }
}
