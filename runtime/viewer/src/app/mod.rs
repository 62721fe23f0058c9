//! State of a window: what is shown, its look, and the user's changes. Draws nothing itself.

mod frame;
mod controls;
mod messages;
mod open;
mod save;
mod state;
mod edits;

pub use state::App;
