//! One drawn copy of a model.

use crate::light_view::Hull;
use crate::shadow::InstanceKey;
use crate::{Model, RuntimeError};
use glam::{Mat3, Mat4};
use pelage_formats::Pose;

/// How an instance is posed.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Motion {
    /// As the model was stored: no clip playing.
    #[default]
    Rest,
    /// A moment of one of the model's clips.
    Clip {
        /// Index into [`Model::clips`]; see [`Model::clip_index`].
        clip: usize,
        /// Seconds. Before the first and after the last key the pose holds; looping is the caller's choice.
        time_s: f32,
    },
    /// The application's own animation.
    Joints(
        /// Mesh space to model space, one per joint of the package's skeleton.
        Vec<Mat4>,
    ),
}

/// One drawn copy of a model: where it stands and how it is posed. Instances of one model share everything but the posed
/// vertices.
#[derive(Debug)]
pub struct Instance {
    model: Model,
    /// Model to world space: any invertible affine matrix; mirrored copies are fine. The fur's height follows the cube root of
    /// the volume's scale.
    pub transform: Mat4,
    /// How it is posed; without effect for models without skeleton.
    pub motion: Motion,
    pub(crate) posed: Option<Posed>,
    pose: Pose,
}

/// The posed vertices, and the motion they are of.
#[derive(Debug)]
pub(crate) struct Posed {
    pub(crate) vertices: wgpu::Buffer,
    motion: Option<Motion>,
}

impl Instance {
    /// A copy at the origin, at rest.
    pub fn new(model: &Model) -> Self {
        let model = model.clone();
        Self { model, transform: Mat4::IDENTITY, motion: Motion::Rest, posed: None, pose: Pose::default() }
    }

    /// The model it is a copy of.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Bytes on the GPU of this copy alone: its posed vertices, from the first frame on.
    pub fn gpu_bytes(&self) -> u64 {
        self.posed.as_ref().map_or(0, |p| p.vertices.size())
    }

    /// Forgets the posed vertices, so that the next frame computes them anew. Needed only after an encoder that a frame was
    /// prepared into was dropped instead of submitted.
    pub fn invalidate(&mut self) {
        if let Some(posed) = &mut self.posed {
            posed.motion = None;
        }
    }

    /// The joint matrices, where the posed vertices are not of this motion already. Makes the buffer on first use.
    pub(crate) fn changed_pose(&mut self, device: &wgpu::Device) -> Result<Option<&[Mat4]>, RuntimeError> {
        let Some(animation) = self.model.skeleton() else { return Ok(None) };
        let vertices = self.model.geometry();
        let posed = self.posed.get_or_insert_with(|| Posed {
            vertices: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("pelage posed vertices"),
                size: vertices.size(),
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::VERTEX,
                mapped_at_creation: false,
            }),
            motion: None,
        });
        if posed.motion.as_ref() == Some(&self.motion) {
            return Ok(None);
        }
        match &self.motion {
            Motion::Rest => self.pose.sample(animation, None, 0.0),
            Motion::Clip { clip, time_s } => {
                if *clip >= animation.clips.len() {
                    return Err(RuntimeError::Params {
                        field: "Instance::motion",
                        found: format!("clip {clip}"),
                        expected: format!("less than the {} clips", animation.clips.len()),
                    });
                }
                self.pose.sample(animation, Some(*clip), *time_s);
            }
            Motion::Joints(joints) => {
                if joints.len() != animation.joints.len() {
                    return Err(RuntimeError::Params {
                        field: "Instance::motion",
                        found: format!("{} joints", joints.len()),
                        expected: format!("the {} joints of the skeleton", animation.joints.len()),
                    });
                }
                self.pose.joints.clone_from(joints);
            }
        }
        posed.motion = Some(self.motion.clone());
        Ok(Some(&self.pose.joints))
    }

    /// The first vertex stream: posed where the model has a skeleton.
    pub(crate) fn geometry(&self) -> &wgpu::Buffer {
        self.posed.as_ref().map_or_else(|| self.model.geometry(), |p| &p.vertices)
    }

    /// What the shadow maps see of it.
    pub(crate) fn shadow_key(&self, furry: bool) -> InstanceKey {
        let motion = self.model.skeleton().map(|_| self.motion.clone());
        InstanceKey { model: self.model.number(), transform: self.transform, motion, furry }
    }

    /// Adds the posed skin and its fur, in world space, to `hull`; the pose is that of the last frame prepared.
    pub(crate) fn add_to(&self, hull: &mut Hull) {
        // Leaning hair reaches farther than its height.
        let fur_m = std::f32::consts::SQRT_2 * self.model.manifest().fur.height_m;
        self.model.extent().add_to(hull, &self.pose.joints, self.transform, fur_m);
    }

    pub(crate) fn check(&self) -> Result<(), RuntimeError> {
        if self.transform.is_finite() && Mat3::from_mat4(self.transform).determinant() != 0.0 {
            return Ok(());
        }
        Err(RuntimeError::Params {
            field: "Instance::transform",
            found: format!("{:?}", self.transform),
            expected: "a finite, invertible matrix".into(),
        })
    }
}
