//! What an application may take part in while a frame is prepared.

use crate::light::Casters;
use crate::passes::PassId;
use std::fmt;

/// Called with the encoder after each pass that is recorded, or left out, before the picture.
pub(crate) type Mark<'a> = dyn FnMut(&mut wgpu::CommandEncoder, PassId) + 'a;

/// What else belongs to a frame: `Hooks::default()` is nothing.
#[derive(Default)]
#[non_exhaustive]
pub struct Hooks<'a> {
    /// Geometry of the application's own among the shadows.
    pub casters: Option<Casters<'a>>,
    /// Called after each pass with [`crate::PassPlace::Before`], whether it recorded anything or not: how passes are timed. It may put another
    /// encoder of the device in the place of the one it is given, and must then submit them in their order.
    pub mark: Option<&'a mut Mark<'a>>,
}

impl<'a> Hooks<'a> {
    /// With geometry of the application's own among the shadows.
    pub fn casters(self, casters: Casters<'a>) -> Self {
        Self { casters: Some(casters), ..self }
    }

    /// With a call after each pass before the picture.
    pub fn mark(self, mark: &'a mut Mark<'a>) -> Self {
        Self { mark: Some(mark), ..self }
    }
}

impl fmt::Debug for Hooks<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Hooks").field("casters", &self.casters).finish_non_exhaustive()
    }
}
