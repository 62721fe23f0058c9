//! Shadows of the key light: what is asked for, what is drawn, and when it must be drawn again.

use super::deep::{self, DeepHair, DeepKey};
use super::view::LightView;
use crate::bounds::Hull;
use crate::camera::Light;
use crate::gpu::{Gpu, Shelf};
use crate::params::{FrameParams, ShadowParams};
use crate::shared::deep_opacity::DeepOpacity;
use crate::shared::receiver::ShadowReceiver;
use crate::shared::soft_shadow::SoftShadow;
use crate::study;
use glam::{Mat4, Vec3};
use pelage_formats::meaning::TOTAL_MAP_LAYERS;
use std::sync::Arc;

/// The key light's shadow maps of a frame: [`crate::Frame::shadows`]. They belong to the renderer and are kept while nothing in them
/// changes.
///
/// All are square, of [`crate::ShadowParams::map_size`] texels a side, seen from the light as [`LightView`] says, and have the usages
/// `TEXTURE_BINDING` and `COPY_SRC`. A shader that only wants to know how much light arrives needs none of this:
/// [`crate::Frame::shadow_receiver`] and [`crate::shared::receiver`] do that.
#[derive(Debug)]
pub struct ShadowMaps {
    pub(crate) key: ShadowKey,
    pub(crate) nearest: Map,
    pub(crate) layers: Option<LayerMaps>,
    pub(crate) width: Option<WidthMaps>,
    /// The deep opacity map of strands.
    pub(crate) deep: Option<wgpu::Buffer>,
}

/// A texture and the view of all of it.
#[derive(Debug)]
pub(crate) struct Map {
    pub(crate) texture: wgpu::Texture,
    pub(crate) view: wgpu::TextureView,
}

/// The layer-wise maps: an array, and each of its layers alone.
#[derive(Debug)]
pub(crate) struct LayerMaps {
    pub(crate) map: Map,
    pub(crate) slices: Vec<wgpu::TextureView>,
}

/// Textures of the soft shadow.
#[derive(Debug)]
pub(crate) struct WidthMaps {
    pub(crate) farthest: Map,
    pub(crate) deepest: Map,
    pub(crate) shrunk: Map,
    pub(crate) width: Map,
}

impl ShadowMaps {
    /// Format of the depth maps that [`crate::Casters::draw`] records into.
    pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
    /// Format of the layer-wise maps. Not 8 bits: a product of many layers that are nearly clear stalls there at the same step.
    pub const LAYER_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;
    /// Format of the shadow-width map.
    pub const WIDTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

    /// Where the maps lie.
    pub fn view(&self) -> &LightView {
        &self.key.view
    }

    /// What the shadow-width map's numbers mean in metres, for [`crate::shared::soft_shadow`]; part of [`Self::receiver`].
    pub fn soft_shadow(&self) -> SoftShadow {
        let (view, params) = (&self.key.view, &self.key.params);
        let texel = view.extent / params.map_size as f32;
        SoftShadow { range_m: view.range_m, penumbra: params.penumbra, blur: blur_texels(params.shrink) * texel, texel }
    }

    /// The uniform block for [`crate::shared::receiver`]; `None` without soft shadow, where there is no map to read.
    pub fn receiver(&self) -> Option<ShadowReceiver> {
        self.width.is_some().then(|| ShadowReceiver {
            map_from_world: self.key.view.map_from_world,
            soft_shadow: self.soft_shadow(),
            centred: u32::from(self.key.centred),
            reserved: [0; 3],
        })
    }

    /// The layer-wise maps, [`Self::LAYER_FORMAT`]: array layer k holds the transmittance of the hair above map layer k; layer 0 is what
    /// reaches the skin, the last is 1. `None` where hair is not shadowed by them.
    pub fn layers(&self) -> Option<&wgpu::Texture> {
        self.layers.as_ref().filter(|_| self.key.hair == HairMaps::LayerWise).map(|layers| &layers.map.texture)
    }

    /// The shadow-width map, [`Self::WIDTH_FORMAT`], for a linear filter; `None` without soft shadow. Channels:
    ///
    /// * x - occlusion, blurred: 0 where nothing near is in shadow, 1 deep in it, 1/2 at the edge
    /// * y - depth of what throws the shadow, blurred, times x
    /// * z - depth of the first surface
    /// * w - transmittance of the hair above that surface, blurred but for places beside deeper ones; 1 where hair does not shadow hair
    ///
    /// Depths are those of [`LightView::map_from_world`]; [`crate::shared::soft_shadow`] makes light of x, y and z.
    pub fn width(&self) -> Option<&wgpu::Texture> {
        self.width.as_ref().map(|w| &w.width.texture)
    }

    /// The depth maps, nearest surface and farthest one that faces the light, [`Self::DEPTH_FORMAT`], depth of
    /// [`LightView::clip_from_world`]. `None` without soft shadow.
    pub fn depths(&self) -> Option<[&wgpu::Texture; 2]> {
        self.width.as_ref().map(|w| [&self.nearest.texture, &w.farthest.texture])
    }

    /// Size of a texel, metres; of a point light's maps in the middle of their range.
    pub(crate) fn texel_m(&self) -> f32 {
        self.key.view.texel_m(self.key.params.map_size)
    }

    /// Bytes on the GPU.
    pub fn gpu_bytes(&self) -> u64 {
        let of = |map: &Map| {
            let t = &map.texture;
            let texels = u64::from(t.width()) * u64::from(t.height()) * u64::from(t.depth_or_array_layers());
            texels * u64::from(t.format().block_copy_size(None).unwrap_or(4))
        };
        let width = self.width.iter().flat_map(|w| [&w.farthest, &w.deepest, &w.shrunk, &w.width]);
        let layers = self.layers.iter().map(|layers| &layers.map);
        let textures: u64 = std::iter::once(&self.nearest).chain(layers).chain(width).map(of).sum();
        textures + self.deep.as_ref().map_or(0, wgpu::Buffer::size)
    }

    /// The map in which single strands shadow each other, with the usage `COPY_SRC`; [`crate::shared::deep_opacity`] says what it holds. `None` where no
    /// strands are drawn with self-shadow.
    pub fn deep(&self) -> Option<&wgpu::Buffer> {
        self.deep.as_ref()
    }

    /// What the numbers of [`Self::deep`] mean; zeros without it.
    pub fn deep_opacity(&self) -> DeepOpacity {
        let (view, params) = (&self.key.view, &self.key.params);
        let Some(key) = self.key.deep else { return DeepOpacity::default() };
        DeepOpacity {
            size: key.size,
            slabs: key.slabs,
            slabs_per_depth: key.slabs as f32 * view.range_m / key.reach_m,
            texel_m: view.extent / key.size as f32,
            density: params.density,
            whole_from: key.whole_from,
            reserved: [0.0; 2],
        }
    }
}

/// Half the width of the blur, in texels: what 2·occlusion − 1 is multiplied with to give a distance from the edge. A box of `shrink`
/// texels stretched by a tent of twice that width has this slope at a straight edge.
fn blur_texels(shrink: u32) -> f32 {
    2.0 / 3.0 * shrink as f32
}

/// What maps of hair there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HairMaps {
    /// None: hair throws no shadow.
    None,
    /// What all hair together lets through, of a few layers: for the shadow of fur on other things. Hair is shadowed as its package knows it.
    Total,
    /// What is above each layer.
    LayerWise,
}

/// Everything that the maps depend on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ShadowKey {
    pub(crate) light: Light,
    pub(crate) view: LightView,
    pub(crate) params: ShadowParams,
    pub(crate) hair: HairMaps,
    /// Single strands shadow each other.
    pub(crate) deep: Option<DeepKey>,
    pub(crate) soft_shadow: bool,
    /// The light's way through a layer grows with its slant.
    pub(crate) slanted: bool,
    /// The penumbra lies on both sides of the hard edge.
    pub(crate) centred: bool,
    /// Layers of the layer-wise maps, skin counted.
    pub(crate) map_layers: u32,
    pub(crate) instances: Vec<InstanceKey>,
    /// [`crate::Casters::revision`].
    pub(crate) casters: Option<u64>,
}

/// What the maps see of an instance.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct InstanceKey {
    pub(crate) transform: Mat4,
    /// Of its shape: no two shapes of any owners ever have the same.
    pub(crate) revision: u64,
    pub(crate) furry: bool,
    /// Which of its sets of strands are drawn.
    pub(crate) sets: Vec<usize>,
    /// Which index list is drawn of it.
    pub(crate) list: usize,
}

/// Most layers of the layer-wise maps.
const MAX_MAP_LAYERS: u32 = 256;

impl ShadowKey {
    /// Of a frame; `None` where it needs no maps. `by_maps`: some instance is shadowed by the layer-wise maps; `deep`: strands are by a deep opacity
    /// map, on a device of such limits. `layers`: of the finest instance, skin counted; what draws other layers reads between the maps. `hull`: of all that throws or receives a
    /// shadow.
    pub(crate) fn new(
        params: &FrameParams,
        by_maps: bool,
        deep: Option<(DeepHair, wgpu::Limits)>,
        layers: u32,
        hull: &Hull,
        instances: Vec<InstanceKey>,
        casters: Option<u64>,
    ) -> Option<Self> {
        // Beside an environment a black light says how deep hair lies, and throws no shadows.
        let soft_shadow = params.soft_shadow && !params.is_key_dark();
        let guided = deep.as_ref().is_some_and(|(hair, _)| hair.guided);
        let hair = match params.self_shadow() && (layers > 1 || guided) {
            true if by_maps => HairMaps::LayerWise,
            true if soft_shadow => HairMaps::Total,
            _ => HairMaps::None,
        };
        // A light without light throws no shadow.
        let is_black = params.light.color() == Vec3::ZERO && !params.is_key_dark();
        if !(hair != HairMaps::None || soft_shadow || deep.is_some()) || is_black {
            return None;
        }
        let shadows = params.shadows;
        let view = LightView::new(&params.light, hull, hull.sphere()?);
        Some(Self {
            light: params.light,
            params: shadows,
            hair,
            deep: deep.map(|(hair, limits)| DeepKey::new(params, hair, hull, &view, &limits)),
            view,
            soft_shadow,
            slanted: hair != HairMaps::None && study::light_is_slanted(params),
            centred: study::penumbra_is_centred(params),
            map_layers: match hair {
                HairMaps::None => 1,
                HairMaps::Total => layers.min(TOTAL_MAP_LAYERS),
                HairMaps::LayerWise => shadows.map_layers.unwrap_or(layers).min(MAX_MAP_LAYERS),
            },
            instances,
            casters,
        })
    }
}

impl ShadowKey {
    /// Whether hair on guides throws a shadow.
    pub(crate) fn guided(&self) -> bool {
        self.deep.is_some_and(|deep| deep.guided)
    }
}

impl ShadowMaps {
    fn new(gpu: &Gpu, key: ShadowKey) -> Self {
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC;
        let texture = |label, size: u32, layers: u32, format, usage| {
            gpu.texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: size, height: size, depth_or_array_layers: layers },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let size = key.params.map_size;
        let map = |label, size, format| {
            let texture = texture(label, size, 1, format, attachment);
            Map { view: texture.create_view(&wgpu::TextureViewDescriptor::default()), texture }
        };
        let small = size.div_ceil(key.params.shrink);
        let layers = (key.hair != HairMaps::None).then(|| {
            let count = match key.hair {
                // Hair on guides alone has one of its own.
                HairMaps::Total => 1 + u32::from(key.guided()),
                _ => key.map_layers,
            };
            // Each layer starts as a copy of the one above.
            let copied = attachment | wgpu::TextureUsages::COPY_DST;
            let texture = texture("pelage layer shadow", size, count, Self::LAYER_FORMAT, copied);
            let view = |dimension, base_array_layer, array_layer_count| {
                texture.create_view(&wgpu::TextureViewDescriptor {
                    label: Some("pelage layer shadow"),
                    dimension: Some(dimension),
                    base_array_layer,
                    array_layer_count,
                    ..Default::default()
                })
            };
            let slices = (0..count).map(|k| view(wgpu::TextureViewDimension::D2, k, Some(1))).collect();
            let all = view(wgpu::TextureViewDimension::D2Array, 0, None);
            LayerMaps { slices, map: Map { view: all, texture } }
        });
        let width = key.soft_shadow.then(|| WidthMaps {
            farthest: map("pelage farthest depth", size, Self::DEPTH_FORMAT),
            deepest: map("pelage deepest", small, Self::WIDTH_FORMAT),
            shrunk: map("pelage occlusion", small, Self::WIDTH_FORMAT),
            width: map("pelage shadow width", size, Self::WIDTH_FORMAT),
        });
        let nearest = map("pelage nearest depth", size, Self::DEPTH_FORMAT);
        let deep = key.deep.map(|deep| deep::make(gpu, &deep));
        Self { key, nearest, layers, width, deep }
    }

    /// Whether its textures fit another key.
    fn fits(&self, key: &ShadowKey) -> bool {
        let slabs = |k: &ShadowKey| k.deep.map(|deep| (deep.size, deep.slabs));
        let of = |k: &ShadowKey| {
            (k.hair, k.guided(), slabs(k), k.soft_shadow, k.map_layers, k.params.map_size, k.params.shrink)
        };
        of(&self.key) == of(key)
    }
}

/// The maps of `key`, and whether they must be drawn anew. Maps that another frame still reads stay as they are.
pub(crate) fn settle(shelf: &mut Shelf<ShadowMaps>, gpu: &Gpu, key: ShadowKey) -> (Arc<ShadowMaps>, bool) {
    if let Some(maps) = shelf.share(|maps| maps.key == key) {
        return (maps, false);
    }
    let maps = match shelf.take(|maps| maps.fits(&key)) {
        Some(maps) => ShadowMaps { key, ..maps },
        None => ShadowMaps::new(gpu, key),
    };
    (shelf.put(maps), true)
}
