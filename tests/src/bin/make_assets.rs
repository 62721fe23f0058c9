//! Writes the project's own models: `cargo run -p pelage-tests --bin make_assets -- [--out DIR] [--preview DIR]`.
//!
//! `--out` (default `assets` of this checkout) receives hare.glb, torus.glb and knot.glb in `models`, zebra.png and spots.png in
//! `patterns`; `--preview` also receives a picture of each model. Figures about the models go to stdout.

use std::path::PathBuf;

use anyhow::{Context as _, bail};
use pelage_tests::assets::{charts, glb::Model, hare, patterns, preview, shapes};

fn main() -> anyhow::Result<()> {
    let mut out = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../assets"));
    let mut pictures = None;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().map(PathBuf::from).with_context(|| format!("{argument} needs a folder"));
        match argument.as_str() {
            "--out" => out = value()?,
            "--preview" => pictures = Some(value()?),
            other => bail!("unknown argument {other:?}; expected --out DIR or --preview DIR"),
        }
    }
    for (name, model) in [("hare", hare::model()?), ("torus", shapes::torus()), ("knot", shapes::knot())] {
        let bytes = model.to_glb()?;
        let path = out.join("models").join(format!("{name}.glb"));
        std::fs::write(&path, &bytes).with_context(|| format!("cannot write {}", path.display()))?;
        print_facts(name, &model, bytes.len());
        if let Some(folder) = &pictures {
            let path = folder.join(format!("{name}.png"));
            preview::draw(&model).save(&path).with_context(|| format!("cannot write {}", path.display()))?;
        }
    }
    for (name, picture) in [("zebra", patterns::zebra()), ("spots", patterns::spots())] {
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
