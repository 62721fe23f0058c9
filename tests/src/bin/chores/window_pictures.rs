//! Takes the pictures of the window for the gallery: `chores window-pictures assets/gallery MODEL [RECIPE]`.
//!
//! Opens the model in a real window on a virtual display. Saves it once with both panels, and once beside its
//! path-traced reference image of 16 samples.

use anyhow::{Context as _, bail, ensure};
use pelage_tests::desktop::Desktop;
use std::path::{Path, PathBuf};

const SIZE: &str = "1440x900";

pub fn run(arguments: &[String]) -> anyhow::Result<()> {
    let [folder, model, recipe @ ..] = arguments else { bail!("expected the FOLDER of the gallery, then a MODEL") };
    let absolute = |path: &String| std::fs::canonicalize(path).with_context(|| path.clone());
    let model = absolute(model)?;
    let recipe: Vec<PathBuf> = recipe.iter().take(1).map(absolute).collect::<Result<_, _>>()?;
    let scratch = tempfile::tempdir()?;
    let desktop = Desktop::start();
    let mut arguments = vec![model.display().to_string(), "--window".into(), SIZE.into()];
    for path in &recipe {
        arguments.extend(["--recipe".to_owned(), path.display().to_string()]);
    }

    let mut window = desktop.view(scratch.path(), &arguments);
    window.wait_for("made");
    window.wait_for("first picture");
    window.focus();
    std::thread::sleep(std::time::Duration::from_secs(3));
    let panels = window.save("F12");
    std::fs::copy(&panels, Path::new(folder).join("window.png"))?;

    window.key("n");
    window.skip_events();
    window.key("t");
    let mut last = window.wait_for("truth");
    // 16 samples suffice: with more, only FLIP would show a difference.
    while last["samples"].as_u64().is_some_and(|samples| samples < 16) {
        last = window.wait_for("truth");
    }
    let truth = window.save("F12");
    ensure!(truth != panels, "the two pictures must differ");
    std::fs::copy(&truth, Path::new(folder).join("window_truth.png"))?;
    println!("{folder}/window.png, {folder}/window_truth.png: FLIP {}", last["flip"]);
    Ok(())
}
