//! Pairs of pictures that a person has ranked. They calibrate the error measure of a bake with limits.

use crate::binary::workspace;
use pelage_bake::io;
use pelage_bake::picture::Picture;
use pelage_truth::likeness::Likeness;
use std::path::{Path, PathBuf};

/// Ranked pair of settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pair {
    /// Name of the animal.
    pub animal: String,
    /// Setting whose picture is closer to the reference image, in the form `layers_texels_fins`.
    pub better: String,
    /// Setting whose picture is less close to the reference image, in the form `layers_texels_fins`.
    pub worse: String,
}

/// Height of the longest hair in the stored pictures, pixels. A larger value gives the same error: beyond the hair both
/// pictures are empty, and within the body both are covered.
pub const FUR_PX: f64 = 8.0;

/// Returns the folder of the stored pictures.
pub fn folder() -> PathBuf {
    workspace().join("tests/golden/likeness")
}

/// Reads all pairs of `pairs.txt`.
///
/// # Panics
///
/// If the file is missing, or a line is malformed.
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

/// Returns the settings of an animal that occur in a pair, sorted and without duplicates.
pub fn settings(animal: &str) -> Vec<String> {
    let of = pairs().into_iter().filter(|pair| pair.animal == animal);
    let mut all: Vec<String> = of.flat_map(|pair| [pair.better, pair.worse]).collect();
    all.sort();
    all.dedup();
    all
}

/// Compares the picture `drawn` with the reference image `truth`.
///
/// * `fur_px`: height of the fur, pixels
///
/// # Panics
///
/// If a picture is missing, or the sizes differ.
pub fn likeness(drawn: &Path, truth: &Path, fur_px: f64) -> Likeness {
    let read = |path: &Path| -> Picture { io::read_picture(path).unwrap_or_else(|e| panic!("{e}")) };
    Likeness::of(&read(drawn), &read(truth), fur_px).unwrap_or_else(|e| panic!("{}: {e}", drawn.display()))
}
