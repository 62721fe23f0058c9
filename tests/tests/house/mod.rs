//! Checks that need no GPU, bake or test data and take seconds: dependencies of crates and files, and documents.

mod dependencies;
mod documentation;
mod floors;
mod gate;
mod language;
mod published;
mod register;
mod shaders;
mod sources;
