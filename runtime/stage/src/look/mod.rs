//! Look of a picture: all parameters except the models, the camera and the time.
//!
//! Each knob is declared here once, with its meaning, default and range. The declarations define look files
//! (`look.toml`), `--look key=value`, the command-line flags ([`SHORT_FORMS`]), scene files, sliders and the reference
//! page.
//!
//! ```
//! use pelage_stage::{Look, LookStyle};
//! let mut look = Look::default();
//! look.read("[picture]\nstyle = \"ink\"\n[ink]\nwidth = \"0.05m\"\n")?;
//! look.set("shadow.penumbra=0.3")?;
//! assert_eq!((look.picture.style, look.shadow.penumbra), (LookStyle::Ink, 0.3));
//! # Ok::<(), pelage_stage::ParamError>(())
//! ```

/// Converts an enum value to the runtime's enum value of the same name.
#[cfg(feature = "draw")]
macro_rules! same {
    ($value:expr, $from:ident => $to:ident: $($name:ident),+) => {
        match $value { $($from::$name => $to::$name),+ }
    };
}

mod apply;
#[cfg(feature = "draw")]
mod frame;
mod kinds;
mod short;
#[cfg(feature = "study")]
mod study;
mod styles;
mod tables;

pub use kinds::{
    Background, FillLight, Interval, LookDetail, LookFurShow, LookHair, LookLines, LookScattering, LookSelfShadow,
    LookSheet, LookShow, LookStrandEdges, LookStudio, LookStyle, LookToneMapping, LookWidth, Rgb, Samples, SealSource,
    Size, SkyKind, SkySource,
};
pub use short::{SAMPLES, SHORT_FORMS, ShortForm};
#[cfg(feature = "study")]
pub use study::{LookAnchoring, LookLighting, LookPenumbra, LookRule, LookSlant, LookSphereMap, LookStudy};
pub use styles::{BUILT_IN_LOOKS, BuiltInLook, DEFAULT_INK};
pub use tables::{
    CONDITIONS, KeyLight, LightsRead, Look, LookBrush, LookEnvironment, LookFur, LookInk, LookLight, LookMotion,
    LookPicture, LookShadow, ReadLights, ReadSeal,
};

#[cfg(test)]
mod tests;
