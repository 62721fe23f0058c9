//! `strand_shadow`: deep opacity map of single strands, seen from the key light.

use super::{Outcome, Pass, PassId, PassStage};
use crate::gpu::{
    BindingResource, ComputeSpec, DrawBindGroup, Shader, depth_texture, flag, in_compute, storage_out, uniform,
};
use crate::hair::{StrandSetDrawing, growth_constants};
use crate::light::CasterPass;
use crate::params::StyleKind;
use crate::scene::{Dispatch, Recording, posed_layout, record_depth, record_dispatches, strand_sets};
use crate::shared::deep_opacity::DeepOpacity;

pub(crate) const SHADER: Shader = Shader {
    name: "pelage strand shadow",
    parts: &[
        include_str!("../../shared/frame.wgsl"),
        include_str!("../../shared/skinning.wgsl"),
        include_str!("../../shared/tile_frame.wgsl"),
        include_str!("../../surface/place.wgsl"),
        include_str!("../../shared/deep_opacity.wgsl"),
        crate::study::form_wgsl!("light/deep_forms.wgsl"),
        include_str!("../../hair/constants.wgsl"),
        include_str!("../../hair/strand.wgsl"),
        include_str!("../../hair/posed.wgsl"),
        include_str!("strand_shadow.wgsl"),
    ],
};

impl PassId {
    /// Compute pass: deep opacity map of strands.
    pub const STRAND_SHADOW: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "strand_shadow",
    place: PassStage::Before,
    styles: &[StyleKind::Fur],
    lines: None,
    does: "compute: measures how much hair lies between the key light and each point, in slabs behind the first hair \
         of each texel (a deep opacity map)",
    runs_when: "strands are drawn with self-shadow, and light, pose or model changed",
    shaders: &[SHADER],
    targets: &[],
    run,
};

/// Minimum number of segments of a strand in the map.
const FEWEST_PIECES: u32 = 4;
/// Minimum number of segments of guided hair, which bends around bodies. A segment that cuts a corner would be inside
/// the body and cast no shadow.
const FEWEST_GUIDED: u32 = 16;

fn run(frame: &mut Recording<'_>) -> Outcome {
    let maps = frame.maps.clone();
    let Some((maps, deep)) = maps.as_deref().and_then(|maps| maps.deep.as_ref().map(|deep| (maps, deep))) else {
        return Outcome::Skipped("no strands are drawn, or they receive no shadows");
    };
    if !frame.redraws_maps() {
        return Outcome::Skipped("light, poses and models are unchanged");
    }
    // The depth map is recorded here, because later passes need the same map.
    record_depth(frame, maps, CasterPass::Nearest);
    let layout = frame.cache.layouts.get(frame.gpu, SHADER.name, || {
        let mut entries = posed_layout().to_vec();
        entries.extend([
            storage_out::<u32>(4),
            in_compute(depth_texture(5, wgpu::TextureViewDimension::D2)),
            in_compute(uniform::<DeepOpacity>(6, false)),
        ]);
        entries
    });
    let block = frame.uniforms.put(frame.gpu, &[maps.deep_opacity()]);
    let instances = frame.instances.clone();
    let (mut first, mut opacity) = (Vec::new(), Vec::new());
    for (seen, set) in strand_sets(&instances) {
        let strands = set.strands;
        let pieces = strands.points - 1;
        let fewest = if strands.guided().is_some() { FEWEST_GUIDED } else { FEWEST_PIECES };
        let step = strands.steps().rfind(|step| pieces / step >= fewest).unwrap_or(1);
        // A fixed share of the strands makes the map independent of the distance of the eye.
        let share = strands.shadow_share();
        let thrown = StrandSetDrawing { share, widened: share.recip(), step, ..*set.drawn };
        for (part, of_part) in set.parts(seen.model.parts(), share) {
            let mut entries = frame.posed_strands(&set, &of_part, &thrown).to_vec();
            entries.extend([
                (4, BindingResource::all(deep)),
                (5, BindingResource::View(maps.nearest.view.clone())),
                (6, BindingResource::block::<DeepOpacity>(&block.buffer, block.offset)),
            ]);
            let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
            let mut dispatch = |entry| {
                let surfaces = frame.surfaces;
                let groups = vec![surfaces.frame.clone(), surfaces.material.clone(), layout.clone()];
                let coat = strands.guided().is_none();
                let constants = if coat { growth_constants(&seen.model, part) } else { vec![flag("GUIDED", true)] };
                let spec = ComputeSpec { shader: SHADER, entry, groups, constants };
                Dispatch {
                    pipeline: frame.compute_pipeline(spec),
                    groups: vec![frame.light_group(seen), DrawBindGroup::of(&part.material), DrawBindGroup::of(&group)],
                    threads: of_part.len() as u32,
                }
            };
            first.push(dispatch("find_first"));
            opacity.push(dispatch("add_opacity"));
        }
    }
    frame.encoder.clear_buffer(deep, 0, None);
    // All strands must find the first depth before any strand adds opacity behind it.
    first.append(&mut opacity);
    record_dispatches(frame.encoder, SHADER.name, &first);
    let DeepOpacity { size, slabs, .. } = maps.deep_opacity();
    Outcome::recorded(format!("{slabs} slabs, {size} x {size}"))
}
