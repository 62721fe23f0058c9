//! The window of `pelage view`. It shows an animal in fur or ink, with controls for camera, light, animation and knobs.
//! It rebakes the animal when its files change.
//!
//! The window can draw packages with looks. The application provides a [`Workshop`], which makes packages from models
//! and recipes, and lists the files that they came from. It also provides a [`ReferenceSource`], which traces reference
//! pictures. Both run on their own threads. The window stays responsive and shows the previous content until the new
//! content is ready.
//!
//! Every control is derived from the declaration of its knob ([`pelage_params::Knob`]); the window has no list of
//! knobs.

mod app;
mod events;
mod knobs;
mod lights;
mod save;
mod show;
mod subject;
mod truth;
mod ui;
mod watch;
mod window;
mod worker;
mod workshop;

pub use knobs::{Edit, Edits, Knobs};
pub use lights::{LoadLights, LoadSeal};
pub use subject::{ClipInfo, Subject};
pub use watch::{Stamp, stamp};
pub use window::{ViewError, ViewOptions, view};
pub use workshop::{Outcome, Progress, ReferencePicture, ReferenceRequest, ReferenceSource, WindowContent, Workshop};

pub use image;
