//! What the example and the tests need around the runtime: a device without a window, pictures read back, and a small furry
//! package made in code.

#![allow(clippy::unwrap_used, reason = "examples and tests stop at the first surprise")]

pub mod headless;
pub mod ktx2;
pub mod sphere;
