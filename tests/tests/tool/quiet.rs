//! Tests of commands with `--quiet`, in an environment where the graphics driver would print complaints.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_tests::binary::{Sandbox, run_to_end, workspace};
use pelage_tests::gpu::gpu;
use pelage_tests::schema;

/// Returns a folder with a small `a.pelage`.
fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    let torus = workspace().join("assets/models/torus.glb").display().to_string();
    let sets = ["slice.layers=4", "slice.tile_texels=16", "hair.density=60", "ink.enabled=false"];
    let run = sandbox
        .run(&[&["bake", &torus, "-o", "a.pelage", "-q"], &sets.map(|set| ["--set", set]).concat()[..]].concat());
    assert_eq!((run.code, run.stdout.as_str(), run.stderr.as_str()), (Some(0), "", ""));
    sandbox
}

#[test]
fn quiet_commands_print_nothing() {
    let sandbox = sandbox();
    for arguments in [
        &["inspect", "a.pelage", "-q"][..],
        &["unpack", "a.pelage", "folder", "--quiet"],
        &["reference", "a.pelage", "-o", "a.png", "--size", "8x8", "--samples", "1", "-q"],
    ] {
        let run = sandbox.run(arguments);
        assert_eq!((run.code, run.stdout.as_str(), run.stderr.as_str()), (Some(0), "", ""), "{arguments:?}");
    }
    let run = sandbox.run(&["inspect", "none.pelage", "-q"]);
    assert!(run.code == Some(2) && run.stdout.is_empty() && run.stderr.starts_with("error: "), "{run:?}");
    assert!(schema::parse_success(&sandbox.run(&["inspect", "a.pelage", "-q", "--json"]), "inspect")["bytes"].is_u64());
}

#[test]
fn samples_option_has_one_name_in_every_command() {
    let sandbox = sandbox();
    let traced = |name: &str, samples: &str| {
        let run = sandbox.run(&["reference", "a.pelage", "-o", name, "--size", "8x8", samples, "3", "-q"]);
        assert_eq!(run.code, Some(0), "{run:?}");
        sandbox.read(name)
    };
    assert!(traced("new.png", "--samples") == traced("old.png", "--spp"));
    for command in ["render", "bench", "view", "reference"] {
        let run = sandbox.run(&[command, "--help"]);
        assert!(run.stdout.contains("--samples <N>") && !run.stdout.contains("--spp"), "{command}: {}", run.stdout);
    }
    let run = sandbox.run(&["bench", "a.pelage", "--samples", "3"]);
    assert!(run.code == Some(1) && run.stderr.contains("--samples"), "{run:?}");
}

#[test]
fn missing_mesa_environment_variables_cause_no_warning() {
    if gpu("missing_mesa_environment_variables_cause_no_warning").is_none() {
        return;
    }
    let sandbox = sandbox();
    for value in [None, Some("not/absolute")] {
        let mut command = sandbox.command(&["render", "a.pelage", "-o", "a.png", "--size", "8x8", "-q"]);
        match value {
            Some(value) => command.env("XDG_RUNTIME_DIR", value),
            None => command.env_remove("XDG_RUNTIME_DIR"),
        };
        let run = run_to_end(command);
        assert_eq!((run.code, run.stdout.as_str(), run.stderr.as_str()), (Some(0), "", ""), "{value:?}");
    }
}
