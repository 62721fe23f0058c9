//! The window of `pelage view`: an animal in fur or ink that people turn, light, play and change, and that bakes again as its files change.
//!
//! The window knows packages, looks and how to draw them. Who opens it brings a [`Workshop`], which makes packages of models and recipes and knows
//! which files they came from, and a [`Judge`], which traces true pictures. Both work on threads of their own; the window goes on
//! meanwhile, and shows what was there before until the new is ready.
//!
//! Every control follows from the declaration of its knob ([`pelage_params::Knob`]): the window has no list of them.

mod app;
mod knobs;
mod lights;
mod save;
mod script;
mod show;
mod subject;
mod truth;
mod ui;
mod watch;
mod window;
mod worker;
mod workshop;

pub use knobs::{Edit, Edits, Knobs};
pub use lights::LightsOf;
pub use subject::{ClipInfo, Subject};
pub use watch::{Stamp, stamp};
pub use window::{ViewError, ViewOptions, view};
pub use workshop::{Judge, Made, Outcome, Progress, Truth, TruthAsked, Workshop};

pub use image;
