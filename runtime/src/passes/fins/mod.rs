//! `fins`: hair quads on mesh edges, faded by viewing angle (Lengyel 2001). They are blended into the application's
//! colour target, with depth test and without depth write. Runs between `skin` and `shells`.

use super::{Outcome, Pass, PassId, PassStage, any_reduced};
use crate::gpu::{DrawBindGroup, RenderSpec, Shader, flag};
use crate::hair::{groom_constants, hair_wgsl, material_constants};
use crate::model::Part;
use crate::params::StyleKind;
use crate::scene::{Recording, VisibleInstance, fin_draws};

pub(crate) const SHADER: Shader = Shader {
    name: "pelage fins",
    parts: hair_wgsl!(
        include_str!("../../surface/geometry.wgsl"),
        include_str!("../../hair/fin_corner.wgsl"),
        include_str!("fins.wgsl"),
    ),
};

impl PassId {
    /// Hair quads on mesh edges, visible when they face the eye.
    pub const FINS: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "fins",
    place: PassStage::Picture,
    styles: &[StyleKind::Fur],
    lines: None,
    does: "draws quads of hair on the edges of the skin, faded by viewing angle. The vertex shader reads them from \
         storage buffers, because each corner needs both ends of its edge",
    runs_when: "fur is visible, the package has fins, and the device has storage buffers in vertex shaders",
    shaders: &[SHADER],
    targets: &[],
    run,
};

fn spec(frame: &Recording<'_>, seen: &VisibleInstance, part: &Part) -> RenderSpec {
    let mut constants = material_constants(part);
    constants.extend(seen.look.lit_surface_constants());
    constants.extend(groom_constants(&seen.model, part));
    constants.extend([
        flag("LEAN", seen.model.varies().lean),
        flag("PLANAR_DIRECTIONS", seen.model.fins().is_some_and(|fins| fins.planar_directions)),
    ]);
    // Fins are visible from both sides and occlude nothing.
    let spec = frame.picture_spec(SHADER, ["vs_fins", "fs_fins"], constants, [false, true], true);
    RenderSpec { depth: Some(frame.picture_depth(false, true)), ..spec }
}

fn run(frame: &mut Recording<'_>) -> Outcome {
    let instances = frame.instances.clone();
    let (mut draws, mut with_fins, mut edges) = (Vec::new(), 0, 0);
    for seen in instances.iter().filter(|seen| seen.in_picture() && seen.look.fins) {
        let textures = seen.model.fins().and_then(|fins| DrawBindGroup::of(&fins.textures));
        let of_model = fin_draws(frame, seen, textures, |frame, part| spec(frame, seen, part));
        if !of_model.is_empty() {
            with_fins += 1;
            edges += seen.model.parts().iter().map(|part| part.fins.len()).sum::<usize>();
            draws.extend(of_model);
        }
    }
    if edges > 0 {
        return Outcome::Ran(format!("{with_fins} instances, {edges} edges"), draws);
    }
    let fur = frame.params.style.fur();
    Outcome::Skipped(match (instances.is_empty(), fur.and_then(|fur| fur.layers)) {
        (true, _) => "no instances",
        (_, Some(1)) => "the only layer is the skin",
        _ if fur.is_some_and(|fur| !fur.fins) => "switched off",
        _ if !instances.iter().any(VisibleInstance::in_picture) => "nothing is in the picture",
        _ if any_reduced(frame) => "the fur is too small on screen",
        _ if instances.iter().any(|seen| seen.model.manifest().fur.fins.is_some()) => {
            "no edges, or no storage buffers in vertex shaders"
        }
        _ => "no package has fins",
    })
}
