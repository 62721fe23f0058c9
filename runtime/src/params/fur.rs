//! How fur is drawn.

use super::detail::Detail;
use crate::error::RuntimeError;

/// How hair shadows hair: t of Yang 2006, eq. (2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SelfShadow {
    /// As the package knows it, and by layer-wise maps where it does not.
    #[default]
    Auto,
    /// As the package knows it ([`crate::shared::visibility`]), for all lights; not at all where it does not. No layer-wise map is drawn; with soft
    /// shadows one of all hair is, for what it throws on other things.
    Baked,
    /// By layer-wise shadow maps of the key light (Yang 2006, §3), drawn when light, pose or model change.
    Maps,
    /// Not at all.
    Off,
}

/// How hair scatters light, where the package knows the fibres that it is made of (`shading.model = "marschner"` in its recipe). Hair of other packages is
/// lit by Yang 2006, eq. (3), always.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scattering {
    /// By the tables of its fibres (Marschner 2003), with the light that goes on from hair to hair.
    #[default]
    Multiple,
    /// By the tables of its fibres, without that light: right for black hair alone.
    Single,
    /// By Yang 2006, eq. (3), as hair of other packages.
    Off,
}

/// What hair is drawn as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Hair {
    /// As single strands where the package has them and they are wide enough on screen to be seen; else as layers.
    #[default]
    Auto,
    /// As layers.
    Shells,
    /// As single strands wherever the package has them and the device can draw them, short of the far coat.
    Strands,
}

/// How pixels are made of single strands, which are mostly thinner than they.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StrandEdges {
    /// Opaque ribbons, in the samples of the application's pass.
    #[default]
    Samples,
    /// Each pixel blends the eight nearest of its strands, by how much of it each covers: still and smooth with one sample a pixel, for 68 bytes a
    /// pixel that hair may reach. Where the device's buffers do not hold those, as with [`Self::Samples`].
    Blended,
}

/// How a frame in [`crate::Style::Fur`] is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct FurParams {
    /// Layers to draw, skin counted, 1..=1024; `None` (default) draws as many as were baked. The density of the fur stays the
    /// same (see [`crate::shared::opacity`]); fewer layers cost less, and show their steps at the silhouette.
    pub layers: Option<u32>,
    /// How much of the fur is drawn where it is small on screen (default [`Detail::Full`]). `layers` goes before it.
    pub detail: Detail,
    /// Whether fins are drawn where the package has them (default true).
    pub fins: bool,
    /// What hair is drawn as (default [`Hair::Auto`]).
    pub hair: Hair,
    /// How pixels are made of single strands (default [`StrandEdges::Samples`]).
    pub strand_edges: StrandEdges,
    /// How hair shadows hair, t of Yang 2006, eq. (2) (default [`SelfShadow::Auto`]).
    pub self_shadow: SelfShadow,
    /// How hair scatters light where the package knows its fibres (default [`Scattering::Multiple`]).
    pub scattering: Scattering,
}

/// More layers than this are a mistake.
const MAX_LAYERS: u32 = 1024;

impl Default for FurParams {
    fn default() -> Self {
        Self {
            layers: None,
            detail: Detail::default(),
            fins: true,
            hair: Hair::Auto,
            strand_edges: StrandEdges::Samples,
            self_shadow: SelfShadow::Auto,
            scattering: Scattering::Multiple,
        }
    }
}

impl FurParams {
    /// The same with changes: `FurParams::default().with(|f| f.fins = false)`.
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }

    pub(crate) fn check(&self) -> Result<(), RuntimeError> {
        self.detail.check()?;
        match self.layers {
            Some(layers) if !(1..=MAX_LAYERS).contains(&layers) => Err(RuntimeError::Params {
                field: "FurParams::layers",
                found: layers.to_string(),
                expected: "1..=1024".into(),
            }),
            _ => Ok(()),
        }
    }
}
