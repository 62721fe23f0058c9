//! One pass is one folder: its shader, what it draws to, its pipelines, when it runs, and its words in reports. Their order is the list in
//! `frame.rs`.

pub(crate) mod fins;
pub(crate) mod fur_motion;
pub(crate) mod hair_motion;
pub(crate) mod hair_pose;
pub(crate) mod ink_composite;
pub(crate) mod ink_dilate;
pub(crate) mod ink_features;
pub(crate) mod ink_fur;
pub(crate) mod ink_normals;
pub(crate) mod ink_stroke;
pub(crate) mod ink_trace;
pub(crate) mod layer_shadow;
pub(crate) mod pose;
#[cfg(test)]
pub(crate) mod probe;
pub(crate) mod shadow_width;
pub(crate) mod shells;
pub(crate) mod skin;
pub(crate) mod strand_blend;
pub(crate) mod strand_gather;
pub(crate) mod strand_light;
pub(crate) mod strand_pose;
pub(crate) mod strand_shadow;
pub(crate) mod strands;

use crate::gpu::{Draw, Shader, Target};
use crate::params::StyleKind;
use crate::scene::Recording;
use glam::Mat3;
use std::fmt;

/// When a pass is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PassPlace {
    /// By [`crate::Renderer::prepare`], before the application's render pass.
    Before,
    /// By [`crate::Frame::draw`], in the application's render pass.
    Picture,
}

/// A pass: what it is, whatever the frame, and what it does in one. It keeps nothing: what lasts is the renderer's.
pub(crate) struct Pass {
    pub(crate) name: &'static str,
    pub(crate) place: PassPlace,
    /// Styles of frames that have it.
    pub(crate) styles: &'static [StyleKind],
    /// What it does, as documents say it.
    pub(crate) does: &'static str,
    /// When it runs, as documents say it.
    pub(crate) runs_when: &'static str,
    #[cfg_attr(not(test), expect(dead_code, reason = "tests hold all shaders against the Rust that feeds them"))]
    pub(crate) shaders: &'static [Shader],
    /// Textures of the picture's size that it draws to.
    pub(crate) targets: &'static [Target],
    /// Records it, or plans its draws in the application's pass, in a frame of one of its styles.
    pub(crate) run: fn(&mut Recording<'_>) -> Outcome,
}

/// A matrix as uniforms have it.
pub(crate) fn columns(m: Mat3) -> [[f32; 4]; 3] {
    [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.extend(0.0).to_array())
}

/// A pass of a frame.
#[derive(Clone, Copy)]
pub struct PassId(pub(crate) &'static Pass);

impl PassId {
    /// Name in reports.
    pub fn name(self) -> &'static str {
        self.0.name
    }

    /// When it is recorded.
    pub fn place(self) -> PassPlace {
        self.0.place
    }

    /// Styles of frames that have it.
    pub fn styles(self) -> &'static [StyleKind] {
        self.0.styles
    }

    /// What it does, in a sentence.
    pub fn does(self) -> &'static str {
        self.0.does
    }

    /// When it runs, in a sentence.
    pub fn runs_when(self) -> &'static str {
        self.0.runs_when
    }
}

impl PartialEq for PassId {
    fn eq(&self, other: &Self) -> bool {
        self.0.name == other.0.name
    }
}

impl Eq for PassId {}

impl fmt::Debug for PassId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0.name)
    }
}

/// What a pass does in a frame.
#[derive(Debug)]
pub(crate) enum Outcome {
    /// Nothing, and why.
    Skipped(&'static str),
    /// What it did, or will do with these draws in the application's pass.
    Ran(String, Vec<Draw>),
}

impl Outcome {
    /// What a pass recorded before the picture.
    pub(crate) fn recorded(words: String) -> Self {
        Self::Ran(words, Vec::new())
    }
}

/// Whether some fur is left out because it is small on screen.
pub(crate) fn any_reduced(frame: &Recording<'_>) -> bool {
    frame.instances.iter().any(|seen| seen.drawing.is_reduced())
}

/// Nothing, because the frame is of a style without the pass.
pub(crate) fn not_of(style: StyleKind) -> Outcome {
    Outcome::Skipped(match style {
        StyleKind::Fur => "style is fur",
        StyleKind::Bare => "style is bare",
        StyleKind::Ink => "style is ink",
    })
}
