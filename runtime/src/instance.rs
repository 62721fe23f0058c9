//! One drawn copy of a model in a frame: plain data of the application.

use crate::error::RuntimeError;
use crate::model::Model;
use crate::params::{FrameParams, Scattering, SelfShadow};
use glam::{Mat3, Mat4};
use pelage_formats::meaning::hair_motion::Capsule;
use pelage_formats::{Animation, ClipLayer};

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
    /// Several moments one over another, of one clip or of more: a character that goes from one motion into the next.
    Blend(
        /// Each goes over, by its share, from what those before it come to. At most [`Motion::MOST_LAYERS`].
        Vec<ClipLayer>,
    ),
    /// The application's own animation.
    Joints(
        /// Mesh space to model space, one per joint of the package's skeleton.
        Vec<Mat4>,
    ),
}

impl Motion {
    /// Layers of a [`Motion::Blend`] at most: each is a whole pose.
    pub const MOST_LAYERS: usize = 16;

    /// What is wrong with it for that skeleton, and what would be right.
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
            Self::Blend(layers) if layers.len() > Self::MOST_LAYERS => {
                Some((format!("{} layers", layers.len()), format!("at most {}", Self::MOST_LAYERS)))
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

/// One drawn copy of a model in one frame: whose it is, where it stands and how it is posed. Nothing of the device is in it: it may be kept and
/// changed, or made anew for every frame from what an application keeps elsewhere.
///
/// What lasts from frame to frame, such as posed vertices, the [`crate::Renderer`] keeps under `owner`.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Instance {
    /// The application's number for whoever this is: the same in every frame, and another for each instance of one frame. Any but
    /// [`Instance::NOBODY`].
    pub owner: u64,
    /// The model that it is a copy of.
    pub model: Model,
    /// Model to world space: any invertible affine matrix; mirrored copies are fine. The fur's height follows the cube root of
    /// the volume's scale.
    pub transform: Mat4,
    /// How it is posed; without effect for models without skeleton.
    pub motion: Motion,
    /// Morph targets that the application moves itself, a face that speaks for one: index into [`Model::morph_targets`], and weight. The others follow the
    /// motion. Where one stands twice, the last counts.
    pub morphs: Vec<(usize, f32)>,
    /// Whatever number, the same from frame to frame; with another one its hair begins as it was groomed, in place of being dragged along: set it on where
    /// it was put elsewhere, or a shot begins.
    pub cut: u32,
    /// What its hair does not go into beside its own body, in world space: as many in every frame, or its hair begins anew. At most
    /// [`Instance::MOST_COLLIDERS`].
    pub colliders: Vec<Capsule>,
}

impl Instance {
    /// The number that no owner has.
    pub const NOBODY: u64 = u64::MAX;
    /// Colliders of the application at most: each point of each guide looks at all.
    pub const MOST_COLLIDERS: usize = 64;

    /// A copy at the origin, at rest.
    pub fn new(owner: u64, model: &Model) -> Self {
        Self {
            owner,
            model: model.clone(),
            transform: Mat4::IDENTITY,
            motion: Motion::Rest,
            morphs: Vec::new(),
            cut: 0,
            colliders: Vec::new(),
        }
    }

    /// The same at another place.
    pub fn at(self, transform: Mat4) -> Self {
        Self { transform, ..self }
    }

    /// The same in another pose.
    pub fn moving(self, motion: Motion) -> Self {
        Self { motion, ..self }
    }

    /// The same with morph targets at these weights ([`Instance::morphs`]).
    pub fn morphing(self, morphs: Vec<(usize, f32)>) -> Self {
        Self { morphs, ..self }
    }

    /// Whether a frame reads from its package how hair shadows hair.
    pub(crate) fn reads_baked_shadow(&self, params: &FrameParams) -> bool {
        let may = matches!(params.form_of_self_shadow(), SelfShadow::Auto | SelfShadow::Baked);
        may && self.model.knows_visibility()
    }

    /// How its hair scatters light by tables of its fibres; `None` where it is lit without.
    pub(crate) fn scattering(&self, params: &FrameParams) -> Option<Scattering> {
        let asked = params.style.fur().map_or(Scattering::Off, |fur| fur.scattering);
        (asked != Scattering::Off && self.model.fibres().is_some()).then_some(asked)
    }

    /// Scale of lengths: cube root of that of volumes.
    pub(crate) fn scale(&self) -> f32 {
        Mat3::from_mat4(self.transform).determinant().abs().cbrt()
    }

    pub(crate) fn check_owner(&self) -> Result<(), RuntimeError> {
        if self.owner != Self::NOBODY {
            return Ok(());
        }
        let expected = "any other number: this one is nobody's".into();
        Err(RuntimeError::Params { field: "Instance::owner", found: self.owner.to_string(), expected })
    }

    pub(crate) fn check(&self) -> Result<(), RuntimeError> {
        let fail = |field, found, expected| Err(RuntimeError::Params { field, found, expected });
        if !(self.transform.is_finite() && Mat3::from_mat4(self.transform).determinant() != 0.0) {
            let found = format!("{:?}", self.transform);
            return fail("Instance::transform", found, "a finite, invertible matrix".into());
        }
        if self.colliders.len() > Self::MOST_COLLIDERS {
            let found = format!("{} colliders", self.colliders.len());
            return fail("Instance::colliders", found, format!("at most {}", Self::MOST_COLLIDERS));
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
