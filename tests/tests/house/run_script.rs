//! Checks the gate script: a skipped check prints a message for developers, and is a failure if `CI` is set.
#![cfg(unix)]

use pelage_tests::binary::workspace;
use std::process::Command;

/// Runs `tests/not_checked.sh advisories` with the given `CI` and `PELAGE_EXCEPTIONS`. Returns whether the gate
/// continues, and the stderr.
fn not_checked(ci: Option<&str>, exceptions: Option<&str>) -> (bool, String) {
    let mut command = Command::new("sh");
    command.args(["tests/not_checked.sh", "advisories", "no network"]).current_dir(workspace());
    for (name, value) in [("CI", ci), ("PELAGE_EXCEPTIONS", exceptions), ("PELAGE_NOT_CHECKED", None)] {
        match value {
            Some(value) => command.env(name, value),
            None => command.env_remove(name),
        };
    }
    let output = command.output().unwrap_or_else(|e| panic!("sh: {e}"));
    (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn skipped_checks_fail_in_ci_unless_excepted() {
    for (ci, exceptions, goes_on) in [
        (None, None, true),
        (Some("false"), None, true),
        (Some("true"), None, false),
        (Some("true"), Some("wasm shell"), false),
        // Checks that `advisories2` does not match `advisories`.
        (Some("true"), Some("advisories2"), false),
        (Some("true"), Some("wasm advisories"), true),
    ] {
        let (went_on, words) = not_checked(ci, exceptions);
        assert_eq!(went_on, goes_on, "CI {ci:?}, exceptions {exceptions:?}: {words}");
        assert!(words.contains("NOT CHECKED: advisories: no network"), "{words}");
        assert_eq!(words.contains("EXCEPTION: advisories"), exceptions == Some("wasm advisories"), "{words}");
    }
}

#[test]
fn run_script_skips_checks_only_through_not_checked() {
    let text = std::fs::read_to_string(workspace().join("run")).unwrap_or_else(|e| panic!("run: {e}"));
    assert!(text.contains("tests/not_checked.sh ") && !text.contains("NOT CHECKED"), "run must ask not_checked.sh");
}
