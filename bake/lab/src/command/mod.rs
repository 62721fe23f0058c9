//! `pelage chart`: accuracy against cost, as a table and a picture.
//!
//! A topic is a file that lists configurations and measures one of them (`driver::Topic`). All topics share row
//! numbers, journal, progress, Pareto front, table and picture (`driver.rs`).

mod args;
mod cost;
mod detail;
mod driver;
mod environment;
mod environment_fit;
mod greys;
mod ink;
mod journal;
mod light_bench;
mod lighting;
mod multiple;
mod opacity_shadow;
mod scattering;
mod self_shadow;
mod shells;
mod soft_shadow;
mod stability;
mod strands;
mod subject;
mod surface;
mod textures;
mod verlet;

use args::Topic;
use clap::ValueEnum as _;
use pelage_import::BakeError;
use pelage_tool::exit::{Exit, Failure};
use pelage_tool::output::Output;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use subject::Subject;

pub use args::ChartArgs;

/// Row of a chart.
#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "only its schema is used")]
enum ChartRow {
    /// Configuration of any other topic.
    Measured(driver::MeasuredRow),
    /// Row of the topic `stability`.
    Stability(stability::StabilityRow),
}

/// Returns the JSON schema of the result.
pub fn result_schema(generator: &mut SchemaGenerator) -> Schema {
    driver::ChartResult::<ChartRow>::json_schema(generator)
}

/// Runs the subcommand.
pub fn run(args: &ChartArgs, output: &mut Output) -> Result<Exit, Failure> {
    if args.topic == Topic::Stability {
        return stability::run(args, output);
    }
    let name = args.topic.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned());
    let needs = || Failure::Usage(format!("chart {name} needs -o DIR for its table and picture"));
    let folder = args.output.as_deref().ok_or_else(needs)?;
    if let Some(own) = built_in_input(args.topic)
        && (args.model.is_some() || args.recipe.recipe.is_some() || !args.recipe.set.is_empty())
    {
        return Err(Failure::Usage(format!("chart {name} takes neither model nor recipe: its {own} are built in")));
    }
    if !args.sky.is_empty() && !matches!(args.topic, Topic::Environment | Topic::EnvironmentFit) {
        return Err(Failure::Usage(format!("chart {name} takes no --sky: it sets the lights of its model")));
    }
    let subject = Subject::new(args)?;
    if subject.package.is_some()
        && !matches!(
            args.topic,
            Topic::Cost | Topic::Shells | Topic::Detail | Topic::Strands | Topic::OpacityShadow | Topic::Ink
        )
    {
        if args.topic == Topic::Surface {
            let why = "the mesh of a package is already cut into patches";
            return Err(Failure::Usage(format!("chart surface needs the model: {why}")));
        }
        if let Some((key, _)) = subject.recipe.images().first() {
            let why = format!("a package does not contain the image of {key}");
            return Err(Failure::Usage(format!("chart {name} needs the model: {why}")));
        }
    }
    let mut topic = topic(args, &subject)?;
    driver::run(args, &subject, folder, &mut *topic, output)
}

/// Returns the name of the built-in input of a topic that needs no model.
fn built_in_input(topic: Topic) -> Option<&'static str> {
    match topic {
        Topic::Verlet => Some("guides"),
        Topic::Scattering => Some("fibres"),
        Topic::Environment => Some("fibres and skies"),
        Topic::EnvironmentFit => Some("skies"),
        _ => None,
    }
}

/// Creates the topic. Every topic with a picture is covered.
fn topic<'a>(args: &ChartArgs, subject: &'a Subject) -> Result<Box<dyn driver::Topic + 'a>, Failure> {
    Ok(match args.topic {
        Topic::Environment => Box::new(environment::EnvironmentTopic::new(&args.sky)?),
        Topic::EnvironmentFit => Box::new(environment_fit::EnvironmentFitTopic::new(&args.sky)?),
        Topic::Cost => Box::new(cost::CostTopic::new(subject)?),
        Topic::Surface => Box::new(surface::SurfaceTopic::new(subject)?),
        Topic::Textures => Box::new(textures::TexturesTopic::new(subject)?),
        Topic::Verlet => Box::new(verlet::VerletTopic::new()),
        Topic::Scattering => Box::new(scattering::ScatteringTopic::new()?),
        Topic::Multiple => Box::new(multiple::MultipleTopic::new(subject)?),
        Topic::Shells => Box::new(shells::ShellsTopic::new(subject)?),
        Topic::Detail => Box::new(detail::DetailTopic::new(subject)?),
        Topic::Strands => Box::new(strands::StrandsTopic::new(subject)?),
        Topic::Lighting => Box::new(lighting::LightingTopic::new(subject)?),
        Topic::SelfShadow => Box::new(self_shadow::SelfShadowTopic::new(subject)?),
        Topic::OpacityShadow => Box::new(opacity_shadow::OpacityShadowTopic::new(subject)?),
        Topic::SoftShadow => Box::new(soft_shadow::SoftShadowTopic::new(subject)?),
        Topic::Ink => Box::new(ink::InkTopic::new(subject)?),
        Topic::Stability => return Err(BakeError::Internal("stability has no picture".into()).into()),
    })
}
