//! Tests of the stages of a bake, individually and in sequence.

mod pipeline;
mod rebake;
mod reference;
mod surface;
