//! Cases of texts that people write: recipes, scenes and looks.

use super::bases::{Bases, LOOK, SCENE};
use super::case::{Case, Entry, OutputCheck, Step};
use super::change;
use super::random::Random;

/// Creates a case. Recipes are twice as frequent as scenes and looks, which take longer if they are valid.
pub fn case(bases: &Bases, turn: u64, random: &mut Random) -> Case {
    match random.below(6) {
        0..=3 => recipe(bases, turn, random),
        4 => {
            let (how, text) = change::toml(SCENE, turn, random);
            let step = Step::makes(&["render", "s.toml", "-o", "a.png"], "a.png", OutputCheck::Nothing);
            render_case(bases, format!("scene: {how}"), Entry::file("s.toml", text), step)
        }
        _ => {
            let style = *random.pick(&["fur", "ink"]);
            let (how, text) = change::toml(&LOOK.replace("\"fur\"", &format!("{style:?}")), turn, random);
            let args = ["render", "a.pelage", "-o", "a.png", "--look", "l.toml"];
            render_case(
                bases,
                format!("look: {how}"),
                Entry::file("l.toml", text),
                Step::makes(&args, "a.png", OutputCheck::Nothing),
            )
        }
    }
}

fn recipe(bases: &Bases, turn: u64, random: &mut Random) -> Case {
    let (name, base) = random.pick(&bases.recipes);
    let (mut how, mut text) = change::toml(base, turn, random);
    if random.below(4) == 0 {
        let more = change::toml(&text, random.next_u64(), random);
        how = format!("{how}, {}", more.0);
        text = more.1;
    }
    let base = [bases.images(), bases.guides.clone(), vec![bases.glb()]].concat();
    let args = ["bake", "m.glb", "-o", "out.pelage", "--threads", "1", "--recipe", "r.toml"];
    let step = Step::makes(&args, "out.pelage", OutputCheck::Validates);
    Case::new(format!("recipe {name}: {how}"), &base, vec![Entry::file("r.toml", text)], vec![step])
}

fn render_case(bases: &Bases, how: String, text: Entry, step: Step) -> Case {
    let package = bases.packages.iter().find(|(name, _)| *name == "plain").map(|(_, bytes)| bytes.clone());
    let package = Entry::File("a.pelage".into(), package.unwrap_or_default());
    Case::new(how, &[package], vec![text], vec![step])
}
