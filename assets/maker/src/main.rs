//! Writes the models of this project: `cargo run -p pelage-assets -- [--out DIR] [--preview DIR] [--only NAME]`.
//!
//! `--out` (default: `assets` of this checkout) receives models such as hare.glb in `models`, and patterns such as
//! zebra.png in `patterns`. `--preview` receives a picture of each model and of each of its clips. `--only` makes one
//! model and no patterns. Statistics of the models go to stdout.

use std::path::PathBuf;

use anyhow::{Context as _, bail};
use pelage_assets::{charts, crane, glb::Model, hare, head, hills, ox, patterns, pony, preview, shapes};

type Maker = fn() -> anyhow::Result<Model>;

fn main() -> anyhow::Result<()> {
    let mut out = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let (mut pictures, mut only) = (None, None);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().with_context(|| format!("{argument} needs a value"));
        match argument.as_str() {
            "--out" => out = value()?.into(),
            "--preview" => pictures = Some(PathBuf::from(value()?)),
            "--only" => only = Some(value()?),
            other => bail!("unknown argument {other:?}; expected --out DIR, --preview DIR or --only NAME"),
        }
    }
    let makers: [(&str, Maker); 8] = [
        ("hare", hare::model),
        ("ox", ox::model),
        ("crane", crane::model),
        ("hills", hills::model),
        ("pony", pony::model),
        ("head", head::model),
        ("torus", || Ok(shapes::torus())),
        ("knot", || Ok(shapes::knot())),
    ];
    let wanted = |name: &str| only.as_deref().is_none_or(|o| o == name);
    if let Some(name) = only.as_deref().filter(|o| makers.iter().all(|m| m.0 != *o)) {
        bail!("no model {name:?}, expected one of {:?}", makers.map(|m| m.0));
    }
    for (name, make) in makers.into_iter().filter(|m| wanted(m.0)) {
        let model = make()?;
        let bytes = model.to_glb()?;
        let path = out.join("models").join(format!("{name}.glb"));
        std::fs::write(&path, &bytes).with_context(|| format!("cannot write {}", path.display()))?;
        print_facts(name, &model, bytes.len());
        if let Some(folder) = &pictures {
            let path = folder.join(format!("{name}.png"));
            preview::draw(&model).save(&path).with_context(|| format!("cannot write {}", path.display()))?;
            for clip in &model.clips {
                let path = folder.join(format!("{name}_{}.png", clip.name));
                preview::draw_clip(&model, clip)
                    .save(&path)
                    .with_context(|| format!("cannot write {}", path.display()))?;
            }
        }
    }
    if only.is_some() {
        return Ok(());
    }
    for (name, picture) in patterns::all() {
        let path = out.join("patterns").join(format!("{name}.png"));
        picture.save(&path).with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

fn print_facts(name: &str, model: &Model, bytes: usize) {
    println!("{name}: {bytes} bytes");
    for p in &model.primitives {
        println!("  {}: {} triangles, {} vertices", p.name, p.triangles.len(), p.len());
    }
    let coat = &model.primitives[0];
    println!("  {:?}", charts::report(&coat.positions, &coat.uvs, &coat.triangles));
}
