//! How fur is drawn.

use super::detail::Detail;
use crate::error::RuntimeError;

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
    /// Whether hair shadows hair, t of Yang 2006, eq. (2), by layer-wise shadow maps (default true).
    pub self_shadow: bool,
}

/// More layers than this are a mistake.
const MAX_LAYERS: u32 = 1024;

impl Default for FurParams {
    fn default() -> Self {
        Self { layers: None, detail: Detail::Full, fins: true, self_shadow: true }
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
