//! Render passes, one folder each: shader, targets, pipelines, run condition and report texts. `frame.rs` lists them in
//! order.

pub(crate) mod fins;
pub(crate) mod fur_motion;
pub(crate) mod hair_motion;
pub(crate) mod hair_pose;
pub(crate) mod ink_composite;
pub(crate) mod ink_contours;
pub(crate) mod ink_dilate;
pub(crate) mod ink_features;
pub(crate) mod ink_fur;
pub(crate) mod ink_lines;
pub(crate) mod ink_normals;
pub(crate) mod ink_seal;
pub(crate) mod ink_stroke;
pub(crate) mod ink_trace;
pub(crate) mod layer_shadow;
pub(crate) mod painting_depth;
pub(crate) mod painting_ribbons;
pub(crate) mod painting_sheet;
pub(crate) mod painting_strokes;
pub(crate) mod painting_wet;
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
use crate::params::{InkLines, StyleKind};
use crate::scene::Recording;
use glam::Mat3;
use std::fmt;

/// Stage of the frame at which a pass is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PassStage {
    /// Recorded by [`crate::Renderer::prepare`], before the application's render pass.
    Before,
    /// Recorded by [`crate::Frame::draw`], in the application's render pass.
    Picture,
}

/// Pass descriptor: properties that do not depend on the frame, and the function that runs the pass. Stateless; the
/// renderer owns all persistent data.
pub(crate) struct Pass {
    pub(crate) name: &'static str,
    pub(crate) place: PassStage,
    /// Styles of the frames in which the pass can run.
    pub(crate) styles: &'static [StyleKind],
    /// Ink lines with which the pass runs; `None` for all.
    pub(crate) lines: Option<InkLines>,
    /// Description for documentation.
    pub(crate) does: &'static str,
    /// Run condition for documentation.
    pub(crate) runs_when: &'static str,
    #[cfg_attr(not(test), expect(dead_code, reason = "tests compare all shaders with the Rust that feeds them"))]
    pub(crate) shaders: &'static [Shader],
    /// Targets of the picture's size that the pass uses.
    pub(crate) targets: &'static [Target],
    /// Records the pass, or plans its draws in the application's pass. Called only in frames of one of its styles.
    pub(crate) run: fn(&mut Recording<'_>) -> Outcome,
}

/// Returns the matrix in uniform layout: three columns padded to four components.
pub(crate) fn columns(m: Mat3) -> [[f32; 4]; 3] {
    [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.extend(0.0).to_array())
}

/// Identifier of a render pass.
#[derive(Clone, Copy)]
pub struct PassId(pub(crate) &'static Pass);

impl PassId {
    /// Returns the name used in reports.
    pub fn name(self) -> &'static str {
        self.0.name
    }

    /// Returns when the pass is recorded.
    pub fn stage(self) -> PassStage {
        self.0.place
    }

    /// Returns the styles of the frames in which the pass can run.
    pub fn styles(self) -> &'static [StyleKind] {
        self.0.styles
    }

    /// Returns a description of the pass, in one sentence.
    pub fn does(self) -> &'static str {
        self.0.does
    }

    /// Returns the condition under which the pass runs, in one sentence.
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

/// Result of a pass in a frame.
#[derive(Debug)]
pub(crate) enum Outcome {
    /// Skipped, with the reason for the report.
    Skipped(&'static str),
    /// Ran, with a text for the report, and draws to record in the application's pass.
    Ran(String, Vec<Draw>),
}

impl Outcome {
    /// Returns the outcome of a pass that was recorded before the application's pass. `words`: report text.
    pub(crate) fn recorded(words: String) -> Self {
        Self::Ran(words, Vec::new())
    }
}

/// Returns whether the fur of any instance is reduced because it is small on screen.
pub(crate) fn any_reduced(frame: &Recording<'_>) -> bool {
    frame.instances.iter().any(|seen| seen.drawing.is_reduced())
}

/// Returns the outcome in ink frames whose lines do not include the pass.
pub(crate) fn skipped_for_lines(lines: Option<InkLines>) -> Outcome {
    Outcome::Skipped(match lines {
        Some(InkLines::Strokes) => "ink is painted with strokes",
        _ => "ink lines are pixels, as asked, or because a package or the device lacks what strokes need",
    })
}

/// Returns the outcome in frames whose style does not include the pass.
pub(crate) fn skipped_for_style(style: StyleKind) -> Outcome {
    Outcome::Skipped(match style {
        StyleKind::Fur => "style is fur",
        StyleKind::Bare => "style is bare",
        StyleKind::Ink => "style is ink",
    })
}
