//! Images that show the effect of the most important keys: one animal with three values of each key.
//!
//! The reference page and the program that renders the images (`cargo run -p pelage-tests --bin chores --
//! key-pictures`) both read the table below. So captions and images always agree.

/// Key and three values of it, each rendered on the hare with all other keys at their defaults.
#[derive(Clone, Copy, Debug)]
pub struct KeyPicture {
    /// Name of the key, such as `hair.density`.
    pub key: &'static str,
    /// Values from left to right, in TOML.
    pub values: [&'static str; 3],
    /// Whether the image shows the whole animal. Otherwise, it shows only the shoulder, at which single hairs are
    /// visible.
    pub whole: bool,
}

const fn whole(key: &'static str, values: [&'static str; 3]) -> KeyPicture {
    KeyPicture { key, values, whole: true }
}

const fn close(key: &'static str, values: [&'static str; 3]) -> KeyPicture {
    KeyPicture { key, values, whole: false }
}

impl KeyPicture {
    /// Returns the path of the image, relative to the folder of the reference page.
    pub fn path(&self) -> String {
        format!("pictures/key_{}.png", self.key.replace('.', "_"))
    }

    /// Returns the image as Markdown for the reference page.
    pub(super) fn markdown(&self) -> String {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

    use super::KEY_PICTURES;
    use pelage_bake::recipe::{Recipe, keys};

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
}
