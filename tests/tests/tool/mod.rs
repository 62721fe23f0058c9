//! Tests of the `pelage` command as users run it: fresh folders, real arguments, exit codes, resulting files.

/// Random numbers and packages, shared with the tests of the formats crate.
#[path = "../../../formats/tests/formats/common/mod.rs"]
mod common;

mod bad_input;
mod body;
mod chart;
mod comb;
mod compare;
mod decisions;
mod doctor;
mod first_use;
mod framing;
mod groom;
mod groom_maps;
mod guards;
mod herd;
mod jobs;
mod likeness;
mod limits;
mod models;
mod mutate;
mod packages;
mod quiet;
mod reference;
mod roots;
mod sequences;
mod skies;
mod strands;
mod unpacked_hair;
mod written_recipes;
