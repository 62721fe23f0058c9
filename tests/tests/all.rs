//! Tests that use several crates, linked once. Each module can be run by itself: `cargo test --workspace --test all house::`.

mod assets;
mod house;
mod runtime;
mod stability;
mod tool;
mod window;
