//! Shadow maps of the key light, read back, and their lookup for a fragment. The lookup takes the same steps in the
//! same order as the runtime's `light/visibility.wgsl`, by Rust copies of its functions.

use glam::{Vec3, Vec4};
use pelage_runtime::LightView;
use pelage_runtime::shared::layer_shadow::slanted_path;
use pelage_runtime::shared::soft_shadow::{SoftShadow, soft_shadow};

/// Shadow maps in memory.
#[derive(Clone, Debug)]
pub struct LightMaps {
    /// View from the light from which the maps were rendered.
    pub view: LightView,
    /// Encoding of the shadow-width map.
    pub soft: SoftShadow,
    /// Width and height of each map, texels.
    pub size: u32,
    /// Layer-wise maps, from the mesh surface outwards: `size * size` transmittances each, row-major. Empty without
    /// self-shadow.
    pub layers: Vec<Vec<f32>>,
    /// Shadow-width map of `size * size` texels, row-major; the runtime's `soft_shadow.wgsl` describes the channels.
    /// Empty without soft shadow.
    pub width: Vec<[f32; 4]>,
    /// Depths of the nearest surface, and of the farthest surface that faces the light, as rendered. Each has `size *
    /// size` values, or is empty.
    pub depths: [Vec<f32>; 2],
}

impl LightMaps {
    /// Returns the homogeneous map coordinates (u w, v w, depth, w) of a point in world space.
    pub fn project(&self, position_ws: Vec3) -> Vec4 {
        self.view.map_from_world * position_ws.extend(1.0)
    }

    /// Returns t of Yang 2006, eq. (2): the fraction of light that passes the hair above a point.
    ///
    /// * `map_layer`: layer of the maps, 0 on the mesh surface
    /// * `between`: whether `map_layer` may be fractional, which interpolates between two maps; else it is whole
    pub fn light_through_hair(&self, place: Vec4, map_layer: f32, between: bool) -> f32 {
        let Some(last) = self.layers.len().checked_sub(1) else { return 1.0 };
        let at = |layer: f32| self.bilinear(&self.layers[(layer as usize).min(last)], place);
        if !between {
            return at(map_layer + 0.5);
        }
        let below = map_layer.floor();
        let (a, b) = (at(below), at((below + 1.0).min(last as f32)));
        a + (b - a) * (map_layer - below)
    }

    /// Returns Attenu_Shadow of Yang 2006, eq. (3): the fraction of light that passes other objects.
    pub fn light_past_objects(&self, place: Vec4, n_dot_l: f32, centred: bool) -> f32 {
        soft_shadow(self.width_texel(place), place.z, place.w, slanted_path(n_dot_l), &self.soft, centred)
    }

    /// Samples the shadow-width map.
    pub fn width_texel(&self, place: Vec4) -> Vec4 {
        let texel = |i: usize| Vec4::from(self.width[i]);
        self.filtered(place, texel, Vec4::ZERO)
    }

    /// Returns the size of the layer-wise maps on the GPU, bytes; a texel has two.
    pub fn layer_bytes(&self) -> u64 {
        2 * self.layers.len() as u64 * u64::from(self.size).pow(2)
    }

    /// Samples a map of `size * size` texels bilinearly, at homogeneous coordinates (u w, v w, .., w).
    pub fn bilinear(&self, map: &[f32], place: Vec4) -> f32 {
        self.filtered(place, |i| map[i], 0.0)
    }

    /// Filters bilinearly, clamping at the edge.
    fn filtered<T>(&self, place: Vec4, texel: impl Fn(usize) -> T, zero: T) -> T
    where
        T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
    {
        let last = self.size as f32 - 1.0;
        let at = |x: f32| {
            let x = (x / place.w * self.size as f32 - 0.5).clamp(0.0, last);
            let below = x.floor();
            (below as usize, (below + 1.0).min(last) as usize, x - below)
        };
        let ((x0, x1, fx), (y0, y1, fy)) = (at(place.x), at(place.y));
        let row = |y: usize| y * self.size as usize;
        let corners = [(x0, y0, 1.0 - fx, 1.0 - fy), (x1, y0, fx, 1.0 - fy), (x0, y1, 1.0 - fx, fy), (x1, y1, fx, fy)];
        corners.into_iter().fold(zero, |sum, (x, y, wx, wy)| sum + texel(row(y) + x) * (wx * wy))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Mat4;
    use pelage_runtime::Sphere;

    fn maps() -> LightMaps {
        let view = LightView {
            clip_from_world: Mat4::IDENTITY,
            map_from_world: Mat4::IDENTITY,
            range_m: 1.0,
            extent: 1.0,
            near_m: None,
            sphere: Sphere { center: Vec3::ZERO, radius: 1.0 },
        };
        LightMaps {
            view,
            soft: SoftShadow { range_m: 1.0, penumbra: 0.5, blur: 0.1, texel: 0.5 },
            size: 2,
            layers: vec![vec![0.0, 1.0, 0.0, 1.0], vec![1.0; 4], vec![0.0, 0.0, 1.0, 1.0]],
            width: vec![[0.0; 4], [1.0; 4], [0.0; 4], [1.0; 4]],
            depths: Default::default(),
        }
    }

    #[test]
    fn shadow_maps_are_filtered_like_gpu_textures() {
        let maps = maps();
        let t = |u: f32, v: f32, layer: f32, between: bool| {
            maps.light_through_hair(Vec4::new(2.0 * u, 2.0 * v, 0.0, 2.0), layer, between)
        };
        for (u, expected) in [(-1.0, 0.0), (0.25, 0.0), (0.5, 0.5), (0.6, 0.7), (0.75, 1.0), (2.0, 1.0)] {
            assert!((t(u, 0.3, 0.0, false) - expected).abs() < 1e-6, "{u}");
            assert!((t(0.3, u, 2.0, false) - expected).abs() < 1e-6, "{u}");
            assert!((maps.width_texel(Vec4::new(u, 0.9, 0.0, 1.0)).x - expected).abs() < 1e-6, "{u}");
        }
        // The transmittance is interpolated between layers 0 and 1, and clamped beyond the last layer.
        assert!((t(0.25, 0.25, 0.25, true) - 0.25).abs() < 1e-6 && (t(0.25, 0.25, 1.5, true) - 0.5).abs() < 1e-6);
        assert_eq!(t(0.25, 0.75, 2.0, true), 1.0);
        assert_eq!(LightMaps { layers: Vec::new(), ..maps.clone() }.light_through_hair(Vec4::ONE, 1.0, true), 1.0);
    }
}
