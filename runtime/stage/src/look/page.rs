//! Reference page of looks.

use super::short::{SAMPLES, SHORT_FORMS};
use super::tables::Look;

const INTRODUCTION: [&str; 3] = [
    "A look is everything about a picture except the models in it, the camera and the time: light, shadows, how much \
     of the fur is drawn, the ink style. `--look look.toml` reads one from a file, and `--look shadow.penumbra=0.3` \
     sets one key; both may be given several times, and later ones win. A scene file has a look in its table \
     `[look]`, as in `[look.shadow]`, or names a file: `look = \"look.toml\"`. Keys that a look leaves out keep their \
     defaults. A table or key that does not exist is an error, which names the line and the nearest key that does.",
    "Some keys have a flag as a short form, such as `--penumbra 0.3`. Flags override looks, later looks override \
     earlier ones, and looks override a scene file.",
    "This page is made from the declarations in `runtime/stage/src/look/` by `cargo run --bin chores write-docs`.",
];

impl Look {
    /// Returns a Markdown page that documents every key of a look.
    pub fn reference_page() -> String {
        let mut page = pelage_params::reference_page::<Self>("Look reference", &INTRODUCTION, |_| None);
        page += "\n## Flags\n\n";
        for short in SHORT_FORMS.iter().chain([&SAMPLES]) {
            page += &format!("- `--{} <{}>` sets `{}`.\n", short.flag, short.value_name, short.key);
        }
        page
    }
}
