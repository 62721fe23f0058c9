//! Published forms of the papers' formulas, in addition to pelage's own; compiled with the feature `study`.
//!
//! Shader functions that have another form are in files of their own (`light/forms.wgsl`, `light/deep_forms.wgsl`,
//! `ink/line_forms.wgsl`, `ink/surface_forms.wgsl`). With the feature, files of the same names in this folder replace
//! them. `amend` then replaces a requested pipeline by its study variant.

use crate::params::FrameParams;
#[cfg(feature = "study")]
use crate::params::{OpacityForm, PenumbraForm, SlantForm};

#[cfg(feature = "study")]
mod amend;

#[cfg(feature = "study")]
pub(crate) use amend::{amend, amend_compute};

/// Includes the forms file that belongs to this build, with or without the feature `study`; for files in a folder of
/// `passes`.
macro_rules! form_wgsl {
    ($file:literal) => {
        if cfg!(feature = "study") {
            include_str!(concat!("../../study/", $file))
        } else {
            include_str!(concat!("../../", $file))
        }
    };
}
pub(crate) use form_wgsl;

/// Declares functions by which Rust code queries a form. Each has a default value and a value in a study.
macro_rules! forms {
    ($($(#[$doc:meta])+ $name:ident: $ty:ty = $ours:expr, studied $study:ident: $studied:expr;)+) => {
        $($(#[$doc])+
        pub(crate) fn $name(params: &FrameParams) -> $ty {
            #[cfg(feature = "study")]
            {
                let $study = &params.study;
                $studied
            }
            #[cfg(not(feature = "study"))]
            {
                let _ = params;
                $ours
            }
        })+

        #[cfg(all(test, feature = "study"))]
        #[test]
        fn default_study_draws_like_a_build_without_the_study_feature() {
            let projection = crate::Projection::Perspective { fov_y_rad: 1.0, aspect: 1.0, near_m: 0.1, far_m: 100.0 };
            let camera = crate::Camera::look_at(glam::Vec3::Z, glam::Vec3::ZERO, projection);
            let params = FrameParams::new(camera, [8, 8]);
            $(assert_eq!($name(&params), $ours, stringify!($name));)+
        }
    };
}

forms! {
    /// Returns whether the slabs of strand shadows divide the whole depth of the hair.
    opacity_spans_all: bool = false, studied study: study.opacity != OpacityForm::Deep;
    /// Returns whether the slabs of strand shadows use the published spacing.
    spacing_is_printed: bool = false, studied study: study.opacity == OpacityForm::Printed;
    /// Returns whether texels of strand shadows may be narrower than a strand.
    texels_may_be_thin: bool = false, studied study: study.thin_texels;
    /// Returns the fixed number of segments per strand; `None` if the size on screen decides.
    strand_pieces: Option<u32> = None, studied study: study.strand_pieces;
    /// Returns whether the path of light through a layer grows with its inclination.
    light_is_slanted: bool = true, studied study: study.light_slant == SlantForm::Corrected;
    /// Returns whether the penumbra extends to both sides of the hard edge.
    penumbra_is_centred: bool = true, studied study: study.penumbra == PenumbraForm::Centred;
    /// Returns whether direct light ends at the terminator.
    back_attenuation: bool = true, studied study: study.back_attenuation;
    /// Returns whether ambient light decreases towards the mesh surface.
    ambient_attenuation: bool = true, studied study: study.ambient_attenuation;
}
