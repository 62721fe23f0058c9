//! What a window is about: what is shown, how, and what hands changed. It draws nothing of its own.

mod frame;
mod go;
mod hear;
mod open;
mod save;
mod state;
mod turn;

pub use state::App;
