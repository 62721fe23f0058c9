//! Page of coats.

use pelage_bake::recipe::Coat;
use pelage_params::{Choice, Control, Field as _, wrap};

/// Returns a Markdown page of all coats: description, values set, and image.
///
/// * `has_picture`: whether the file of a path relative to the page's folder exists
pub(super) fn coats_page(has_picture: impl Fn(&str) -> bool) -> String {
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
    "A coat is a named kind of hair. Set it on the command line (`pelage bake fox.glb --set hair.coat=winter -o \
     fox.pelage`) or in a recipe (`coat = \"winter\"` in the table `[hair]`). It changes the defaults listed below. \
     All other keys keep the defaults of the [recipe reference](recipe.md), which describe the coat `animal`.",
    "Keys set in a recipe, wherever they are in the file, and keys set by `--set` override the coat. `--set \
     hair.coat=winter` after a recipe changes the keys that still have the value of the previous coat.",
    "Lengths follow from the model's size (`hair.length_per_radius`, `surface.tile_size_per_radius`); `hair.length_m` \
     and `surface.tile_size_m` set them in metres.",
    "This page is made from the files in `bake/src/recipe/coats/` by `cargo run --bin chores write-docs`.",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coats_page_lists_every_coat_and_existing_pictures() {
        let page = coats_page(|path| path == "pictures/coat_wool.png");
        for coat in &Coat::ALL[1..] {
            assert!(page.contains(&format!("\n## `{}`\n", coat.word())) && page.contains(coat.toml()), "{page}");
        }
        assert!(page.contains("\n## `wool`\n\nTightly curled"), "{page}");
        assert_eq!(page.matches("](pictures/").count(), 1);
        assert!(page.contains("](pictures/coat_wool.png)"));
        assert!(page.lines().all(|line| line.chars().count() <= 120), "{page}");
    }
}
