//! `ink_trace`: selects the features that form lines, by following them to both sides. Features are detected per pixel,
//! and the normals of a dense mesh change at every face. The continuation of a line decides whether it is drawn, with
//! which strength and width.

use super::{Outcome, Pass, PassId, PassStage, ink_features, ink_normals};
use crate::gpu::{Shader, Target};
use crate::params::{InkLines, StyleKind};
use crate::scene::{Recording, ScreenPass, ink_screen_wgsl};

pub(crate) const SHADER: Shader =
    Shader { name: "pelage ink trace", parts: ink_screen_wgsl!(include_str!("ink_trace.wgsl")) };

/// Features that form lines.
pub(crate) const TRACED: Target = Target::new("pelage ink traced", ink_features::FEATURES.format);

impl PassId {
    /// Ink: the features that form lines.
    pub const INK_TRACE: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "ink_trace",
    place: PassStage::Before,
    styles: &[StyleKind::Ink],
    lines: Some(InkLines::Pixels),
    does: "follows the line of each feature in both directions: removes lines that end soon inside the body, and \
         smooths strength and width",
    runs_when: "ink lines are found in pixels",
    shaders: &[SHADER],
    targets: &[TRACED],
    run,
};

fn run(frame: &mut Recording<'_>) -> Outcome {
    let reads = &[(1, ink_normals::NORMALS), (2, ink_features::FEATURES)];
    frame.run_screen_pass(SHADER, "fs_trace", &ScreenPass { reads, ..ScreenPass::default() }, &TRACED);
    let [width, height] = frame.params.viewport;
    Outcome::recorded(format!("{width} x {height}"))
}
