//! `ink_stroke`: opacity and grey of lines. The dilated features are filled by brush and sphere map (Fang 2006, §2),
//! and roughened by the paper.

use super::{Outcome, Pass, PassId, PassStage, ink_dilate, ink_normals, ink_trace};
use crate::gpu::{Shader, Target};
use crate::params::{InkLines, StyleKind};
use crate::scene::{Recording, ScreenPass, ink_screen_wgsl};

pub(crate) const SHADER: Shader =
    Shader { name: "pelage ink stroke", parts: ink_screen_wgsl!(include_str!("ink_stroke.wgsl")) };

/// Opacity and darkness of the lines, and offsets to their features.
pub(crate) const STROKES: Target = Target::new("pelage ink strokes", wgpu::TextureFormat::Rgba8Unorm);

impl PassId {
    /// Ink: lines.
    pub const INK_STROKE: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "ink_stroke",
    place: PassStage::Before,
    styles: &[StyleKind::Ink],
    lines: Some(InkLines::Pixels),
    does: "repeats the search of `ink_dilate` along columns, and writes opacity and darkness of the line: the brush \
         fills its core, the sphere map the rest of its width",
    runs_when: "ink lines are found in pixels",
    shaders: &[SHADER],
    targets: &[STROKES],
    run,
};

fn run(frame: &mut Recording<'_>) -> Outcome {
    let screen = ScreenPass {
        reads: &[(1, ink_normals::NORMALS), (2, ink_normals::SURFACES), (3, ink_trace::TRACED), (4, ink_dilate::ROWS)],
        paper: Some([5, 6]),
        ..ScreenPass::default()
    };
    frame.run_screen_pass(SHADER, "fs_stroke", &screen, &STROKES);
    Outcome::recorded(format!("{} pixels along columns", frame.ink_reach_px()))
}
