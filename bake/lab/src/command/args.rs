//! Arguments of `pelage chart`: topic, model and rows.

use pelage_tool::bake::RecipeArgs;
use pelage_tool::exit::Failure;
use pelage_tool::share::share;
use std::path::PathBuf;
use std::str::FromStr;

/// Chart speed against accuracy: CSV and SVG with a row for each configuration. Part of `pelage-lab`: ./run chart
#[derive(Clone, Debug, clap::Args)]
pub struct ChartArgs {
    /// Topic to measure
    #[arg(value_name = "TOPIC", value_enum)]
    pub(super) topic: Topic,
    /// Model (.glb, .gltf or .obj), or a package, whose mesh and recipe are used; by default the built-in hare
    #[arg(value_name = "MODEL|PKG")]
    pub(super) model: Option<PathBuf>,
    /// Folder for TOPIC.csv and TOPIC.svg, created if missing; not needed for stability, which makes no picture
    #[arg(long, short, value_name = "DIR")]
    pub(super) output: Option<PathBuf>,
    /// Measure only these rows: numbers in the whole table, from 1, or the K-th of M equal parts of all rows. A row's
    /// command contains this option if it reproduces only that row
    #[arg(long, value_name = "N|K/M,..", value_delimiter = ',')]
    pub(super) rows: Vec<Rows>,
    /// Leave the rows in TOPIC.rows.jsonl without making table and picture, for a machine that measures only some of
    /// them
    #[arg(long, conflicts_with = "from")]
    pub(super) part: bool,
    /// Read rows that other machines with the same tool and adapter measured with --part; missing rows are measured
    #[arg(long, value_name = "JSONL")]
    pub(super) from: Vec<PathBuf>,
    /// Measure all rows again; by default, rows that an interrupted run left in TOPIC.rows.jsonl are reused
    #[arg(long)]
    pub(super) restart: bool,
    /// Environment map to measure, .hdr or .exr; may be repeated; only for environment and environment-fit; default: a
    /// painted clear sky and a painted room
    #[arg(long, value_name = "SKY")]
    pub(super) sky: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) recipe: RecipeArgs,
}

impl ChartArgs {
    /// Returns the numbers of the rows to measure, out of `count`.
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
    /// Single row.
    Number(usize),
    /// Every `of`-th row, beginning with row `share`.
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
        number.or_else(share).ok_or_else(|| "expected a row number from 1, or a share of the rows such as 2/8".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_partition_the_rows() {
        let of = |text: &str| text.parse::<Rows>().expect("rows");
        for number in 1..=20 {
            let shares = ["1/3", "2/3", "3/3"].map(|text| of(text).has(number));
            assert_eq!(shares.iter().filter(|has| **has).count(), 1, "{number}");
        }
        assert!(of("2/3").has(2) && of("3/3").has(3) && of("7").has(7) && !of("7").has(14));
        assert!(["0", "4/3", "0/3", "a", "1/"].iter().all(|text| text.parse::<Rows>().is_err()));
    }
}

/// Topic of a chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum, schemars::JsonSchema)]
#[schemars(rename_all = "kebab-case")]
pub(super) enum Topic {
    /// Layers, tile, filter, formats and fins: error of the picture against the true strands, and cost
    Shells,
    /// Layers, triangles and texels that a picture needs at four sizes on screen: error against the true strands, and
    /// cost
    Detail,
    /// Single strands and layers, in close-up and at five sizes, with one sample per pixel and four: error against the
    /// true strands, and cost
    Strands,
    /// Pixels, layers, triangles, strands and copies: time of a frame, and its exponent
    Cost,
    /// Lapped patches: trade-off between seams and distortion, and seconds
    Surface,
    /// Light per pixel and per vertex: error of the direction used against the strand's own, and cost
    Lighting,
    /// Baked visibility and layer-wise shadow maps: error of the light between hairs against traced light, and cost
    SelfShadow,
    /// Deep and opacity shadow maps between single strands: error of light and picture, and cost
    OpacityShadow,
    /// Shadow-width maps: error of the soft shadow against a disc light, and cost
    SoftShadow,
    /// Ink lines: distance from the contours and creases of the mesh, width, flicker, and cost
    Ink,
    /// Texel formats, encoders and mip filters: error of colour, hair direction and coverage, and cost
    Textures,
    /// Simulated guided hair, by method and frequency of enforcing lengths: error against its equations, and cost;
    /// needs no model
    Verlet,
    /// Scattering of a fibre by tables of several sizes and axes, by the published tables and by a fit: error against
    /// its equations, and nanoseconds; needs no model
    Scattering,
    /// Black, brown, blond and white fur in three lights, with several models of the light between fibres: error
    /// against path tracing, and cost
    Multiple,
    /// Fibres under an environment map, by one broad light, by one lobe at a time, in the published form, by samples
    /// and by constant light: error, and microseconds; needs no model
    Environment,
    /// Few lights fitted to an environment map: error by the number of lights, and seconds of the fit; needs no model
    EnvironmentFit,
    /// Numerical failures of methods: error of the naive form beside pelage's, and its bound; exit code 7 if a bound is
    /// exceeded
    Stability,
}
