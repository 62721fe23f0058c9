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
        /// Strength of the wash, or of the full ink if `fill` is `solid`.
        amount: ScalarMap, in SHARE;
        /// Overrides `ink.lines`.
        line: ScalarMap, in SHARE;
    }
}

params! {
    /// `[ink]`: the model as an ink-wash painting after Fang 2006. Maps have the form of those in `[groom]` and are
    /// read at the vertices.
    InkParams in ink {
        /// Whether the package supports the ink style.
        enabled: bool = true;
        /// Random seed of stroke, wash, paper and fur.
        seed: u64 = 1, in 0..=i64::MAX as u64;
        /// CP of Fang 2006, §3, the point at which the wash is darkest, metres on the model at rest. Left out, it is
        /// chosen such that the wash varies most over the mesh surface, dark above and pale below.
        center: Option<[f32; 3]> = None, in PLACE;
        /// a of Fang 2006, §3: rate at which the wash fades away from the centre, independent of the model's size.
        speed: f32 = InkShading::default().wash_speed, in 0.0..=100.0;
        /// b of Fang 2006, §3: grey at the centre, 0 black to 1 white; below 0 the surroundings are black too.
        range: f32 = InkShading::default().wash_range, in -4.0..=4.0;
        /// Whether the wash depends on the angle to the centre alone, following the paper's abstract, instead of the
        /// printed product.
        normalised: bool = InkShading::default().normalised;
        /// Weight of the wash texture in the wash: 0 smooth, 1 as blotchy as the texture.
        grain: f32 = InkShading::default().grain, in SHARE;
        /// Period of the wash texture on the mesh surface, metres. Left out, it is chosen from the model's size.
        grain_size_m: Option<f32> = None, in 1e-6..=1e3;
        /// Share of the base colour's darkness that the wash adopts: 0 none, 1 a black cat is black.
        tone: f32 = InkShading::default().tone, in SHARE;
        /// Strength of the fur strokes. Left out, it is 1 if the model has a skeleton or the recipe sets any key of
        /// `[hair]`, `[groom]`, `[color]`, `[fins]`, or `model.bare`. Otherwise it is 0: a scan of a stone grows no
        /// hair.
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
        /// Scanned stroke that replaces the generated one: an image of one stroke from left to right, with its outer
        /// edge at the top. The path is relative to the recipe's folder.
        stroke_image: Option<FilePath> = None;
        /// Width of the outline stroke, as a share of the radius of the body that it surrounds.
        stroke_width: f32 = 0.09, in 0.01..=0.9;
        /// Variation of the stroke's width and roughness of its edge.
        stroke_variation: f32 = 0.5, in SHARE;
        /// Dryness of the brush in its dry form: 0 wet, 1 mostly bristles.
        stroke_dryness: f32 = 0.4, in SHARE;
        /// Width and height of the stroke texture, texels.
        stroke_texels: u32 = 256, in 32..=2048, as PowerOfTwo;
        /// Painting, or part of one, that supplies the grain and blotches of the wash. The path is relative to the
        /// recipe's folder.
        wash_image: Option<FilePath> = None;
        /// Strength of the dark edges where a wash dries: 0 soft blotches, 1 dark rims around them.
        wash_edges: f32 = 0.5, in SHARE;
        /// Width and height of the wash texture, texels.
        wash_texels: u32 = 256, in 32..=2048, as PowerOfTwo;
        /// Amount of visible paper fibres: 0 none, 1 coarse mulberry paper.
        paper_fibres: f32 = 0.5, in SHARE;
        /// Unevenness of the paper's absorbency: 0 sized, 1 raw.
        paper_absorbency: f32 = 0.5, in SHARE;
        /// Darkness of flecks and coloured fibres in the paper.
        paper_tone: f32 = 0.4, in SHARE;
        /// Width and height of the paper texture, texels.
        paper_texels: u32 = 256, in 32..=2048, as PowerOfTwo;
        /// Width and height of the fur strokes of a hair tile, texels.
        fur_texels: u32 = 256, in 32..=2048, as PowerOfTwo;
    }
}
