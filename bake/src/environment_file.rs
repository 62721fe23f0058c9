//! Environment maps in files: panoramas in Radiance HDR and OpenEXR, and sets of lights in TOML.

use crate::io::{read_file, read_text};
use glam::DVec3;
use pelage_import::BakeError;
use pelage_import::image_file::{bounded_reader, check_memory};
use pelage_stage::sky::{Environment, FitParams, Panorama, environment_from_toml};
use std::path::Path;

/// Width and height of the intermediate panorama, texels. A set of lights is rendered into it before its ground is
/// replaced.
const PAINTED: (u32, u32) = (128, 64);

/// Environment map read from a file.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentFile {
    /// Panorama image.
    Panorama(Panorama),
    /// Small set of lights.
    Lights(Environment),
}

impl EnvironmentFile {
    /// Replaces the lower hemisphere by level ground of the given albedo, linear RGB. From a set of lights, this makes
    /// a newly fitted set with at most `lobes` lobes. Returns the environment unchanged if `albedo` is `None`.
    ///
    /// Fails with [`BakeError::Internal`] only if the lights cannot be rendered.
    pub fn over_ground(self, albedo: Option<[f32; 3]>, lobes: usize) -> Result<Self, BakeError> {
        let Some(albedo) = albedo else { return Ok(self) };
        Ok(match self {
            Self::Panorama(panorama) => Self::Panorama(panorama.over_ground(albedo, DVec3::ZERO)),
            Self::Lights(lights) => {
                let sun = lights.sun;
                let onto = Environment { sun, ..Environment::default() }.ground_irradiance();
                let painted = Panorama::from_fn(PAINTED, |way| lights.radiance(way));
                let painted = painted.map_err(|error| BakeError::Internal(error.to_string()))?;
                let fitted = painted.over_ground(albedo, onto).fit(FitParams { lobes, sun: f64::INFINITY });
                Self::Lights(Environment { sun, ..fitted.environment })
            }
        })
    }

    /// Reads an environment map; the extension selects the format: `.hdr`, `.exr` or `.toml`.
    ///
    /// Fails with [`BakeError::Input`] if the file cannot be read or its contents do not match the extension.
    pub fn read(path: &Path) -> Result<Self, BakeError> {
        let file = path.display().to_string();
        let input = |place: &str, reason: String| BakeError::Input { file: file.clone(), place: place.into(), reason };
        let end = path.extension().map(|end| end.to_string_lossy().to_lowercase()).unwrap_or_default();
        let format = match end.as_str() {
            "toml" => {
                let text = read_text(path, "lights in TOML")?;
                let lights = environment_from_toml(&file, &text).map_err(|error| match error {
                    pelage_stage::StageError::Input { place, reason, .. } => input(&place, reason),
                    other => input("whole file", other.to_string()),
                })?;
                return Ok(Self::Lights(lights));
            }
            "hdr" => image::ImageFormat::Hdr,
            "exr" => image::ImageFormat::OpenExr,
            _ => {
                let reason = format!("has a name that ends in {end:?}, expected .hdr, .exr or .toml");
                return Err(input("whole file", reason));
            }
        };
        let bytes = read_file(path)?;
        let (pixels, width, height) = bounded_reader(&bytes, format).map_err(|reason| input("header", reason))?;
        // Texels are held twice while they are converted.
        let memory = check_memory(24 * u64::from(width) * u64::from(height));
        memory.map_err(|reason| input("header", format!("{reason}; scale it to 8192 x 4096 texels")))?;
        let broken = |error: image::ImageError| input("pixels", format!("cannot be decoded: {error}"));
        let pixels = pixels.decode().map_err(broken)?.into_rgb32f().into_raw();
        let pixels = pixels.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2]]).collect();
        let panorama = Panorama::new(width, height, pixels);
        panorama.map(Self::Panorama).map_err(|error| input("pixels", error.to_string()))
    }
}
