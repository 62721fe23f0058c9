//! `skin`: the opaque base mesh, bare parts included, into the application's colour target, with depth write.

use super::{Outcome, Pass, PassId, PassPlace};
use crate::gpu::{RenderSpec, Shader, on};
use crate::hair::{groom, hair_wgsl, material};
use crate::model::Part;
use crate::params::StyleKind;
use crate::scene::{Recording, Seen};

/// Shader of the `skin` pass.
pub(crate) const SHADER: Shader =
    Shader { name: "pelage skin", parts: hair_wgsl!(include_str!("../../hair/coat.wgsl"), include_str!("skin.wgsl")) };

impl PassId {
    /// Opaque base mesh and bare parts.
    pub const SKIN: Self = Self(&PASS);
}

/// Descriptor of the `skin` pass.
pub(crate) const PASS: Pass = Pass {
    name: "skin",
    place: PassPlace::Picture,
    styles: &[StyleKind::Fur, StyleKind::Bare],
    does: "the opaque base mesh, depth written",
    runs_when: "always, but in ink",
    shaders: &[SHADER],
    targets: &[],
    run,
};

fn spec(frame: &Recording<'_>, seen: &Seen, part: &Part, furred: bool) -> RenderSpec {
    let (model, look) = (&seen.model, &seen.look);
    let mut constants = material(part);
    constants.extend(look.lights());
    let sides = [look.mirrored, part.double_sided];
    if !furred {
        constants.push(on("ROLL_OFF", frame.params.style.kind() == StyleKind::Bare));
        let mut spec = frame.picture_spec(SHADER, ["vs_bare", "fs_bare"], constants, sides, false);
        // Bare parts bind no hair textures.
        spec.groups.truncate(2);
        return spec;
    }
    constants.extend(groom(model, part));
    constants.extend([
        // The surface has no lean unless it is raised to the far fur layer.
        on("LEAN", model.varies().lean && look.coat),
        on("PLANAR_DIRECTIONS", model.planar_directions()),
        on("COAT", look.coat),
    ]);
    frame.picture_spec(SHADER, ["vs_furred", "fs_furred"], constants, sides, false)
}

fn run(frame: &mut Recording<'_>) -> Outcome {
    let mut draws = Vec::new();
    let instances = frame.instances.clone();
    let shown = || instances.iter().filter(|seen| seen.in_picture());
    let furry = frame.params.style.fur().is_some();
    for seen in shown() {
        let groups = [frame.seen_from_eye(seen), seen.fur()];
        let spec = |frame: &Recording<'_>, part: &Part| spec(frame, seen, part, part.furred && furry);
        draws.extend(frame.part_draws(seen, |_| true, groups, 0..1, spec));
    }
    if draws.is_empty() {
        return Outcome::Skipped(if instances.is_empty() { "no instances" } else { "nothing is in the picture" });
    }
    let coats = shown().filter(|seen| seen.look.coat).count();
    let coats = if coats > 0 { format!(", {coats} with the far coat") } else { String::new() };
    Outcome::Ran(format!("{} instances, {} parts{coats}", shown().count(), draws.len()), draws)
}
