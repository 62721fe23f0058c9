//! What the renderer keeps of each owner from frame to frame.

use crate::bounds::Hull;
use crate::gpu::Gpu;
use crate::instance::{Instance, Motion};
use crate::lean::{self, Fur, Lean};
use crate::model::{Guided, Model, Strands};
use crate::params::{FrameParams, HairMotionParams, StyleKind};
use crate::swing::{Past, Swing, swing};
use glam::Mat4;
use pelage_formats::Pose;
use pelage_formats::meaning::fur_motion;
use std::collections::HashMap;

/// Frames after which an owner that none of them named is forgotten.
const FORGOTTEN_AFTER: u64 = 256;

/// The state of one owner.
#[derive(Debug)]
struct State {
    model: Model,
    /// Posed vertices, where the model has a skeleton.
    posed: Option<wgpu::Buffer>,
    /// What they are of: the motion, and weights of morph targets.
    motion: Option<(Motion, Vec<(usize, f32)>)>,
    /// They are to be computed anew although they are of that motion.
    is_stale: bool,
    pose: Pose,
    /// Of its hair, where that moves.
    past: Option<Past>,
    /// Its fur, where that leaned once, and whether it does.
    fur: Option<Fur>,
    is_leaning: bool,
    /// Another number whenever the shape in model space is another, and never one that any owner had before.
    revision: u64,
    last_frame: u64,
}

/// The states of all owners.
#[derive(Debug, Default)]
pub(crate) struct States {
    owners: HashMap<u64, State>,
    /// By owner and number of the model's set, of those that were drawn of late: many owners are never near enough.
    strands: HashMap<(u64, usize), StrandState>,
    frame: u64,
    revisions: u64,
    /// Lives of hair that began so far.
    lives: u64,
}

/// An instance as it is in this frame.
#[derive(Clone, Debug)]
pub(crate) struct Moved {
    /// The first vertex stream as it is drawn: posed where the model has a skeleton, and leaned where fur leans.
    pub(crate) geometry: wgpu::Buffer,
    /// The same without leaning.
    pub(crate) posed: wgpu::Buffer,
    /// How its fur moves, where it does in this frame.
    pub(crate) lean: Option<Lean>,
    /// Where its parts are, where the posed vertices are not of it yet.
    pub(crate) pose: Option<Moves>,
    pub(crate) revision: u64,
    /// How its hair moves, where frames move it.
    pub(crate) swing: Option<Swing>,
    /// The posed skin with its fur, in world space.
    pub(crate) hull: Hull,
}

/// What moves the vertices of an instance.
#[derive(Clone, Debug)]
pub(crate) struct Moves {
    /// Mesh space to model space, one per joint.
    pub(crate) joints: Vec<Mat4>,
    /// How far the weight of each morph target is from where it rests.
    pub(crate) shifts: Vec<f32>,
}

/// A set of strands on the posed skin.
#[derive(Debug)]
struct StrandState {
    points: wgpu::Buffer,
    /// Points of its guides, where it follows some.
    guides: Option<wgpu::Buffer>,
    /// Their pearls, where they may move, and the life that they went through last.
    pearls: Option<wgpu::Buffer>,
    life: Option<u64>,
    /// The revision that both are of; 0 where they hold nothing yet.
    revision: u64,
    /// Share of them that is posed.
    share: f32,
    last_frame: u64,
}

/// Points of strands on the posed skin.
#[derive(Debug)]
pub(crate) struct PosedStrands {
    pub(crate) buffer: wgpu::Buffer,
    /// Points of their guides, where they follow some: relative to their roots.
    pub(crate) guides: Option<wgpu::Buffer>,
    /// The pearls of those, where they may move.
    pub(crate) pearls: Option<wgpu::Buffer>,
    /// The pearls are not of the life before: hair begins as it was groomed.
    pub(crate) is_fresh: bool,
    /// They went through this life in an earlier frame of its moment.
    pub(crate) has_lived: bool,
    /// They are of another pose, or too few.
    pub(crate) stale: bool,
    /// Share of them that is posed.
    pub(crate) share: f32,
}

impl PosedStrands {
    /// Whether its guides are where they swung to: else they are as they were groomed.
    pub(crate) fn swings(&self, moved: &Moved, guided: &Guided) -> bool {
        let swing = moved.swing.as_ref().filter(|_| guided.motion.is_some());
        swing.is_some_and(|swing| !swing.is_fresh && !self.is_fresh)
    }
}

impl States {
    /// Moves the owners of instances that passed their check to where this frame has them.
    pub(crate) fn move_to(
        &mut self,
        gpu: &Gpu,
        params: &FrameParams,
        clip_from_view: Mat4,
        instances: &[&Instance],
    ) -> Vec<Moved> {
        self.frame += 1;
        let oldest = self.frame.saturating_sub(FORGOTTEN_AFTER);
        self.owners.retain(|_, state| state.last_frame >= oldest);
        self.strands.retain(|_, state| state.last_frame >= oldest);
        instances.iter().map(|instance| self.moved(gpu, params, clip_from_view, instance)).collect()
    }

    fn moved(&mut self, gpu: &Gpu, params: &FrameParams, clip_from_view: Mat4, instance: &Instance) -> Moved {
        let model = &instance.model;
        let frame = self.frame;
        if self.owners.get(&instance.owner).is_some_and(|state| !state.model.is(model)) {
            self.forget(instance.owner);
        }
        let state = self.owners.entry(instance.owner).or_insert_with(|| State {
            model: model.clone(),
            posed: model.skeleton().map(|_| {
                let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::VERTEX;
                gpu.buffer("pelage posed vertices", model.geometry().size(), usage)
            }),
            motion: None,
            is_stale: false,
            pose: Pose::default(),
            past: None,
            fur: None,
            is_leaning: false,
            revision: 0,
            last_frame: frame,
        });
        state.last_frame = frame;
        let mut pose = None;
        // Without skeleton nothing moves.
        let (motion, morphs) = match model.skeleton() {
            Some(_) => (&instance.motion, &instance.morphs[..]),
            None => (&Motion::Rest, &[][..]),
        };
        let is_posed = state.motion.as_ref().is_none_or(|(of, with)| (of, &with[..]) != (motion, morphs));
        if is_posed || std::mem::take(&mut state.is_stale) {
            state.is_stale = false;
            self.revisions += 1;
            state.revision = self.revisions;
            state.motion = Some((motion.clone(), morphs.to_vec()));
            if let Some(animation) = model.skeleton() {
                match motion {
                    Motion::Rest => state.pose.sample(animation, None, 0.0),
                    Motion::Clip { clip, time_s } => state.pose.sample(animation, Some(*clip), *time_s),
                    Motion::Blend(layers) => state.pose.blend(animation, layers),
                    Motion::Joints(joints) => {
                        state.pose.joints.clone_from(joints);
                        state.pose.shifts.clear();
                    }
                }
                state.pose.morph(animation, morphs);
                pose = Some(Moves { joints: state.pose.joints.clone(), shifts: state.pose.shifts.clone() });
            }
        }
        let mut hull = Hull::default();
        // Leaning hair reaches farther than its height.
        let fur_m = std::f32::consts::SQRT_2 * model.manifest().fur.height_m;
        model.extent().add_to(&mut hull, &state.pose, instance.transform, fur_m);
        let leans = |moved: &HairMotionParams| {
            moved.fur > 0.0 && model.has_leaning_fur() && params.style.kind() != StyleKind::Bare
        };
        let leaning = params.hair_motion.filter(leans);
        let fur_rest_s = leaning.map(|_| fur_motion::rest_s(model.manifest().fur.height_m * instance.scale()));
        let rest_s = fur_rest_s.into_iter().chain(model.hair_rest_s()).reduce(f32::max);
        self.lives += 1;
        let lives = params.hair_motion.zip(rest_s).map(|(moved, rest_s)| {
            let moment = (moved, params.time_s);
            swing(
                state.past.as_ref(),
                instance,
                moment,
                rest_s,
                &state.pose,
                is_posed && model.skeleton().is_some(),
                self.lives,
            )
        });
        let (swing, past) = lives.unzip();
        // Hair that begins to move, moves, or ceases to, has another shape.
        let mut is_other = match &swing {
            Some(swing) => swing.life == self.lives && !swing.is_at_rest,
            None => state.past.is_some(),
        };
        state.past = past;
        let posed = state.posed.as_ref().unwrap_or(model.geometry()).clone();
        let (mut geometry, mut lean) = (posed.clone(), None);
        let wanted = leaning.map_or(0.0, |moved| {
            let clip_from_world = clip_from_view * params.camera.view_from_world;
            let px_per_m = instance.scale() * hull.px_per_m(clip_from_view, clip_from_world, params.viewport[1]);
            lean::strength(moved.fur, model.manifest().fur.height_m * px_per_m)
        });
        let mut is_leaning = false;
        if let (Some(swing), Some(_)) = (&swing, leaning) {
            if wanted > 0.0 && state.fur.is_none() {
                state.fur = Some(Fur::new(gpu, &posed));
            }
            if let Some(fur) = &mut state.fur
                && fur.is_seen(swing, wanted)
            {
                lean = fur.lean(swing, wanted);
                geometry = fur.leaned().clone();
                is_leaning = true;
            }
        }
        is_other |= lean.is_some() || is_leaning != state.is_leaning;
        state.is_leaning = is_leaning;
        if is_other {
            self.revisions += 1;
            state.revision = self.revisions;
        }
        Moved { geometry, posed, lean, pose, revision: state.revision, swing, hull }
    }

    /// Where a set of an instance's strands is posed, of which this frame draws a share as it was moved.
    pub(crate) fn pose_strands(
        &mut self,
        gpu: &Gpu,
        instance: &Instance,
        moved: &Moved,
        set: usize,
        share: f32,
    ) -> PosedStrands {
        let strands = &instance.model.strands()[set];
        let made = || StrandState::new(gpu, strands);
        let state = self.strands.entry((instance.owner, set)).or_insert_with(made);
        state.last_frame = self.frame;
        let swing = moved.swing.as_ref();
        let has_lived = swing.is_some_and(|swing| state.life == Some(swing.life));
        let is_fresh = !has_lived && swing.is_none_or(|swing| swing.follows.is_none() || state.life != swing.follows);
        state.life = swing.map(|swing| swing.life);
        let wanted = share.max(strands.shadow_share());
        let stale = state.revision != moved.revision || state.share < wanted;
        if stale {
            (state.revision, state.share) = (moved.revision, wanted);
        }
        PosedStrands {
            buffer: state.points.clone(),
            guides: state.guides.clone(),
            pearls: state.pearls.clone(),
            is_fresh,
            has_lived,
            stale,
            share: state.share,
        }
    }

    /// The buffer of an owner's guides.
    #[cfg(test)]
    pub(crate) fn posed_guides(&self, owner: u64, set: usize) -> Option<&wgpu::Buffer> {
        self.strands.get(&(owner, set))?.guides.as_ref()
    }

    /// The buffer of an owner's leaned vertices.
    #[cfg(test)]
    pub(crate) fn leaned(&self, owner: u64) -> Option<&wgpu::Buffer> {
        Some(self.owners.get(&owner)?.fur.as_ref()?.leaned())
    }

    /// Forgets all poses, so that they are computed anew.
    pub(crate) fn invalidate(&mut self) {
        self.owners.values_mut().for_each(|state| state.is_stale = true);
    }

    /// Forgets them with how hair swings, where the device may not have seen the last of it.
    pub(crate) fn lose(&mut self) {
        self.invalidate();
        self.owners.values_mut().for_each(|state| state.past = None);
    }

    /// Forgets an owner.
    pub(crate) fn forget(&mut self, owner: u64) {
        self.owners.remove(&owner);
        self.strands.retain(|(of, _), _| *of != owner);
    }

    /// Bytes on the GPU.
    pub(crate) fn gpu_bytes(&self) -> u64 {
        let of_skin = |state: &State| {
            state.posed.as_ref().map_or(0, wgpu::Buffer::size) + state.fur.as_ref().map_or(0, Fur::gpu_bytes)
        };
        self.owners.values().map(of_skin).sum::<u64>() + self.strands.values().map(StrandState::gpu_bytes).sum::<u64>()
    }
}

impl StrandState {
    fn new(gpu: &Gpu, strands: &Strands) -> Self {
        // Tests read it.
        let read = if cfg!(test) { wgpu::BufferUsages::COPY_SRC } else { wgpu::BufferUsages::empty() };
        let buffer = |label, bytes| gpu.buffer(label, bytes, wgpu::BufferUsages::STORAGE | read);
        Self {
            points: buffer("pelage posed strands", strands.posed_bytes()),
            guides: strands.guided().map(|guided| buffer("pelage posed guides", guided.guides.size())),
            pearls: strands.pearl_bytes().map(|bytes| buffer("pelage pearls", bytes)),
            life: None,
            revision: 0,
            share: 0.0,
            last_frame: 0,
        }
    }

    fn gpu_bytes(&self) -> u64 {
        let more = [&self.guides, &self.pearls].into_iter().flatten();
        self.points.size() + more.map(wgpu::Buffer::size).sum::<u64>()
    }
}
