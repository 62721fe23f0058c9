//! JSON schemas of what `--json` prints.

use super::{
    bake, bench, compare, demo, doctor, export, groom, herd, inspect, job, merge, output, pack, reference, render, sky,
    unpack, validate,
};
use schemars::{JsonSchema as _, Schema, SchemaGenerator};

/// Name of a subcommand, and a function that generates the schema of its result.
pub type ResultSchema = (&'static str, fn(&mut SchemaGenerator) -> Schema);

/// Lists the schemas of the results of all subcommands, of errors, and of records.
pub fn results() -> Vec<ResultSchema> {
    vec![
        ("bake", bake::BakeResult::json_schema),
        ("bench", bench::BenchResult::json_schema),
        ("compare", compare::CompareResult::json_schema),
        ("demo", demo::DemoResult::json_schema),
        ("doctor", doctor::DoctorResult::json_schema),
        ("error", output::ErrorResult::json_schema),
        ("export", export::ExportResult::json_schema),
        ("groom", groom::GroomResult::json_schema),
        ("herd", herd::HerdResult::json_schema),
        ("inspect", inspect::InspectResult::json_schema),
        ("merge", merge::MergeResult::json_schema),
        ("pack", pack::PackResult::json_schema),
        ("record", job::CommandRecord::json_schema),
        ("reference", reference::ReferenceResult::json_schema),
        ("render", render::RenderResult::json_schema),
        ("sky", sky::SkyResult::json_schema),
        ("unpack", unpack::UnpackResult::json_schema),
        ("validate", validate::ValidateResult::json_schema),
    ]
}
