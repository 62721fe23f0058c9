//! The stages of a bake, alone and one after the other.
#![allow(clippy::disallowed_methods, reason = "tests make no package that anyone keeps")]

mod pipeline;
mod rebake;
mod reference;
mod surface;
