//! Draws the pairs of pictures that a person has ranked, and prints the error that a bake with limits assigns to each
//! picture: `chores likeness-pairs [WIDTHxHEIGHT FOLDER]`.
//!
//! Without arguments, redraws the pictures in `tests/golden/likeness` at 417x212 pixels. With arguments, draws larger
//! ones into FOLDER for viewing. Needs the test data.

use anyhow::Context as _;
use pelage_tests::binary::workspace;
use pelage_tests::chores::ChoreFolder;
use pelage_tests::likeness::{FUR_PX, folder, likeness, pairs, settings};
use std::path::{Path, PathBuf};

/// Animals: name, model, and options of `pelage bake`. Models that begin with `meshes/` are in the test data.
const ANIMALS: [(&str, &str, &[&str]); 6] = [
    // Long hair makes the shiba look like a husky.
    ("shiba", "meshes/skinned/quaternius_ShibaInu.glb", &["--set", "hair.length_m=0.25"]),
    ("wolf", "meshes/skinned/quaternius_Wolf.glb", &["--set", "hair.length_m=0.12"]),
    ("alpaca", "meshes/skinned/quaternius_Alpaca.glb", &[]),
    ("hare", "assets/models/hare.glb", &["--recipe", "assets/recipes/hare.toml"]),
    ("ox", "assets/models/ox.glb", &["--recipe", "assets/recipes/ox.toml"]),
    ("knot", "assets/models/knot.glb", &["--recipe", "assets/recipes/knot.toml"]),
];

/// Samples per pixel of the reference images.
const SAMPLES: &str = "64";

pub fn run(arguments: &[String]) -> anyhow::Result<()> {
    let (size, to) = match arguments {
        [] => ("417x212", folder()),
        [size, folder] => (size.as_str(), PathBuf::from(folder)),
        _ => anyhow::bail!("expected nothing, or a size and a folder"),
    };
    let data = std::env::var_os("PELAGE_DATA").map_or_else(|| workspace().join("../shared/data"), PathBuf::from);
    let workshop = ChoreFolder::default();
    for (animal, model, bake) in ANIMALS {
        let model = if model.starts_with("meshes/") { data.join(model) } else { workspace().join(model) };
        let bake: Vec<String> = bake.iter().map(|word| absolute(word)).collect();
        let here = to.join(animal);
        std::fs::create_dir_all(&here).with_context(|| here.display().to_string())?;
        for (i, setting) in settings(animal).iter().enumerate() {
            draw(&workshop, (&model, &bake), setting, &here, size, i == 0).with_context(|| animal.to_owned())?;
        }
    }
    println!("{:8} {:10} {:>7} {:>7} {:>8} {:>8}", "animal", "setting", "error", "flip", "outline", "contrast");
    let scale = size.split_once('x').and_then(|(width, _)| width.parse::<f64>().ok()).unwrap_or(417.0) / 417.0;
    for (animal, ..) in ANIMALS {
        for setting in settings(animal) {
            let l = picture_of(&to, animal, &setting, scale);
            println!("{animal:8} {setting:10} {:7.4} {:7.4} {:8.4} {:8.3}", l.error, l.flip, l.outline, l.contrast);
        }
    }
    for pair in pairs() {
        let of = |setting| picture_of(&to, &pair.animal, setting, scale).error;
        let margin = of(&pair.worse) / of(&pair.better) - 1.0;
        println!("{:8} {:10} {:10} {:+.1} %", pair.animal, pair.better, pair.worse, 100.0 * margin);
    }
    Ok(())
}

fn picture_of(folder: &Path, animal: &str, setting: &str, scale: f64) -> pelage_truth::likeness::Likeness {
    let here = folder.join(animal);
    likeness(&here.join(format!("{setting}.png")), &here.join("true.png"), FUR_PX * scale)
}

/// Makes the path of a recipe absolute; recipe paths are relative to the workspace.
fn absolute(word: &str) -> String {
    if word.starts_with("assets/") { workspace().join(word).display().to_string() } else { word.to_owned() }
}

/// Bakes and draws one setting. If `truth` is set, also traces the reference image.
fn draw(
    workshop: &ChoreFolder,
    (model, bake): (&Path, &[String]),
    setting: &str,
    folder: &Path,
    size: &str,
    truth: bool,
) -> anyhow::Result<()> {
    let words: Vec<&str> = setting.split('_').collect();
    let &[layers, texels, fins] = &words[..] else { anyhow::bail!("{setting}: expected layers_texels_fins") };
    let package = folder.join("a.pelage").display().to_string();
    let sets = [
        format!("slice.layers={layers}"),
        format!("slice.tile_texels={texels}"),
        format!("fins.enabled={}", fins == "1"),
        "ink.enabled=false".into(),
        "pack.shell_format=rgba8".into(),
        "pack.direction_format=rg8".into(),
    ];
    let model = model.display().to_string();
    let mut arguments: Vec<&str> = vec!["bake", &model, "-q", "-o", &package];
    arguments.extend(bake.iter().map(String::as_str));
    arguments.extend(sets.iter().flat_map(|set| ["--set", set]));
    workshop.run(&arguments)?;
    let picture = folder.join(format!("{setting}.png")).display().to_string();
    workshop.run(&["render", &package, "-q", "-o", &picture, "--size", size])?;
    if truth {
        let picture = folder.join("true.png").display().to_string();
        workshop.run(&["reference", &package, "-q", "-o", &picture, "--size", size, "--samples", SAMPLES])?;
    }
    std::fs::remove_file(&package).with_context(|| package.clone())
}
