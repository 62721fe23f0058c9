//! Bounding spheres of animals and their shadow casters.

use bevy_math::{Mat3, Vec3};
use pelage_runtime::{Instance, ShadowParams, Sphere};

/// Maximum extent of an animal in motion, relative to its extent at rest.
const MOTION_FACTOR: f32 = 1.5;

/// Maximum factor by which shadow maps are enlarged. The factor is the extent of all animals divided by that of one.
const MAX_ENLARGEMENT: f32 = 4.0;

/// Returns a sphere that contains an animal in any pose.
pub(crate) fn animal_bounds(animal: &Instance) -> Sphere {
    let manifest = animal.model.manifest();
    let scale = Mat3::from_mat4(animal.transform).determinant().abs().cbrt();
    Sphere {
        center: animal.transform.transform_point3(manifest.bounds.center.into()),
        radius: MOTION_FACTOR * scale * (manifest.bounds.radius + manifest.fur.height_m),
    }
}

pub(crate) fn enclosing_sphere(a: Sphere, b: Sphere) -> Sphere {
    let apart = a.center.distance(b.center);
    if apart + b.radius <= a.radius {
        return a;
    }
    if apart + a.radius <= b.radius {
        return b;
    }
    let radius = 0.5 * (apart + a.radius + b.radius);
    let center = a.center + (b.center - a.center) * ((radius - a.radius) / apart);
    Sphere { center, radius }
}

/// Returns how far a caster extends towards the light past the centre of `lit`, metres. `None` if no part of it can
/// shade `lit`.
///
/// * `towards_light`: direction of unit length
pub(crate) fn extent_towards_light(lit: Sphere, towards_light: Vec3, caster: Sphere) -> Option<f32> {
    let way = caster.center - lit.center;
    let along = way.dot(towards_light);
    let aside = (way - along * towards_light).length();
    let shades = aside < lit.radius + caster.radius && along + caster.radius > -lit.radius;
    shades.then_some(along + caster.radius)
}

/// Increases the size of the shadow maps if the animals of a frame are spread out. All animals share the same maps;
/// larger maps keep the size of a texel.
pub(crate) fn enlarge_maps(shadows: ShadowParams, animals: &[Sphere], max_texels: u32) -> ShadowParams {
    let Some(all) = animals.iter().copied().reduce(enclosing_sphere) else { return shadows };
    let least = animals.iter().map(|animal| animal.radius).fold(all.radius, f32::min);
    let times = (all.radius / least.max(1e-6)).clamp(1.0, MAX_ENLARGEMENT).log2().ceil().exp2() as u32;
    shadows.with(|shadows| shadows.map_size = shadows.map_size.max((shadows.map_size * times).min(max_texels)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sphere(x: f32, y: f32, radius: f32) -> Sphere {
        Sphere { center: Vec3::new(x, y, 0.0), radius }
    }

    #[test]
    fn enclosing_sphere_of_two_is_minimal() {
        let both = enclosing_sphere(sphere(0.0, 0.0, 1.0), sphere(4.0, 0.0, 2.0));
        assert!((both.center.x - 2.5).abs() < 1e-6 && (both.radius - 3.5).abs() < 1e-6, "{both:?}");
        assert_eq!(
            enclosing_sphere(sphere(0.0, 0.0, 3.0), sphere(1.0, 0.0, 1.0)),
            sphere(0.0, 0.0, 3.0),
            "one inside the other"
        );
        assert_eq!(enclosing_sphere(sphere(0.0, 0.0, 1.0), sphere(0.0, 0.0, 1.0)), sphere(0.0, 0.0, 1.0));
    }

    #[test]
    fn only_spheres_towards_the_light_cast_shadows() {
        let lit = sphere(0.0, 0.0, 1.0);
        assert_eq!(extent_towards_light(lit, Vec3::Y, sphere(0.5, 5.0, 0.5)), Some(5.5));
        assert_eq!(extent_towards_light(lit, Vec3::Y, sphere(2.0, 5.0, 0.5)), None, "beside the path of the light");
        assert_eq!(extent_towards_light(lit, Vec3::Y, sphere(0.0, -2.0, 0.5)), None, "behind the lit sphere");
        assert_eq!(extent_towards_light(lit, Vec3::Y, sphere(0.0, 0.0, 0.2)), Some(0.2), "inside the lit sphere");
    }

    #[test]
    fn maps_grow_with_the_spread_of_the_animals_up_to_a_limit() {
        let texels = |animals: &[Sphere]| enlarge_maps(ShadowParams::default(), animals, 1500).map_size;
        assert_eq!(texels(&[]), 512);
        assert_eq!(texels(&[sphere(0.0, 0.0, 1.0)]), 512);
        assert_eq!(texels(&[sphere(0.0, 0.0, 1.0), sphere(2.0, 0.0, 1.0)]), 1024);
        assert_eq!(texels(&[sphere(0.0, 0.0, 1.0), sphere(90.0, 0.0, 1.0)]), 1500, "limited by the device");
        let wanted = ShadowParams::default().with(|shadows| shadows.map_size = 4096);
        assert_eq!(
            enlarge_maps(wanted, &[sphere(0.0, 0.0, 1.0)], 2048).map_size,
            4096,
            "a requested size is never reduced"
        );
    }
}
