//! Tests that use several crates, linked once. Each module can be run by itself: `cargo test --workspace --test all house::`.

mod assets;
mod house;
mod import;
mod runtime;
mod stability;
mod stages;
mod tool;
mod window;
