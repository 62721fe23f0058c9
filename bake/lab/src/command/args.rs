//! What is charted, and of which model.

use pelage_tool::bake::RecipeArgs;
use pelage_tool::exit::Failure;
use pelage_tool::share::share;
use std::path::PathBuf;
use std::str::FromStr;

/// Chart speed against accuracy: CSV and SVG with a row for each configuration. Part of `pelage-lab`: ./run chart
#[derive(Clone, Debug, clap::Args)]
pub struct ChartArgs {
    /// What to measure
    #[arg(value_name = "TOPIC", value_enum)]
    pub(super) topic: Topic,
    /// The model, .glb, .gltf or .obj, or a package, whose own mesh and recipe then serve; by default the built-in hare
    #[arg(value_name = "MODEL|PKG")]
    pub(super) model: Option<PathBuf>,
    /// Folder for TOPIC.csv and TOPIC.svg, made where it is missing; stability needs none, and draws no picture
    #[arg(long, short, value_name = "DIR")]
    pub(super) output: Option<PathBuf>,
    /// Measure these rows only, by their number in the whole table, from 1, or the K-th of M shares of all rows; where
    /// a row's command says so, it gives that row again
    #[arg(long, value_name = "N|K/M,..", value_delimiter = ',')]
    pub(super) rows: Vec<Rows>,
    /// Leave the rows in TOPIC.rows.jsonl and draw no table: for a machine that measures some of them
    #[arg(long, conflicts_with = "from")]
    pub(super) part: bool,
    /// Take rows that other machines with the same tool and adapter have left there with --part; what is missing is
    /// measured
    #[arg(long, value_name = "JSONL")]
    pub(super) from: Vec<PathBuf>,
    /// Measure all rows anew; without it, those count that a run which was killed left in TOPIC.rows.jsonl
    #[arg(long)]
    pub(super) restart: bool,
    /// A sky to measure, .hdr or .exr; may be given several times, to environment and environment-fit alone, which else
    /// paint a clear sky and a room
    #[arg(long, value_name = "SKY")]
    pub(super) sky: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) recipe: RecipeArgs,
}

impl ChartArgs {
    /// Numbers of the rows to measure, of `count` that there are.
    pub(super) fn numbers(&self, count: usize) -> Result<impl Iterator<Item = usize> + use<>, Failure> {
        let beyond = |rows: &Rows| matches!(rows, Rows::Number(row) if *row > count);
        if let Some(Rows::Number(row)) = self.rows.iter().find(|rows| beyond(rows)) {
            return Err(Failure::Usage(format!("--rows {row}: the table has {count} rows")));
        }
        let rows = self.rows.clone();
        Ok((1..=count).filter(move |number| rows.is_empty() || rows.iter().any(|rows| rows.has(*number))))
    }
}

/// Rows of a table, numbered from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rows {
    /// One of them.
    Number(usize),
    /// Every `of`-th, beginning with row `share`.
    Share { share: usize, of: usize },
}

impl Rows {
    fn has(self, number: usize) -> bool {
        match self {
            Self::Number(row) => row == number,
            Self::Share { share, of } => number % of == share % of,
        }
    }
}

impl FromStr for Rows {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = text.trim().parse().ok().filter(|row| *row > 0).map(Self::Number);
        let share = || share(text).map(|(share, of)| Self::Share { share: share as usize, of: of as usize });
        number.or_else(share).ok_or_else(|| "expected a row from 1, or a share of the rows from 1 such as 2/8".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_have_every_row_once() {
        let of = |text: &str| text.parse::<Rows>().expect("rows");
        for number in 1..=20 {
            let shares = ["1/3", "2/3", "3/3"].map(|text| of(text).has(number));
            assert_eq!(shares.iter().filter(|has| **has).count(), 1, "{number}");
        }
        assert!(of("2/3").has(2) && of("3/3").has(3) && of("7").has(7) && !of("7").has(14));
        assert!(["0", "4/3", "0/3", "a", "1/"].iter().all(|text| text.parse::<Rows>().is_err()));
    }
}

/// What can be charted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum, schemars::JsonSchema)]
#[schemars(rename_all = "kebab-case")]
pub(super) enum Topic {
    /// Layers, tile, filter, formats and fins: how far their pictures are from the true strands, and what they cost
    Shells,
    /// Layers, triangles and texels at four sizes on screen: how many a picture needs, against the true strands, and
    /// what they cost
    Detail,
    /// Single strands and layers, close and at five sizes, with one sample a pixel and four: how far from the true
    /// strands, and what they cost
    Strands,
    /// Lapped patches: what fewer seams cost in distortion and seconds
    Surface,
    /// Light per pixel and per vertex: the direction it is computed with against the strand's own, and what that costs
    Lighting,
    /// Baked visibility and layer-wise shadow maps: what light they let between hairs, against the true way of the
    /// light, and what they cost
    SelfShadow,
    /// Maps of slabs in which single strands shadow each other, deep and over the whole depth: their light and picture
    /// against the true ones, and what they cost
    OpacityShadow,
    /// Shadow-width maps: the soft shadows they make, against a light that is a disc, and what they cost
    SoftShadow,
    /// Ink lines: how far they are from the contours and creases of the mesh, how wide they grow, how they flicker, and
    /// what they cost
    Ink,
    /// Texel formats, encoders and mip filters: what they do to colour, hair direction and coverage, and what they cost
    Textures,
    /// Hair on guides that swings: how far it is from its equations, by how its lengths are held and how often, and
    /// what that costs; it needs no model
    Verlet,
    /// What a fibre scatters, by tables of several sizes and axes, by the printed ones and by a fit: how far from its
    /// equations, and nanoseconds; it needs no model
    Scattering,
    /// Black, brown, blond and white coats in three lights, by fibres with the light of other fibres and without: how
    /// far from traced paths, and what that costs
    Multiple,
    /// What a fibre sends of a sky, by one broad light, a light at a time, as printed, by samples and by constant
    /// light: how far from the truth, and microseconds; it needs no model
    Environment,
    /// Few lights for a sky: how near they come by their number, and the seconds that finding them takes; it needs no
    /// model
    EnvironmentFit,
    /// Where methods fail: the naive form's error beside ours and its bound; exit code 7 where a bound is broken
    Stability,
}
