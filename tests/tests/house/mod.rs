//! Checks that need no GPU, bake or test data and take seconds: dependencies of crates and files, and documents.

mod dependencies;
mod documentation;
mod language;
mod layers;
mod published;
mod register;
mod run_script;
mod shaders;
mod sources;
