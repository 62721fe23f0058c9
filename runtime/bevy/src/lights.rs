//! Conversion of Bevy's lights for fur.
//!
//! Bevy's lights are in lux and in candela per square metre. The exposure of a camera converts them to picture values.
//! A Lambertian surface of albedo 1 that faces a sun of E lux has the picture value E · exposure / π. In pelage the
//! same surface has the value 1 under a light of strength 1, which is full light.

use bevy_camera::visibility::RenderLayers;
use bevy_color::{ColorToComponents as _, LinearRgba};
use bevy_math::Vec3;
use pelage_runtime::formats::Shading;
use pelage_runtime::{FrameParams, Light, MAX_FILL_LIGHTS, Sphere};
use std::f32::consts::{FRAC_PI_2, PI};

/// A directional light of Bevy.
#[derive(Clone, Debug)]
pub(crate) struct Sun {
    pub(crate) towards_light: Vec3,
    pub(crate) color: LinearRgba,
    /// Illuminance, lux.
    pub(crate) illuminance: f32,
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

/// A point or spot light of Bevy.
#[derive(Clone, Debug)]
pub(crate) struct Lamp {
    pub(crate) position: Vec3,
    pub(crate) color: LinearRgba,
    /// Luminous power, lumens, as if the light shone in all directions.
    pub(crate) power: f32,
    /// Distance at which the light ends, metres.
    pub(crate) range_m: f32,
    /// Direction of a spot light, and its inner and outer angles in radians; `None` for a point light.
    pub(crate) cone: Option<(Vec3, f32, f32)>,
    pub(crate) shadows: bool,
    pub(crate) layers: RenderLayers,
}

/// Light of a lamp on an animal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LampLight {
    position: Vec3,
    /// Colour times illuminance, lux.
    illuminance: Vec3,
    shadows: bool,
}

/// Lamps that are weaker at an animal than this share of the strongest sun do not light it.
const LEAST_SHARE: f32 = 0.02;

impl Lamp {
    /// Returns the illuminance of a surface that faces the lamp, lux. The formulas are those of Bevy's meshes
    /// (`getDistanceAttenuation` and `spot_light` in its shader `pbr_lighting`).
    fn illuminance(&self, at: Vec3, least_distance_m: f32) -> f32 {
        let way = at - self.position;
        let distance = way.length().max(least_distance_m);
        let falloff = (1.0 - (distance / self.range_m).powi(4)).max(0.0);
        let cone = self.cone.map_or(1.0, |(direction, inner, outer)| {
            let outer = outer.min(FRAC_PI_2 - 1e-4);
            let width = (inner.min(outer).cos() - outer.cos()).max(1e-4);
            ((direction.dot(way.normalize_or(direction)) - outer.cos()) / width).clamp(0.0, 1.0)
        });
        self.power / (4.0 * PI * distance * distance) * (falloff * cone).powi(2)
    }
}

/// Returns the lamps that light an animal, for a camera with the render layers `layers`.
pub(crate) fn lamps_at(lamps: &[Lamp], suns: &[Sun], layers: &RenderLayers, animal: Sphere) -> Vec<LampLight> {
    let suns = suns.iter().filter(|sun| sun.layers.intersects(layers));
    let strongest = suns.map(|sun| (sun.color.to_vec3() * sun.illuminance).element_sum()).fold(0.0, f32::max);
    let lit = lamps.iter().filter(|lamp| lamp.layers.intersects(layers)).map(|lamp| LampLight {
        position: lamp.position,
        // Inside the animal the distance says nothing about its fur.
        illuminance: lamp.color.to_vec3() * lamp.illuminance(animal.center, 0.5 * animal.radius),
        shadows: lamp.shadows,
    });
    lit.filter(|light| light.illuminance.element_sum() > LEAST_SHARE * strongest).collect()
}

/// Sets the lights of a frame for a camera with the render layers `layers`. The strongest light is the key light and
/// casts shadows. Up to 32 others are fill lights.
pub(crate) fn set_lights(
    params: &mut FrameParams,
    suns: &[Sun],
    lamps: &[LampLight],
    ambient: Ambient,
    exposure: f32,
    layers: &RenderLayers,
) {
    // Full light has the strength 1.
    let per_lux = exposure / PI;
    let suns = suns.iter().filter(|sun| sun.layers.intersects(layers)).map(|sun| {
        let color = sun.color.to_vec3() * (sun.illuminance * per_lux);
        (Light::Directional { towards_light: sun.towards_light, color }, sun.shadows)
    });
    let lamps = lamps
        .iter()
        .map(|lamp| (Light::Point { position: lamp.position, color: lamp.illuminance * per_lux }, lamp.shadows));
    let mut lights: Vec<(Light, bool)> = suns.chain(lamps).collect();
    lights.sort_by(|(a, _), (b, _)| b.color().element_sum().total_cmp(&a.color().element_sum()));
    // Without lights the key light is black, and its shadow maps are not drawn.
    let black = (Light::Directional { towards_light: Vec3::Y, color: Vec3::ZERO }, false);
    (params.light, params.soft_shadow) = lights.first().copied().unwrap_or(black);
    params.fill_lights = lights.iter().skip(1).take(MAX_FILL_LIGHTS).map(|(light, _)| *light).collect();
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

    fn frame_params(suns: &[Sun], lamps: &[LampLight]) -> FrameParams {
        let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, Projection::Custom(bevy_math::Mat4::IDENTITY));
        let mut params = FrameParams::new(camera, [4, 4]);
        let ambient = Ambient::new(LinearRgba::rgb(0.5, 1.0, 1.0), 350.0);
        set_lights(&mut params, suns, lamps, ambient, EXPOSURE, &RenderLayers::default());
        params
    }

    #[test]
    fn strongest_directional_light_of_the_layers_is_the_key_light() {
        let params = frame_params(&[sun(1000.0, false, 0), sun(2000.0 * PI, true, 0), sun(1e6, true, 3)], &[]);
        let near = |a: Vec3, b: Vec3| assert!((a - b).length() < 1e-4, "{a} is not {b}");
        near(params.light.color(), Vec3::new(2.0, 1.0, 0.5));
        assert!(params.soft_shadow);
        assert_eq!(params.fill_lights.len(), 1, "the sun in another layer is ignored");
        near(params.fill_lights[0].color(), Vec3::new(1.0, 0.5, 0.25) / PI);
        near(params.ambient, Vec3::new(0.5, 1.0, 1.0));
    }

    #[test]
    fn without_suns_the_key_light_is_black_and_excess_suns_are_dropped() {
        assert_eq!(frame_params(&[], &[]).light.color(), Vec3::ZERO);
        assert!(!frame_params(&[], &[]).soft_shadow);
        assert_eq!(frame_params(&vec![sun(1.0, false, 0); 40], &[]).fill_lights.len(), MAX_FILL_LIGHTS);
    }

    fn lamp(cone: Option<(Vec3, f32, f32)>) -> Lamp {
        let (color, layers) = (LinearRgba::WHITE, RenderLayers::default());
        Lamp { position: Vec3::Y * 3.0, color, power: 4.0 * PI * 900.0, range_m: 10.0, cone, shadows: true, layers }
    }

    #[test]
    fn lamps_fall_off_with_distance_range_and_cone() {
        let near =
            |found: f32, expected: f32| assert!((found - expected).abs() < 1e-3 * expected, "{found} {expected}");
        near(lamp(None).illuminance(Vec3::ZERO, 0.1), 100.0 * (1.0f32 - 0.0081).powi(2));
        near(lamp(None).illuminance(Vec3::Y * 3.0, 1.0), 900.0 * (1.0f32 - 1e-4).powi(2));
        assert_eq!(lamp(None).illuminance(Vec3::Y * -7.1, 0.1), 0.0, "beyond the range");
        let spot = |direction: Vec3| lamp(Some((direction, 0.2, 0.6))).illuminance(Vec3::ZERO, 0.1);
        assert_eq!(spot(Vec3::NEG_Y), lamp(None).illuminance(Vec3::ZERO, 0.1), "inside the inner cone");
        let between = spot(Vec3::new(0.4f32.sin(), -0.4f32.cos(), 0.0)) / spot(Vec3::NEG_Y);
        near(between, ((0.4f32.cos() - 0.6f32.cos()) / (0.2f32.cos() - 0.6f32.cos())).powi(2));
        assert_eq!(spot(Vec3::new(0.7f32.sin(), -0.7f32.cos(), 0.0)), 0.0, "outside the outer cone");
    }

    #[test]
    fn strongest_lamp_is_the_key_light_unless_a_sun_outshines_it() {
        let animal = Sphere { center: Vec3::ZERO, radius: 0.5 };
        let lamps_beside = |suns: &[Sun]| lamps_at(&[lamp(None)], suns, &RenderLayers::default(), animal);
        let dim = [sun(10.0, false, 0)];
        let params = frame_params(&dim, &lamps_beside(&dim));
        assert!(matches!(params.light, Light::Point { position, .. } if position == Vec3::Y * 3.0), "{params:?}");
        assert!(params.soft_shadow && params.fill_lights.len() == 1);
        let day = [sun(100_000.0, false, 0)];
        assert_eq!(lamps_beside(&day), [], "weaker than a fiftieth of the sun");
        let lamps = lamps_beside(&[sun(100_000.0, false, 2)]);
        assert_eq!(lamps.len(), 1, "the sun is in another layer");
    }
}
