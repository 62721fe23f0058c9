//! `pelage-web`: draws a `.pelage` package on a `<canvas>` with WebGPU.
//!
//! This is the WebAssembly half of the npm package in `runtime/web/npm`, whose `index.js` pages call. That script owns
//! the event loop; this crate owns device, stage and camera. No method blocks: operations that need the browser, such
//! as `open`, return promises.

#[cfg(target_arch = "wasm32")]
mod canvas;
#[cfg(target_arch = "wasm32")]
mod js_error;
#[cfg(target_arch = "wasm32")]
mod pass;
#[cfg(target_arch = "wasm32")]
mod player;
#[cfg(target_arch = "wasm32")]
mod report;
#[cfg(target_arch = "wasm32")]
mod viewer;

#[cfg(target_arch = "wasm32")]
pub use canvas::{OpenedDevice, open, open_shared};
#[cfg(target_arch = "wasm32")]
pub use pass::Pass;
#[cfg(target_arch = "wasm32")]
pub use viewer::Viewer;
