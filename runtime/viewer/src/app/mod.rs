//! State of a window: what is shown, its look, and the user's changes. Draws nothing itself.

mod frame;
mod go;
mod hear;
mod open;
mod save;
mod state;
mod turn;

pub use state::App;
