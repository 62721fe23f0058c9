//! Checks that take seconds, without GPU, bake or test data: dependencies of crates and files, and documents.

mod dependencies;
mod documentation;
mod language;
mod layers;
mod published;
mod register;
mod run_script;
mod shaders;
mod sources;
