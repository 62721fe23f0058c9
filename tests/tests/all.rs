//! Tests that use several crates, linked as one binary. A module can be run alone: `cargo test --workspace --test all
//! house::`. The window tests are a separate binary that runs alone, because simulated input needs an idle machine.

mod assets;
mod cases;
mod house;
mod import;
mod runtime;
mod stability;
mod stages;
mod tool;
