//! The stages of a bake, alone and one after the other.

mod pipeline;
mod reference;
mod surface;
