//! `ink_composite`: draws paper, wash and lines into the application's pass, with the depth of the painted surface.

use super::{Outcome, Pass, PassId, PassStage, ink_normals, ink_stroke, ink_trace};
use crate::gpu::{Draw, Shader, flag};
use crate::params::{InkBackground, InkDebugView, InkLines, StyleKind};
use crate::scene::{Recording, ScreenPass, ink_screen_wgsl};

pub(crate) const SHADER: Shader = Shader {
    name: "pelage ink composite",
    parts: ink_screen_wgsl!(include_str!("ink_composite.wgsl"), include_str!("../../debug/ink_show.wgsl")),
};

impl PassId {
    /// Ink: paper, wash and lines.
    pub const INK_COMPOSITE: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "ink_composite",
    place: PassStage::Picture,
    styles: &[StyleKind::Ink],
    lines: Some(InkLines::Pixels),
    does: "draws paper, wash and lines into the application's pass, with the depth of what is painted",
    runs_when: "ink lines are found in pixels",
    shaders: &[SHADER],
    targets: &[],
    run,
};

fn run(frame: &mut Recording<'_>) -> Outcome {
    let lines = if frame.params.debug.ink == InkDebugView::Features { ink_trace::TRACED } else { ink_stroke::STROKES };
    let picture = frame.params.style.ink().is_some_and(|ink| ink.background == InkBackground::Picture);
    let screen = ScreenPass {
        constants: vec![flag("PICTURE", picture)],
        reads: &[(1, ink_normals::NORMALS), (2, ink_normals::SURFACES), (3, lines)],
        depth: Some((4, ink_normals::DEPTH)),
        paper: Some([5, 6]),
        clamped: Some(7),
    };
    let Some((mut spec, group)) = frame.screen_spec(SHADER, "fs_composite", &screen, frame.options.color_format) else {
        return Outcome::Skipped("the style is not ink");
    };
    spec.colors = vec![frame.picture_color(true)];
    spec.depth = Some(frame.picture_depth(true, false));
    spec.samples = frame.options.sample_count;
    let draw = Draw::screen(frame.pipeline(spec), &group);
    let [width, height] = frame.params.viewport;
    Outcome::Ran(format!("{width} x {height}"), vec![draw])
}
