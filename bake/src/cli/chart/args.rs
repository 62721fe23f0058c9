//! What is charted, and of which model.

use crate::cli::bake::RecipeArgs;
use crate::cli::exit::Failure;
use std::path::PathBuf;

/// Chart speed against accuracy: CSV and SVG with a row for each configuration
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
    /// Measure these rows only, by their number in the whole table, from 1; where a row's command says so, it gives that row again
    #[arg(long, value_name = "N,N..", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) rows: Vec<u32>,
    /// Measure all rows anew; without it, those count that a run which was killed left in TOPIC.rows.jsonl
    #[arg(long)]
    pub(super) restart: bool,
    /// A sky to measure, .hdr or .exr; may be given several times, to environment and environment-fit alone, which else paint a clear sky and a room
    #[arg(long, value_name = "SKY")]
    pub(super) sky: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) recipe: RecipeArgs,
}

impl ChartArgs {
    /// Numbers of the rows to measure, of `count` that there are.
    pub(super) fn numbers(&self, count: usize) -> Result<impl Iterator<Item = usize> + use<>, Failure> {
        if let Some(row) = self.rows.iter().find(|row| **row as usize > count) {
            return Err(Failure::Usage(format!("--rows {row}: the table has {count} rows")));
        }
        let rows: Vec<usize> = self.rows.iter().map(|row| *row as usize).collect();
        Ok((1..=count).filter(move |number| rows.is_empty() || rows.contains(number)))
    }
}

/// What can be charted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Topic {
    /// Layers, tile, filter, formats and fins: how far their pictures are from the true strands, and what they cost
    Shells,
    /// Layers, triangles and texels at four sizes on screen: how many a picture needs, against the true strands, and what they cost
    Detail,
    /// Single strands and layers, close and at five sizes, with one sample a pixel and four: how far from the true strands, and what they cost
    Strands,
    /// Lapped patches: what fewer seams cost in distortion and seconds
    Surface,
    /// Light per pixel and per vertex: the direction it is computed with against the strand's own, and what that costs
    Lighting,
    /// Baked visibility and layer-wise shadow maps: what light they let between hairs, against the true way of the light, and what they cost
    SelfShadow,
    /// Maps of slabs in which single strands shadow each other, deep and over the whole depth: their light and picture against the true ones, and what they cost
    OpacityShadow,
    /// Shadow-width maps: the soft shadows they make, against a light that is a disc, and what they cost
    SoftShadow,
    /// Ink lines: how far they are from the contours and creases of the mesh, how wide they grow, how they flicker, and what they cost
    Ink,
    /// Texel formats, encoders and mip filters: what they do to colour, hair direction and coverage, and what they cost
    Textures,
    /// Hair on guides that swings: how far it is from its equations, by how its lengths are held and how often, and what that costs; it needs no model
    Verlet,
    /// What a fibre scatters, by tables of several sizes and axes, by the printed ones and by a fit: how far from its equations, and nanoseconds; it needs no model
    Scattering,
    /// Black, brown, blond and white coats in three lights, by fibres with the light of other fibres and without: how far from traced paths, and what that costs
    Multiple,
    /// What a fibre sends of a sky, by one broad light, a light at a time, as printed, by samples and by constant light: how far from the truth, and microseconds; it needs no model
    Environment,
    /// Few lights for a sky: how near they come by their number, and the seconds that finding them takes; it needs no model
    EnvironmentFit,
    /// Where methods fail: the naive form's error beside ours and its bound; exit code 7 where a bound is broken
    Stability,
}
