//! Tests with the real binary: no command overwrites a file that it reads, or leaves half of its outputs.
#![allow(clippy::unwrap_used, reason = "in tests a panic is the report")]

use super::jobs::{SMALL, sandbox as model_sandbox};
use pelage_tests::binary::{Run, Sandbox, workspace};
use std::collections::BTreeMap;
use std::time::{Duration, SystemTime};

/// Returns the model of the tests for build systems, with a hair group whose guides are in a file.
fn sandbox() -> Sandbox {
    let sandbox = model_sandbox();
    sandbox.write("recipes/guides.txt", "0.2 0 -0.2 0.01\n0.2 0.3 -0.2 0.01\n");
    let recipe = String::from_utf8(sandbox.read("recipes/r.toml")).unwrap();
    sandbox.write("recipes/r.toml", recipe + "[[strands.group]]\nname = \"mane\"\nfile = \"guides.txt\"\n");
    sandbox
}

/// Returns every file with its contents.
fn contents(sandbox: &Sandbox) -> BTreeMap<String, Vec<u8>> {
    let files = sandbox.files().into_iter().filter(|name| !name.ends_with('/'));
    files.map(|name| (name.clone(), std::fs::read(sandbox.path().join(&name)).unwrap_or_default())).collect()
}

/// Runs a command that must be refused as a wrong command line, with both files named and nothing written.
#[track_caller]
fn refused(sandbox: &Sandbox, args: &[&str], words: &[&str]) {
    let before = contents(sandbox);
    let run = sandbox.run(args);
    assert_eq!(run.code, Some(1), "{args:?}: {run:?}");
    assert!(words.iter().all(|word| run.stderr.contains(word)), "{args:?}: {words:?}: {run:?}");
    assert!(contents(sandbox) == before, "{args:?} changed a file");
}

fn bake_args<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["bake", "models/m.gltf", "--recipe", "recipes/r.toml"], &SMALL[..], more].concat()
}

/// Creates links of both kinds to a file, and returns all three names.
fn names(sandbox: &Sandbox, file: &str) -> Vec<String> {
    let at = |name: &str| sandbox.path().join(name);
    let mut names = vec![file.to_owned()];
    std::fs::hard_link(at(file), at(&format!("{file}.hard"))).unwrap();
    names.push(format!("{file}.hard"));
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(at(file), at(&format!("{file}.link"))).unwrap();
        names.push(format!("{file}.link"));
    }
    names
}

#[test]
fn outputs_never_replace_inputs_of_the_command_line() {
    let sandbox = sandbox();
    for (input, role) in [("models/m.gltf", "given as MODEL"), ("recipes/r.toml", "given as --recipe")] {
        for name in names(&sandbox, input) {
            let written = |option: &str| format!("{option} {name}: is the same file as {input}, {role}");
            refused(&sandbox, &bake_args(&["-o", &name]), &[&written("--output")]);
            for option in ["--depfile", "--record", "--write-recipe"] {
                refused(&sandbox, &bake_args(&["-o", "out/p.pelage", option, &name]), &[&written(option)]);
            }
        }
    }
    // A rejected command line writes its record, but not over a file of any other kind.
    refused(&sandbox, &bake_args(&["-o", "p.pelage", "--odd", "--record", "models/m.gltf"]), &["'--odd'"]);
    // Neither may two outputs be one file.
    let twice = "--depfile out/../out/p.pelage: is the same file as out/p.pelage, given as --output";
    refused(&sandbox, &bake_args(&["-o", "out/p.pelage", "--depfile", "out/../out/p.pelage"]), &[twice]);
    let run = sandbox.run(&bake_args(&["-o", "models/m.gltf", "--record", "out/r.json"]));
    assert_eq!(run.code, Some(1), "{run:?}");
    let record: serde_json::Value = serde_json::from_slice(&sandbox.read("out/r.json")).unwrap();
    assert!(record["error"].as_str().unwrap().contains("models/m.gltf"), "{record}");
}

#[test]
fn outputs_never_replace_files_that_other_inputs_name() {
    let sandbox = sandbox();
    for (input, by) in [
        ("models/a mesh.bin", "named by models/m.gltf"),
        ("models/skin #1.png", "named by models/m.gltf"),
        ("recipes/length.png", "named by recipes/r.toml, groom.length"),
        ("recipes/guides.txt", "named by recipes/r.toml, strands.group, table 0, file"),
    ] {
        for name in names(&sandbox, input) {
            let written = |option: &str| format!("{option} {name}: is the same file as {input}, {by}");
            refused(&sandbox, &bake_args(&["-o", &name]), &[&written("--output")]);
            for option in ["--depfile", "--record"] {
                refused(&sandbox, &bake_args(&["-o", "out/p.pelage", option, &name]), &[&written(option)]);
            }
        }
    }
}

#[test]
fn every_command_spares_its_inputs() {
    let sandbox = sandbox();
    let torus = workspace().join("assets/models/torus.glb");
    let plain = [torus.to_str().unwrap(), "--set", "hair.density=20", "-o"];
    sandbox.fixture(&[&plain[..], &["p.pelage"], &SMALL[..]].concat());
    sandbox.fixture(&[&plain[..], &["p.obj"], &SMALL[..]].concat());
    sandbox.write("a.png", sandbox.read("recipes/length.png"));
    sandbox.write("s.toml", "[[model]]\npackage = \"p.png\"\n");
    sandbox.write("p.png", sandbox.read("p.pelage"));
    sandbox.write("sky.toml", "[[lobe]]\ntowards = [0, 1, 0]\nsharpness = 1\ncolor = [1, 1, 1]\n");
    assert_eq!(sandbox.run(&["unpack", "p.pelage", "u"]).code, Some(0));
    // This folder looks like an unpacked package, and so may be replaced, but a file in it is the input.
    assert_eq!(sandbox.run(&["unpack", "p.pelage", "v"]).code, Some(0));
    sandbox.write("v/mesh.glb", sandbox.read("p.pelage"));
    for args in [
        &["pack", "u", "u/mesh.glb"][..],
        &["unpack", "v/mesh.glb", "v"],
        &["unpack", "v/mesh.glb", "v", "--force"],
        &["inspect", "p.pelage", "--record", "p.pelage"],
        &["inspect", "p.pelage", "--depfile", "p.pelage"],
        &["validate", "p.pelage", "--record", "p.pelage"],
        &["compare", "a.png", "a.png", "-o", "a.png"],
        &["export", "p.obj", "--mesh", "p.obj"],
        &["export", "p.pelage", "--mesh", "q.obj", "--strands", "./p.pelage.txt", "--record", "q.obj"],
        &["reference", "p.png", "-o", "p.png"],
        &["merge", "a.png", "-o", "a.png"],
        &["sky", "sky.toml", "-o", "sky.toml"],
        &["groom", "models/m.gltf", "--map", "length", "-o", "models/skin #1.png"],
        &["groom", "models/m.gltf", "--map", "length", "-o", "out/x.png", "--mesh", "out/x.png"],
        &["render", "p.png", "-o", "p.png"],
        &["render", "s.toml", "-o", "p.png"],
    ] {
        refused(&sandbox, args, &["is the same file as"]);
    }
}

#[test]
fn cached_results_spare_inputs_too() {
    let sandbox = sandbox();
    let run = |out: &str| sandbox.run(&bake_args(&["-o", out, "--cache", "cache"]));
    sandbox.write("out/a mesh.bin", "");
    assert_eq!(run("out/a mesh.bin").code, Some(0));
    // The cache knows this result by its file name, but in this folder the name is that of the model's buffer.
    refused(&sandbox, &bake_args(&["-o", "models/a mesh.bin", "--cache", "cache"]), &["named by", "an input"][1..]);
}

#[test]
fn a_depfile_that_cannot_be_written_stops_the_command() {
    let sandbox = sandbox();
    for (option, file) in [("--depfile", "none/p.d"), ("--record", "none/p.json"), ("--depfile", "out")] {
        let before = contents(&sandbox);
        let Run { code, stderr, .. } = sandbox.run(&bake_args(&["-o", "p.pelage", option, file]));
        assert!(code == Some(2) && stderr.contains(file.split('/').next().unwrap()), "{option} {file}: {stderr}");
        assert!(contents(&sandbox) == before, "{option} {file}");
    }
}

#[test]
fn a_dash_is_not_taken_for_a_file() {
    let sandbox = sandbox();
    refused(&sandbox, &bake_args(&["-o", "-"]), &["--output", "standard output", "expected a file name"]);
    refused(&sandbox, &bake_args(&["-o", "p.pelage", "--record", "-"]), &["--record"]);
    refused(&sandbox, &["pack", "recipes", "-"], &["PKG", "standard output"]);
}

#[test]
fn leftovers_of_killed_commands_are_removed() {
    let sandbox = sandbox();
    let long_ago = SystemTime::now() - Duration::from_secs(3600);
    let age = |name: &str| std::fs::File::open(sandbox.path().join(name)).unwrap().set_modified(long_ago).unwrap();
    sandbox.write("out/.pelage-old.tmp/new/mesh.glb", "half");
    sandbox.write("out/.pelage-old2.tmp", "half");
    sandbox.write("out/.pelage-fresh.tmp/new/mesh.glb", "half");
    sandbox.write("out/mine.tmp", "mine");
    for name in ["out/.pelage-old.tmp", "out/.pelage-old2.tmp", "out/mine.tmp"] {
        age(name);
    }
    assert_eq!(sandbox.run(&bake_args(&["-o", "out/p.pelage"])).code, Some(0));
    let found: Vec<String> = sandbox.files().into_iter().filter(|name| name.contains(".tmp")).collect();
    let fresh = ["out/.pelage-fresh.tmp/", "out/.pelage-fresh.tmp/new/", "out/.pelage-fresh.tmp/new/mesh.glb"];
    assert_eq!(found, [&fresh[..], &["out/mine.tmp"]].concat());
}

#[cfg(unix)]
#[test]
fn depfiles_name_any_file_or_none() {
    use std::ffi::{OsStr, OsString};
    use std::os::unix::ffi::OsStrExt as _;
    let sandbox = sandbox();
    let bake = |model: &OsStr| {
        std::fs::copy(sandbox.path().join("models/m.gltf"), sandbox.path().join("models").join(model)).unwrap();
        let mut args: Vec<OsString> =
            bake_args(&["-o", "p.pelage", "--depfile", "p.d"]).iter().map(Into::into).collect();
        args[1] = OsString::from("models/");
        args[1].push(model);
        sandbox.run(&args)
    };
    let run = bake(OsStr::from_bytes(b"\xff:50%.gltf"));
    assert_eq!(run.code, Some(0), "{run:?}");
    let text = sandbox.read("p.d");
    let word = b" models/\xff\\:50%.gltf \\\n";
    assert!(text.windows(word.len()).any(|found| found == word), "{}", String::from_utf8_lossy(&text));
    // Neither Make nor Ninja reads a line feed in a name, so neither depfile nor package may exist.
    let run = bake(OsStr::new("a\nb.gltf"));
    assert!(run.code == Some(2) && run.stderr.contains(r#"p.d: cannot write: "#), "{run:?}");
    assert!(run.stderr.contains(r#""models/a\nb.gltf""#), "{run:?}");
    assert!(!sandbox.path().join("p.pelage").exists());
}

#[test]
fn scenes_have_a_limit_of_models() {
    let sandbox = Sandbox::new();
    sandbox.write("s.toml", "[[model]]\npackage = \"p.pelage\"\n".repeat(10_001));
    let run = sandbox.run(&["render", "s.toml", "-o", "x.png"]);
    assert_eq!(run.code, Some(3), "{run:?}");
    assert!(run.stderr.contains("found 10001 models, expected at most 10000"), "{run:?}");
}

#[test]
fn cameras_too_far_away_are_refused_in_plain_words() {
    let sandbox = Sandbox::new();
    for camera in ["1e38,0,0/0,0,0/40", "0,0,1/0,-3e38,0/40"] {
        let run = sandbox.run(&["render", "p.pelage", "-o", "x.png", &format!("--camera={camera}")]);
        assert_eq!(run.code, Some(1), "{run:?}");
        let expected = "expected numbers from -1e15 to 1e15";
        assert!(run.stderr.contains(expected) && !run.stderr.contains("Mat4"), "{run:?}");
    }
}

/// Returns a herd of one model beside files that cannot be followed or named.
#[cfg(unix)]
fn herd() -> Sandbox {
    use std::os::unix::ffi::OsStrExt as _;
    let sandbox = Sandbox::new();
    let model = std::fs::read(workspace().join("assets/models/torus.glb")).unwrap();
    sandbox.write("herd/animals/torus.glb", model);
    sandbox.write("herd/herd.toml", "[[model]]\nfiles = \"animals/**/*.glb\"\n");
    let at = |name: &str| sandbox.path().join("herd/animals").join(name);
    std::os::unix::fs::symlink("nowhere", at("lost.txt")).unwrap();
    std::os::unix::fs::symlink("..", at("up")).unwrap();
    std::fs::write(at("x").with_file_name(std::ffi::OsStr::from_bytes(b"caf\xe9.txt")), "").unwrap();
    sandbox
}

#[cfg(unix)]
#[test]
fn herd_continues_past_links_that_lead_nowhere() {
    let sandbox = herd();
    let run = sandbox.run(&["herd", "plan", "herd/herd.toml", "-o", "herd/out"]);
    assert_eq!(run.code, Some(0), "{run:?}");
    assert_eq!(run.stdout.lines().filter(|line| line.contains("bake animals/torus.glb")).count(), 1, "{run:?}");
    for (file, why) in [("animals/lost.txt", "its link cannot be followed"), ("animals/up", "a folder above it")] {
        let note = |line: &&str| line.starts_with("note: ") && line.contains(file) && line.contains(why);
        assert_eq!(run.stderr.lines().filter(note).count(), 1, "{file}: {run:?}");
    }
    assert_eq!(run.stderr.lines().count(), 2, "{run:?}");
}

#[cfg(unix)]
#[test]
fn herd_waits_for_the_ninja_of_a_killed_run() {
    let sandbox = herd();
    let shim = sandbox.write("bin/ninja", "#!/bin/sh\nexec sleep 60\n");
    std::fs::set_permissions(&shim, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    let command = || {
        let mut command = sandbox.command(&["herd", "run", "herd/herd.toml", "-o", "herd/out", "--quiet"]);
        let path = format!("{}:{}", shim.parent().unwrap().display(), std::env::var("PATH").unwrap());
        command.env("PATH", path);
        command
    };
    let mut first = command().spawn().unwrap();
    let owner = || std::fs::read_to_string(sandbox.path().join("herd/out/.herd/lock")).unwrap_or_default();
    let began = std::time::Instant::now();
    while [String::new(), format!("{}\n", first.id())].contains(&owner()) && began.elapsed().as_secs() < 60 {
        std::thread::sleep(Duration::from_millis(10));
    }
    let ninja = owner().trim().to_owned();
    let again = || pelage_tests::binary::run_to_end(command());
    let refused = |run: &Run| run.code == Some(2) && run.stderr.contains(&format!("another run, process {ninja},"));
    assert!(refused(&again()), "while the first run is at work: {:?}", again());
    first.kill().unwrap();
    first.wait().unwrap();
    assert!(refused(&again()), "after it was killed: {:?}", again());
    assert!(std::process::Command::new("kill").args(["-9", &ninja]).status().unwrap().success());
    std::fs::write(&shim, "#!/bin/sh\n").unwrap();
    let freed = again();
    assert!(!freed.stderr.contains("another run"), "{freed:?}");
}
