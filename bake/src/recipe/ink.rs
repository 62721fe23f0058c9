//! `[ink]`: the model as an ink-wash painting.

use super::maps::{FilePath, ScalarMap};
use super::material_groom::SHARE;
use super::named_table::named_table;
use pelage_formats::InkShading;
use pelage_params::{PowerOfTwo, Range, params, words};

/// Range of coordinates.
const PLACE: Range<f32> = -1e6..=1e6;

words! {
    /// What the skin of a material is painted with.
    InkFill {
        /// Left as the paper is.
        Blank = "blank",
        /// Washed.
        #[default]
        Wash = "wash",
        /// Full dark ink.
        Solid = "solid",
    }
}

named_table! {
    /// The ink of the materials that `name` matches: what is given here stands in for what `[ink]` says. Later tables win.
    MaterialInk of "a material" {
        /// `blank` leaves the paper white, `wash` washes, `solid` is full dark ink.
        fill: InkFill, in ();
        /// As `ink.center`, for the wash of these materials alone.
        center: [f32; 3], in PLACE;
        /// Share of the wash, or of the full ink where `fill` is `solid`.
        amount: ScalarMap, in SHARE;
        /// As `ink.lines`.
        line: ScalarMap, in SHARE;
    }
}

params! {
    /// `[ink]`: the model as an ink-wash painting after Fang 2006. A map is as in `[groom]`, read at the vertices.
    InkParams in ink {
        /// Whether the package can be drawn in ink.
        enabled: bool = true;
        /// Seed of everything random in stroke, wash, paper and fur.
        seed: u64 = 1, in 0..=i64::MAX as u64;
        /// CP of Fang 2006, §3, where the wash is darkest: a place on the model at rest, metres. Left out, it is chosen so that the wash
        /// varies most over the skin, dark above and pale below.
        center: Option<[f32; 3]> = None, in PLACE;
        /// a of Fang 2006, §3: how fast the wash fades away from the centre. The model's size does not matter.
        speed: f32 = InkShading::default().wash_speed, in 0.0..=100.0;
        /// b of Fang 2006, §3: grey at the centre, 0 black to 1 white; below 0 all about it is black.
        range: f32 = InkShading::default().wash_range, in -4.0..=4.0;
        /// Whether the wash follows the angle to the centre alone, as the paper's abstract has it, and not the printed product.
        normalised: bool = InkShading::default().normalised;
        /// Share of the wash texture in the wash: 0 smooth, 1 as blotchy as the texture.
        grain: f32 = InkShading::default().grain, in SHARE;
        /// Period of the wash texture on the skin, metres. Left out, it is chosen from the model's size.
        grain_size_m: Option<f32> = None, in 1e-6..=1e3;
        /// Share of the base colour's darkness that the wash takes on: 0 none, 1 a black cat is black.
        tone: f32 = InkShading::default().tone, in SHARE;
        /// Strength of the strokes of fur. Left out, it is 1 where the model has a skeleton or the recipe says something of its fur
        /// (`[hair]`, `[groom]`, `[color]`, `[fins]`, `model.bare`), and 0 where nothing does: a scan of stone grows no hair.
        fur: Option<f32> = None, in SHARE;
        /// Factor on the width of lines.
        line: f32 = InkShading::default().line, in InkShading::LINE;
        /// Share of the wash: 0 leaves the paper blank.
        wash: ScalarMap = ScalarMap::Constant(1.0), in SHARE;
        /// Share of full dark ink.
        solid: ScalarMap = ScalarMap::Constant(0.0), in SHARE;
        /// Share of the lines' width: 0 none, 1 as wide as they come.
        lines: ScalarMap = ScalarMap::Constant(1.0), in SHARE;
        /// The same for single materials: `[[ink.material]]` with a `name`, in which `*` stands for any characters and `?` for one, and any
        /// of `fill`, `center`, `amount` and `line`. Later ones win.
        material: Vec<MaterialInk> = Vec::new();
        /// A scanned stroke in place of the painted one: an image of one stroke that runs from left to right, its outer edge above. The path is
        /// from the recipe's folder.
        stroke_image: Option<FilePath> = None;
        /// Width of the stroke at the outline, as a share of the radius of the body that it goes round.
        stroke_width: f32 = 0.09, in 0.01..=0.9;
        /// How much the stroke swells and thins, and how uneven its edge is.
        stroke_variation: f32 = 0.5, in SHARE;
        /// How dry the brush is in its dry form: 0 wet, 1 mostly bristles.
        stroke_dryness: f32 = 0.4, in SHARE;
        /// Width and height of the stroke texture, texels.
        stroke_texels: u32 = 256, in 32..=2048, as PowerOfTwo;
        /// A painting, or a part of one, that the grain and blotches of the wash are taken from. The path is from the recipe's folder.
        wash_image: Option<FilePath> = None;
        /// How strongly ink gathers where a wash dries: 0 soft blotches, 1 dark marks round them.
        wash_edges: f32 = 0.5, in SHARE;
        /// Width and height of the wash texture, texels.
        wash_texels: u32 = 256, in 32..=2048, as PowerOfTwo;
        /// How many fibres the paper shows: 0 none, 1 coarse mulberry paper.
        paper_fibres: f32 = 0.5, in SHARE;
        /// How unevenly the paper draws ink in: 0 sized, 1 raw.
        paper_absorbency: f32 = 0.5, in SHARE;
        /// How dark flecks and coloured fibres in the paper are.
        paper_tone: f32 = 0.4, in SHARE;
        /// Width and height of the paper texture, texels.
        paper_texels: u32 = 256, in 32..=2048, as PowerOfTwo;
        /// Width and height of the strokes of fur in a tile of hair, texels.
        fur_texels: u32 = 256, in 32..=2048, as PowerOfTwo;
    }
}
