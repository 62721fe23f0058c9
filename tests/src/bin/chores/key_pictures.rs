//! Draws the small pictures of the reference pages: `chores key-pictures bake/docs [KEY…]`.
//!
//! Each picture shows an animal at three values of one key, side by side, or several paintings in ink. KEY is a key of
//! a recipe or of a look, the name of a picture of several paintings, or `paintings` for everything in ink. Without
//! KEY, all pictures are drawn.

use anyhow::{Context as _, bail, ensure};
use image::RgbImage;
use pelage_tests::binary::workspace;
use pelage_tests::chores::{Baked, ChoreFolder, save_indexed, sheet};
use pelage_tests::pages::{INK_KEY_PICTURES, KEY_PICTURES, KeyPicture, KeyView, PAINTING_SHEETS, Painting};
use std::collections::BTreeMap;
use std::path::Path;

const WHOLE: &str = "--camera=0.5,0.42,0.66/0,0.235,0.01/28";
const SHOULDER: &str = "--camera=0.6,0.4,0.6/0.03,0.225,-0.045/6";
/// Size of the paintings of a key.
const PAINTING: &str = "300x220";
/// Word for all pictures in ink.
const PAINTINGS: &str = "paintings";

pub fn run(arguments: &[String]) -> anyhow::Result<()> {
    let [folder, names @ ..] = arguments else { bail!("expected the FOLDER of the page, optionally followed by keys") };
    let folder = Path::new(folder);
    let key_pictures = || KEY_PICTURES.iter().chain(&INK_KEY_PICTURES);
    let known: Vec<&str> = key_pictures()
        .map(|picture| picture.key)
        .chain(PAINTING_SHEETS.iter().map(|sheet| sheet.name))
        .chain([PAINTINGS])
        .collect();
    let unknown = names.iter().find(|name| !known.contains(&name.as_str()));
    ensure!(unknown.is_none(), "there is no picture of the key {unknown:?}");
    let is_wanted =
        |name: &str, in_ink: bool| names.is_empty() || names.iter().any(|n| n == name || in_ink && n == PAINTINGS);
    let mut studio = Studio::default();
    for picture in key_pictures().filter(|p| is_wanted(p.key, matches!(p.view, KeyView::Ink(_)))) {
        let path = folder.join(picture.path());
        match picture.view {
            KeyView::Ink(painting) => save_indexed(&sheet(&studio.painted_values(picture, painting)?, 3)?, &path)?,
            KeyView::Whole => studio.draw_values(picture, WHOLE, &path)?,
            KeyView::Shoulder => studio.draw_values(picture, SHOULDER, &path)?,
        }
        println!("{}", path.display());
    }
    for group in PAINTING_SHEETS.iter().filter(|group| is_wanted(group.name, true)) {
        let paintings: anyhow::Result<Vec<RgbImage>> =
            group.paintings.iter().map(|painting| studio.paint(*painting, group.size, &[])).collect();
        let path = folder.join(group.path());
        save_indexed(&sheet(&paintings?, group.columns)?, &path)?;
        println!("{}", path.display());
    }
    Ok(())
}

/// Folder of the chore, with the packages that were baked for paintings.
#[derive(Default)]
struct Studio {
    folder: ChoreFolder,
    /// Packages by model and options of the bake.
    packages: BTreeMap<(&'static str, &'static str), Baked>,
}

impl Studio {
    /// Draws the hare in fur at each value of a recipe's key.
    fn draw_values(&self, picture: &KeyPicture, camera: &str, path: &Path) -> anyhow::Result<()> {
        let model = workspace().join("assets/models/hare.glb").display().to_string();
        let mut row = Vec::new();
        for value in picture.values {
            let baked = self.folder.bake("hare", &[&model, "--set", &format!("{}={value}", picture.key)])?;
            row.push(self.folder.draw(&baked, "200x180", &[camera, "--light=0.9,0.9,0.7"])?);
        }
        sheet(&row, row.len())?.save(path).with_context(|| format!("cannot write {}", path.display()))
    }

    /// Returns a painting at each value of a look's key.
    fn painted_values(&mut self, picture: &KeyPicture, painting: Painting) -> anyhow::Result<Vec<RgbImage>> {
        let look = |value: &str| format!("{}={value}", picture.key);
        picture.values.iter().map(|value| self.paint(painting, PAINTING, &["--look", &look(value)])).collect()
    }

    fn paint(&mut self, painting: Painting, size: &str, options: &[&str]) -> anyhow::Result<RgbImage> {
        let Painting { model, bake, render } = painting;
        if !self.packages.contains_key(&(model, bake)) {
            let file = |kind: &str| workspace().join(format!("assets/{kind}")).display().to_string();
            let (glb, recipe) = (file(&format!("models/{model}.glb")), file(&format!("recipes/{model}.toml")));
            let mut arguments = vec![glb.as_str(), "--recipe", &recipe];
            arguments.extend(bake.split_whitespace());
            let name = format!("{model}{}", self.packages.len());
            self.packages.insert((model, bake), self.folder.bake(&name, &arguments)?);
        }
        let options: Vec<&str> = render.split_whitespace().chain(options.iter().copied()).collect();
        self.folder.paint(&self.packages[&(model, bake)], size, &options)
    }
}
