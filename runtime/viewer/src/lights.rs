//! Environment map files; read when the look names a different one.

use pelage_stage::{LightsRead, Look};
use std::cell::RefCell;
use std::path::{Path, PathBuf};

/// Function that loads an environment map. Arguments: path, number of lobes to fit to a panorama, albedo of a ground
/// below it.
pub type LoadLights = fn(&Path, u32, Option<[f32; 3]>) -> LightsRead;

/// Arguments with which [`LoadLights`] was called.
type LightsKey = (PathBuf, u32, Option<[f32; 3]>);

/// Cache of the most recently loaded environment map.
#[derive(Default)]
pub(crate) struct Lights {
    read: Option<LoadLights>,
    last: RefCell<Option<(LightsKey, LightsRead)>>,
}

impl Lights {
    pub(crate) fn new(read: LoadLights) -> Self {
        Self { read: Some(read), last: RefCell::default() }
    }

    /// Sets the lights of a look from the environment map file that it names, if any.
    pub(crate) fn apply_to(&self, look: &mut Look) -> Result<(), String> {
        look.read_environment(&mut |path, lobes, ground| {
            let mut last = self.last.borrow_mut();
            let asked = (path.to_owned(), lobes, ground);
            if let Some((_, lights)) = last.as_ref().filter(|(before, _)| *before == asked) {
                return lights.clone();
            }
            let unread = || Err("files cannot be read here".to_owned());
            let lights = self.read.map_or_else(unread, |read| read(path, lobes, ground));
            *last = Some((asked, lights.clone()));
            lights
        })
    }
}
