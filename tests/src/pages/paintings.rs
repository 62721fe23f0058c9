//! Paintings on the pages: models, options and cells of each picture.
//!
//! The program that draws them (`cargo run -p pelage-tests --bin chores -- key-pictures`) and the tests of the pages
//! read the tables below.

/// Painting in ink of a model in `assets/models`, baked with its recipe.
#[derive(Clone, Copy, Debug)]
pub struct Painting {
    /// Name of the model and of its recipe, without extension.
    pub model: &'static str,
    /// Options of `pelage bake`, separated by spaces.
    pub bake: &'static str,
    /// Options of `pelage render`, separated by spaces.
    pub render: &'static str,
}

impl Painting {
    /// Returns the painting of a model with options of `pelage bake` and of `pelage render`.
    pub const fn new(model: &'static str, bake: &'static str, render: &'static str) -> Self {
        Self { model, bake, render }
    }
}

/// Picture of several paintings.
#[derive(Clone, Copy, Debug)]
pub struct PaintingSheet {
    /// Name of the file in `bake/docs/pictures`, without extension.
    pub name: &'static str,
    /// Size of each painting, `WxH` in pixels.
    pub size: &'static str,
    /// Number of paintings in a row.
    pub columns: usize,
    /// Paintings, row by row.
    pub paintings: &'static [Painting],
    /// Pages that quote the options of all paintings.
    pub pages: &'static [&'static str],
}

impl PaintingSheet {
    /// Returns the path of the picture, relative to the folder of the pages.
    pub fn path(&self) -> String {
        format!("pictures/{}.png", self.name)
    }
}

/// Pictures of several paintings on the pages for artists.
pub const PAINTING_SHEETS: [PaintingSheet; 5] = [
    PaintingSheet {
        name: "ink",
        size: "300x330",
        columns: 3,
        paintings: &[
            Painting::new("hare", "", ""),
            Painting::new("hare", "", "--look gongbi"),
            Painting::new("hare", "", "--look xieyi"),
            Painting::new("hare", "", "--brush-dryness 1 --brush-width 2"),
            Painting::new("hare", "", "--brush-sheet silk --brush-ground 0"),
            Painting::new("hare", "--set hair.length_m=0.03 --set surface.tile_size_m=0.09", "--brush-tufts 150"),
        ],
        pages: &["artists.md", "artists.zh-CN.md"],
    },
    PaintingSheet {
        name: "painting",
        size: "400x340",
        columns: 3,
        paintings: &[Painting::new("hare", "", ""), Painting::new("ox", "", ""), Painting::new("crane", "", "")],
        pages: &["painting.md"],
    },
    PaintingSheet {
        name: "painting_styles",
        size: "300x240",
        columns: 4,
        paintings: &[
            Painting::new("ox", "", "--look gongbi"),
            Painting::new("ox", "", "--look xieyi"),
            Painting::new("ox", "", "--look dry"),
            Painting::new("ox", "", "--look wet"),
        ],
        pages: &["painting.md"],
    },
    PaintingSheet {
        name: "painting_seal",
        size: "400x340",
        columns: 2,
        paintings: &[
            Painting::new("crane", "", "--ink-seal assets/seals/fur.png"),
            Painting::new("hare", "", "--ink-seal assets/seals/fur.png:0.1,0.2,0.16 --brush-sheet silk"),
        ],
        pages: &["painting.md"],
    },
    PaintingSheet {
        name: "painting_heads",
        size: "300x260",
        columns: 4,
        paintings: &[
            Painting::new("hare", "", "--look-at head --orbit 40,5"),
            Painting::new("ox", "", "--look-at head --orbit 40,5"),
            Painting::new("pony", "", "--look-at head --orbit 40,5"),
            Painting::new("crane", "", "--look-at crown --orbit 40,5,0.3"),
        ],
        pages: &["painting.md"],
    },
];

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

    use super::PAINTING_SHEETS;
    use crate::binary::workspace;
    use pelage_stage::BUILT_IN_LOOKS;

    #[test]
    fn pages_quote_the_options_of_their_paintings() {
        for sheet in PAINTING_SHEETS {
            for page in sheet.pages {
                let text = std::fs::read_to_string(workspace().join("bake/docs").join(page)).unwrap();
                assert!(text.contains(&format!("]({})", sheet.path())), "{page} lacks {}", sheet.path());
                for options in sheet.paintings.iter().flat_map(|painting| [painting.bake, painting.render]) {
                    assert!(text.contains(options), "{page} lacks {options:?} of {}", sheet.path());
                }
            }
        }
    }

    #[test]
    fn picture_of_the_styles_shows_every_built_in_look() {
        let sheet = PAINTING_SHEETS.iter().find(|sheet| sheet.name == "painting_styles").unwrap();
        let drawn: Vec<&str> = sheet.paintings.iter().map(|painting| painting.render).collect();
        assert_eq!(drawn, BUILT_IN_LOOKS.map(|style| format!("--look {}", style.name)));
    }
}
