//! Reference page of looks.

use super::short::{SAMPLES, SHORT_FORMS};
use super::tables::Look;

const INTRODUCTION: [&str; 3] = [
    "A look is everything about a picture but who stands in it, where the camera is and what time it is: light, shadows, how much of the fur is drawn, \
     the ink style. `--look look.toml` reads one from a file, and `--look shadow.penumbra=0.3` sets one key; both may be given several times, \
     and later ones win. A scene file has it in its table `[look]`, as in `[look.shadow]`, or names a file: `look = \"look.toml\"`. What a look leaves \
     out keeps its default. A table or key that does not exist is an error, which names the line and the nearest key that does.",
    "Some keys have a flag as a short form, such as `--penumbra 0.3`. A scene file counts least, then looks in their order, and flags most.",
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
