//! Cases of compressed models: streams of Draco and meshopt, and their descriptions in the glTF documents.

use super::bases::{Bases, glb, glb_of_text};
use super::case::{Case, Entry};
use super::change;
use super::models::bake;
use super::random::Random;

/// Creates a case. `bases` must contain compressed models.
pub fn case(bases: &Bases, turn: u64, random: &mut Random) -> Case {
    let (name, document, bin) = random.pick(&bases.packed);
    let (how, file) = if random.below(4) == 0 {
        let (how, text) = change::json(document, turn, random);
        (how, glb_of_text(&text, bin))
    } else {
        let mut bin = bin.clone();
        let mut how = change::bytes(&mut bin, random);
        if random.below(3) == 0 {
            how = format!("{how}, {}", change::bytes(&mut bin, random));
        }
        (how, glb(document, &bin))
    };
    Case::new(format!("{name}: {how}"), &[], vec![Entry::File("m.glb".into(), file)], bake("m.glb", &[], turn))
}
