//! Tests of `pelage herd` with the real binary and Ninja: commands that are run, skipped, failed and interrupted.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_needs::has_ninja;
use pelage_tests::binary::{Run, Sandbox, run_to_end, walk, workspace};
use pelage_tests::gpu::gpu;
use pelage_tests::schema;
use serde_json::Value;
use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Herd of two small models, one of them in two variants. It has pictures, reference images that are traced in parts,
/// comparisons, and a sequence that is rendered in shares.
const HERD: &str = concat!(
    r#"
title = "A herd of <three>"

[[model]]
files = "animals/*.{glb,obj,gltf}"

[[recipe]]
set = { slice = { tile_texels = 32, layers = 4 }, "#,
    r#""hair.density" = 60, pack.shell_format = "rgba8", "ink.enabled" = false, "visibility.enabled" = false, "#,
    r#""shading.model" = "kajiya-kay" }

[[recipe]]
models = "*knot*"
file = "recipes/knot.toml"

[[variant]]
name = "wet one"
models = "*torus*"
set = { "color.gain" = 0.8 }

[[variant]]
name = "dry"
models = "*torus*"

[[view]]
name = "front"
size = "48x32"
set = { "fur.layers" = 3 }
truth = { samples = 2, parts = 2, max_flip = 0.9 }

[[sequence]]
name = "turn"
models = "*knot*"
view = "front"
frames = 3
shares = 2
auto_rotate = true
"#
);

/// Number of tasks. Three packages each have a bake, inspection, picture, two traced parts, merge and comparison; the
/// sequence has two shares.
const TASKS: usize = 3 * 7 + 2;

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    for name in ["torus", "knot"] {
        let model = std::fs::read(workspace().join(format!("assets/models/{name}.glb"))).unwrap();
        sandbox.write(&format!("herd/animals/{name}.glb"), model);
    }
    sandbox.write("herd/recipes/knot.toml", "[hair]\nlean = 0.3\n");
    sandbox.write("herd/herd.toml", HERD);
    sandbox
}

fn herd(sandbox: &Sandbox, action: &str, more: &[&str]) -> Run {
    sandbox.run(&[&["herd", action, "herd/herd.toml", "-o", "herd/out", "--json"], more].concat())
}

/// Runs a herd and asserts the exit code. Returns the result, and the number of commands that were run.
#[track_caller]
fn run(sandbox: &Sandbox, code: i32, more: &[&str]) -> (Value, u64) {
    let run = herd(sandbox, "run", more);
    assert_eq!(run.code, Some(code), "{run:?}");
    let said = schema::parse_answer(&run, "herd");
    let ran = said["ran"].as_u64().unwrap();
    (said, ran)
}

/// Returns the hash of each result file of a herd; internal files are omitted.
fn results(sandbox: &Sandbox, out: &str) -> BTreeMap<String, Vec<u8>> {
    let mut files = Vec::new();
    for folder in ["packages", "pictures", "truths", "differences", "sequences"] {
        walk(&sandbox.path().join(out).join(folder), &mut files);
    }
    let hash = |path: &std::path::PathBuf| {
        let name = path.strip_prefix(sandbox.path().join(out)).unwrap().display().to_string();
        (name, Sha256::digest(std::fs::read(path).unwrap()).to_vec())
    };
    files.iter().map(hash).collect()
}

fn touch(sandbox: &Sandbox, name: &str) {
    // Ninja compares modification times, which are coarse on some file systems.
    std::thread::sleep(Duration::from_millis(20));
    let file = std::fs::File::options().append(true).open(sandbox.path().join(name)).unwrap();
    file.set_modified(std::time::SystemTime::now()).unwrap();
}

#[test]
fn herd_runs_only_changed_tasks() {
    if !has_ninja("herd_runs_only_changed_tasks") {
        return;
    }
    let Some(_) = gpu("herd_runs_only_changed_tasks") else { return };
    let sandbox = sandbox();
    let (said, ran) = run(&sandbox, 0, &[]);
    assert_eq!((ran as usize, &said["models"], &said["tasks"]["done"]), (TASKS, &3.into(), &TASKS.into()), "{said}");
    let first = results(&sandbox, "herd/out");
    for name in [
        "packages/animals/torus.wet one.pelage",
        "packages/animals/knot.pelage",
        "pictures/animals/torus.dry.front.png",
        "truths/animals/knot.front.png",
        "truths/animals/knot.front.parts/2.part",
        "differences/animals/knot.front.png",
        "sequences/animals/knot.turn/0002.png",
    ] {
        assert!(first.contains_key(name), "{name} is missing: {:?}", first.keys());
    }
    let page = std::fs::read_to_string(sandbox.path().join("herd/out/report.html")).unwrap();
    assert!(page.contains("<title>A herd of &lt;three&gt;") && page.contains("data:image/jpeg;base64,"));

    // Checks what is due after no change, after rewriting a model with the same bytes, and after changing a recipe that
    // the torus does not use.
    let due = || {
        let plan = schema::parse_answer(&herd(&sandbox, "plan", &["--due"]), "herd");
        plan["tasks"]
            .as_array()
            .unwrap()
            .iter()
            .map(|task| task["name"].as_str().unwrap().to_owned())
            .collect::<Vec<_>>()
    };
    assert_eq!(due(), [""; 0]);
    assert_eq!(run(&sandbox, 0, &[]).1, 0);
    touch(&sandbox, "herd/animals/torus.glb");
    let touched = due();
    assert_eq!(touched.len(), 2 * 7, "{touched:?}");
    assert!(touched.iter().all(|name| name.contains("torus")), "{touched:?}");
    assert_eq!(run(&sandbox, 0, &[]).1, 2, "only the two variants are baked; later tasks must be up to date");
    assert_eq!(results(&sandbox, "herd/out"), first);
    sandbox.write("herd/recipes/knot.toml", "[hair]\nlean = 0.5\n");
    let (_, ran) = run(&sandbox, 0, &[]);
    assert_eq!(ran as usize, TASKS / 3 + 2, "all tasks of the knot must run, and no others");
    let second = results(&sandbox, "herd/out");
    let changed: Vec<_> = second.iter().filter(|(name, hash)| first[*name] != **hash).map(|(name, _)| name).collect();
    assert!(changed.len() > 4 && changed.iter().all(|name| name.contains("knot")), "{changed:?}");

    // In another folder, and with one command at a time, the results must have the same bytes, with and without a
    // cache.
    let elsewhere = |out: &str, cache: &str| {
        let args = ["herd", "run", "herd/herd.toml", "-o", out, "--jobs", "1", "--cache", cache, "--json"];
        let run = sandbox.run(&args);
        assert_eq!(run.code, Some(0), "{run:?}");
        let said = schema::parse_answer(&run, "herd")["cached"].as_u64().unwrap() as usize;
        let mut records = Vec::new();
        walk(&sandbox.path().join(out).join(".herd/records"), &mut records);
        let read = |path| serde_json::from_slice::<Value>(&std::fs::read(path).unwrap()).unwrap();
        let cached = records.iter().map(read).filter(|record| record["cached"] == true).count();
        assert_eq!(said, cached);
        cached
    };
    assert_eq!(elsewhere("alone", "cache"), 0);
    assert_eq!(results(&sandbox, "alone"), second);
    // The run is repeated without outputs, as on another machine. Everything except the inspections must come from the
    // cache.
    std::fs::remove_dir_all(sandbox.path().join("alone")).unwrap();
    assert_eq!(elsewhere("alone", "cache"), TASKS - 3);
    assert_eq!(results(&sandbox, "alone"), second);
}

#[test]
fn herd_continues_after_failures_and_reports_them() {
    if !has_ninja("herd_continues_after_failures_and_reports_them") {
        return;
    }
    let Some(_) = gpu("herd_continues_after_failures_and_reports_them") else { return };
    let sandbox = sandbox();
    sandbox.write("herd/animals/broken <one>.glb", "no model");
    sandbox.write("herd/herd.toml", HERD.replace("max_flip = 0.9", "max_flip = 1e-6"));
    let (said, _) = run(&sandbox, 3, &[]);
    let (tasks, failures) = (&said["tasks"], said["failures"].as_array().unwrap());
    let counts = ["failed", "differ", "missing"].map(|key| tasks[key].as_u64().unwrap());
    assert_eq!(counts, [1, 3, 6], "{said}");
    assert_eq!(tasks["done"].as_u64().unwrap() as usize, TASKS - 3);
    let first = failures[0]["message"].as_str().unwrap();
    assert!(first.contains("animals/broken <one>.glb: byte 0"), "{first}");
    assert!(failures[1]["message"].as_str().unwrap().contains("--max-flip"), "{said}");
    // Only the failed commands may run again.
    assert_eq!(run(&sandbox, 3, &[]).1, 4);
    std::fs::remove_file(sandbox.path().join("herd/animals/broken <one>.glb")).unwrap();
    let (said, ran) = run(&sandbox, 7, &[]);
    assert_eq!((ran, &said["tasks"]["missing"]), (3, &0.into()), "{said}");
    sandbox.write("herd/herd.toml", HERD);
    assert_eq!(run(&sandbox, 0, &[]).1, 3, "a changed limit must rerun the command");
    let report = herd(&sandbox, "report", &[]);
    assert_eq!(report.code, Some(0), "{report:?}");
}

#[test]
fn killed_herd_resumes_with_identical_results() {
    if !has_ninja("killed_herd_resumes_with_identical_results") {
        return;
    }
    let Some(_) = gpu("killed_herd_resumes_with_identical_results") else { return };
    let whole = sandbox();
    run(&whole, 0, &[]);
    let expected = results(&whole, "herd/out");
    let sandbox = sandbox();
    for made in [1, 3, 5] {
        // The process group is killed, so that the tool, Ninja and the commands have no chance to clean up.
        let mut command = sandbox.command(&["herd", "run", "herd/herd.toml", "-o", "herd/out", "--quiet"]);
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command.stdout(std::process::Stdio::null()).spawn().unwrap();
        let began = Instant::now();
        let count = || {
            let mut files = Vec::new();
            walk(&sandbox.path().join("herd"), &mut files);
            files.iter().filter(|path| path.extension().is_some_and(|e| e == "pelage" || e == "png")).count()
        };
        while count() < made + 1 && began.elapsed() < Duration::from_secs(120) {
            std::thread::sleep(Duration::from_millis(5));
        }
        let killed = std::process::Command::new("kill").args(["-9", "--", &format!("-{}", child.id())]).status();
        assert!(killed.unwrap().success());
        child.wait().unwrap();
    }
    let (said, ran) = run(&sandbox, 0, &[]);
    assert!(ran > 0 && (ran as usize) < TASKS, "{said}");
    let found: BTreeMap<_, _> =
        results(&sandbox, "herd/out").into_iter().filter(|(name, _)| !name.contains(".pelage-")).collect();
    assert_eq!(found, expected);
    assert_eq!(run(&sandbox, 0, &[]).1, 0);
}

#[test]
fn silently_killed_commands_are_reported() {
    if !has_ninja("silently_killed_commands_are_reported") {
        return;
    }
    let sandbox = sandbox();
    let models_alone = HERD.split("[[view]]").next().unwrap();
    sandbox.write("herd/herd.toml", models_alone);
    // With this limit, the system kills a process that writes a large file.
    sandbox.write("bin/ninja", "#!/bin/sh\nPATH=\"${PATH#*:}\"\nulimit -f 8\nexec ninja \"$@\"\n");
    let shim = sandbox.path().join("bin/ninja");
    std::fs::set_permissions(shim, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    let without_room = |counts: [u64; 3]| {
        let mut command = sandbox.command(&["herd", "run", "herd/herd.toml", "-o", "herd/out", "--json"]);
        let path = format!("{}/bin:{}", sandbox.path().display(), std::env::var("PATH").unwrap());
        // The user's settings for terminal output must not break the parser.
        command.env("PATH", path).env("CLICOLOR_FORCE", "1").env("NINJA_STATUS", "%p ");
        let killed = run_to_end(command);
        assert_eq!(killed.code, Some(2), "{killed:?}");
        let said = schema::parse_answer(&killed, "herd");
        let found = ["failed", "differ", "missing"].map(|key| said["tasks"][key].as_u64().unwrap());
        assert_eq!(found, counts, "{said}");
        let why = said["failures"][0]["message"].as_str().unwrap();
        assert!(why.contains("it ended without a"), "{said}");
        let page = std::fs::read_to_string(sandbox.path().join("herd/out/report.html")).unwrap();
        assert!(page.contains("it ended without a"));
    };
    without_room([3, 0, 3]);
    // When there is space again, the failed commands must run again.
    let (said, ran) = run(&sandbox, 0, &[]);
    assert_eq!((ran, &said["tasks"]["failed"]), (6, &0.into()), "{said}");
    // Checks that earlier results do not count as current.
    sandbox.write("herd/recipes/knot.toml", "[hair]\nlean = 0.5\n");
    without_room([1, 0, 1]);
    let plan = schema::parse_answer(&herd(&sandbox, "plan", &["--due"]), "herd");
    assert_eq!(plan["tasks"].as_array().unwrap().len(), 2, "{plan}");
    assert_eq!(run(&sandbox, 0, &[]).1, 2);
}

#[test]
fn herd_plan_is_a_graph_of_plain_commands() {
    let sandbox = sandbox();
    let plan = herd(&sandbox, "plan", &["--cache", "cache"]);
    assert_eq!(plan.code, Some(0), "{plan:?}");
    let plan = schema::parse_answer(&plan, "herd");
    let tasks = plan["tasks"].as_array().unwrap();
    assert_eq!(tasks.len(), TASKS);
    let mut made: Vec<&str> = Vec::new();
    for task in tasks {
        let strings = |key: &str| -> Vec<&str> {
            task[key].as_array().unwrap().iter().map(|word| word.as_str().unwrap()).collect()
        };
        // The inputs of each task must exist, or be made by an earlier task.
        for input in strings("inputs") {
            assert!(made.contains(&input) || sandbox.path().join("herd").join(input).is_file(), "{input}");
        }
        made.extend(strings("outputs"));
        assert!(task["expected"]["seconds"].as_f64().unwrap() > 0.0 && strings("command")[0] == "pelage", "{task}");
    }
    // Look keys for layers must not be passed to reference images.
    let words = |kind: &str| tasks.iter().find(|task| task["kind"] == kind).unwrap()["command"].to_string();
    assert!(words("render").contains("--look=fur.layers=3") && !words("part").contains("fur.layers"));
    assert!(words("bake").contains("--cache\",\"../cache") || words("bake").contains("cache"), "{}", words("bake"));
    // The printed commands must work in a shell, in the herd's folder.
    let text = sandbox.run(&["herd", "plan", "herd/herd.toml", "-o", "herd/out"]).stdout;
    let bake = text.lines().find(|line| line.contains("knot.pelage") && line.contains("bake")).unwrap();
    let bake = bake.strip_prefix("pelage ").unwrap();
    for folder in ["packages/animals", ".herd/deps/packages/animals", ".herd/records/packages/animals"] {
        std::fs::create_dir_all(sandbox.path().join("herd/out").join(folder)).unwrap();
    }
    let mut shell = std::process::Command::new("sh");
    let tool = pelage_tests::binary::pelage().display().to_string();
    shell.arg("-c").arg(format!("'{tool}' {bake}")).current_dir(sandbox.path().join("herd"));
    let run = run_to_end(shell);
    assert_eq!(run.code, Some(0), "{run:?}");
    assert!(sandbox.path().join("herd/out/packages/animals/knot.pelage").is_file());
}

#[test]
fn herd_file_errors_are_reported_before_anything_runs() {
    let sandbox = sandbox().with_lab();
    for (text, code, word) in [
        ("[[model]]\nfiles = \"none/*.glb\"", 3, "herd/herd.toml: line 2, model[0].files: \"none\" is not a folder"),
        ("[[model]]\nfiles = \"animals/*.fbx\"", 3, "herd/herd.toml: line 1, model: no file matches these patterns"),
        (
            "[[model]]\nfiles = \"animals/*\"\n[[recipe]]\nfile = \"no.toml\"",
            3,
            "herd/herd.toml: line 4, recipe[0].file: \"no.toml\" is not a file",
        ),
        ("[[model]]\nfiles = \"animals/*\"\n[[view]]\nnme = \"a\"", 3, "herd/herd.toml: line 4, view[0].nme"),
        (
            "[[model]]\nfiles = \"animals/*\"\n[[view]]\nname = \"a\"\nsize = \"96\"",
            3,
            "line 5, view[0].size: invalid value '96'",
        ),
        (
            "[[model]]\nfiles = \"animals/*\"\n[[view]]\nname = \"a\"\norbit = \"1,2\"\ncamera = \"0,0,1/0,0,0/40\"",
            3,
            "line 3, view[0]: the argument '--camera",
        ),
        (
            "[[model]]\nfiles = \"animals/*\"\n[[view]]\nname = \"a\"\nset = { \"fur.layer\" = 3 }",
            3,
            "line 5, view[0].set.fur.layer: invalid value",
        ),
        (
            "[[model]]\nfiles = \"animals/*\"\n[[view]]\nname = \"a\"\n[view.truth]\nfibre = \"wool\"",
            3,
            "line 6, view[0].truth.fibre: invalid value 'wool' for '--fibre <HOW>' [possible values: ",
        ),
        (
            "[[model]]\nfiles = \"animals/*\"\n[[view]]\nname = \"a\"\n[view.truth]\nmax_flip = -1",
            3,
            "line 6, view[0].truth.max_flip: invalid value '-1'",
        ),
        (
            "[[model]]\nfiles = \"animals/*\"\n[[chart]]\ntopic = \"fur\"",
            3,
            "line 4, chart[0].topic: invalid value 'fur' for '<TOPIC>' [possible values: ",
        ),
        (
            "[[model]]\nfiles = \"animals/*\"\n[[recipe]]\nset = { \"hair.lenght_m\" = 1 }",
            3,
            "line 4, recipe[0].set.hair.lenght_m: unknown key",
        ),
        ("[[model]]\nfiles = \"animals/*\"\n[[variant]]\nname = \"a b\"", 0, ""),
        ("[[model]]\nfiles = \"animals/*\"\n[[recipe]]\nset = { \"color.pattern\" = \"/maps/a.png\" }", 0, ""),
        (
            "[[model]]\nfiles = \"animals/*\"\n[[recipe]]\nmodels = \"*fox*\"",
            0,
            "note: herd/herd.toml: line 4, recipe[0].models: matches no model",
        ),
        (
            "[[model]]\nfiles = \"animals/*\"\n[[recipe]]\nfile = \"r/{name}.toml\"",
            0,
            "note: herd/herd.toml: line 4, recipe[0].file: no model has such a recipe",
        ),
    ] {
        sandbox.write("herd/herd.toml", text);
        let run = herd(&sandbox, "plan", &[]);
        assert!(run.code == Some(code) && run.stderr.contains(word), "{text}: {run:?}");
    }
    let run = herd(&sandbox, "run", &["--detach"]);
    assert!(run.code == Some(1) && run.stderr.contains("--detach: it applies to --engine slurm"), "{run:?}");
    let run = herd(&sandbox, "run", &["--engine", "slurm", "--jobs", "2"]);
    assert!(run.code == Some(1) && run.stderr.contains("--jobs: it applies to --engine ninja"), "{run:?}");
    let run = sandbox.run(&["herd", "run", "none.toml", "-o", "out"]);
    assert_eq!(run.code, Some(2), "{run:?}");
    // Without Ninja, the error must say how to install it.
    let mut command = sandbox.command(&["herd", "run", "herd/herd.toml", "-o", "herd/out"]);
    let run = run_to_end({
        command.env("PATH", sandbox.path());
        command
    });
    assert!(run.code == Some(2) && run.stderr.contains("apt-get install ninja-build"), "{run:?}");
}
