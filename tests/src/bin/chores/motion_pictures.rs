//! Draws four frames of each moving subject, one row per subject: `chores motion-pictures PICTURE.png [FOX.glb]`.
//!
//! Subjects: the pony's mane and tail at a gallop, its head in a breeze, the hare landing, and the hare in a gust. If a
//! model is given, it is shown running.

use anyhow::{Context as _, bail};
use pelage_tests::binary::workspace;
use pelage_tests::chores::{ChoreFolder, sheet};

const COLUMNS: usize = 4;
const SIZE: &str = "320x250";
const BREEZE: &str = "--wind 1.6,0,0.6 --gust 0.9 --gust-seconds 1.2 --fps 6";
const GUST: &str = "--wind 5,0,2 --gust 0.9 --gust-seconds 1.2 --fps 6";

pub fn run(arguments: &[String]) -> anyhow::Result<()> {
    let (picture, more) = match arguments {
        [picture] => (picture, None),
        [picture, model] => (picture, Some(model)),
        _ => bail!("expected PICTURE.png, optionally followed by a model"),
    };
    let asset = |kind: &str, name: &str| workspace().join("assets").join(kind).join(name).display().to_string();
    let own = |name: &str| {
        [asset("models", &format!("{name}.glb")), "--recipe".into(), asset("recipes", &format!("{name}.toml"))].to_vec()
    };
    let hare = "--camera 0.42,0.5,0.62/0,0.24,0.02/34";
    let mut rows = vec![
        ("pony", own("pony"), "--clip Gallop --fps 8 --camera=-3.1,0.9,1.3/0,.68,-.1/30".into()),
        ("head", own("head"), format!("{BREEZE} --camera=-.75,.3,.8/0,.19,-.01/30")),
        ("hare", own("hare"), "--clip Walk --fps 7 --time 0.1".into()),
        ("hare", own("hare"), format!("{GUST} {hare}")),
    ];
    if let Some(model) = more {
        rows.push((
            "fox",
            vec![model.clone(), "--recipe".into(), asset("recipes", "fox.toml")],
            "--clip Run --fps 7".into(),
        ));
    }
    let workshop = ChoreFolder::default();
    let mut pictures = Vec::new();
    for (name, model, options) in rows {
        let baked = workshop.bake(name, &model)?;
        let options: Vec<&str> = options.split_whitespace().collect();
        pictures.extend(workshop.sequence(&baked, SIZE, COLUMNS, &options)?);
    }
    sheet(&pictures, COLUMNS)?.save(picture).with_context(|| format!("cannot write {picture}"))
}
