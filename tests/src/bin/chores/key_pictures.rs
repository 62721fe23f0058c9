//! Draws the small pictures of the recipe reference: `chores key-pictures bake/docs [KEY…]`.
//!
//! Each picture shows the hare without a recipe at three values of one key, side by side. Without KEY, all pictures are
//! drawn.

use anyhow::{Context as _, bail, ensure};
use pelage_tests::binary::workspace;
use pelage_tests::chores::{ChoreFolder, sheet};
use pelage_tests::pages::KEY_PICTURES;
use std::path::Path;

const WHOLE: &str = "--camera=0.5,0.42,0.66/0,0.235,0.01/28";
const SHOULDER: &str = "--camera=0.6,0.4,0.6/0.03,0.225,-0.045/6";

pub fn run(arguments: &[String]) -> anyhow::Result<()> {
    let [folder, keys @ ..] = arguments else { bail!("expected the FOLDER of the page, optionally followed by keys") };
    let unknown = keys.iter().find(|key| KEY_PICTURES.iter().all(|picture| picture.key != key.as_str()));
    ensure!(unknown.is_none(), "there is no picture of the key {unknown:?}");
    let workshop = ChoreFolder::default();
    let model = workspace().join("assets/models/hare.glb").display().to_string();
    for picture in KEY_PICTURES.iter().filter(|picture| keys.is_empty() || keys.iter().any(|key| key == picture.key)) {
        let mut row = Vec::new();
        for value in picture.values {
            let baked = workshop.bake("hare", &[&model, "--set", &format!("{}={value}", picture.key)])?;
            let camera = if picture.whole { WHOLE } else { SHOULDER };
            row.push(workshop.draw(&baked, "200x180", &[camera, "--light=0.9,0.9,0.7"])?);
        }
        let path = Path::new(folder).join(picture.path());
        sheet(&row, row.len())?.save(&path).with_context(|| format!("cannot write {}", path.display()))?;
        println!("{}", path.display());
    }
    Ok(())
}
