//! Sky as the background of a picture.

use super::environment::Sky;
use super::exit::Failure;
use glam::DVec2;
use image::RgbaImage;
use pelage_formats::meaning::{linear_to_srgb, srgb_to_linear};
use pelage_stage::{Background, Look};
use pelage_truth::TrueCamera;

/// Checks that a look with a sky background has a sky.
///
/// Fails with [`Failure::Usage`] if the sky is missing.
pub fn check(look: &Look) -> Result<(), Failure> {
    if look.picture.background == Some(Background::Sky) && look.environment.sky.is_none() {
        let reason = "--background sky: found no environment map, expected --environment as well";
        return Err(Failure::Usage(reason.into()));
    }
    Ok(())
}

/// Composites a picture over the sky if the look has a sky background; the sky is rotated by an additional `turn_deg`.
/// The picture is sRGB-encoded, with straight alpha.
pub fn lay_over_sky(look: &Look, sky: Option<&Sky>, pixels: &mut RgbaImage, camera: &TrueCamera, turn_deg: f32) {
    let Some(sky) = sky.filter(|_| look.picture.background == Some(Background::Sky)) else { return };
    let ways = camera.view_directions(pixels.dimensions());
    for (x, y, pixel) in pixels.enumerate_pixels_mut() {
        let [r, g, b, alpha] = pixel.0;
        if alpha == u8::MAX {
            continue;
        }
        let behind =
            sky.radiance(ways.direction_at(DVec2::new(x.into(), y.into()) + 0.5), turn_deg).as_vec3().to_array();
        let share = f32::from(alpha) / 255.0;
        let over = |color: u8, behind: f32| linear_to_srgb(srgb_to_linear(color) * share + behind * (1.0 - share));
        *pixel = image::Rgba([over(r, behind[0]), over(g, behind[1]), over(b, behind[2]), u8::MAX]);
    }
}
