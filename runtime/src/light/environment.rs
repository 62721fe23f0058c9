//! Environment light on surfaces and hair. It is stored in a small map by the direction that they face, which is
//! rebuilt when the environment map changes. Also tables of how fibres scatter light that is spread about a direction.

use crate::error::RuntimeError;
use crate::gpu::Gpu;
use crate::shared::environment::from_octahedral;
use glam::{DVec3, Vec2, Vec3, Vec4};
use half::f16;
use pelage_formats::FibreInfo;
use pelage_formats::meaning::environment::Environment;
use pelage_formats::meaning::luminance;
use pelage_formats::meaning::scattering::broad::{BroadSize, BroadTables, HORIZON_SINE};
use std::f32::consts::PI;
use std::sync::Arc;

/// Size of the map, texels along each edge.
const MAP_SIZE: u32 = 24;
/// Number of sampled light directions, about 6 degrees apart.
const DIRECTIONS: usize = 1024;
/// Half width of the fade-in above the lowest light direction ([`HORIZON_SINE`]), as the sine of the elevation: half
/// the spacing of directions.
const RISE: f32 = 0.05;
/// Maximum number of parts into which an environment is divided.
pub(crate) const PARTS: usize = 2;
/// Minimum distance between the centres of two parts, as 1 minus the cosine of their angle.
const LEAST_APART: f32 = 0.15;
/// Number of rounds in which the centres of parts move to the mean of their lights.
const ROUNDS: usize = 8;
/// Largest value of a half float.
const MAX_HALF: f32 = 65_000.0;

/// Environment map in the form that shaders read.
#[derive(Debug)]
pub(crate) struct EnvironmentMap {
    of: Environment,
    pub(crate) map: wgpu::TextureView,
    /// Largest channel of the irradiance over all directions, divided by π.
    pub(crate) max_irradiance: f32,
}

/// Broad-light tables for the fibres of several models, concatenated.
#[derive(Debug)]
pub(crate) struct BroadLightTables {
    of: Vec<Arc<FibreInfo>>,
    pub(crate) tables: wgpu::TextureView,
}

/// Environment map and broad-light tables that a renderer keeps.
#[derive(Debug, Default)]
pub(crate) struct EnvironmentCache {
    sky: Option<Arc<EnvironmentMap>>,
    broad: Option<Arc<BroadLightTables>>,
}

impl EnvironmentCache {
    /// Returns the map of an environment; rebuilds it if the environment has changed.
    pub(crate) fn sky(&mut self, gpu: &Gpu, environment: &Environment) -> Arc<EnvironmentMap> {
        if let Some(sky) = self.sky.as_ref().filter(|sky| sky.of == *environment) {
            return sky.clone();
        }
        let (layers, most) = build_map(environment);
        let count = layers.len() as u32 / (MAP_SIZE * MAP_SIZE);
        let map = texture(gpu, "pelage environment", [MAP_SIZE, MAP_SIZE, count], &layers);
        let sky = Arc::new(EnvironmentMap { of: environment.clone(), map, max_irradiance: most });
        self.sky = Some(sky.clone());
        sky
    }

    /// Returns the tables for the fibres of `models`, and for each model the index of its first table; `None` for a
    /// model without fibres.
    ///
    /// # Errors
    ///
    /// [`RuntimeError::DeviceLimit`] if there are more fibres than a texture can have layers.
    pub(crate) fn broad<'m>(
        &mut self,
        gpu: &Gpu,
        models: impl Iterator<Item = Option<&'m Arc<FibreInfo>>> + Clone,
    ) -> Result<(Arc<BroadLightTables>, Vec<u32>), RuntimeError> {
        let mut of: Vec<Arc<FibreInfo>> = Vec::new();
        for info in models.clone().flatten() {
            if !of.iter().any(|known| Arc::ptr_eq(known, info)) {
                of.push(info.clone());
            }
        }
        let first = |info: &Arc<FibreInfo>| {
            let before = of.iter().take_while(|known| !Arc::ptr_eq(known, info));
            before.map(|known| known.fibres.len() as u32).sum()
        };
        let firsts = models.map(|info| info.map_or(0, first)).collect();
        let same = |broad: &BroadLightTables| {
            broad.of.len() == of.len() && broad.of.iter().zip(&of).all(|(a, b)| Arc::ptr_eq(a, b))
        };
        if let Some(broad) = self.broad.as_ref().filter(|broad| same(broad)) {
            return Ok((broad.clone(), firsts));
        }
        let found = of.iter().map(|info| info.fibres.len() as u64).sum();
        let allowed = u64::from(gpu.device.limits().max_texture_array_layers);
        if found > allowed {
            let what = "fibres of all models in a frame with an environment".into();
            return Err(RuntimeError::DeviceLimit { what, found, limit: "max_texture_array_layers", allowed });
        }
        let [width, height] = BroadTables::image_size(BroadSize::default()).map(|edge| edge as u32);
        let mut texels = Vec::new();
        for optics in of.iter().flat_map(|info| &info.fibres) {
            let tables = BroadTables::new(&optics.fibre(), BroadSize::default());
            texels.extend(tables.image().into_iter().map(Vec4::from));
        }
        if texels.is_empty() {
            texels.resize((width * height) as usize, Vec4::ZERO);
        }
        let layers = (found as u32).max(1);
        let tables = texture(gpu, "pelage broad light", [width, height, layers], &texels);
        let broad = Arc::new(BroadLightTables { of, tables });
        self.broad = Some(broad.clone());
        Ok((broad, firsts))
    }
}

/// Returns the directions of the centres of the parts into which an environment is divided (formulas 4.15). They are
/// clusters of its lobes, so that they turn with the environment; a single one if all its light is uniform.
fn part_centres(environment: &Environment) -> Vec<Vec3> {
    // The wider a lobe, the less its direction matters.
    let weighted: Vec<(Vec3, f32)> = environment
        .lobes
        .iter()
        .map(|lobe| {
            let light = lobe.light();
            let mean = 1.0 / light.sharpness.tanh() - 1.0 / light.sharpness;
            (light.towards.as_vec3(), (luminance(lobe.integral()) * mean) as f32)
        })
        .filter(|(_, weight)| *weight > 0.0)
        .collect();
    let nearest = |centres: &[Vec3], way: Vec3| centres.iter().map(|centre| way.dot(*centre)).fold(-1.0, f32::max);
    let mut centres: Vec<Vec3> = Vec::new();
    for _ in 0..PARTS {
        let gain = |(way, weight): &(Vec3, f32)| weight * (1.0 - nearest(&centres, *way));
        let Some(next) = weighted.iter().max_by(|a, b| gain(a).total_cmp(&gain(b))) else { break };
        if 1.0 - nearest(&centres, next.0) < LEAST_APART {
            break;
        }
        centres.push(next.0);
        for _ in 0..ROUNDS {
            let mut sums = vec![Vec3::ZERO; centres.len()];
            for (way, weight) in &weighted {
                sums[nearest_of(&centres, *way)] += *way * *weight;
            }
            centres = centres.iter().zip(sums).map(|(old, sum)| sum.try_normalize().unwrap_or(*old)).collect();
        }
    }
    if centres.is_empty() { vec![Vec3::Y] } else { centres }
}

/// Returns the index of the direction nearest to `way`.
fn nearest_of(centres: &[Vec3], way: Vec3) -> usize {
    let by_cosine = |a: &usize, b: &usize| way.dot(centres[*a]).total_cmp(&way.dot(centres[*b]));
    (0..centres.len()).max_by(by_cosine).unwrap_or(0)
}

/// Returns the layers of the map over the direction that a surface faces, and the maximum of the irradiance divided by
/// π. Three layers for each part of the environment: total light from above the horizon and slightly below it; mean
/// direction of that light; irradiance divided by π.
fn build_map(environment: &Environment) -> (Vec<Vec4>, f32) {
    let centres = part_centres(environment);
    let lights: Vec<(usize, Vec3, Vec3, f32)> = (0..DIRECTIONS)
        .map(|i| {
            let y = 1.0 - (2.0 * i as f64 + 1.0) / DIRECTIONS as f64;
            let (sin, cos) = (2.399_963_229_728_653 * i as f64).sin_cos();
            let out = (1.0 - y * y).sqrt();
            let way = DVec3::new(out * cos, y, out * sin);
            let light = environment.radiance(way) * (4.0 * std::f64::consts::PI / DIRECTIONS as f64);
            let way = way.as_vec3();
            (nearest_of(&centres, way), way, light.as_vec3(), luminance(light) as f32)
        })
        .collect();
    let place = |i: u32| 2.0 * i as f32 / (MAP_SIZE - 1) as f32 - 1.0;
    let texels = MAP_SIZE * MAP_SIZE;
    let mut layers = vec![Vec::with_capacity(texels as usize); 3 * centres.len()];
    let mut most = 0.0_f32;
    for (y, x) in (0..MAP_SIZE).flat_map(|y| (0..MAP_SIZE).map(move |x| (y, x))) {
        let normal = from_octahedral(Vec2::new(place(x), place(y)));
        let mut irradiance_of_all = Vec3::ZERO;
        for (part, layers) in layers.chunks_exact_mut(3).enumerate() {
            let (mut whole, mut middle, mut bright, mut falls) = (Vec3::ZERO, Vec3::ZERO, 0.0, Vec3::ZERO);
            for (_, way, light, brightness) in lights.iter().filter(|light| light.0 == part) {
                let height = normal.dot(*way);
                let risen = (0.5 + (height + HORIZON_SINE as f32) / (2.0 * RISE)).clamp(0.0, 1.0);
                whole += *light * risen;
                middle += *way * (brightness * risen);
                bright += brightness * risen;
                falls += *light * height.max(0.0);
            }
            let irradiance = falls / PI;
            irradiance_of_all += irradiance;
            let texel = |v: Vec3| v.min(Vec3::splat(MAX_HALF)).extend(0.0);
            layers[0].push(texel(whole));
            // In the dark, any direction will do.
            layers[1].push(texel(if bright > 0.0 { middle / bright } else { 0.5 * normal }));
            layers[2].push(texel(irradiance));
        }
        most = most.max(irradiance_of_all.max_element());
    }
    (layers.concat(), most)
}

/// Creates a filterable texture of half floats with this number of columns, rows and layers.
fn texture(gpu: &Gpu, label: &str, [width, height, layers]: [u32; 3], texels: &[Vec4]) -> wgpu::TextureView {
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: layers };
    let texture = gpu.texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let halves: Vec<u8> = texels.iter().flat_map(Vec4::to_array).flat_map(|x| f16::from_f32(x).to_le_bytes()).collect();
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(8 * width), rows_per_image: Some(height) };
    gpu.queue.write_texture(texture.as_image_copy(), &halves, layout, size);
    let dimension = Some(wgpu::TextureViewDimension::D2Array);
    texture.create_view(&wgpu::TextureViewDescriptor { dimension, ..Default::default() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared::environment::octahedral;
    use pelage_formats::meaning::environment::LightLobe;
    use pelage_formats::meaning::scattering::broad::LEAST_MEAN;

    fn at(layers: &[Vec4], layer: u32, normal: Vec3) -> Vec3 {
        let place = octahedral(normal);
        let texel = |x: f32| (0.5 * (x + 1.0) * (MAP_SIZE - 1) as f32).round() as u32;
        layers[(layer * MAP_SIZE * MAP_SIZE + texel(place.y) * MAP_SIZE + texel(place.x)) as usize].truncate()
    }

    #[test]
    fn uniform_sky_lights_every_normal_equally() {
        let (layers, most) = build_map(&Environment::constant([1.0, 0.5, 0.25]));
        for normal in [Vec3::Y, Vec3::NEG_Y, Vec3::X, Vec3::new(1.0, 1.0, -1.0)] {
            let whole = at(&layers, 0, normal);
            let all = 2.0 * PI * (1.0 + HORIZON_SINE as f32);
            assert!((whole / all - Vec3::new(1.0, 0.5, 0.25)).abs().max_element() < 0.01, "{whole}");
            assert!((at(&layers, 2, normal) - Vec3::new(1.0, 0.5, 0.25)).abs().max_element() < 0.01);
        }
        // No texel faces straight up: the nearest ones face slightly to the side, and so does their light.
        let texel = from_octahedral(Vec2::splat(1.0 / (MAP_SIZE - 1) as f32));
        let middle = at(&layers, 1, Vec3::Y);
        assert!(middle.distance(LEAST_MEAN as f32 * texel) < 0.01 && (most - 1.0).abs() < 0.01, "{middle} {most}");
        let (dark, most) = build_map(&Environment::default());
        assert_eq!((at(&dark, 0, Vec3::Y), most), (Vec3::ZERO, 0.0));
    }

    #[test]
    fn lights_from_two_sides_are_two_parts_that_turn_with_the_environment() {
        let lobe = |towards, radiance| LightLobe { towards, width_deg: 10.0, radiance };
        let sky = |x: [f32; 3], z: [f32; 3]| Environment {
            lobes: vec![lobe(x, [4.0, 0.0, 0.0]), lobe(z, [0.0, 0.0, 3.0])],
            ..Environment::default()
        };
        let still = part_centres(&sky([1.0, 0.2, 0.0], [-1.0, 0.2, 0.3]));
        let turned = part_centres(&sky([0.0, 0.2, -1.0], [0.3, 0.2, 1.0]));
        let quarter = |way: &Vec3| Vec3::new(way.z, way.y, -way.x);
        assert_eq!(still.len(), PARTS);
        assert!(still.iter().map(quarter).zip(&turned).all(|(a, b)| a.distance(*b) < 1e-5), "{still:?} {turned:?}");
        // Each part has the colour and direction of its own light.
        let (layers, _) = build_map(&sky([1.0, 0.2, 0.0], [-1.0, 0.2, 0.3]));
        for (part, centre) in still.iter().enumerate() {
            let whole = at(&layers, 3 * part as u32, Vec3::Y);
            let towards = at(&layers, 3 * part as u32 + 1, Vec3::Y).normalize();
            assert!(
                towards.dot(*centre) > 0.98 && whole.x * whole.z < 1e-3 * whole.length_squared(),
                "{whole} {towards}"
            );
        }
    }
}
