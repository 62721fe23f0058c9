//! Reference pages that are generated from the code: recipes and coats, looks, the command line and its JSON schemas.

mod coats;
mod key_pictures;
mod paintings;

pub use key_pictures::{INK_KEY_PICTURES, KEY_PICTURES, KeyPicture, KeyView};
pub use paintings::{PAINTING_SHEETS, Painting, PaintingSheet};

use crate::binary::{Sandbox, workspace};
use pelage_bake::recipe::Recipe;
use pelage_params::{reference_page, wrap};
use pelage_stage::{BUILT_IN_LOOKS, Look, SAMPLES, SHORT_FORMS};
use serde_json::Value;
use std::path::PathBuf;

/// Returns the path and text of every page.
///
/// # Panics
/// If the binary does not describe its command line.
pub fn pages() -> Vec<(PathBuf, String)> {
    let run = Sandbox::new().with_lab().run(&["commands-page", "--json"]);
    assert_eq!(run.code, Some(0), "{run:?}");
    let said: Value = serde_json::from_str(&run.stdout).unwrap_or_else(|e| panic!("{e}: {run:?}"));
    let page = |name: &str, text: String| (workspace().join("bake/docs").join(name), text);
    vec![
        page("commands.md", format!("{}\n", said["page"].as_str().unwrap_or_default().trim_end())),
        page("schemas.json", format!("{:#}\n", said["schemas"])),
        page("recipe.md", recipe_page()),
        page("coats.md", coats::coats_page(|picture| workspace().join("bake/docs").join(picture).exists())),
        page("look.md", look_page()),
    ]
}

/// Returns the recipe reference. For every key, it gives meaning, default, type and range, and the image if the key is
/// in [`KEY_PICTURES`].
fn recipe_page() -> String {
    reference_page::<Recipe>("Recipe reference", &RECIPE_INTRODUCTION, |key| {
        KEY_PICTURES.iter().find(|picture| picture.key == key).map(KeyPicture::markdown)
    })
}

const RECIPE_INTRODUCTION: [&str; 4] = [
    "A recipe is a TOML file that describes how a model becomes furry: `pelage bake fox.glb --recipe fox.toml -o \
     fox.pelage`. It has a table for each stage of the bake and a key for each parameter. Keys that are left out keep \
     their defaults, so an empty recipe gives the coat `animal`; `hair.coat` selects another one ([coats](coats.md)). \
     `--set hair.length_m=0.02` sets one key on the command line and overrides the recipe. A table or key that does \
     not exist is an error, which names the line and the nearest key that does.",
    "Lengths end in `_m` and are metres, angles end in `_deg`, widths on screen in `_px`. Where a default is \"left \
     out\", the bake chooses the value from the model. `pelage unpack` writes out the recipe that a package was baked \
     with.",
    "The pictures show the hare from `assets/models`, baked with the default recipe and three values of one key.",
    "This page is made from the declarations in `bake/src/recipe/` by `cargo run --bin chores write-docs`.",
];

/// Returns the reference of looks: every key, the built-in looks, and the flags that set keys.
fn look_page() -> String {
    let mut page = reference_page::<Look>("Look reference", &LOOK_INTRODUCTION, |key| {
        INK_KEY_PICTURES.iter().find(|picture| picture.key == key).map(KeyPicture::markdown)
    });
    page += "\n## Built-in looks\n\n";
    page += &format!("{}\n\n", wrap("", BUILT_IN_INTRODUCTION));
    for style in BUILT_IN_LOOKS {
        page += &format!("### `{}`\n\n{}\n\n```toml\n{}```\n\n", style.name, wrap("", style.about), style.text);
    }
    page += "## Flags\n\n";
    for short in SHORT_FORMS.iter().chain([&SAMPLES]) {
        page += &format!("- `--{} <{}>` sets `{}`.\n", short.flag, short.value_name, short.key);
    }
    page
}

const BUILT_IN_INTRODUCTION: &str = "`--look gongbi` sets the keys of a built-in look, and later options change them. \
     All are styles of ink painting; [painting](painting.md) shows them.";

const LOOK_INTRODUCTION: [&str; 3] = [
    "A look is everything about a picture except the models in it, the camera and the time: light, shadows, how much \
     of the fur is drawn, the ink style. `--look look.toml` reads one from a file, and `--look shadow.penumbra=0.3` \
     sets one key; both may be given several times, and later ones win. A scene file has a look in its table \
     `[look]`, as in `[look.shadow]`, or names a file: `look = \"look.toml\"`. Keys that a look leaves out keep their \
     defaults. A table or key that does not exist is an error, which names the line and the nearest key that does.",
    "Some keys have a flag as a short form, such as `--penumbra 0.3`. Flags override looks, later looks override \
     earlier ones, and looks override a scene file.",
    "This page is made from the declarations in `runtime/stage/src/look/` by `cargo run --bin chores write-docs`.",
];
