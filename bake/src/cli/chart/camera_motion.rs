//! Pictures between which the camera moves, for what changes in them though the model does not.

use glam::Quat;
use image::RgbaImage;
use pelage_stage::Viewpoint;

/// The camera, gone about the vertical axis through its target.
pub fn turned(Viewpoint { eye, target, fov_deg }: Viewpoint, degrees: f32) -> Viewpoint {
    Viewpoint { eye: target + Quat::from_rotation_y(degrees.to_radians()) * (eye - target), target, fov_deg }
}

/// Luma of sRGB-encoded pixels, 0..=1.
pub fn greys(picture: &RgbaImage) -> Vec<f32> {
    let luma = |p: &image::Rgba<u8>| {
        let [r, g, b, _] = p.0.map(|byte| f32::from(byte) / 255.0);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    picture.pixels().map(luma).collect()
}
