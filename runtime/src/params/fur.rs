//! Parameters of fur.

use super::detail::Detail;
use crate::error::RuntimeError;

/// Method of hair self-shadow: t of Yang 2006, eq. (2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SelfShadow {
    /// Baked visibility if the package has it, otherwise layer-wise maps.
    #[default]
    Auto,
    /// Baked visibility ([`crate::shared::visibility`]), for all lights; no self-shadow if the package has none. No
    /// layer-wise maps are drawn. With soft shadows, one map of all hair is drawn, for its shadow on other objects.
    Baked,
    /// Layer-wise shadow maps of the key light (Yang 2006, §3), redrawn when light, pose or model change.
    Maps,
    /// No self-shadow.
    Off,
}

/// Scattering model, for packages with fibre data (`shading.model = "marschner"` in the recipe). Hair of other packages
/// is always lit by Yang 2006, eq. (3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scattering {
    /// Fibre tables (Marschner 2003) with multiple scattering between hairs.
    #[default]
    Multiple,
    /// Fibre tables without multiple scattering; correct only for black hair.
    Single,
    /// Yang 2006, eq. (3), as for packages without fibre data.
    Off,
}

/// Geometry of hair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HairGeometry {
    /// Single strands if the package has them and they are wide enough on screen, otherwise layers.
    #[default]
    Auto,
    /// Only layers.
    Shells,
    /// Single strands wherever the package has them and the device can draw them, except where the far fur layer is
    /// drawn.
    Strands,
}

/// Rendering of strand edges; most strands are thinner than a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StrandEdges {
    /// Opaque ribbons, antialiased by the multisampling of the application's pass.
    #[default]
    Samples,
    /// Each pixel blends its eight nearest strands by coverage, which is stable and smooth with one sample per pixel.
    /// This needs 68 bytes per pixel that hair may cover. If the device's buffers are too small, [`Self::Samples`] is
    /// used.
    Blended,
}

/// Parameters of a frame in [`crate::Style::Fur`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct FurParams {
    /// Number of layers, skin included, 1..=1024; `None` (default) draws the baked number. The density of the fur stays
    /// the same (see [`crate::shared::opacity`]). Fewer layers are faster, but the steps between them show at the
    /// silhouette.
    pub layers: Option<u32>,
    /// Level of detail of fur that is small on screen (default [`Detail::Auto`] with a bias of 1). `layers` overrides
    /// it.
    pub detail: Detail,
    /// Whether fins are drawn, if the package has them (default true).
    pub fins: bool,
    /// Geometry of hair (default [`HairGeometry::Auto`]).
    pub hair: HairGeometry,
    /// Rendering of strand edges (default [`StrandEdges::Samples`]).
    pub strand_edges: StrandEdges,
    /// Method of hair self-shadow, t of Yang 2006, eq. (2) (default [`SelfShadow::Auto`]).
    pub self_shadow: SelfShadow,
    /// Scattering model, for packages with fibre data (default [`Scattering::Multiple`]).
    pub scattering: Scattering,
}

/// Maximum layer count; a greater value is assumed to be a mistake.
const MAX_LAYERS: u32 = 1024;

impl Default for FurParams {
    fn default() -> Self {
        Self {
            layers: None,
            detail: Detail::default(),
            fins: true,
            hair: HairGeometry::Auto,
            strand_edges: StrandEdges::Samples,
            self_shadow: SelfShadow::Auto,
            scattering: Scattering::Multiple,
        }
    }
}

impl FurParams {
    /// Returns the parameters with changes: `FurParams::default().with(|f| f.fins = false)`.
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
