//! `strand_light`: makes ribbons of the strands that can be seen, with the light of each point, once a frame. What is drawn of them reads vertices alone.

use super::{Outcome, Pass, PassId, PassPlace};
use crate::gpu::{Bound, ComputeSpec, Group, Shader, on, storage, storage_out, uniform};
use crate::hair::{groom, hair_wgsl, material};
use crate::light::ShadowMaps;
use crate::model::{Part, STRAND_WORKGROUP, Strand, StrandConstants};
use crate::params::StyleKind;
use crate::scene::{Dispatch, Recording, Seen, StrandSet, record_dispatches};
use crate::shared::deep_opacity::DeepOpacity;

/// The shader.
pub(crate) const SHADER: Shader = Shader {
    name: "pelage strand light",
    wgsl: hair_wgsl!(
        include_str!("../../shared/deep_opacity.wgsl"),
        crate::study::form_wgsl!("strand shadows"),
        include_str!("../../hair/constants.wgsl"),
        include_str!("../../hair/strand.wgsl"),
        include_str!("strand_light.wgsl"),
    ),
};

impl PassId {
    /// Compute: ribbons of the strands that can be seen, with their light.
    pub const STRAND_LIGHT: Self = Self(&PASS);
}

/// The pass.
pub(crate) const PASS: Pass = Pass {
    name: "strand_light",
    place: PassPlace::Before,
    styles: &[StyleKind::Fur],
    does: "compute: finds the strands that can be seen, and makes ribbons of them that face the eye, with the light of each point",
    runs_when: "strands are drawn",
    shaders: &[SHADER],
    targets: &[],
    run,
};

fn constants(seen: &Seen, set: &StrandSet<'_>, part: &Part) -> Vec<(&'static str, u32)> {
    let mut constants = seen.look.lights();
    constants.extend([on("DEEP_SHADOW", seen.look.deep_shadow), ("POINT_STEP", set.drawn.step)]);
    // The map of single strands has that hair too.
    constants.retain(|(name, _)| *name != "GUIDED_SHADOW");
    // The skin and its groom say nothing of hair on guides.
    if set.strands.guided().is_some() {
        constants.push(on("OWN_COLOR", true));
    } else {
        constants.extend(material(part));
        constants.extend(groom(&seen.model, part));
        constants.push(on("LEAN", seen.model.varies().lean));
    }
    constants
}

fn run(frame: &mut Recording<'_>) -> Outcome {
    // A device that cannot draw them cannot make these layouts.
    if !frame.instances.iter().any(|seen| seen.look.strands) {
        return Outcome::Skipped("no single hairs are to be seen");
    }
    let layout = frame.cache.layouts.get(frame.gpu, SHADER.name, || {
        let compute = wgpu::ShaderStages::COMPUTE;
        let for_compute = |entry| wgpu::BindGroupLayoutEntry { visibility: compute, ..entry };
        vec![
            storage::<[f32; 4]>(0, compute),
            storage::<Strand>(1, compute),
            storage::<[u32; 4]>(2, compute),
            for_compute(uniform::<StrandConstants>(3, false)),
            storage_out::<u32>(4),
            storage_out::<u32>(5),
            storage_out::<[u32; 4]>(6),
            storage::<u32>(7, compute),
            for_compute(uniform::<DeepOpacity>(8, false)),
        ]
    });
    let maps = frame.maps.clone();
    let maps = maps.as_deref();
    let block = frame.uniforms.put(frame.gpu, &[maps.map_or(DeepOpacity::default(), ShadowMaps::deep_opacity)]);
    let instances = frame.instances.clone();
    let [mut select, mut scan, mut light] = [Vec::new(), Vec::new(), Vec::new()];
    let mut count = 0;
    for (seen, set) in instances.iter().flat_map(|seen| seen.strands().map(move |set| (seen, set))) {
        let (strands, Some(ribbons)) = (set.strands, set.ribbons) else { continue };
        for (number, (part, of_part)) in set.parts(seen.model.parts()).enumerate() {
            let drawn = set.drawn;
            let place = frame.uniforms.put(frame.gpu, &[strands.constants(of_part, drawn.share, drawn.widened)]);
            let buffer = |binding, buffer: &wgpu::Buffer| (binding, Bound::Buffer(buffer.clone()));
            // Without a map nothing is read of what stands in for it.
            let deep = maps.and_then(|maps| maps.deep.as_ref()).unwrap_or(&strands.tile);
            let entries = vec![
                buffer(0, &set.posed.buffer),
                buffer(1, &strands.strands),
                buffer(2, &strands.tile),
                (3, Bound::block::<StrandConstants>(&place.buffer, place.offset)),
                buffer(4, &ribbons.seen),
                buffer(5, &ribbons.counts),
                buffer(6, &ribbons.corners),
                buffer(7, deep),
                (8, Bound::block::<DeepOpacity>(&block.buffer, block.offset)),
            ];
            let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
            let mut dispatch = |entry, threads| {
                let surfaces = frame.surfaces;
                let groups = vec![surfaces.frame.clone(), surfaces.material.clone(), layout.clone()];
                let spec = ComputeSpec { shader: SHADER, entry, groups, constants: constants(seen, &set, part) };
                Dispatch {
                    pipeline: frame.compute_pipeline(spec),
                    groups: vec![frame.seen_from_eye(seen), Group::of(&part.material), Group::of(&group)],
                    threads,
                }
            };
            let threads = of_part.len() as u32;
            select.push(dispatch("select_strands", threads));
            if number == 0 {
                // One workgroup for all parts.
                scan.push(dispatch("scan_strands", STRAND_WORKGROUP));
            }
            light.push(dispatch("light_strands", threads));
            count += threads;
        }
    }
    if select.is_empty() {
        return Outcome::Skipped("no single hairs are to be seen");
    }
    for ribbons in instances.iter().flat_map(Seen::strands).filter_map(|set| set.ribbons) {
        frame.encoder.clear_buffer(&ribbons.seen, 0, None);
    }
    // Each sees what those before it wrote.
    select.append(&mut scan);
    select.append(&mut light);
    record_dispatches(frame.encoder, SHADER.name, &select);
    Outcome::recorded(format!("{count} strands"))
}
