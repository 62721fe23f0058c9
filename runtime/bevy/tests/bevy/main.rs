//! Tests of animals in a Bevy app without a window.
#![allow(clippy::unwrap_used, reason = "in tests a panic is the report")]

mod assets;
mod cost;
mod example;
#[path = "../../../examples/support/ktx2.rs"]
#[allow(dead_code, reason = "of the runtime's examples")]
mod ktx2;
mod lights;
mod pictures;
#[path = "../../walk/src/scene.rs"]
mod scene;
#[path = "../../../examples/support/sphere.rs"]
#[allow(dead_code, reason = "of the runtime's examples")]
mod sphere;
mod support;
