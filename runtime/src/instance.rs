//! Instance: one drawn copy of a model in a frame, as plain data of the application.

use crate::error::RuntimeError;
use crate::model::Model;
use crate::params::{FrameParams, Scattering, SelfShadow};
use glam::{Mat3, Mat4};
use pelage_formats::meaning::hair_motion::Capsule;
use pelage_formats::{Animation, ClipLayer};

/// Pose of an instance.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Motion {
    /// Rest pose as stored, without a clip.
    #[default]
    Rest,
    /// Pose at one moment of one of the model's clips.
    Clip {
        /// Index into [`Model::clips`]; see [`Model::clip_index`].
        clip: usize,
        /// Time in seconds. The pose holds before the first and after the last key; looping is up to the caller.
        time_s: f32,
    },
    /// Several poses blended in order, from the same or different clips, such as a transition between two motions.
    Blend(
        /// Layers in order. Each blends, by its share, from the result of the layers before it to its own pose. At most
        /// [`Motion::MAX_LAYERS`].
        Vec<ClipLayer>,
    ),
    /// Pose computed by the application.
    Joints(
        /// Transforms from mesh space to model space, one per joint of the package's skeleton.
        Vec<Mat4>,
    ),
}

impl Motion {
    /// Maximum number of layers of a [`Motion::Blend`]; each costs the evaluation of a whole pose.
    pub const MAX_LAYERS: usize = 16;

    /// Returns the found and the expected value if the motion is invalid for the skeleton of `animation`; `None` if it
    /// is valid.
    fn fault(&self, animation: &Animation) -> Option<(String, String)> {
        let moment = |clip: Option<usize>, time_s: f32| {
            if !time_s.is_finite() {
                return Some((format!("{time_s} seconds"), "a finite number".into()));
            }
            let clip = clip.filter(|clip| *clip >= animation.clips.len())?;
            Some((format!("clip {clip}"), format!("less than the {} clips", animation.clips.len())))
        };
        let share = |share: f32| {
            let is_off = !(0.0..=1.0).contains(&share);
            is_off.then(|| (format!("a share of {share}"), "0 to 1".into()))
        };
        match self {
            Self::Rest => None,
            Self::Clip { clip, time_s } => moment(Some(*clip), *time_s),
            Self::Blend(layers) if layers.len() > Self::MAX_LAYERS => {
                Some((format!("{} layers", layers.len()), format!("at most {}", Self::MAX_LAYERS)))
            }
            Self::Blend(layers) => {
                layers.iter().find_map(|layer| moment(layer.clip, layer.time_s).or_else(|| share(layer.share)))
            }
            Self::Joints(joints) => {
                let of_skeleton = animation.joints.len();
                let is_off = joints.len() != of_skeleton;
                is_off
                    .then(|| (format!("{} joints", joints.len()), format!("the {of_skeleton} joints of the skeleton")))
            }
        }
    }
}

/// Copy of a model drawn in one frame: owner, transform and pose. It holds no GPU resources. Keep and change it, or
/// create it for every frame from the application's own data.
///
/// The [`crate::Renderer`] stores state that lasts between frames, such as posed vertices, under `owner`.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Instance {
    /// Identity chosen by the application: constant between frames, and unique among the instances of a frame. Any
    /// number except [`Instance::NO_OWNER`].
    pub owner: u64,
    /// Model that is drawn.
    pub model: Model,
    /// Transform from model to world space: any invertible affine matrix, mirroring included. The fur height scales
    /// with the cube root of the absolute determinant.
    pub transform: Mat4,
    /// Pose; has no effect on models without a skeleton.
    pub motion: Motion,
    /// Morph targets that the application sets itself, such as those of a speaking face: index into
    /// [`Model::morph_targets`], and weight. The other targets follow the motion. If a target appears twice, the last
    /// weight applies.
    pub morphs: Vec<(usize, f32)>,
    /// Revision of the hair motion: any number, constant between frames. A change resets the hair to its groomed state
    /// instead of dragging it along. Increment it when the instance is teleported or a new shot begins.
    pub hair_revision: u32,
    /// Colliders for the hair in addition to the instance's own body, in world space. If their number changes between
    /// frames, the hair is reset. At most [`Instance::MAX_COLLIDERS`].
    pub colliders: Vec<Capsule>,
}

impl Instance {
    /// Reserved number that is not valid as an owner.
    pub const NO_OWNER: u64 = u64::MAX;
    /// Maximum number of colliders set by the application; each point of each guide tests all of them.
    pub const MAX_COLLIDERS: usize = 64;

    /// Creates an instance at the origin, in the rest pose.
    pub fn new(owner: u64, model: &Model) -> Self {
        Self {
            owner,
            model: model.clone(),
            transform: Mat4::IDENTITY,
            motion: Motion::Rest,
            morphs: Vec::new(),
            hair_revision: 0,
            colliders: Vec::new(),
        }
    }

    /// Returns the instance with another transform.
    pub fn at(self, transform: Mat4) -> Self {
        Self { transform, ..self }
    }

    /// Returns the instance in another pose.
    pub fn moving(self, motion: Motion) -> Self {
        Self { motion, ..self }
    }

    /// Returns the instance with morph targets at these weights ([`Instance::morphs`]).
    pub fn morphing(self, morphs: Vec<(usize, f32)>) -> Self {
        Self { morphs, ..self }
    }

    /// Whether a frame uses the self-shadow of hair that is baked into the instance's package.
    pub(crate) fn reads_baked_shadow(&self, params: &FrameParams) -> bool {
        let may = matches!(params.self_shadow_form(), SelfShadow::Auto | SelfShadow::Baked);
        may && self.model.has_baked_visibility()
    }

    /// Returns the scattering mode of the instance's hair, lit with the tables of its fibres; `None` if lit without
    /// them.
    pub(crate) fn scattering(&self, params: &FrameParams) -> Option<Scattering> {
        let asked = params.style.fur().map_or(Scattering::Off, |fur| fur.scattering);
        (asked != Scattering::Off && self.model.fibres().is_some()).then_some(asked)
    }

    /// Returns the length scale: the cube root of the transform's absolute determinant.
    pub(crate) fn scale(&self) -> f32 {
        Mat3::from_mat4(self.transform).determinant().abs().cbrt()
    }

    pub(crate) fn check_owner(&self) -> Result<(), RuntimeError> {
        if self.owner != Self::NO_OWNER {
            return Ok(());
        }
        let expected = "any other number: this one means no owner".into();
        Err(RuntimeError::Params { field: "Instance::owner", found: self.owner.to_string(), expected })
    }

    pub(crate) fn check(&self) -> Result<(), RuntimeError> {
        let fail = |field, found, expected| Err(RuntimeError::Params { field, found, expected });
        if !(self.transform.is_finite() && Mat3::from_mat4(self.transform).determinant() != 0.0) {
            let found = format!("{:?}", self.transform);
            return fail("Instance::transform", found, "a finite, invertible matrix".into());
        }
        if self.colliders.len() > Self::MAX_COLLIDERS {
            let found = format!("{} colliders", self.colliders.len());
            return fail("Instance::colliders", found, format!("at most {}", Self::MAX_COLLIDERS));
        }
        let sane = |c: &Capsule| c.from.is_finite() && c.to.is_finite() && c.radius_m.is_finite() && c.radius_m >= 0.0;
        if let Some(found) = self.colliders.iter().find(|collider| !sane(collider)) {
            return fail("Instance::colliders", format!("{found:?}"), "finite numbers, a radius of at least 0".into());
        }
        let Some(animation) = self.model.skeleton() else { return Ok(()) };
        let targets = animation.morphs.targets.len();
        if let Some((target, weight)) = self.morphs.iter().find(|(t, w)| *t >= targets || !w.is_finite()) {
            let found = format!("morph target {target} of weight {weight}");
            let expected = format!("a target less than {targets} and a finite weight");
            return fail("Instance::morphs", found, expected);
        }
        match self.motion.fault(animation) {
            Some((found, expected)) => fail("Instance::motion", found, expected),
            None => Ok(()),
        }
    }
}

impl AsRef<Instance> for Instance {
    fn as_ref(&self) -> &Self {
        self
    }
}
