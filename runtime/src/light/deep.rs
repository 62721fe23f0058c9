//! Deep opacity map of strands: optical depth of the hair between the key light and each point, counted from the first
//! hair of each texel.

use super::view::LightView;
use crate::bounds::Hull;
use crate::gpu::{Gpu, largest_buffer};
use crate::params::FrameParams;
use crate::study;

/// Settings of a deep opacity map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DeepMapSettings {
    /// Texels along each edge.
    pub(crate) size: u32,
    /// Number of depth slabs per texel.
    pub(crate) slabs: u32,
    /// Total depth of the slabs of a texel, metres.
    pub(crate) reach_m: f32,
    /// Whether some of the hair is guided. If so, the map also stores the optical depth of all guided hair at each
    /// texel.
    pub(crate) guided: bool,
    /// Map depth, 0..=1, at which the slabs begin if they span the depth of all hair. Unused (0) if they begin at the
    /// first hair of each texel.
    pub(crate) whole_from: f32,
}

/// Depth range of the slabs behind the first hair, relative to the height of the highest fur.
const REACH: f32 = 2.0;

/// Minimum width of a texel relative to that of a strand. In a finer map, a strand covers some texels completely and
/// others not at all, and too much light passes.
const TEXEL_WIDTHS: f32 = 1.25;

/// Minimum size of a map, texels along each edge.
const LEAST_SIZE: u32 = 16;

/// Properties of the hair in a map: maximum height, maximum strand width, and whether some of it is guided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DeepMapHair {
    pub(crate) fur_m: f32,
    pub(crate) width_m: f32,
    pub(crate) guided: bool,
}

impl DeepMapHair {
    /// Returns properties of a map that contains both kinds of hair: the maxima of height and width. It is guided if
    /// either is guided.
    pub(crate) fn union(self, other: Self) -> Self {
        Self {
            fur_m: self.fur_m.max(other.fur_m),
            width_m: self.width_m.max(other.width_m),
            guided: self.guided || other.guided,
        }
    }
}

impl DeepMapSettings {
    /// Returns the settings of a map for `params`. The texel size is doubled until it suits the strands and the
    /// device's buffer limits. `hull`: bounds of all objects that cast a shadow.
    pub(crate) fn new(
        params: &FrameParams,
        hair: DeepMapHair,
        hull: &Hull,
        view: &LightView,
        limits: &wgpu::Limits,
    ) -> Self {
        let wanted = params.shadows.slabs;
        let (slabs, reach_m, whole_from) = if study::opacity_spans_all(params) {
            let (from, to) = depths(hull, view);
            // N planes enclose N − 1 slabs. In the published form, the depth is divided by N instead, so the planes are
            // closer together.
            let slabs = wanted.saturating_sub(1).max(1);
            let share = if study::spacing_is_printed(params) { slabs as f32 / (slabs + 1) as f32 } else { 1.0 };
            (slabs, (to - from) * view.range_m * share, from)
        } else {
            (wanted, REACH * hair.fur_m, 0.0)
        };
        let thin = study::texels_may_be_thin(params);
        let too_fine = |size: u32| !thin && view.texel_m(size) < TEXEL_WIDTHS * hair.width_m;
        let too_large = |size: u32| map_bytes(size, slabs) > largest_buffer(limits);
        let mut size = params.shadows.map_size;
        while size > LEAST_SIZE && (too_fine(size) || too_large(size)) {
            size /= 2;
        }
        Self { size, slabs, reach_m, whole_from, guided: hair.guided }
    }
}

/// Returns the range of map depths that a hull spans.
fn depths(hull: &Hull, view: &LightView) -> (f32, f32) {
    let row = view.map_from_world.row(2);
    let ends = hull.0.iter().map(|(point, margin)| {
        let (depth, margin) = (row.dot(point.extend(1.0)), margin / view.range_m);
        (depth - margin, depth + margin)
    });
    let (from, to) = ends.fold((1.0f32, 0.0f32), |(from, to), end| (from.min(end.0), to.max(end.1)));
    if from < to { (from.max(0.0), to.min(1.0)) } else { (0.0, 1.0) }
}

/// Returns the size in bytes of a map with `size` texels along each edge.
fn map_bytes(size: u32, slabs: u32) -> u64 {
    4 * u64::from(size) * u64::from(size) * u64::from(2 + slabs)
}

/// Creates an empty map.
pub(super) fn create_map(gpu: &Gpu, key: &DeepMapSettings) -> wgpu::Buffer {
    use wgpu::BufferUsages as Usage;
    let usage = Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC;
    gpu.buffer("pelage deep opacity", map_bytes(key.size, key.slabs), usage)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::camera::{Camera, Light, Projection};
    use glam::{Mat4, Vec3};

    fn frame(map_size: u32) -> FrameParams {
        let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, Projection::Custom(Mat4::IDENTITY));
        FrameParams::new(camera, [64; 2]).with(|p| p.shadows.map_size = map_size)
    }

    #[test]
    fn opacity_map_texels_exceed_strand_width_and_fit_the_buffer() {
        let hull = Hull(vec![(Vec3::ZERO, 0.5)]);
        let view = LightView::new(&Light::default(), &hull, hull.sphere().unwrap());
        let key = |params: &FrameParams, width_m| {
            DeepMapSettings::new(
                params,
                DeepMapHair { fur_m: 0.01, width_m, guided: false },
                &hull,
                &view,
                &wgpu::Limits::default(),
            )
        };
        let size = |map_size, width_m| key(&frame(map_size), width_m).size;
        // The maps are slightly wider than the hull: about 2 mm per texel.
        assert!((0.0019..0.0023).contains(&view.texel_m(512)), "{}", view.texel_m(512));
        assert_eq!([0.0005, 0.0015, 0.0018, 0.004, 1.0].map(|width_m| size(512, width_m)), [512, 512, 256, 128, 16]);
        assert_eq!((size(2048, 0.0), size(8192, 0.0), size(100, 0.0)), (2048, 2048, 100));
        let slabs = |slabs, map_size| key(&frame(map_size).with(|p| p.shadows.slabs = slabs), 0.0);
        assert_eq!((slabs(4, 512).reach_m, slabs(16, 512).reach_m, slabs(16, 512).slabs), (0.02, 0.02, 16));
        // 128 MiB hold 18 numbers for each of 1024² texels, but not for 2048².
        assert_eq!((slabs(16, 1024).size, slabs(16, 2048).size), (1024, 1024));
        let both = DeepMapHair { fur_m: 1.0, width_m: 0.1, guided: false }.union(DeepMapHair {
            fur_m: 2.0,
            width_m: 0.05,
            guided: true,
        });
        assert_eq!(both, DeepMapHair { fur_m: 2.0, width_m: 0.1, guided: true });
    }

    /// Checks 16 planes over a sphere of 1 m diameter. They reach from the near end of the sphere to its far end. In
    /// the published form, the last plane is a sixteenth of the diameter before the far end.
    #[cfg(feature = "study")]
    #[test]
    fn planes_span_the_hair() {
        use crate::params::OpacityForm;
        let hull = Hull(vec![(Vec3::new(0.3, -2.0, 0.1), 0.5)]);
        let light = Light::Directional { towards_light: Vec3::new(0.2, 1.0, -0.4), color: Vec3::ONE };
        let near = Light::Point { position: Vec3::new(0.3, 1.0, 0.2), color: Vec3::ONE };
        for light in [light, near] {
            let view = LightView::new(&light, &hull, hull.sphere().unwrap());
            let key = |form| {
                let params =
                    frame(512).with(|p| (p.shadows.slabs, p.study.opacity, p.study.thin_texels) = (16, form, true));
                DeepMapSettings::new(
                    &params,
                    DeepMapHair { fur_m: 0.01, width_m: 1.0, guided: false },
                    &hull,
                    &view,
                    &wgpu::Limits::default(),
                )
            };
            let [safe, printed] = [OpacityForm::WholeDepth, OpacityForm::Printed].map(key);
            assert!((safe.reach_m - 1.0).abs() < 1e-4 && safe.slabs == 15 && safe.size == 512, "{safe:?}");
            assert!((printed.reach_m - 15.0 / 16.0).abs() < 1e-4 && printed.slabs == 15, "{printed:?}");
            let from_m = safe.whole_from * view.range_m + view.near_m.unwrap_or(0.0);
            let begins = view.map_from_world.row(2).dot(hull.0[0].0.extend(1.0)) - 0.5 / view.range_m;
            assert!((safe.whole_from - begins).abs() < 1e-5 && from_m > 0.0, "{safe:?}");
            assert_eq!(safe.whole_from, printed.whole_from);
        }
    }
}
