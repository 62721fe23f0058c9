//! Animals in a Bevy app without a window.
#![allow(clippy::unwrap_used, reason = "in tests a panic is the report")]

mod pictures;
mod support;
