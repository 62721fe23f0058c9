//! Measures and updates the tables of runtime/docs/performance.md: `chores performance-table`.
//!
//! Replaces the lines between the markers of the page, including adapter, date and commit. Run it on an idle machine.

use anyhow::{Context as _, ensure};
use pelage_tests::binary::workspace;
use pelage_tests::chores::ChoreFolder;
use serde_json::Value;
use std::process::Command;

/// Formats a JSON result for a table.
type Formatter = fn(&Value) -> String;

/// Frame measurements: description, options of `pelage bench`, and formatter of the result.
const FRAMES: [(&str, &[&str], Formatter); 10] = [
    ("the hare, 834×424, all shadows, light still", &[], |found| {
        format!("{}, of which shells {}, skin {}", frame(found), pass_time(found, "shells"), pass_time(found, "skin"))
    }),
    ("the same at 1668×848", &["--size", "1668x848"], frame),
    ("the same with all layers, whatever the size", &["--detail", "full"], frame),
    ("the same without shadows", &["--self-shadow", "off", "--soft-shadow", "off"], frame),
    ("the same by Kajiya–Kay", &["--scattering", "off"], frame),
    ("the same with four samples a pixel", &["--samples", "4"], frame),
    ("the same as single strands with blended edges", &["--strand-edges", "blended", "--frames", "5"], frame),
    ("a hundred hares", &["--crowd", "100"], frame),
    ("the hare in ink", &["--style", "ink"], frame),
    ("the hare's shadow maps redrawn", &[], |found| milliseconds(&found["shadow_maps_ms"])),
];

/// Bake measurements: description, name of the model in assets/models, options of `pelage bake`, and formatter of the
/// result.
const BAKES: [(&str, &str, &[&str], Formatter); 4] = [
    ("the hare, ink and all; its package", "hare", &["--recipe", "assets/recipes/hare.toml"], format_bake),
    (
        "the same without ink",
        "hare",
        &["--recipe", "assets/recipes/hare.toml", "--set", "ink.enabled=false"],
        format_bake,
    ),
    ("the pony with mane and tail", "pony", &["--recipe", "assets/recipes/pony.toml"], format_bake),
    (
        "a tile of 512×512×64 with 20 000 strands, plain texels",
        "torus",
        &[
            "--set",
            "slice.tile_texels=512",
            "--set",
            "slice.layers=64",
            "--set",
            "hair.density=20000",
            "--set",
            "pack.shell_format=rgba8",
            "--set",
            "pack.direction_format=rg8",
        ],
        format_bake,
    ),
];

fn milliseconds(value: &Value) -> String {
    format!("{:.1} ms", value.as_f64().unwrap_or(f64::NAN))
}

fn frame(found: &Value) -> String {
    milliseconds(&found["frame_ms"]["median"])
}

fn pass_time(found: &Value, name: &str) -> String {
    let pass = found["passes"].as_array().into_iter().flatten().find(|pass| pass["name"] == name);
    pass.map_or_else(|| "none".to_owned(), |pass| milliseconds(&pass["median_ms"]))
}

fn format_bake(found: &Value) -> String {
    let number = |key: &str| found[key].as_f64().unwrap_or(f64::NAN);
    format!("{:.2} s; {:.2} MiB", number("seconds"), number("bytes") / f64::from(1 << 20))
}

/// Runs a program in the workspace and returns its stdout.
pub fn stdout_of(program: &str, arguments: &[&str]) -> anyhow::Result<String> {
    let output = Command::new(program).args(arguments).current_dir(workspace()).output()?;
    ensure!(output.status.success(), "{program} {arguments:?} failed");
    Ok(String::from_utf8(output.stdout)?.trim().to_owned())
}

/// Replaces the lines between the markers of `table`.
pub fn replace_table(page: &str, table: &str, lines: &[String]) -> anyhow::Result<String> {
    let (begin, end) = (format!("<!-- {table}: begin -->\n"), format!("<!-- {table}: end -->\n"));
    let (before, rest) = page.split_once(&begin).with_context(|| format!("no mark {begin:?}"))?;
    let (_, after) = rest.split_once(&end).with_context(|| format!("no mark {end:?}"))?;
    Ok(format!("{before}{begin}{}\n{end}{after}", lines.join("\n")))
}

pub fn run() -> anyhow::Result<()> {
    std::env::set_current_dir(workspace())?;
    let workshop = ChoreFolder::default();
    let head = ["| what | measured | command |", "|---|---|---|"].map(str::to_owned);
    let (mut frames, mut bakes) = (head.to_vec(), head.to_vec());
    let run = |arguments: &[&str]| -> anyhow::Result<Value> {
        Ok(serde_json::from_str(&workshop.run(&[arguments, &["--json", "--quiet"]].concat())?.stdout)?)
    };
    let folder = tempfile::tempdir()?;
    let package = folder.path().join("a.pelage").display().to_string();
    for (what, model, options, said) in BAKES {
        let model = format!("assets/models/{model}.glb");
        let found = run(&[&["bake", &model, "-o", &package], options].concat())?;
        bakes.push(format!(
            "| {what} | {} | `{}` |",
            said(&found),
            [&["pelage bake", &model], options].concat().join(" ")
        ));
    }
    run(&["bake", "assets/models/hare.glb", "--recipe", "assets/recipes/hare.toml", "-o", &package])?;
    let mut adapter = String::new();
    for (what, options, said) in FRAMES {
        let found = run(&[&["bench", &package], options].concat())?;
        adapter = found["adapter"].as_str().unwrap_or_default().to_owned();
        frames.push(format!(
            "| {what} | {} | `{}` |",
            said(&found),
            [&["pelage bench hare.pelage"], options].concat().join(" ")
        ));
    }
    let when =
        format!("{}, commit {}", stdout_of("date", &["+%F"])?, stdout_of("git", &["rev-parse", "--short", "HEAD"])?);
    let cores = std::thread::available_parallelism()?;
    frames.extend([String::new(), format!("Measured on {adapter}, {cores} cores, {when}.")]);
    bakes.extend([String::new(), format!("Measured on {cores} cores, {when}.")]);
    let path = workspace().join("runtime/docs/performance.md");
    let page = replace_table(&std::fs::read_to_string(&path)?, "frames", &frames)?;
    std::fs::write(&path, replace_table(&page, "bakes", &bakes)?)?;
    Ok(())
}
