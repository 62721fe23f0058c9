//! Conversion of Bevy's lights for fur.
//!
//! Bevy's lights are in lux and in candela per square metre. The exposure of a camera converts them to picture values.
//! A Lambertian surface of albedo 1 that faces a sun of E lux has the picture value E · exposure / π. In pelage the
//! same surface has the value 1 under a light of strength 1, which is full light.

use bevy_camera::visibility::RenderLayers;
use bevy_color::{ColorToComponents as _, LinearRgba};
use bevy_math::Vec3;
use pelage_runtime::formats::Shading;
use pelage_runtime::{FrameParams, Light, MAX_FILL_LIGHTS};
use std::f32::consts::PI;

/// A directional light of Bevy.
#[derive(Clone, Debug)]
pub(crate) struct Sun {
    pub(crate) towards_light: Vec3,
    pub(crate) color: LinearRgba,
    /// Illuminance, lux.
    pub(crate) illuminance: f32,
    /// Whether it casts shadows.
    pub(crate) shadows: bool,
    pub(crate) layers: RenderLayers,
}

/// An ambient light of Bevy: colour times brightness, candela per square metre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Ambient(pub(crate) Vec3);

impl Ambient {
    pub(crate) fn new(color: LinearRgba, brightness: f32) -> Self {
        Self(color.to_vec3() * brightness)
    }
}

/// Returns the strength of a light, linear RGB; 1 is full light.
fn strength(sun: &Sun, exposure: f32) -> Vec3 {
    sun.color.to_vec3() * (sun.illuminance * exposure / PI)
}

/// Sets the lights of a frame for a camera with the render layers `layers`. The strongest sun is the key light and
/// casts shadows. Up to 32 others are fill lights.
pub(crate) fn set_lights(
    params: &mut FrameParams,
    suns: &[Sun],
    ambient: Ambient,
    exposure: f32,
    layers: &RenderLayers,
) {
    let mut visible: Vec<&Sun> = suns.iter().filter(|sun| sun.layers.intersects(layers)).collect();
    let brightness = |sun: &Sun| strength(sun, exposure).element_sum();
    visible.sort_by(|a, b| brightness(b).total_cmp(&brightness(a)));
    let directional =
        |sun: &Sun| Light::Directional { towards_light: sun.towards_light, color: strength(sun, exposure) };
    // Without a sun the key light is black, and its shadow maps are not drawn.
    params.light = visible
        .first()
        .map_or(Light::Directional { towards_light: Vec3::Y, color: Vec3::ZERO }, |key| directional(key));
    params.soft_shadow = visible.first().is_some_and(|key| key.shadows);
    params.fill_lights = visible.iter().skip(1).take(MAX_FILL_LIGHTS).map(|sun| directional(sun)).collect();
    // The runtime multiplies ambient light by a constant of the package. Dividing by the constant's default compensates
    // for it. A package with the default then looks as bright as the Bevy meshes beside it.
    params.ambient = ambient.0 * exposure / Vec3::from(Shading::default().ambient);
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_runtime::{Camera, Projection};

    const EXPOSURE: f32 = 0.001;

    fn sun(illuminance: f32, shadows: bool, layer: usize) -> Sun {
        let color = LinearRgba::rgb(1.0, 0.5, 0.25);
        Sun { towards_light: Vec3::X, color, illuminance, shadows, layers: RenderLayers::layer(layer) }
    }

    fn frame_params(suns: &[Sun]) -> FrameParams {
        let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, Projection::Custom(bevy_math::Mat4::IDENTITY));
        let mut params = FrameParams::new(camera, [4, 4]);
        let ambient = Ambient::new(LinearRgba::rgb(0.5, 1.0, 1.0), 350.0);
        set_lights(&mut params, suns, ambient, EXPOSURE, &RenderLayers::default());
        params
    }

    #[test]
    fn strongest_directional_light_of_the_layers_is_the_key_light() {
        let params = frame_params(&[sun(1000.0, false, 0), sun(2000.0 * PI, true, 0), sun(1e6, true, 3)]);
        let near = |a: Vec3, b: Vec3| assert!((a - b).length() < 1e-4, "{a} is not {b}");
        near(params.light.color(), Vec3::new(2.0, 1.0, 0.5));
        assert!(params.soft_shadow);
        assert_eq!(params.fill_lights.len(), 1, "the sun in another layer is ignored");
        near(params.fill_lights[0].color(), Vec3::new(1.0, 0.5, 0.25) / PI);
        near(params.ambient, Vec3::new(0.5, 1.0, 1.0));
    }

    #[test]
    fn without_suns_the_key_light_is_black_and_excess_suns_are_dropped() {
        assert_eq!(frame_params(&[]).light.color(), Vec3::ZERO);
        assert!(!frame_params(&[]).soft_shadow);
        assert_eq!(frame_params(&vec![sun(1.0, false, 0); 40]).fill_lights.len(), MAX_FILL_LIGHTS);
    }
}
