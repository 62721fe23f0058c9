//! `skin`: draws the opaque base mesh, including bare parts, into the application's colour target, with depth write.

use super::{Outcome, Pass, PassId, PassStage};
use crate::gpu::{RenderSpec, Shader, flag};
use crate::hair::{groom_constants, hair_wgsl, material_constants};
use crate::model::Part;
use crate::params::StyleKind;
use crate::scene::{Recording, VisibleInstance};
use crate::surface::BARE_NORMALS;

pub(crate) const SHADER: Shader =
    Shader { name: "pelage skin", parts: hair_wgsl!(include_str!("../../hair/coat.wgsl"), include_str!("skin.wgsl")) };

impl PassId {
    /// Opaque base mesh, including bare parts.
    pub const SKIN: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "skin",
    place: PassStage::Picture,
    styles: &[StyleKind::Fur, StyleKind::Bare],
    lines: None,
    does: "draws the opaque base mesh and writes depth",
    runs_when: "always, except in ink",
    shaders: &[SHADER],
    targets: &[],
    run,
};

fn spec(frame: &Recording<'_>, seen: &VisibleInstance, part: &Part, furred: bool) -> RenderSpec {
    let (model, look) = (&seen.model, &seen.look);
    let mut constants = material_constants(part);
    constants.push(flag("GLOSS", part.glossy));
    constants.extend(look.lit_surface_constants());
    let sides = [look.mirrored, part.double_sided];
    let bare_normals = model.bare_normals().is_some();
    let stream = bare_normals.then_some(BARE_NORMALS);
    if !furred {
        constants.push(flag("ROLL_OFF", frame.params.style.kind() == StyleKind::Bare));
        let vertex = if bare_normals { "vs_bare_with_normals" } else { "vs_bare" };
        let mut spec = frame.picture_spec(SHADER, [vertex, "fs_bare"], constants, sides, false);
        // Bare parts need no hair textures.
        spec.groups.truncate(2);
        spec.streams.extend(stream);
        return spec;
    }
    constants.extend(groom_constants(model, part));
    constants.extend([
        // The mesh surface needs the lean only if it is raised to the far fur layer.
        flag("LEAN", model.varies().lean && look.coat),
        flag("PLANAR_DIRECTIONS", model.planar_directions()),
        flag("COAT", look.coat),
        flag("BARE_NORMALS", bare_normals),
    ]);
    let vertex = if bare_normals { "vs_furred_with_normals" } else { "vs_furred" };
    let mut spec = frame.picture_spec(SHADER, [vertex, "fs_furred"], constants, sides, false);
    spec.streams.extend(stream);
    spec
}

fn run(frame: &mut Recording<'_>) -> Outcome {
    let mut draws = Vec::new();
    let instances = frame.instances.clone();
    let shown = || instances.iter().filter(|seen| seen.in_picture());
    let furry = frame.params.style.fur().is_some();
    for seen in shown() {
        let groups = [frame.eye_group(seen), seen.fur()];
        let spec = |frame: &Recording<'_>, part: &Part| spec(frame, seen, part, part.furred && furry);
        let mut of_parts = frame.part_draws(seen, |_| true, groups, 0..1, spec);
        of_parts.iter_mut().for_each(|draw| draw.vertices[2] = seen.model.bare_normals().cloned());
        draws.extend(of_parts);
    }
    if draws.is_empty() {
        return Outcome::Skipped(if instances.is_empty() { "no instances" } else { "nothing is in the picture" });
    }
    let coats = shown().filter(|seen| seen.look.coat).count();
    let coats = if coats > 0 { format!(", {coats} with the far fur layer") } else { String::new() };
    Outcome::Ran(format!("{} instances, {} parts{coats}", shown().count(), draws.len()), draws)
}
