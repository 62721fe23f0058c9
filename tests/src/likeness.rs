//! Pairs of pictures that a person ranked, which the error of a bake with limits is calibrated on.

use crate::binary::workspace;
use pelage_bake::io;
use pelage_bake::picture::Picture;
use pelage_truth::likeness::Likeness;
use std::path::{Path, PathBuf};

/// One setting looks more like the truth than another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pair {
    /// Whose pictures.
    pub animal: String,
    /// The setting that a person prefers, `layers_texels_fins`.
    pub better: String,
    /// The other one.
    pub worse: String,
}

/// Height of the fur in the stored pictures, pixels: that of the longest hair. Beyond the hair both pictures are empty and within the body both are
/// covered, so that more than enough changes no error.
pub const FUR_PX: f64 = 8.0;

/// Where the pictures are.
pub fn folder() -> PathBuf {
    workspace().join("tests/golden/likeness")
}

/// All pairs of `pairs.txt`.
///
/// # Panics
///
/// Where the file is not there, or a line is no pair.
pub fn pairs() -> Vec<Pair> {
    let path = folder().join("pairs.txt");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let lines = text.lines().filter(|line| !line.starts_with('#') && !line.is_empty());
    let pair = |line: &str| match line.split(' ').collect::<Vec<_>>()[..] {
        [animal, better, worse] => Pair { animal: animal.into(), better: better.into(), worse: worse.into() },
        _ => panic!("{}: {line:?}, expected animal, better, worse", path.display()),
    };
    lines.map(pair).collect()
}

/// The settings of an animal that a pair names, and the arguments of `pelage bake --set` that each stands for.
pub fn settings(animal: &str) -> Vec<String> {
    let of = pairs().into_iter().filter(|pair| pair.animal == animal);
    let mut all: Vec<String> = of.flat_map(|pair| [pair.better, pair.worse]).collect();
    all.sort();
    all.dedup();
    all
}

/// The likeness of one picture of the folder to another.
///
/// * `fur_px`: height of the fur, pixels
///
/// # Panics
///
/// Where a picture is not there, or they are of two sizes.
pub fn likeness(drawn: &Path, truth: &Path, fur_px: f64) -> Likeness {
    let read = |path: &Path| -> Picture { io::read_picture(path).unwrap_or_else(|e| panic!("{e}")) };
    Likeness::of(&read(drawn), &read(truth), fur_px).unwrap_or_else(|e| panic!("{}: {e}", drawn.display()))
}
