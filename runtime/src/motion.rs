//! State that the renderer keeps per owner between frames.

use crate::bounds::Hull;
use crate::fur_motion::{self, FurState, FurUpdate};
use crate::gpu::Gpu;
use crate::guide_motion::{GuideMotion, GuideMotionState, advance_motion};
use crate::instance::{Instance, Motion};
use crate::model::{Guided, Model, StrandSet};
use crate::params::{FrameParams, HairMotionParams, StyleKind};
use glam::Mat4;
use pelage_formats::Pose;
use pelage_formats::meaning::fur_motion::rest_s;
use std::collections::HashMap;

/// Number of frames after which the state of an unused owner is dropped.
const DROPPED_AFTER: u64 = 256;

#[derive(Debug)]
struct OwnerState {
    model: Model,
    /// Posed vertices, if the model has a skeleton.
    posed: Option<wgpu::Buffer>,
    /// Motion and morph target weights with which the vertices were posed.
    motion: Option<(Motion, Vec<(usize, f32)>)>,
    /// Whether to recompute the posed vertices even if the motion is unchanged.
    is_stale: bool,
    pose: Pose,
    /// Hair motion state, if the hair of the model moves.
    past: Option<GuideMotionState>,
    fur: Option<FurState>,
    /// Whether the fur leaned in the owner's last frame.
    is_leaning: bool,
    /// Revision; changes whenever the shape in model space changes. Unique among all owners.
    revision: u64,
    last_frame: u64,
}

#[derive(Debug, Default)]
pub(crate) struct OwnerStates {
    owners: HashMap<u64, OwnerState>,
    /// State by owner and strand set. Kept only for recently drawn sets, because many owners are never so near to the
    /// camera that their strands are drawn.
    strands: HashMap<(u64, usize), StrandState>,
    frame: u64,
    revisions: u64,
    /// Number of hair motion updates so far.
    updates: u64,
}

#[derive(Clone, Debug)]
pub(crate) struct PosedInstance {
    /// First vertex stream that is drawn: posed if the model has a skeleton, leaned if the fur leans.
    pub(crate) geometry: wgpu::Buffer,
    /// First vertex stream without leaning.
    pub(crate) posed: wgpu::Buffer,
    /// Fur motion, if the fur moves in this frame.
    pub(crate) lean: Option<FurUpdate>,
    /// Joints and morphs, if the posed vertices need to be recomputed.
    pub(crate) pose: Option<PoseInputs>,
    pub(crate) revision: u64,
    /// Hair motion, if the frame enables it.
    pub(crate) swing: Option<GuideMotion>,
    /// Bounds of the posed surface with its fur, in world space.
    pub(crate) hull: Hull,
}

/// Inputs that pose the vertices of an instance.
#[derive(Clone, Debug)]
pub(crate) struct PoseInputs {
    /// Transforms from mesh space to model space, one per joint.
    pub(crate) joints: Vec<Mat4>,
    /// Difference between the current weight of each morph target and its rest weight.
    pub(crate) shifts: Vec<f32>,
}

/// Strand set on the posed surface.
#[derive(Debug)]
struct StrandState {
    points: wgpu::Buffer,
    /// Guide points, if the strands follow guides.
    guides: Option<wgpu::Buffer>,
    /// Guide particles, if they may move.
    particles: Option<wgpu::Buffer>,
    /// Number of the last motion update applied to the particles.
    life: Option<u64>,
    /// Revision of the pose for which the points and guides were computed; 0 if they are still empty.
    revision: u64,
    /// Share of the strands that are posed.
    share: f32,
    last_frame: u64,
}

/// Points of strands on the posed surface.
#[derive(Debug)]
pub(crate) struct PosedStrands {
    pub(crate) buffer: wgpu::Buffer,
    /// Guide points relative to their roots, if the strands follow guides.
    pub(crate) guides: Option<wgpu::Buffer>,
    /// Guide particles, if they may move.
    pub(crate) particles: Option<wgpu::Buffer>,
    /// Whether the hair is reset to its groomed state, because the particles do not continue the previous update.
    pub(crate) is_fresh: bool,
    /// Whether an earlier frame with the same time has already applied this update to the particles.
    pub(crate) is_updated: bool,
    /// Whether the stored points must be recomputed, because they have another pose or belong to too few strands.
    pub(crate) stale: bool,
    /// Share of the strands that are posed.
    pub(crate) share: f32,
}

impl PosedStrands {
    /// Whether hair motion moves the guides; otherwise they keep their groomed shape.
    pub(crate) fn is_moved(&self, moved: &PosedInstance, guided: &Guided) -> bool {
        let swing = moved.swing.as_ref().filter(|_| guided.motion.is_some());
        swing.is_some_and(|swing| !swing.is_fresh && !self.is_fresh)
    }
}

impl OwnerStates {
    /// Updates the owners of `instances`, which must be valid, to their poses in this frame.
    pub(crate) fn pose_instances(
        &mut self,
        gpu: &Gpu,
        params: &FrameParams,
        clip_from_view: Mat4,
        instances: &[&Instance],
    ) -> Vec<PosedInstance> {
        self.frame += 1;
        let oldest = self.frame.saturating_sub(DROPPED_AFTER);
        self.owners.retain(|_, state| state.last_frame >= oldest);
        self.strands.retain(|_, state| state.last_frame >= oldest);
        instances.iter().map(|instance| self.pose_instance(gpu, params, clip_from_view, instance)).collect()
    }

    fn pose_instance(
        &mut self,
        gpu: &Gpu,
        params: &FrameParams,
        clip_from_view: Mat4,
        instance: &Instance,
    ) -> PosedInstance {
        let model = &instance.model;
        let frame = self.frame;
        if self.owners.get(&instance.owner).is_some_and(|state| !state.model.shares_resources(model)) {
            self.forget(instance.owner);
        }
        let state = self.owners.entry(instance.owner).or_insert_with(|| OwnerState {
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
        // A model without a skeleton is not posed.
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
                pose = Some(PoseInputs { joints: state.pose.joints.clone(), shifts: state.pose.shifts.clone() });
            }
        }
        let mut hull = Hull::default();
        // Leaning hair reaches farther than its height.
        let fur_m = std::f32::consts::SQRT_2 * model.manifest().fur.height_m;
        model.bounds().add_to(&mut hull, &state.pose, instance.transform, fur_m);
        let leans = |moved: &HairMotionParams| {
            moved.fur > 0.0 && model.has_leaning_fur() && params.style.kind() != StyleKind::Bare
        };
        let leaning = params.hair_motion.filter(leans);
        let fur_rest_s = leaning.map(|_| rest_s(model.manifest().fur.height_m * instance.scale()));
        let rest_s = fur_rest_s.into_iter().chain(model.hair_rest_s()).reduce(f32::max);
        self.updates += 1;
        let lives = params.hair_motion.zip(rest_s).map(|(moved, rest_s)| {
            let moment = (moved, params.time_s);
            advance_motion(
                state.past.as_ref(),
                instance,
                moment,
                rest_s,
                &state.pose,
                is_posed && model.skeleton().is_some(),
                self.updates,
            )
        });
        let (swing, past) = lives.unzip();
        // The shape of hair changes when its motion starts, continues or stops.
        let mut is_other = match &swing {
            Some(swing) => swing.update == self.updates && !swing.is_at_rest,
            None => state.past.is_some(),
        };
        state.past = past;
        let posed = state.posed.as_ref().unwrap_or(model.geometry()).clone();
        let (mut geometry, mut lean) = (posed.clone(), None);
        let wanted = leaning.map_or(0.0, |moved| {
            let clip_from_world = clip_from_view * params.camera.view_from_world;
            let px_per_m = instance.scale() * hull.px_per_m(clip_from_view, clip_from_world, params.viewport[1]);
            fur_motion::lean_strength(moved.fur, model.manifest().fur.height_m * px_per_m)
        });
        let mut is_leaning = false;
        if let (Some(swing), Some(_)) = (&swing, leaning) {
            if wanted > 0.0 && state.fur.is_none() {
                state.fur = Some(FurState::new(gpu, &posed));
            }
            if let Some(fur) = &mut state.fur
                && fur.begin_frame(swing, wanted)
            {
                lean = fur.update(swing, wanted);
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
        PosedInstance { geometry, posed, lean, pose, revision: state.revision, swing, hull }
    }

    /// Returns the buffers for posing a strand set of an instance, of which this frame draws the share `share`.
    pub(crate) fn pose_strands(
        &mut self,
        gpu: &Gpu,
        instance: &Instance,
        moved: &PosedInstance,
        set: usize,
        share: f32,
    ) -> PosedStrands {
        let strands = &instance.model.strands()[set];
        let made = || StrandState::new(gpu, strands);
        let state = self.strands.entry((instance.owner, set)).or_insert_with(made);
        state.last_frame = self.frame;
        let swing = moved.swing.as_ref();
        let has_lived = swing.is_some_and(|swing| state.life == Some(swing.update));
        let is_fresh = !has_lived
            && swing.is_none_or(|swing| swing.previous_update.is_none() || state.life != swing.previous_update);
        state.life = swing.map(|swing| swing.update);
        let wanted = share.max(strands.shadow_share());
        let stale = state.revision != moved.revision || state.share < wanted;
        if stale {
            (state.revision, state.share) = (moved.revision, wanted);
        }
        PosedStrands {
            buffer: state.points.clone(),
            guides: state.guides.clone(),
            particles: state.particles.clone(),
            is_fresh,
            is_updated: has_lived,
            stale,
            share: state.share,
        }
    }

    #[cfg(test)]
    pub(crate) fn posed_guides(&self, owner: u64, set: usize) -> Option<&wgpu::Buffer> {
        self.strands.get(&(owner, set))?.guides.as_ref()
    }

    #[cfg(test)]
    pub(crate) fn leaned(&self, owner: u64) -> Option<&wgpu::Buffer> {
        Some(self.owners.get(&owner)?.fur.as_ref()?.leaned())
    }

    /// Marks all poses as stale, so that they are recomputed.
    pub(crate) fn invalidate(&mut self) {
        self.owners.values_mut().for_each(|state| state.is_stale = true);
    }

    /// Invalidates all poses and resets the hair motion. Used when the device may have missed the last update.
    pub(crate) fn invalidate_motion(&mut self) {
        self.invalidate();
        self.owners.values_mut().for_each(|state| state.past = None);
    }

    /// Drops the state of an owner.
    pub(crate) fn forget(&mut self, owner: u64) {
        self.owners.remove(&owner);
        self.strands.retain(|(of, _), _| *of != owner);
    }

    pub(crate) fn gpu_bytes(&self) -> u64 {
        let of_skin = |state: &OwnerState| {
            state.posed.as_ref().map_or(0, wgpu::Buffer::size) + state.fur.as_ref().map_or(0, FurState::gpu_bytes)
        };
        self.owners.values().map(of_skin).sum::<u64>() + self.strands.values().map(StrandState::gpu_bytes).sum::<u64>()
    }
}

impl StrandState {
    fn new(gpu: &Gpu, strands: &StrandSet) -> Self {
        // Tests read the buffer.
        let read = if cfg!(test) { wgpu::BufferUsages::COPY_SRC } else { wgpu::BufferUsages::empty() };
        let buffer = |label, bytes| gpu.buffer(label, bytes, wgpu::BufferUsages::STORAGE | read);
        Self {
            points: buffer("pelage posed strands", strands.posed_bytes()),
            guides: strands.guided().map(|guided| buffer("pelage posed guides", guided.guides.size())),
            particles: strands.particle_bytes().map(|bytes| buffer("pelage particles", bytes)),
            life: None,
            revision: 0,
            share: 0.0,
            last_frame: 0,
        }
    }

    fn gpu_bytes(&self) -> u64 {
        let more = [&self.guides, &self.particles].into_iter().flatten();
        self.points.size() + more.map(wgpu::Buffer::size).sum::<u64>()
    }
}
