//! Coats: named kinds of hair, each a set of defaults.
//!
//! A coat is a partial recipe in a file in `coats/` beside this one. Its values replace the defaults of keys, so keys
//! that a recipe sets take precedence. The coat `animal` has no file: it consists of the declared defaults.

use pelage_params::{ParamError, Tables, knobs, read, words};

words! {
    /// Kinds of hair that a recipe can start from.
    Coat {
        /// Default values of the recipe reference: underfur below guard hair, short on face and legs, long on neck and
        /// tail, like a fox or a dog.
        #[default]
        Animal = "animal",
        /// Thick hair of the same length everywhere, like a toy. Recipes were based on it before coats existed.
        Natural = "natural",
        /// Short and smooth, combed along the body, like a boxer or a horse in summer.
        Short = "short",
        /// Dense, even and upright, like a mole or a toy.
        Plush = "plush",
        /// Long, uneven and hanging, like a highland cow.
        Shaggy = "shaggy",
        /// Tightly curled, like a sheep or an alpaca.
        Wool = "wool",
        /// Coarse and stiff in all directions, like a terrier or a boar.
        Wire = "wire",
        /// Long, fine and very dense, like a wolf in winter.
        Winter = "winter",
        /// Gathered into dark, shiny locks, like an animal that comes out of the water.
        Wet = "wet",
    }
}

impl Coat {
    /// Returns the coat's values as a partial recipe in TOML; empty for [`Coat::Animal`].
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

/// Changes the coat of a recipe: keys that have the value of coat `before` get that of coat `after`, all others keep
/// theirs.
///
/// Fails with the error in the file of a coat.
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

#[cfg(test)]
#[path = "coats_tests.rs"]
mod tests;
