//! `shells`: draws the hair layers above the skin, from the inside out, into the application's colour target. Blended,
//! with depth test and depth write (Lengyel 2001; Yang 2006, §2).

use super::{Outcome, Pass, PassId, PassStage, any_reduced};
use crate::gpu::{Draw, RenderSpec, Shader, flag};
use crate::hair::{groom_constants, hair_wgsl, material_constants};
use crate::model::Part;
use crate::params::StyleKind;
use crate::scene::{Recording, VisibleInstance};
use std::ops::Range;

/// Shader of the `shells` pass.
pub(crate) const SHADER: Shader = Shader {
    name: "pelage shells",
    parts: hair_wgsl!(
        include_str!("../../light/tones.wgsl"),
        include_str!("varying.wgsl"),
        include_str!("shells.wgsl"),
        include_str!("../../debug/yardstick.wgsl")
    ),
};

impl PassId {
    /// Hair layers, from the inside out.
    pub const SHELLS: Self = Self(&PASS);
}

/// Descriptor of the `shells` pass.
pub(crate) const PASS: Pass = Pass {
    name: "shells",
    place: PassStage::Picture,
    styles: &[StyleKind::Fur],
    lines: None,
    does: "draws layers from the skin outwards, each pixel lit by Yang 2006, eq. (3)",
    runs_when: "fur is visible",
    shaders: &[SHADER],
    targets: &[],
    run,
};

fn spec(frame: &Recording<'_>, seen: &VisibleInstance, part: &Part) -> RenderSpec {
    let (model, look) = (&seen.model, &seen.look);
    let varies = model.varies();
    let of_material = part.has_texture || part.cutout || part.has_groom_texture;
    let of_coat = varies.lean || varies.groom || model.manifest().fur.wet.is_some();
    // Use the variant with the fewest interpolants.
    let entries = if look.lit_at_vertices() {
        ["vs_shells_sky", "fs_shells_sky"]
    } else if look.fill_lights || look.environment.is_some() {
        ["vs_shells_filled", "fs_shells_filled"]
    } else if of_material || of_coat || look.resampled || look.maps_between {
        ["vs_shells_mapped", "fs_shells_mapped"]
    } else {
        ["vs_shells", "fs_shells"]
    };
    let mut constants = material_constants(part);
    constants.extend(look.lit_surface_constants());
    constants.extend(groom_constants(model, part));
    constants.extend([
        flag("LEAN", varies.lean),
        flag("PLANAR_DIRECTIONS", model.planar_directions()),
        flag("RESAMPLED", look.resampled),
        flag("DETAIL", look.detail),
        flag("MAPS_BETWEEN", look.maps_between),
    ]);
    frame.picture_spec(SHADER, entries, constants, [look.mirrored, part.double_sided], true)
}

fn layers(frame: &Recording<'_>, seen: &VisibleInstance) -> Range<u32> {
    frame.params.debug.only_layer.map_or_else(
        || seen.drawing.shell_instances(),
        |k| k.min(seen.drawing.layers)..(k + 1).min(seen.drawing.layers),
    )
}

fn draws(frame: &mut Recording<'_>, seen: &VisibleInstance) -> Vec<Draw> {
    let (layers, groups) = (layers(frame, seen), [frame.eye_group(seen), seen.fur()]);
    let spec = |frame: &Recording<'_>, part: &Part| spec(frame, seen, part);
    let draws = frame.part_draws(seen, |part| part.furred, groups, layers.clone(), spec);
    if draws.len() < 2 {
        // Instances of one draw are rasterised in order, so one draw per part covers all layers.
        return draws;
    }
    // Adjacent parts may overlap, so their layers alternate: an outer layer of one part must not hide an inner layer of
    // another.
    let layer = |k: u32| draws.iter().map(move |draw| Draw { instances: k..k + 1, ..draw.clone() });
    layers.flat_map(layer).collect()
}

fn run(frame: &mut Recording<'_>) -> Outcome {
    let instances = frame.instances.clone();
    let (mut all, mut furry, mut drawn) = (Vec::new(), 0, 0);
    for seen in instances.iter().filter(|seen| seen.in_picture() && seen.drawing.draws_shells()) {
        let draws = draws(frame, seen);
        if !draws.is_empty() {
            furry += 1;
            drawn += seen.drawing.detail.layers;
            all.extend(draws);
        }
    }
    if drawn > 0 {
        let of: u32 = instances.iter().map(|seen| seen.drawing.detail.of_layers).sum();
        let of = if any_reduced(frame) { format!(" of {of}") } else { String::new() };
        let words = if frame.params.debug.yardstick { ", yardstick mode: one texture read, no lighting" } else { "" };
        return Outcome::Ran(format!("{furry} instances, {drawn}{of} layers{words}"), all);
    }
    Outcome::Skipped(match (instances.is_empty(), frame.params.style.fur().and_then(|fur| fur.layers)) {
        (true, _) => "no instances",
        (_, Some(1)) => "the only layer is the skin",
        _ if !instances.iter().any(VisibleInstance::in_picture) => "nothing is in the picture",
        _ if instances.iter().any(|seen| seen.look.strands) => "single strands are drawn instead",
        _ if any_reduced(frame) => "the fur is too small on screen: the skin shows the far fur layer",
        _ => "no package has fur",
    })
}
