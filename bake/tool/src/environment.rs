//! Environment map named by a look, read and fitted.

use super::exit::Failure;
use glam::{DQuat, DVec3};
use pelage_bake::environment_file::EnvironmentFile;
use pelage_import::BakeError;
#[cfg(feature = "view")]
use pelage_stage::LightsRead;
use pelage_stage::sky::{Environment, FitParams, FitResult, Sun};
use pelage_stage::{Look, SkyKind};
use pelage_truth::TrueSky;
use std::path::Path;
#[cfg(feature = "view")]
use std::sync::Arc;
use std::sync::OnceLock;

/// Reads an environment map and returns its lights.
///
/// Fails with a message that names the file, the location in it, and the error.
#[cfg(feature = "view")]
pub fn lights_of(path: &Path, lobes: u32, ground: Option<[f32; 3]>) -> LightsRead {
    let of = read(path, lobes, ground).map_err(|error| error.to_string())?;
    let sky = Sky { of, yaw_deg: 0.0, strength: 1.0, lobes: lobes as usize, fitted: OnceLock::new() };
    Ok(Arc::new(sky.lights()))
}

/// Reads an environment map. If `ground` is given, it replaces everything below the horizon.
fn read(path: &Path, lobes: u32, ground: Option<[f32; 3]>) -> Result<EnvironmentFile, BakeError> {
    EnvironmentFile::read(path)?.over_ground(ground, lobes as usize)
}

/// Environment map of a look, with the look's rotation and strength.
#[derive(Debug)]
pub struct Sky {
    of: EnvironmentFile,
    yaw_deg: f32,
    strength: f32,
    lobes: usize,
    fitted: OnceLock<Option<FitResult>>,
}

impl PartialEq for Sky {
    fn eq(&self, other: &Self) -> bool {
        let numbers = |sky: &Self| (sky.yaw_deg, sky.strength, sky.lobes);
        self.of == other.of && numbers(self) == numbers(other)
    }
}

impl Sky {
    /// Reads the environment map of a look; `None` if the look has none.
    ///
    /// Fails for an unreadable file, and for a file that is not an environment map.
    pub fn of(look: &Look) -> Result<Option<Self>, Failure> {
        let Some(source) = &look.environment.sky else { return Ok(None) };
        let of = match &source.kind {
            SkyKind::File(path) => read(Path::new(path), look.environment.lobes, look.environment.ground_color())?,
            _ => EnvironmentFile::Lights(look.environment.built_in().unwrap_or_default()),
        };
        let (yaw_deg, strength) = (source.yaw_deg, look.environment.strength);
        let lobes = look.environment.lobes as usize;
        Ok(Some(Self { of, yaw_deg, strength, lobes, fitted: OnceLock::new() }))
    }

    /// Returns the lights that were fitted to a panorama; `None` for a file that contains lights.
    pub fn fitted(&self) -> Option<&FitResult> {
        let fit = || match &self.of {
            EnvironmentFile::Panorama(panorama) => {
                Some(panorama.fit(FitParams { lobes: self.lobes, ..FitParams::default() }))
            }
            EnvironmentFile::Lights(_) => None,
        };
        self.fitted.get_or_init(fit).as_ref()
    }

    /// Returns the lights without the look's rotation and strength.
    pub fn lights(&self) -> Environment {
        match (&self.of, self.fitted()) {
            (EnvironmentFile::Lights(lights), _) => lights.clone(),
            (EnvironmentFile::Panorama(_), fitted) => {
                fitted.map(|fitted| fitted.environment.clone()).unwrap_or_default()
            }
        }
    }

    /// Returns the lights with the look's rotation and strength.
    pub fn environment(&self) -> Environment {
        self.lights().turned(self.yaw_deg).scaled(self.strength)
    }

    /// Returns the radiance from the unit direction `towards`, linear RGB. The sky is rotated by an additional
    /// `turn_deg`. For a file of lights, the sun is not included.
    pub fn radiance(&self, towards: DVec3, turn_deg: f32) -> DVec3 {
        let inside = DQuat::from_rotation_y(-f64::from(self.yaw_deg + turn_deg).to_radians()) * towards;
        let radiance = match &self.of {
            EnvironmentFile::Panorama(panorama) => panorama.sample(inside),
            EnvironmentFile::Lights(lights) => lights.radiance(inside),
        };
        radiance * f64::from(self.strength)
    }

    /// Returns the environment for path tracing. A panorama is unchanged and contains its sun; lights have a separate
    /// sun.
    pub fn for_tracing(&self) -> (TrueSky, Option<Sun>) {
        match &self.of {
            EnvironmentFile::Panorama(panorama) => {
                (TrueSky::of_panorama(panorama.clone(), self.yaw_deg, self.strength), None)
            }
            EnvironmentFile::Lights(_) => {
                let lights = self.environment();
                let sun = lights.sun;
                (TrueSky::of_environment(lights), sun)
            }
        }
    }
}
