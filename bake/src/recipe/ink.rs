//! `[ink]`: the model as an ink-wash painting.

use super::maps::{FilePath, ScalarMap};
use super::material_groom::SHARE;
use super::named_table::named_table;
use pelage_formats::InkShading;
use pelage_params::{PowerOfTwo, Range, params, words};

/// Range of coordinates.
const PLACE: Range<f32> = -1e6..=1e6;

words! {
    /// Paint of a material.
    InkFill {
        /// White paper.
        Blank = "blank",
        /// Wash.
        #[default]
        Wash = "wash",
        /// Full dark ink.
        Solid = "solid",
    }
}

named_table! {
    /// Ink settings of the materials that `name` matches; they override `[ink]`. Later tables take precedence.
    MaterialInk of "a material" {
        /// Paint: `blank` leaves the paper white, `wash` applies the wash, `solid` is full dark ink.
        fill: InkFill, in ();
        /// Overrides `ink.center` for these materials.
        center: [f32; 3], in PLACE;
        /// Strength of the wash, or of the dark ink if `fill` is `solid`.
        amount: ScalarMap, in SHARE;
        /// Overrides `ink.lines`.
        line: ScalarMap, in SHARE;
    }
}

params! {
    /// `[ink]`: the model as an ink-wash painting. Only `enabled`, `seed`, `wash`, `solid`, `lines`, `material`,
    /// `paper_fibres`, `paper_tone` and `paper_texels` affect brush strokes; all keys affect lines found in pixels
    /// (Fang 2006, `--ink-lines pixels`). Maps have the same form as in `[groom]` and are read at the vertices.
    InkParams in ink, needs "ink.enabled=true" {
        /// Whether the package supports the ink style.
        enabled: bool = true;
        /// Random seed of stroke, wash, paper and fur strokes.
        seed: u64 = 1, in 0..=i64::MAX as u64;
        /// Point at which the wash is darkest, CP in Fang 2006, §3, metres on the model at rest. If left out, it is
        /// chosen such that the wash varies most over the mesh surface, dark above and pale below.
        center: Option<[f32; 3]> = None, in PLACE;
        /// Rate at which the wash fades with distance from the centre, a in Fang 2006, §3. It is independent of the
        /// model's size.
        speed: f32 = InkShading::default().wash_speed, in 0.0..=100.0;
        /// Grey at the centre, b in Fang 2006, §3: 0 black to 1 white. Below 0, the surroundings are black too.
        range: f32 = InkShading::default().wash_range, in -4.0..=4.0;
        /// Whether the wash depends only on the angle between the surface normal and the direction from the centre, as
        /// the abstract of Fang 2006 says. Otherwise, it depends on the product in §3, which also contains the
        /// distance.
        normalised: bool = InkShading::default().normalised;
        /// Weight of the wash texture in the wash: 0 is smooth, 1 as blotchy as the texture.
        grain: f32 = InkShading::default().grain, in SHARE;
        /// Period of the wash texture on the mesh surface, metres. If left out, it is chosen from the model's size.
        grain_size_m: Option<f32> = None, in 1e-6..=1e3;
        /// Share of the base colour's darkness that the wash adopts: with 0 it ignores the base colour; with 1 a black
        /// cat is black.
        tone: f32 = InkShading::default().tone, in SHARE;
        /// Strength of the fur strokes. If left out, it is 1 if the model has a skeleton or the recipe sets
        /// `model.bare` or any key of `[hair]`, `[groom]`, `[color]` or `[fins]`. Otherwise it is 0, because a scan of
        /// a stone has no hair.
        fur: Option<f32> = None, in SHARE;
        /// Factor on the line width.
        line: f32 = InkShading::default().line, in InkShading::LINE;
        /// Strength of the wash: 0 leaves the paper blank.
        wash: ScalarMap = ScalarMap::Constant(1.0), in SHARE;
        /// Strength of full dark ink.
        solid: ScalarMap = ScalarMap::Constant(0.0), in SHARE;
        /// Relative line width: 0 no lines, 1 full width.
        lines: ScalarMap = ScalarMap::Constant(1.0), in SHARE;
        /// Ink settings of single materials: `[[ink.material]]` with a `name`, in which `*` matches any characters and
        /// `?` one, and any of `fill`, `center`, `amount` and `line`. Later tables take precedence.
        material: Vec<MaterialInk> = Vec::new();
        /// Image of a scanned stroke that replaces the generated one, from left to right with its outer edge at the
        /// top. The path is relative to the recipe's folder.
        stroke_image: Option<FilePath> = None;
        /// Width of the outline stroke, as a share of the radius of the outlined body.
        stroke_width: f32 = 0.09, in 0.01..=0.9;
        /// Variation of the stroke's width and roughness of its edge: 0 none, 1 full.
        stroke_variation: f32 = 0.5, in SHARE;
        /// Dryness of the brush in the dry variant of the stroke: 0 wet, 1 mostly bristles.
        stroke_dryness: f32 = 0.4, in SHARE;
        /// Width and height of the stroke texture, texels.
        stroke_texels: u32 = 256, in 32..=2048, as PowerOfTwo;
        /// Painting, or part of one, that supplies the grain and blotches of the wash. The path is relative to the
        /// recipe's folder.
        wash_image: Option<FilePath> = None;
        /// Strength of the dark edges where a wash dries: 0 gives soft blotches, 1 dark rims around them.
        wash_edges: f32 = 0.5, in SHARE;
        /// Width and height of the wash texture, texels.
        wash_texels: u32 = 256, in 32..=2048, as PowerOfTwo;
        /// Amount of visible paper fibres: 0 none, 1 coarse mulberry paper.
        paper_fibres: f32 = 0.5, in SHARE;
        /// Unevenness of the paper's absorbency: 0 sized paper, 1 raw paper.
        paper_absorbency: f32 = 0.5, in SHARE;
        /// Darkness of flecks and coloured fibres in the paper.
        paper_tone: f32 = 0.4, in SHARE;
        /// Width and height of the paper texture, texels.
        paper_texels: u32 = 256, in 32..=2048, as PowerOfTwo;
        /// Width and height of the fur strokes of a hair tile, texels.
        fur_texels: u32 = 256, in 32..=2048, as PowerOfTwo;
    }
}
