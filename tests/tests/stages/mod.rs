//! Tests of the stages of a bake, individually and in sequence.

mod gloss;
mod pipeline;
mod rebake;
mod reference;
mod surface;
