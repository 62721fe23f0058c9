//! `pelage-web`: a `.pelage` package on a `<canvas>`, drawn by WebGPU.
//!
//! This is the WebAssembly half of the npm package in `runtime/web/npm`, whose `index.js` is what pages call: it owns the event loop, and this crate owns
//! device, stage and camera. A method here never waits; what a browser answers later, such as `open`, is a promise.

#[cfg(target_arch = "wasm32")]
mod canvas;
#[cfg(target_arch = "wasm32")]
mod pass;
#[cfg(target_arch = "wasm32")]
mod player;
#[cfg(target_arch = "wasm32")]
mod report;
#[cfg(target_arch = "wasm32")]
mod thrown;
#[cfg(target_arch = "wasm32")]
mod viewer;

#[cfg(target_arch = "wasm32")]
pub use canvas::{Opened, open, open_shared};
#[cfg(target_arch = "wasm32")]
pub use pass::Pass;
#[cfg(target_arch = "wasm32")]
pub use viewer::Viewer;
