//! Hooks through which an application takes part in the preparation of a frame.

use crate::light::Casters;
use crate::passes::PassId;
use std::fmt;

/// Callback after each pass that runs before the picture, recorded or skipped. Arguments: encoder, pass.
pub(crate) type Mark<'a> = dyn FnMut(&mut wgpu::CommandEncoder, PassId) + 'a;

/// Optional hooks of a frame: `Hooks::default()` has none.
#[derive(Default)]
#[non_exhaustive]
pub struct Hooks<'a> {
    /// Geometry of the application that casts and receives shadows.
    pub casters: Option<Casters<'a>>,
    /// Callback after each pass with [`crate::PassStage::Before`], whether or not it recorded anything; used to time
    /// passes. The callback may replace the encoder by another one of the same device, and must then submit the
    /// encoders in order.
    pub mark: Option<&'a mut Mark<'a>>,
}

impl<'a> Hooks<'a> {
    /// Adds geometry of the application that casts and receives shadows.
    pub fn casters(self, casters: Casters<'a>) -> Self {
        Self { casters: Some(casters), ..self }
    }

    /// Adds a callback after each pass that runs before the picture.
    pub fn mark(self, mark: &'a mut Mark<'a>) -> Self {
        Self { mark: Some(mark), ..self }
    }
}

impl fmt::Debug for Hooks<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Hooks").field("casters", &self.casters).finish_non_exhaustive()
    }
}
