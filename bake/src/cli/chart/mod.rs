//! `pelage chart`: what accuracy costs, as a table and a picture.
//!
//! A topic is a file that lists configurations and measures one of them ([`driver::Topic`]); numbers, journal, progress, front, table and picture are the
//! same for all ([`driver`]).

mod driver;
#[cfg(feature = "preview")]
mod ink;
mod journal;
#[cfg(feature = "preview")]
mod light_bench;
#[cfg(feature = "preview")]
mod lighting;
#[cfg(feature = "preview")]
mod self_shadow;
#[cfg(feature = "preview")]
mod shells;
#[cfg(feature = "preview")]
mod soft_shadow;
mod stability;
mod subject;
mod surface;
mod textures;

use super::bake::RecipeArgs;
use super::exit::{Exit, Failure};
use super::output::Output;
use clap::ValueEnum as _;
use pelage_bake::BakeError;
use std::path::{Path, PathBuf};
use subject::Subject;

/// Chart speed against accuracy: CSV and SVG with a row for each configuration
#[derive(Clone, Debug, clap::Args)]
pub struct ChartArgs {
    /// What to measure
    #[arg(value_name = "TOPIC", value_enum)]
    topic: Topic,
    /// The model, .glb, .gltf or .obj, or a package, whose own mesh and recipe then serve; by default the built-in hare
    #[arg(value_name = "MODEL|PKG")]
    model: Option<PathBuf>,
    /// Folder for TOPIC.csv and TOPIC.svg, made where it is missing; stability needs none, and draws no picture
    #[arg(long, short, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Measure these rows only, by their number in the whole table, from 1; where a row's command says so, it gives that row again
    #[arg(long, value_name = "N,N..", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..))]
    rows: Vec<u32>,
    /// Measure all rows anew; without it, those count that a run which was killed left in TOPIC.rows.jsonl
    #[arg(long)]
    restart: bool,
    #[command(flatten)]
    recipe: RecipeArgs,
}

impl ChartArgs {
    /// Numbers of the rows to measure, of `count` that there are.
    fn numbers(&self, count: usize) -> Result<impl Iterator<Item = usize> + use<>, Failure> {
        if let Some(row) = self.rows.iter().find(|row| **row as usize > count) {
            return Err(Failure::Usage(format!("--rows {row}: the table has {count} rows")));
        }
        let rows: Vec<usize> = self.rows.iter().map(|row| *row as usize).collect();
        Ok((1..=count).filter(move |number| rows.is_empty() || rows.contains(number)))
    }
}

/// What can be charted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Topic {
    /// Layers, tile, filter, formats and fins: how far their pictures are from the true strands, and what they cost
    Shells,
    /// Lapped patches: what fewer seams cost in distortion and seconds
    Surface,
    /// Light per pixel and per vertex: the direction it is computed with against the strand's own, and what that costs
    Lighting,
    /// Layer-wise shadow maps: what light they let between hairs, against the true way of the light, and what they cost
    SelfShadow,
    /// Shadow-width maps: the soft shadows they make, against a light that is a disc, and what they cost
    SoftShadow,
    /// Ink lines: how far they are from the contours and creases of the mesh, how wide they grow, how they flicker, and what they cost
    Ink,
    /// Texel formats, encoders and mip filters: what they do to colour, hair direction and coverage, and what they cost
    Textures,
    /// Where methods fail: the naive form's error beside ours and its bound; exit code 7 where a bound is broken
    Stability,
}

/// Runs the subcommand.
pub fn run(args: &ChartArgs, output: &mut Output) -> Result<Exit, Failure> {
    if args.topic == Topic::Stability {
        return stability::run(args, output);
    }
    let name = args.topic.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned());
    let needs = || Failure::Usage(format!("chart {name} needs -o DIR, to put table and picture there"));
    let folder = args.output.as_deref().ok_or_else(needs)?;
    let subject = Subject::new(args)?;
    if subject.package.is_some() && !matches!(args.topic, Topic::Shells | Topic::Ink) {
        if args.topic == Topic::Surface {
            let why = "a package's mesh is parted into its patches already";
            return Err(Failure::Usage(format!("chart surface needs the model: {why}")));
        }
        if let Some((key, _)) = subject.recipe.images().first() {
            let why = format!("the image of {key} is not in a package");
            return Err(Failure::Usage(format!("chart {name} needs the model: {why}")));
        }
    }
    let mut topic = topic(args.topic, &subject)?;
    driver::run(args, &subject, folder, &mut *topic, output)
}

/// Every topic with a picture.
fn topic<'a>(topic: Topic, subject: &'a Subject) -> Result<Box<dyn driver::Topic + 'a>, Failure> {
    Ok(match topic {
        Topic::Surface => Box::new(surface::SurfaceTopic::new(subject)?),
        Topic::Textures => Box::new(textures::TexturesTopic::new(subject)?),
        #[cfg(feature = "preview")]
        Topic::Shells => Box::new(shells::ShellsTopic::new(subject)?),
        #[cfg(feature = "preview")]
        Topic::Lighting => Box::new(lighting::LightingTopic::new(subject)?),
        #[cfg(feature = "preview")]
        Topic::SelfShadow => Box::new(self_shadow::SelfShadowTopic::new(subject)?),
        #[cfg(feature = "preview")]
        Topic::SoftShadow => Box::new(soft_shadow::SoftShadowTopic::new(subject)?),
        #[cfg(feature = "preview")]
        Topic::Ink => Box::new(ink::InkTopic::new(subject)?),
        #[cfg(not(feature = "preview"))]
        Topic::Ink | Topic::Shells | Topic::Lighting | Topic::SelfShadow | Topic::SoftShadow => {
            return Err(Failure::Usage(
                "light is drawn by the runtime, and this build is without it (feature `preview`)".into(),
            ));
        }
        Topic::Stability => return Err(BakeError::Internal("stability has no picture".into()).into()),
    })
}

fn create(folder: &Path) -> Result<(), BakeError> {
    std::fs::create_dir_all(folder).map_err(|source| BakeError::Io {
        path: folder.to_owned(),
        action: "create",
        source,
    })
}

/// What measures that need no graphics adapter run on.
fn processor() -> String {
    measured_on(&format!("CPU, {} threads", rayon::current_num_threads()))
}

/// Name of what was measured on. A debug build says so: its seconds mean little.
pub(super) fn measured_on(what: &str) -> String {
    let build = if cfg!(debug_assertions) { ", debug build" } else { "" };
    format!("{what}{build}")
}
