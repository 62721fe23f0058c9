//! `hair_motion`: simulates guided hair, once per instance and frame.
//!
//! Reads the posed vertices, the groomed guides and the previous state of the particles. Writes the particles and the
//! posed guides. For guides that do not move, `hair_pose` writes the posed guides.

use super::{Outcome, Pass, PassId, PassStage, columns};
use crate::gpu::{BindingResource, ComputeSpec, DrawBindGroup, Shader, storage_in, storage_out};
use crate::guide_motion::WindBlock;
use crate::model::StrandSource;
use crate::params::StyleKind;
use crate::scene::{Dispatch, Recording, record_dispatches, strand_sets};
use crate::shared::shader_struct::shader_struct;
use pelage_formats::GeometryVertex;

pub(crate) const SHADER: Shader = Shader {
    name: "pelage hair motion",
    parts: &[
        include_str!("../../shared/skinning.wgsl"),
        include_str!("../../hair/triangle_frame.wgsl"),
        include_str!("../../surface/geometry.wgsl"),
        include_str!("../../hair/wind.wgsl"),
        include_str!("hair_motion.wgsl"),
    ],
};

impl PassId {
    /// Compute pass: simulates guided hair.
    pub const HAIR_MOTION: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "hair_motion",
    place: PassStage::Before,
    styles: &[StyleKind::Fur],
    lines: None,
    does: "compute: simulates guided hair by Verlet integration, with length constraints and colliders",
    runs_when: "guided hair is drawn, hair motion is on, and the hair is not at rest",
    shaders: &[SHADER],
    targets: &[],
    run,
};

shader_struct! {
    /// Constants of a group's guides for a frame, in shader layout.
    #[derive(Default)]
    pub(crate) struct HairMotion {
        pub(crate) world_from_model: [[f32; 4]; 3],
        pub(crate) model_from_world: [[f32; 4]; 3],
        pub(crate) origin: [f32; 3],
        pub(crate) points: u32,
        pub(crate) went: [f32; 3],
        pub(crate) steps: u32,
        pub(crate) gravity: [f32; 3],
        pub(crate) step_s: f32,
        pub(crate) wind: WindBlock,
        pub(crate) before_s: f32,
        pub(crate) held: f32,
        pub(crate) free: f32,
        pub(crate) drag_per_s: f32,
        pub(crate) shape_hz: f32,
        pub(crate) bend_hz: f32,
        pub(crate) friction: f32,
        pub(crate) colliders: u32,
        pub(crate) guides: u32,
        pub(crate) fresh: u32,
        pub(crate) reserved: [u32; 2],
    }
}

fn run(frame: &mut Recording<'_>) -> Outcome {
    let nothing = Outcome::Skipped("no guided hair moves, or all of it is at rest");
    // Skip early: a device that cannot draw single hairs cannot create the layout below.
    if !frame.instances.iter().any(|seen| seen.look.strands && seen.moved.swing.is_some()) {
        return nothing;
    }
    let instances = frame.instances.clone();
    let layout = frame.cache.layouts.get(frame.gpu, SHADER.name, || {
        vec![
            storage_in::<GeometryVertex>(0),
            storage_in::<[u32; 4]>(1),
            storage_in::<[f32; 4]>(2),
            storage_in::<[f32; 4]>(3),
            storage_out::<[f32; 4]>(4),
            storage_out::<[f32; 4]>(5),
            storage_in::<[f32; 4]>(6),
            storage_in::<HairMotion>(7),
        ]
    });
    let (mut dispatches, mut count) = (Vec::new(), 0);
    for (seen, set) in strand_sets(&instances) {
        let (StrandSource::Guided(guided), Some(swing)) = (&set.strands.growth, &seen.moved.swing) else { continue };
        let (Some(motion), Some(guides), Some(particles)) = (&guided.motion, &set.posed.guides, &set.posed.particles)
        else {
            continue;
        };
        let is_fresh = swing.is_fresh || set.posed.is_fresh;
        if set.posed.is_updated || swing.is_at_rest && !is_fresh {
            continue;
        }
        let block = HairMotion {
            world_from_model: columns(swing.world_from_model),
            model_from_world: columns(swing.world_from_model.inverse()),
            origin: swing.origin.to_array(),
            points: set.strands.points,
            went: swing.displacement.to_array(),
            steps: swing.steps,
            gravity: swing.params.gravity.to_array(),
            step_s: swing.step_s,
            wind: swing.wind(),
            before_s: swing.before_s,
            held: motion.held,
            free: motion.free,
            drag_per_s: motion.drag_per_s,
            shape_hz: motion.shape_hz,
            bend_hz: motion.bend_hz,
            friction: motion.friction,
            colliders: swing.colliders.len() as u32,
            guides: guided.guide_count,
            fresh: u32::from(is_fresh),
            reserved: [0; 2],
        };
        let end = |c: &pelage_formats::meaning::hair_motion::Capsule| {
            [c.from.extend(c.radius_m).to_array(), c.to.extend(0.0).to_array()]
        };
        let mut colliders: Vec<[f32; 4]> = swing.colliders.iter().flatten().flat_map(end).collect();
        if colliders.is_empty() {
            // A binding must not be empty.
            colliders.push([0.0; 4]);
        }
        let size = size_of_val(&colliders[..]) as u64;
        let place = frame.uniforms.put_array(frame.gpu, &colliders);
        let colliders = BindingResource::Bytes { buffer: place.buffer, offset: place.offset, size };
        let place = frame.uniforms.put_array(frame.gpu, &[block]);
        let entries = vec![
            (0, BindingResource::all(&seen.moved.posed)),
            (1, BindingResource::all(&guided.triangles)),
            (2, BindingResource::all(&guided.guides)),
            (3, BindingResource::all(&guided.ballast)),
            (4, BindingResource::all(particles)),
            (5, BindingResource::all(guides)),
            (6, colliders),
            (7, BindingResource::block::<HairMotion>(&place.buffer, place.offset)),
        ];
        let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
        let groups = vec![layout.clone()];
        let spec = ComputeSpec { shader: SHADER, entry: "move_guides", groups, constants: Vec::new() };
        let pipeline = frame.compute_pipeline(spec);
        dispatches.push(Dispatch { pipeline, groups: vec![DrawBindGroup::of(&group)], threads: guided.guide_count });
        count += guided.guide_count;
    }
    if dispatches.is_empty() {
        return nothing;
    }
    record_dispatches(frame.encoder, SHADER.name, &dispatches);
    Outcome::recorded(format!("{count} guides"))
}
