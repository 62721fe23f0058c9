//! Images that show the effect of the most important keys: one animal with three values of each key.
//!
//! The reference pages, their tests and the program that renders the images (`cargo run -p pelage-tests --bin chores --
//! key-pictures`) all read the table below. So captions and images always agree.

use super::paintings::Painting;

/// Key and three values of it, each rendered with all other keys at their defaults.
#[derive(Clone, Copy, Debug)]
pub struct KeyPicture {
    /// Name of the key, such as `hair.density`.
    pub key: &'static str,
    /// Values from left to right, in TOML.
    pub values: [&'static str; 3],
    /// Subject of the image.
    pub view: KeyView,
}

/// Subject of the image of a key.
#[derive(Clone, Copy, Debug)]
pub enum KeyView {
    /// Whole hare without a recipe, in fur. The key is one of a recipe.
    Whole,
    /// Shoulder of the hare without a recipe, in fur; single hairs are visible. The key is one of a recipe.
    Shoulder,
    /// Painting in ink. The key is one of a look.
    Ink(Painting),
}

const fn whole(key: &'static str, values: [&'static str; 3]) -> KeyPicture {
    KeyPicture { key, values, view: KeyView::Whole }
}

const fn close(key: &'static str, values: [&'static str; 3]) -> KeyPicture {
    KeyPicture { key, values, view: KeyView::Shoulder }
}

const fn ink(key: &'static str, values: [&'static str; 3], model: &'static str, view: &'static str) -> KeyPicture {
    KeyPicture { key, values, view: KeyView::Ink(Painting::new(model, "", view)) }
}

impl KeyPicture {
    /// Returns the path of the image, relative to the folder of the reference page.
    pub fn path(&self) -> String {
        format!("pictures/key_{}.png", self.key.replace('.', "_"))
    }

    /// Returns the image as Markdown for a page.
    pub fn markdown(&self) -> String {
        format!("![{}: {}]({})", self.key, self.values.join(", ").replace('"', ""), self.path())
    }
}

/// Keys with the largest effect on the look of fur, in the order of the reference page.
pub const KEY_PICTURES: [KeyPicture; 14] = [
    close("surface.tile_size_per_radius", ["0.1", "0.15", "0.4"]),
    whole("surface.comb_direction", ["[0, -0.35, -1]", "[0, -1, 0]", "[0, 1, 0]"]),
    close("hair.style", ["\"curly\"", "\"messy\"", "\"wet\""]),
    close("hair.density", ["100", "600", "1600"]),
    whole("hair.length_per_radius", ["0.02", "0.05", "0.2"]),
    close("hair.length_variation", ["0", "0.5", "0.9"]),
    close("hair.root_radius", ["0.002", "0.0065", "0.025"]),
    close("hair.lean", ["0.1", "0.65", "1"]),
    close("hair.frizz", ["0", "0.4", "1"]),
    close("hair.dry_clump", ["0", "0.25", "0.9"]),
    close("underfur.density", ["0", "700", "1600"]),
    whole("groom.by_body", ["0", "0.5", "1"]),
    close("color.band", ["\"#ffffff\"", "\"#c08040\"", "\"#201810\""]),
    close("color.variation", ["0", "0.35", "0.8"]),
];

const SIDE: &str = "--orbit 80,8";
const FLANK: &str = "--orbit 60,8,1.9";
const HEAD: &str = "--look-at head --orbit 60,5,1.1";

/// Keys of a look that change how ink is painted, in the order of the reference page.
pub const INK_KEY_PICTURES: [KeyPicture; 14] = [
    ink("ink.pressure", ["0", "0.5", "1"], "ox", HEAD),
    ink("ink.color", ["auto", "120,30,20", "20,50,110"], "ox", SIDE),
    ink("ink.paper_grain", ["0", "0.5", "1"], "crane", "--look-at crown --orbit 60,5,0.3"),
    ink("ink.mist_m", ["none", "[3, 6]", "[2, 4.5]"], "ox", ""),
    ink("brush.strokes", ["4", "60", "200"], "ox", SIDE),
    ink("brush.wash", ["0", "1", "2"], "ox", SIDE),
    ink("brush.wetness", ["0", "0.6", "1"], "ox", FLANK),
    ink("brush.dryness", ["0", "0.5", "1"], "ox", HEAD),
    KeyPicture {
        key: "brush.tufts",
        values: ["0", "45", "200"],
        view: KeyView::Ink(Painting::new("ox", "--set hair.length_m=0.1 --set surface.tile_size_m=0.5", "")),
    },
    ink("brush.line_width", ["0", "1", "4"], "hare", "--look-at head --orbit 50,5"),
    ink("brush.omission", ["0", "0.5", "1"], "ox", ""),
    ink("brush.ground", ["0", "0.5", "1"], "crane", "--orbit 60,15"),
    ink("brush.sheet", ["raw", "sized", "silk"], "ox", FLANK),
    ink("brush.progress", ["0.2", "0.55", "1"], "ox", ""),
];

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

    use super::{INK_KEY_PICTURES, KEY_PICTURES};
    use crate::binary::workspace;
    use pelage_bake::recipe::{Recipe, keys};
    use pelage_params::{Knob, knobs};
    use pelage_stage::Look;

    #[test]
    fn every_key_picture_uses_a_valid_key_and_values() {
        let order: Vec<String> = keys().map(|knob| knob.name.to_owned()).collect();
        let places: Vec<usize> =
            KEY_PICTURES.iter().map(|picture| order.iter().position(|name| name == picture.key).unwrap()).collect();
        assert!(places.is_sorted(), "not in the order of the page: {places:?}");
        for picture in KEY_PICTURES {
            let drawn = picture.values.map(|value| {
                let mut recipe = Recipe::default();
                recipe.set(&format!("{}={value}", picture.key)).unwrap();
                recipe.validate().unwrap();
                recipe.to_toml()
            });
            assert!(drawn[0] != drawn[1] && drawn[1] != drawn[2] && drawn[0] != drawn[2], "{}", picture.key);
        }
    }

    #[test]
    fn every_knob_of_the_brush_has_a_picture_of_valid_values() {
        let knobs: Vec<&Knob> = knobs::<Look>().collect();
        let place = |key: &str| knobs.iter().position(|knob| knob.name == key);
        let places: Vec<usize> = INK_KEY_PICTURES.iter().map(|picture| place(picture.key).unwrap()).collect();
        assert!(places.is_sorted(), "not in the order of the page: {places:?}");
        for knob in knobs.iter().filter(|knob| knob.name.starts_with("brush.")) {
            assert!(INK_KEY_PICTURES.iter().any(|picture| picture.key == knob.name), "no picture of {}", knob.name);
        }
        for picture in INK_KEY_PICTURES {
            let looks = picture.values.map(|value| {
                let mut look = Look::default();
                look.set(&format!("{}={value}", picture.key)).unwrap();
                look.validate().unwrap();
                look
            });
            let [a, b, c] = &looks;
            assert!(a != b && b != c && a != c, "{}: equal values", picture.key);
            assert!(looks.contains(&Look::default()), "{}: no default", picture.key);
        }
    }

    #[test]
    fn the_page_on_painting_shows_every_key_picture_in_ink() {
        let page = std::fs::read_to_string(workspace().join("bake/docs/painting.md")).unwrap();
        for picture in INK_KEY_PICTURES {
            assert!(page.contains(&picture.markdown()), "bake/docs/painting.md lacks {}", picture.markdown());
        }
    }
}
