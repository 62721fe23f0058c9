//! Draws the fur of a .pelage package with wgpu, inside the application's own render pass.
//!
//! The application owns device, queue, targets, depth buffer, camera and light. It describes its pass once with
//! [`RendererOptions`], and each frame with [`FrameParams`]:
//!
//! ```no_run
//! # use pelage_runtime::{wgpu, *};
//! # fn f(device: &wgpu::Device, queue: &wgpu::Queue, bytes: &[u8], camera: Camera, mut encoder: wgpu::CommandEncoder,
//! #      descriptor: &wgpu::RenderPassDescriptor<'_>) -> Result<(), RuntimeError> {
//! let mut renderer = Renderer::new(device, queue, &RendererOptions::default())?;
//! let fox = renderer.load_bytes(bytes)?;
//! // Every frame: instances with owner and pose. The renderer stores lasting state under the owner's number.
//! let copies = [Instance::new(0, &fox).moving(Motion::Clip { clip: 0, time_s: 0.3 })];
//! let frame = renderer.prepare(&mut encoder, &FrameParams::new(camera, [1280, 720]), &copies)?;
//! let mut pass = encoder.begin_render_pass(descriptor);
//! // ... the application draws its own opaque objects, then:
//! frame.draw(&mut pass);
//! # Ok(()) }
//! ```
//!
//! Space is right-handed with +Y up, in metres; clip depth is 0..=1, reversed on request. Colours are linear RGB and
//! leave the shaders premultiplied with opacity: an sRGB target encodes them.
//!
//! The hair is the layered volume of Lengyel 2001, lit per pixel as in Yang 2006, eq. (3). Hair shadows hair by
//! layer-wise shadow maps; objects cast soft shadows by a shadow-width map. With [`Casters`] the application's own
//! geometry casts and receives these shadows.
//!
//! [`Style::Ink`] paints the same packages as an ink-wash painting, controlled by its [`InkParams`]:
//!
//! ```no_run
//! # use pelage_runtime::*;
//! # fn f(mut params: FrameParams) {
//! params.style = Style::Ink(InkParams::default().with(|ink| ink.background = InkBackground::Picture));
//! # }
//! ```
//!
//! A pass that a package or a frame does not need costs nothing; [`Frame::report`] names what ran.

mod bounds;
mod camera;
mod contours;
mod debug;
mod error;
mod frame;
mod fur_motion;
mod gpu;
mod guide_motion;
mod hair;
mod hooks;
mod ink;
mod instance;
mod light;
mod model;
mod motion;
mod painting;
mod params;
mod passes;
mod renderer;
mod report;
mod scene;
pub mod shared;
mod study;
mod surface;

// Files that tests share with the examples name the crate.
#[cfg(test)]
extern crate self as pelage_runtime;
#[cfg(test)]
mod frame_tests;
#[cfg(test)]
mod layout_tests;
#[cfg(test)]
mod lean_tests;
#[cfg(test)]
mod light_tests;
#[cfg(test)]
mod swing_tests;

pub use bounds::Sphere;
pub use camera::{Camera, Light, Projection};
pub use error::RuntimeError;
pub use frame::Frame;
#[cfg(feature = "study")]
pub use gpu::ShaderVariant;
pub use hooks::Hooks;
pub use instance::{Instance, Motion};
pub use light::{CasterPass, Casters, LightView, ShadowMaps};
pub use model::Model;
pub use painting::{PictureStroke, StrokeLayer, StrokeMark};
#[cfg(feature = "study")]
pub use params::{Anchoring, FeatureRule, LightingStage, OpacityForm, PenumbraForm, SlantForm, SphereMapForm, Study};
pub use params::{
    BrushParams, BrushSheet, DebugView, Detail, FrameParams, FurDebugView, FurParams, HairGeometry, HairMotionParams,
    InkBackground, InkDebugView, InkLines, InkParams, LineWidth, MAX_FILL_LIGHTS, RendererOptions, Scattering, Seal,
    SelfShadow, ShadowParams, StrandEdges, Style, StyleKind, ToneMapping, Wind,
};
pub use passes::{PassId, PassStage};
pub use renderer::Renderer;
pub use report::{CreatedObjects, FrameReport, InstanceDetail, PassReport};

pub use glam;
pub use pelage_formats as formats;
pub use pelage_formats::ClipLayer;
pub use pelage_formats::meaning::environment::{Environment, LightLobe, Sun};
pub use pelage_formats::meaning::hair_motion::Capsule;
pub use pelage_formats::meaning::seal::SealImage;
pub use wgpu;

/// Rust code of the Markdown documents, compiled as doc tests together with the examples in these comments.
#[cfg(doctest)]
mod documents {
    #[doc = include_str!("../../README.md")]
    struct Readme;
    #[doc = include_str!("../docs/application.md")]
    struct Application;
}
