//! Draws the fur of a .pelage package with wgpu, inside the application's own render pass.
//!
//! The application owns device, queue, targets, depth buffer, camera and light. It sets [`RendererOptions`] once to say what its
//! pass looks like, and [`FrameParams`] per frame:
//!
//! ```no_run
//! # use pelage_runtime::{wgpu, *};
//! # fn f(device: &wgpu::Device, queue: &wgpu::Queue, bytes: &[u8], camera: Camera, mut encoder: wgpu::CommandEncoder,
//! #      descriptor: &wgpu::RenderPassDescriptor<'_>) -> Result<(), RuntimeError> {
//! let mut renderer = Renderer::new(device, queue, &RendererOptions::default())?;
//! let fox = renderer.load_bytes(device, queue, bytes)?;
//! let mut instance = Instance::new(&fox);
//! // Every frame:
//! instance.motion = Motion::Clip { clip: 0, time_s: 0.3 };
//! let frame = renderer.prepare(device, &mut encoder, &FrameParams::new(camera), &mut [&mut instance])?;
//! let mut pass = encoder.begin_render_pass(descriptor);
//! // ... the application draws its own opaque things, then:
//! frame.draw(&mut pass);
//! # Ok(()) }
//! ```
//!
//! Space is right-handed with +Y up, in metres; clip depth is 0..=1, reversed on request. Colours are linear RGB and leave the
//! shaders premultiplied with opacity: an sRGB target encodes them.
//!
//! The hair is the layered volume of Lengyel 2001, lit per pixel as in Yang 2006, eq. (3): hair shadows hair by layer-wise shadow
//! maps, things throw soft shadows by a shadow-width map. [`Casters`] lets the application's own geometry take part in both
//! directions.
//!
//! [`Style::Ink`] paints the same packages as an ink-wash painting after Fang 2006, as [`InkParams`] say, which need to know how large the target is:
//!
//! ```no_run
//! # use pelage_runtime::*;
//! # fn f(mut params: FrameParams) {
//! params.style = Style::Ink;
//! params.ink = Some(InkParams { background: InkBackground::Picture, ..InkParams::new(1280, 720) });
//! # }
//! ```
//!
//! A pass that a package or a frame does not need costs nothing; [`Frame::report`] names what ran.

mod camera;
mod detail;
mod error;
mod extent;
mod frame;
mod ink;
mod instance;
mod light_view;
mod model;
mod model_ink;
mod params;
mod passes;
mod renderer;
mod report;
mod shadow;
pub mod shared;

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod layout_tests;

pub use camera::{Camera, Light, Projection};
pub use detail::{Detail, InstanceDetail};
pub use error::RuntimeError;
pub use frame::Frame;
pub use ink::{Anchoring, FeatureRule, InkBackground, InkParams, InkShow, LineWidth, SphereMapForm};
pub use instance::{Instance, Motion};
pub use light_view::{LightView, Sphere};
pub use model::Model;
pub use params::{FrameParams, Lighting, MAX_FILL_LIGHTS, RendererOptions, Style};
pub use passes::PassId;
pub use renderer::Renderer;
pub use report::{FrameReport, PassReport};
pub use shadow::{CasterPass, Casters, PenumbraForm, ShadowMaps, ShadowParams, SlantForm};

pub use glam;
pub use pelage_formats as formats;
pub use wgpu;
