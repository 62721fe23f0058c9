//! `fur_motion`: leans fur in the wind and with the motion of the character, once per instance and frame.
//!
//! Reads the posed vertices and the state of the tip particles. Writes that state, and a copy of the posed vertices
//! with leaned normals and tangents. All later passes draw the copy. Shells, fins, fur strands, ink strokes and shadow
//! maps therefore lean without code of their own.

use super::{Outcome, Pass, PassId, PassStage, columns};
use crate::gpu::{BindingResource, ComputeSpec, DrawBindGroup, Shader, storage_in, storage_out};
use crate::guide_motion::WindBlock;
use crate::params::StyleKind;
use crate::scene::{Dispatch, Recording, record_dispatches};
use crate::shared::shader_struct::shader_struct;
use pelage_formats::{AttributeVertex, GeometryVertex};

pub(crate) const SHADER: Shader = Shader {
    name: "pelage fur motion",
    parts: &[
        include_str!("../../shared/skinning.wgsl"),
        include_str!("../../shared/tile_frame.wgsl"),
        include_str!("../../surface/geometry.wgsl"),
        include_str!("../../hair/wind.wgsl"),
        include_str!("fur_motion.wgsl"),
    ],
};

impl PassId {
    /// Compute pass: leans fur in the wind and with the motion of the character.
    pub const FUR_MOTION: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "fur_motion",
    place: PassStage::Before,
    styles: &[StyleKind::Fur, StyleKind::Ink],
    lines: None,
    does: "compute: leans fur in the wind and as the animal moves, with one particle for each vertex of the skin",
    runs_when: "hair motion is on, and fur is visible, large enough on screen and not at rest",
    shaders: &[SHADER],
    targets: &[],
    run,
};

shader_struct! {
    /// Constants of a model for a frame, in shader layout.
    #[derive(Default)]
    pub(crate) struct FurMotion {
        pub(crate) world_from_model: [[f32; 4]; 3],
        pub(crate) origin: [f32; 3],
        pub(crate) vertices: u32,
        pub(crate) went: [f32; 3],
        pub(crate) seconds: f32,
        pub(crate) wind: WindBlock,
        pub(crate) before_s: f32,
        pub(crate) scale: f32,
        pub(crate) strength: f32,
        pub(crate) begins: u32,
    }
}

fn run(frame: &mut Recording<'_>) -> Outcome {
    let instances = frame.instances.clone();
    let (mut dispatches, mut count) = (Vec::new(), 0);
    for seen in instances.iter() {
        let (Some(lean), Some(swing)) = (&seen.moved.lean, &seen.moved.swing) else { continue };
        let layout = frame.cache.layouts.get(frame.gpu, SHADER.name, || {
            vec![
                storage_in::<GeometryVertex>(0),
                storage_in::<AttributeVertex>(1),
                storage_out::<[f32; 4]>(2),
                storage_out::<GeometryVertex>(3),
                storage_in::<FurMotion>(4),
            ]
        });
        let vertices = (seen.moved.posed.size() / size_of::<GeometryVertex>() as u64) as u32;
        let block = FurMotion {
            world_from_model: columns(swing.world_from_model),
            origin: swing.origin.to_array(),
            vertices,
            went: swing.displacement.to_array(),
            seconds: swing.seconds(),
            wind: swing.wind(),
            before_s: swing.frame_before_s,
            scale: swing.scale(),
            strength: lean.strength,
            begins: lean.begins,
        };
        let place = frame.uniforms.put_array(frame.gpu, &[block]);
        let buffers = [&seen.moved.posed, seen.model.attributes(), &lean.tips, &seen.moved.geometry];
        let bound = (0..).zip(buffers.map(BindingResource::all));
        let entries = bound.chain([(4, BindingResource::block::<FurMotion>(&place.buffer, place.offset))]).collect();
        let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
        let spec = ComputeSpec { shader: SHADER, entry: "lean_fur", groups: vec![layout], constants: Vec::new() };
        let pipeline = frame.compute_pipeline(spec);
        dispatches.push(Dispatch { pipeline, groups: vec![DrawBindGroup::of(&group)], threads: vertices });
        count += vertices;
    }
    if dispatches.is_empty() {
        return Outcome::Skipped("no fur moves, or all of it is at rest or too small on screen");
    }
    record_dispatches(frame.encoder, SHADER.name, &dispatches);
    Outcome::recorded(format!("{count} vertices"))
}
