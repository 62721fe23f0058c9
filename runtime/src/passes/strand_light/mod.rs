//! `strand_light`: builds ribbons of the visible strands and lights them, once per frame. Later passes read only their
//! vertices.

use super::{Outcome, Pass, PassId, PassStage};
use crate::gpu::{
    BindingResource, ComputeSpec, DrawBindGroup, Shader, WORKGROUP, flag, in_compute, storage_in, storage_out, uniform,
};
use crate::hair::{groom_constants, hair_wgsl, material_constants};
use crate::light::ShadowMaps;
use crate::model::Part;
use crate::params::StyleKind;
use crate::scene::{Dispatch, Recording, StrandsToDraw, VisibleInstance, posed_layout, record_dispatches, strand_sets};
use crate::shared::deep_opacity::DeepOpacity;

/// Shader of the `strand_light` pass.
pub(crate) const SHADER: Shader = Shader {
    name: "pelage strand light",
    parts: hair_wgsl!(
        include_str!("../../shared/deep_opacity.wgsl"),
        crate::study::form_wgsl!("light/deep_forms.wgsl"),
        include_str!("../../hair/constants.wgsl"),
        include_str!("../../hair/packed_light.wgsl"),
        include_str!("../../hair/strand.wgsl"),
        include_str!("../../hair/posed.wgsl"),
        include_str!("strand_light.wgsl"),
    ),
};

impl PassId {
    /// Compute pass: lit ribbons of the visible strands.
    pub const STRAND_LIGHT: Self = Self(&PASS);
}

/// Descriptor of the `strand_light` pass.
pub(crate) const PASS: Pass = Pass {
    name: "strand_light",
    place: PassStage::Before,
    styles: &[StyleKind::Fur],
    lines: None,
    does: "compute: finds the visible strands, and turns them into ribbons that face the eye, with the light at each \
         point",
    runs_when: "strands are drawn",
    shaders: &[SHADER],
    targets: &[],
    run,
};

fn constants(seen: &VisibleInstance, set: &StrandsToDraw<'_>, part: &Part) -> Vec<(&'static str, u32)> {
    let mut constants = seen.look.lit_strand_constants();
    constants.push(flag("DEEP_SHADOW", seen.look.deep_shadow));
    // The mesh surface and its groom do not apply to guided hair.
    if let Some(guided) = set.strands.guided() {
        constants.push(flag("HANGS", true));
        constants.push(("FIBRE", guided.fibre));
    } else {
        constants.extend(material_constants(part));
        constants.extend(groom_constants(&seen.model, part));
        constants.push(flag("LEAN", seen.model.varies().lean));
    }
    constants
}

fn run(frame: &mut Recording<'_>) -> Outcome {
    // Skip early: a device that cannot draw single hairs cannot create the layouts below.
    if !frame.instances.iter().any(|seen| seen.look.strands) {
        return Outcome::Skipped("no single hairs are visible");
    }
    let layout = frame.cache.layouts.get(frame.gpu, SHADER.name, || {
        let mut entries = posed_layout().to_vec();
        entries.extend([
            storage_out::<u32>(4),
            storage_out::<u32>(5),
            storage_out::<[u32; 4]>(6),
            storage_in::<u32>(7),
            in_compute(uniform::<DeepOpacity>(8, false)),
        ]);
        entries
    });
    let maps = frame.maps.clone();
    let maps = maps.as_deref();
    let block = frame.uniforms.put(frame.gpu, &[maps.map_or(DeepOpacity::default(), ShadowMaps::deep_opacity)]);
    let instances = frame.instances.clone();
    let [mut select, mut scan, mut light] = [Vec::new(), Vec::new(), Vec::new()];
    let mut count = 0;
    for (seen, set) in strand_sets(&instances) {
        let (strands, Some(ribbons)) = (set.strands, set.ribbons) else { continue };
        for (number, (part, of_part)) in set.parts(seen.model.parts(), set.drawn.share).enumerate() {
            // Without a map, this placeholder buffer is bound and never read.
            let deep = maps.and_then(|maps| maps.deep.as_ref()).unwrap_or(&strands.tile);
            let mut entries = frame.posed_strands(&set, &of_part, set.drawn).to_vec();
            let buffers = [&ribbons.seen, &ribbons.counts, &ribbons.corners, deep];
            entries.extend((4..).zip(buffers.map(BindingResource::all)));
            entries.push((8, BindingResource::block::<DeepOpacity>(&block.buffer, block.offset)));
            let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
            let mut dispatch = |entry, threads| {
                let surfaces = frame.surfaces;
                let groups = vec![surfaces.frame.clone(), surfaces.material.clone(), layout.clone()];
                let spec = ComputeSpec { shader: SHADER, entry, groups, constants: constants(seen, &set, part) };
                Dispatch {
                    pipeline: frame.compute_pipeline(spec),
                    groups: vec![frame.eye_group(seen), DrawBindGroup::of(&part.material), DrawBindGroup::of(&group)],
                    threads,
                }
            };
            let threads = of_part.len() as u32;
            select.push(dispatch("select_strands", threads));
            if number == 0 {
                // A single workgroup scans all parts.
                scan.push(dispatch("scan_strands", WORKGROUP));
            }
            light.push(dispatch("light_strands", threads));
            count += threads;
        }
    }
    if select.is_empty() {
        return Outcome::Skipped("no single hairs are visible");
    }
    for ribbons in instances.iter().flat_map(VisibleInstance::strands).filter_map(|set| set.ribbons) {
        frame.encoder.clear_buffer(&ribbons.seen, 0, None);
    }
    // Order matters: each dispatch sees the writes of those before it.
    select.append(&mut scan);
    select.append(&mut light);
    record_dispatches(frame.encoder, SHADER.name, &select);
    Outcome::recorded(format!("{count} strands"))
}
