//! What can be said without a GPU, a bake or test data: which crate knows which, which file knows which, what the documents promise. Seconds.

mod dependencies;
mod documentation;
mod floors;
mod gate;
mod language;
mod published;
mod register;
mod shaders;
mod sources;
