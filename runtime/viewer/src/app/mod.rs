//! State of a window: what is shown, its look, and the user's changes. Draws nothing itself.

mod controls;
mod edits;
mod frame;
mod messages;
mod open;
mod save;
mod state;

pub use state::App;
