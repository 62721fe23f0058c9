//! The stages of a bake, alone and one after the other.

mod pipeline;
mod rebake;
mod reference;
mod surface;
