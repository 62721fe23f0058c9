//! Coats: kinds of hair by name, each a set of other defaults.
//!
//! A coat is a piece of a recipe, a file in `coats/` beside this one. What it says takes the place of a key's default, so that whatever a recipe says
//! itself still counts. `animal` is the defaults as they are declared, and has no file.

use pelage_params::{Choice, Control, Field, ParamError, Tables, knobs, read, words, wrap};

words! {
    /// Kinds of hair that a recipe can begin with.
    Coat {
        /// The defaults as this page gives them: underfur below guard hairs, short on face and legs and long on neck and tail, as of a fox or a dog.
        #[default]
        Animal = "animal",
        /// One thick coat as long everywhere, as of a toy; what recipes began with before there were coats.
        Natural = "natural",
        /// Close and smooth, combed along the body, as of a boxer or a horse in summer.
        Short = "short",
        /// Dense, even and upright, as of a mole or a toy.
        Plush = "plush",
        /// Long uneven hair that hangs, as of a highland cow.
        Shaggy = "shaggy",
        /// Curls on curls, as of a sheep or an alpaca.
        Wool = "wool",
        /// Coarse and stiff in all directions, as of a terrier or a boar.
        Wire = "wire",
        /// Long, fine and very dense, as of a wolf in snow.
        Winter = "winter",
        /// Gathered into dark shining locks, as of whatever came out of the water.
        Wet = "wet",
    }
}

impl Coat {
    /// What it says, as a piece of a recipe in TOML; nothing for [`Coat::Animal`].
    pub fn toml(self) -> &'static str {
        match self {
            Self::Animal => "",
            Self::Natural => include_str!("coats/natural.toml"),
            Self::Short => include_str!("coats/short.toml"),
            Self::Plush => include_str!("coats/plush.toml"),
            Self::Shaggy => include_str!("coats/shaggy.toml"),
            Self::Wool => include_str!("coats/wool.toml"),
            Self::Wire => include_str!("coats/wire.toml"),
            Self::Winter => include_str!("coats/winter.toml"),
            Self::Wet => include_str!("coats/wet.toml"),
        }
    }
}

/// Changes what a recipe has from its coat: a key that has the value of `before` gets that of `after`, every other stays.
///
/// # Errors
/// What is wrong with the file of a coat.
pub(super) fn change<S: Tables>(recipe: &mut S, before: Coat, after: Coat) -> Result<(), ParamError> {
    let with = |coat: Coat| {
        let mut recipe = S::default();
        read(&mut recipe, coat.toml()).map(|()| recipe)
    };
    let (old, new) = (with(before)?, with(after)?);
    let mut changed = String::new();
    for knob in knobs::<S>().filter(|knob| knob.value(recipe) == knob.value(&old)) {
        if let Some(value) = knob.value(&new).filter(|value| knob.value(&old).as_ref() != Some(value)) {
            changed += &format!("{} = {value}\n", knob.name);
        }
    }
    read(recipe, &changed)
}

/// Every coat as a page of Markdown: what it is, what it sets, and its picture.
///
/// * `has_picture`: whether a file of that path, from the page's folder, is there to be shown
pub fn coats_page(has_picture: impl Fn(&str) -> bool) -> String {
    let mut page = "# Coats\n".to_owned();
    for paragraph in INTRODUCTION {
        page += &format!("\n{}\n", wrap("", paragraph));
    }
    let choices: &[Choice] = match Coat::control(&()) {
        Control::Choice(choices) => choices,
        _ => &[],
    };
    for (coat, choice) in Coat::ALL.iter().zip(choices).filter(|(coat, _)| !coat.toml().is_empty()) {
        let name = coat.word();
        page += &format!("\n## `{name}`\n\n{}\n\n", wrap("", choice.doc.trim()));
        let picture = format!("pictures/coat_{name}.png");
        if has_picture(&picture) {
            page += &format!("![Animals in the coat {name}]({picture})\n\n");
        }
        page += &format!("```toml\n{}```\n", coat.toml());
    }
    page
}

const INTRODUCTION: [&str; 4] = [
    "A coat is a kind of hair by name: `pelage bake fox.glb --set hair.coat=winter -o fox.pelage`, or in a recipe `coat = \"winter\"` in the table \
     `[hair]`. It gives other defaults, which stand below; all other keys have those of the [recipe reference](recipe.md), which are the coat `animal`.",
    "What a recipe says itself counts, wherever in the file it stands, and so does `--set`. `--set hair.coat=winter` after a recipe changes the \
     keys that still have the value of the coat before.",
    "Lengths follow from the model's size (`hair.length_per_radius`, `surface.tile_size_per_radius`); `hair.length_m` and `surface.tile_size_m` \
     say them in metres.",
    "This page is made from the files in `bake/src/recipe/coats/` by `cargo run -p pelage-tests --bin chores -- write-docs`.",
];

#[cfg(test)]
#[path = "coats_tests.rs"]
mod tests;
