//! Tests of the stages of a bake, alone and in sequence.

mod pipeline;
mod rebake;
mod reference;
mod surface;
