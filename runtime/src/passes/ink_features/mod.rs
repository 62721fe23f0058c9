//! `ink_features`: finds the pixels through which lines run, with the half width and strength of each line.
//! Neighbouring normals are compared at two thresholds (Fang 2006, §2).

use super::{Outcome, Pass, PassId, PassStage, ink_normals};
use crate::gpu::{Shader, Target};
use crate::params::{InkLines, StyleKind};
use crate::scene::{Recording, ScreenPass, ink_screen_wgsl};

pub(crate) const SHADER: Shader =
    Shader { name: "pelage ink features", parts: ink_screen_wgsl!(include_str!("ink_features.wgsl")) };

/// Half width and strength of the line through each pixel, and its strength as an outline.
pub(crate) const FEATURES: Target = Target::new("pelage ink features", wgpu::TextureFormat::Rgba8Unorm);

impl PassId {
    /// Ink: pixels through which lines run.
    pub const INK_FEATURES: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "ink_features",
    place: PassStage::Before,
    styles: &[StyleKind::Ink],
    lines: Some(InkLines::Pixels),
    does: "finds the pixels that lines run through, from neighbouring normals at two thresholds (Fang 2006, §2) and \
         from depth steps",
    runs_when: "ink lines are found in pixels",
    shaders: &[SHADER],
    targets: &[FEATURES],
    run,
};

fn run(frame: &mut Recording<'_>) -> Outcome {
    let reads = &[(1, ink_normals::NORMALS), (2, ink_normals::SURFACES)];
    frame.run_screen_pass(SHADER, "fs_features", &ScreenPass { reads, ..ScreenPass::default() }, &FEATURES);
    let [width, height] = frame.params.viewport;
    Outcome::recorded(format!("{width} x {height}"))
}
