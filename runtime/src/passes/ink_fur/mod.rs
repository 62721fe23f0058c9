//! `ink_fur`: draws fins and outer shells as dry brush strokes, blended over the painting in the application's pass,
//! with depth test and without depth write.

use super::{Outcome, Pass, PassId, PassStage, ink_normals};
use crate::gpu::{Draw, RenderSpec, Shader, flag, primitive_state};
use crate::hair::material_constants;
use crate::model::Part;
use crate::params::{InkDebugView, InkLines, StyleKind};
use crate::scene::{Recording, VisibleInstance, fin_draws, has_strokes, ink_surface_wgsl};

pub(crate) const SHADER: Shader = Shader {
    name: "pelage ink fur",
    parts: ink_surface_wgsl!(
        include_str!("../../shared/srgb.wgsl"),
        include_str!("../../surface/geometry.wgsl"),
        include_str!("../../hair/fin_corner.wgsl"),
        include_str!("ink_fur.wgsl")
    ),
};

/// Number of shells with strokes; equal to `STROKE_SHELLS` in the shader.
pub(crate) const SHELLS: u32 = 2;

impl PassId {
    /// Ink: fur strokes over paper, wash and lines.
    pub const INK_FUR: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "ink_fur",
    place: PassStage::Picture,
    styles: &[StyleKind::Ink],
    lines: Some(InkLines::Pixels),
    does: "draws fins and two outer shells as dry strokes",
    runs_when: "ink lines are found in pixels, and a package has strokes of fur",
    shaders: &[SHADER],
    targets: &[],
    run,
};

fn spec(
    frame: &Recording<'_>,
    seen: &VisibleInstance,
    part: &Part,
    entries: [&'static str; 2],
    model_layout: &wgpu::BindGroupLayout,
) -> RenderSpec {
    let mut constants = material_constants(part);
    constants.push(flag("LEAN", seen.model.varies().lean));
    let sides = [seen.look.mirrored, part.double_sided];
    let mut spec = frame.picture_spec(SHADER, entries, constants, sides, true);
    spec.groups[2] = model_layout.clone();
    RenderSpec { depth: Some(frame.picture_depth(false, true)), ..spec }
}

fn draws(frame: &mut Recording<'_>, index: usize, seen: &VisibleInstance, with_fins: bool) -> Vec<Draw> {
    let Some((layout, group)) = frame.ink_model_group(index, Some(ink_normals::NORMALS)) else { return Vec::new() };
    let groups = [frame.eye_group(seen), Some(group.clone())];
    let shells =
        |frame: &Recording<'_>, part: &Part| spec(frame, seen, part, ["vs_ink_shells", "fs_ink_shells"], &layout);
    let mut draws = frame.part_draws(seen, |part| part.furred, groups, 0..SHELLS, shells);
    if with_fins {
        let fins = |frame: &Recording<'_>, part: &Part| {
            let spec = spec(frame, seen, part, ["vs_ink_fins", "fs_ink_fins"], &layout);
            // Fins are visible from both sides.
            RenderSpec { primitive: primitive_state(false, true), ..spec }
        };
        draws.extend(fin_draws(frame, seen, Some(group), fins));
    }
    draws
}

fn run(frame: &mut Recording<'_>) -> Outcome {
    if frame.params.debug.ink != InkDebugView::Painting {
        return Outcome::Skipped("the painting is not shown");
    }
    let Some(ink) = frame.params.style.ink() else { return Outcome::Skipped("the style is not ink") };
    let instances = frame.instances.clone();
    let (mut all, mut furry) = (Vec::new(), 0);
    let shown = instances.iter().enumerate().filter(|(_, seen)| seen.in_picture() && has_strokes(seen, ink));
    for (index, seen) in shown {
        let draws = draws(frame, index, seen, ink.fins);
        furry += usize::from(!draws.is_empty());
        all.extend(draws);
    }
    match furry {
        0 => Outcome::Skipped("no package has strokes of fur to draw"),
        _ => Outcome::Ran(format!("fins and {SHELLS} shells on each of {furry} instances"), all),
    }
}
