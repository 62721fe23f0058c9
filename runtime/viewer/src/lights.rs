//! Files that a look names, environment map and seal; read when the look names a different one.

use pelage_runtime::SealImage;
use pelage_stage::{LightsRead, Look};
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Function that loads an environment map. Arguments: path, number of lobes to fit to a panorama, albedo of a ground
/// below it.
pub type LoadLights = fn(&Path, u32, Option<[f32; 3]>) -> LightsRead;

/// Error message of a viewer that cannot read files.
const UNREAD: &str = "files cannot be read here";

/// Function that loads the image of a seal.
pub type LoadSeal = fn(&Path) -> SealRead;

/// Image read from the file of a seal, or an error message.
type SealRead = Result<Arc<SealImage>, String>;

/// Arguments with which [`LoadLights`] was called.
type LightsKey = (PathBuf, u32, Option<[f32; 3]>);

/// Cache of the most recently loaded environment map and seal.
#[derive(Default)]
pub(crate) struct Lights {
    read: Option<(LoadLights, LoadSeal)>,
    last: RefCell<Option<(LightsKey, LightsRead)>>,
    last_seal: RefCell<Option<(PathBuf, SealRead)>>,
}

impl Lights {
    pub(crate) fn new(lights: LoadLights, seal: LoadSeal) -> Self {
        Self { read: Some((lights, seal)), ..Self::default() }
    }

    /// Sets the lights and the seal of a look from the files that it names, if any.
    pub(crate) fn apply_to(&self, look: &mut Look) -> Result<(), String> {
        look.read_environment(&mut |path, lobes, ground| {
            let mut last = self.last.borrow_mut();
            let asked = (path.to_owned(), lobes, ground);
            if let Some((_, lights)) = last.as_ref().filter(|(before, _)| *before == asked) {
                return lights.clone();
            }
            let unread = || Err(UNREAD.to_owned());
            let lights = self.read.map_or_else(unread, |(read, _)| read(path, lobes, ground));
            *last = Some((asked, lights.clone()));
            lights
        })?;
        look.read_seal(&mut |path| {
            let mut last = self.last_seal.borrow_mut();
            if let Some((_, seal)) = last.as_ref().filter(|(before, _)| before == path) {
                return seal.clone();
            }
            let seal = self.read.map_or_else(|| Err(UNREAD.to_owned()), |(_, read)| read(path));
            *last = Some((path.to_owned(), seal.clone()));
            seal
        })
    }
}
