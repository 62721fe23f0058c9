//! Forms as the papers print them, beside those that pelage draws with: compiled with the feature `study`.
//!
//! Shaders keep what has another form in files of their own (`light/forms.wgsl`, `light/deep_forms.wgsl`,
//! `ink/line_forms.wgsl`, `ink/surface_forms.wgsl`); with the feature, files of the same names in this folder take their
//! place. `amend` then turns a pipeline that a pass asks for into the one that is studied.

use crate::params::FrameParams;
#[cfg(feature = "study")]
use crate::params::{OpacityForm, PenumbraForm, SlantForm};

#[cfg(feature = "study")]
mod amend;

#[cfg(feature = "study")]
pub(crate) use amend::{amend, amend_compute};

/// Source of a file of forms, as this build draws with them; for files in a folder of `passes`.
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

/// Declares what code outside shaders asks of the forms: ours, and what a study says.
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
        fn the_default_study_is_what_builds_without_it_draw() {
            let projection = crate::Projection::Perspective { fov_y_rad: 1.0, aspect: 1.0, near_m: 0.1, far_m: 100.0 };
            let camera = crate::Camera::look_at(glam::Vec3::Z, glam::Vec3::ZERO, projection);
            let params = FrameParams::new(camera, [8, 8]);
            $(assert_eq!($name(&params), $ours, stringify!($name));)+
        }
    };
}

forms! {
    /// Whether the slabs of strands' shadows divide the whole depth of the hair.
    opacity_spans_all: bool = false, studied study: study.opacity != OpacityForm::Deep;
    /// Whether they do with the printed spacing.
    spacing_is_printed: bool = false, studied study: study.opacity == OpacityForm::Printed;
    /// Whether the texels of strands' shadows may be narrower than a strand.
    texels_may_be_thin: bool = false, studied study: study.thin_texels;
    /// Pieces that strands are drawn in, where the size on screen does not say.
    strand_pieces: Option<u32> = None, studied study: study.strand_pieces;
    /// Whether the light's way through a layer grows with its slant.
    light_is_slanted: bool = true, studied study: study.light_slant == SlantForm::Corrected;
    /// Whether the penumbra lies on both sides of the hard edge.
    penumbra_is_centred: bool = true, studied study: study.penumbra == PenumbraForm::Centred;
    /// Whether the light ends past the terminator.
    back_attenuation: bool = true, studied study: study.back_attenuation;
    /// Whether ambient light fades towards the skin.
    ambient_attenuation: bool = true, studied study: study.ambient_attenuation;
}
