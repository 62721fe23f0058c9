//! `ink_dilate`: the row search of the dilation; `ink_stroke` searches the columns. Together they are one dilation by a
//! disc of each feature's own size, which replaces three dilations by 3 x 3 pixels.

use super::{Outcome, Pass, PassId, PassStage, ink_trace};
use crate::gpu::{Shader, Target};
use crate::params::{InkLines, StyleKind};
use crate::scene::{Recording, ScreenPass, ink_screen_wgsl};

pub(crate) const SHADER: Shader =
    Shader { name: "pelage ink dilate", parts: ink_screen_wgsl!(include_str!("ink_dilate.wgsl")) };

/// Result of the row search.
pub(crate) const ROWS: Target = Target::new("pelage ink rows", wgpu::TextureFormat::Rgba8Unorm);

impl PassId {
    /// Ink: reach of lines along pixel rows.
    pub const INK_DILATE: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "ink_dilate",
    place: PassStage::Before,
    styles: &[StyleKind::Ink],
    lines: Some(InkLines::Pixels),
    does: "for each pixel, finds the feature in the same row whose line extends farthest over the pixel, and the \
         weighted share of features within reach",
    runs_when: "ink lines are found in pixels",
    shaders: &[SHADER],
    targets: &[ROWS],
    run,
};

fn run(frame: &mut Recording<'_>) -> Outcome {
    let reads = &[(1, ink_trace::TRACED)];
    frame.run_screen_pass(SHADER, "fs_dilate", &ScreenPass { reads, ..ScreenPass::default() }, &ROWS);
    Outcome::recorded(format!("{} pixels along rows", frame.ink_reach_px()))
}
