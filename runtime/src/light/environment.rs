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
        let map = texture(gpu, "pelage environment", [MAP_SIZE, MAP_SIZE, 3], &layers);
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

/// Returns the three layers of the map over the direction that a surface faces, and the maximum of the irradiance
/// divided by π. Layers: total light from above the horizon and slightly below it; mean direction of that light;
/// irradiance divided by π.
fn build_map(environment: &Environment) -> (Vec<Vec4>, f32) {
    let lights: Vec<(Vec3, Vec3, f32)> = (0..DIRECTIONS)
        .map(|i| {
            let y = 1.0 - (2.0 * i as f64 + 1.0) / DIRECTIONS as f64;
            let (sin, cos) = (2.399_963_229_728_653 * i as f64).sin_cos();
            let out = (1.0 - y * y).sqrt();
            let way = DVec3::new(out * cos, y, out * sin);
            let light = environment.radiance(way) * (4.0 * std::f64::consts::PI / DIRECTIONS as f64);
            (way.as_vec3(), light.as_vec3(), luminance(light) as f32)
        })
        .collect();
    let place = |i: u32| 2.0 * i as f32 / (MAP_SIZE - 1) as f32 - 1.0;
    let texels = MAP_SIZE * MAP_SIZE;
    let mut layers = [(); 3].map(|()| Vec::with_capacity(texels as usize));
    let mut most = 0.0_f32;
    for (y, x) in (0..MAP_SIZE).flat_map(|y| (0..MAP_SIZE).map(move |x| (y, x))) {
        let normal = from_octahedral(Vec2::new(place(x), place(y)));
        let (mut whole, mut middle, mut bright, mut falls) = (Vec3::ZERO, Vec3::ZERO, 0.0, Vec3::ZERO);
        for (way, light, brightness) in &lights {
            let height = normal.dot(*way);
            let risen = (0.5 + (height + HORIZON_SINE as f32) / (2.0 * RISE)).clamp(0.0, 1.0);
            whole += *light * risen;
            middle += *way * (brightness * risen);
            bright += brightness * risen;
            falls += *light * height.max(0.0);
        }
        let irradiance = falls / PI;
        most = most.max(irradiance.max_element());
        let texel = |v: Vec3| v.min(Vec3::splat(MAX_HALF)).extend(0.0);
        layers[0].push(texel(whole));
        // In the dark, any direction will do.
        layers[1].push(texel(if bright > 0.0 { middle / bright } else { 0.5 * normal }));
        layers[2].push(texel(irradiance));
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
}
