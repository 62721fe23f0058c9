//! Tests that use several crates, linked once. Each module can be run by itself: `cargo test --workspace --test all house::`.
//! The tests of the window are a binary of their own, which runs alone: hands and eyes on a screen want a quiet machine.

mod assets;
mod house;
mod import;
mod runtime;
mod stability;
mod stages;
mod tool;
