//! State of a window: subject, look, and the user's changes. This module draws nothing.

mod controls;
mod edits;
mod frame;
mod messages;
mod open;
mod save;
mod state;

pub use state::App;
