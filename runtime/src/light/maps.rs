//! Shadow maps of the key light: which ones a frame needs, what they contain, and when they must be redrawn.

use super::deep::{self, DeepMapHair, DeepMapSettings};
use super::view::LightView;
use crate::bounds::Hull;
use crate::camera::Light;
use crate::gpu::{Gpu, Pool};
use crate::params::{FrameParams, ShadowParams};
use crate::shared::deep_opacity::DeepOpacity;
use crate::shared::receiver::ShadowReceiver;
use crate::shared::soft_shadow::SoftShadow;
use crate::study;
use glam::{Mat4, Vec3};
use pelage_formats::meaning::TOTAL_MAP_LAYERS;
use std::sync::Arc;

/// Shadow maps of the key light in a frame: [`crate::Frame::shadows`]. They belong to the renderer and are reused while
/// nothing in them changes.
///
/// All maps are square, with [`crate::ShadowParams::map_size`] texels a side, seen from the light as in [`LightView`].
/// Their usages include `TEXTURE_BINDING` and `COPY_SRC`. A shader that only needs the amount of arriving light uses
/// [`crate::Frame::shadow_receiver`] and [`crate::shared::receiver`] instead.
#[derive(Debug)]
pub struct ShadowMaps {
    pub(crate) key: ShadowKey,
    pub(crate) nearest: Map,
    pub(crate) layers: Option<LayerMaps>,
    pub(crate) width: Option<WidthMaps>,
    /// Deep opacity map of strands.
    pub(crate) deep: Option<wgpu::Buffer>,
}

/// Texture and a view of the whole texture.
#[derive(Debug)]
pub(crate) struct Map {
    pub(crate) texture: wgpu::Texture,
    pub(crate) view: wgpu::TextureView,
}

/// Layer-wise maps: a texture array, and a view of each of its layers.
#[derive(Debug)]
pub(crate) struct LayerMaps {
    pub(crate) map: Map,
    pub(crate) slices: Vec<wgpu::TextureView>,
}

/// Textures of soft shadows.
#[derive(Debug)]
pub(crate) struct WidthMaps {
    pub(crate) farthest: Map,
    pub(crate) deepest: Map,
    pub(crate) shrunk: Map,
    pub(crate) width: Map,
}

impl ShadowMaps {
    /// Format of the depth maps into which [`crate::Casters::draw`] records.
    pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
    /// Format of the layer-wise maps. 8 bits are too few: the product of many nearly transparent layers would stop
    /// changing.
    pub const LAYER_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;
    /// Format of the shadow-width map.
    pub const WIDTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

    /// Returns the projection of the maps.
    pub fn view(&self) -> &LightView {
        &self.key.view
    }

    /// Returns the scale of the shadow-width map in metres, for [`crate::shared::soft_shadow`]. [`Self::receiver`]
    /// includes it.
    pub fn soft_shadow(&self) -> SoftShadow {
        let (view, params) = (&self.key.view, &self.key.params);
        let texel = view.extent / params.map_size as f32;
        SoftShadow { range_m: view.range_m, penumbra: params.penumbra, blur: blur_texels(params.shrink) * texel, texel }
    }

    /// Returns the uniform block for [`crate::shared::receiver`]; `None` if soft shadows are off, which leaves no map.
    pub fn receiver(&self) -> Option<ShadowReceiver> {
        self.width.is_some().then(|| ShadowReceiver {
            map_from_world: self.key.view.map_from_world,
            soft_shadow: self.soft_shadow(),
            centred: u32::from(self.key.centred),
            reserved: [0; 3],
        })
    }

    /// Returns the layer-wise maps, [`Self::LAYER_FORMAT`]; `None` if they do not shadow the hair. Array layer k holds
    /// the transmittance of the hair above map layer k. Layer 0 is the light that reaches the skin; the last layer is
    /// 1.
    pub fn layers(&self) -> Option<&wgpu::Texture> {
        self.layers.as_ref().filter(|_| self.key.hair == HairMapKind::LayerWise).map(|layers| &layers.map.texture)
    }

    /// Returns the shadow-width map, [`Self::WIDTH_FORMAT`], for linear filtering; `None` without soft shadow.
    /// Channels:
    ///
    /// * x - blurred occlusion: 0 if nothing within the blur is in shadow; 1 if everything is; 1/2 at the edge
    /// * y - blurred depth of the shadow caster, times x
    /// * z - depth of the first surface
    /// * w - transmittance of the hair above that surface, blurred except beside deeper surfaces; 1 if hair casts no
    ///   shadow on hair
    ///
    /// Depths are those of [`LightView::map_from_world`]. [`crate::shared::soft_shadow`] computes the light from x, y
    /// and z.
    pub fn width(&self) -> Option<&wgpu::Texture> {
        self.width.as_ref().map(|w| &w.width.texture)
    }

    /// Returns the two depth maps, [`Self::DEPTH_FORMAT`]: nearest surface, and farthest surface that faces the light.
    /// The depth is that of [`LightView::clip_from_world`]. `None` without soft shadow.
    pub fn depths(&self) -> Option<[&wgpu::Texture; 2]> {
        self.width.as_ref().map(|w| [&self.nearest.texture, &w.farthest.texture])
    }

    /// Returns the texel size in metres; for a point light, in the middle of its range.
    pub(crate) fn texel_m(&self) -> f32 {
        self.key.view.texel_m(self.key.params.map_size)
    }

    /// Returns the size in GPU memory, bytes.
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

    /// Returns the deep opacity map, by which single strands shadow each other, with the usage `COPY_SRC`. `None` if no
    /// strands are drawn with self-shadow. [`crate::shared::deep_opacity`] describes the contents.
    pub fn deep(&self) -> Option<&wgpu::Buffer> {
        self.deep.as_ref()
    }

    /// Returns the parameters for reading [`Self::deep`]; zeros without such a map.
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

/// Returns half the width of the blur, texels. Multiplied by 2·occlusion − 1, it gives the distance from the edge of
/// the shadow. It follows from the slope of the blurred occlusion at a straight edge. The blur is a box of `shrink`
/// texels, convolved with a tent of twice that width.
fn blur_texels(shrink: u32) -> f32 {
    2.0 / 3.0 * shrink as f32
}

/// Kinds of hair shadow maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HairMapKind {
    /// No maps: hair casts no shadow.
    None,
    /// Transmittance of all hair together, computed from a few layers. Used for the shadow of fur on other objects; the
    /// package supplies the self-shadow.
    Total,
    /// Transmittance of the hair above each layer.
    LayerWise,
}

/// Cache key of the maps: all values that they depend on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ShadowKey {
    pub(crate) light: Light,
    pub(crate) view: LightView,
    pub(crate) params: ShadowParams,
    pub(crate) hair: HairMapKind,
    /// Deep opacity map, if single strands shadow each other.
    pub(crate) deep: Option<DeepMapSettings>,
    pub(crate) soft_shadow: bool,
    /// Whether the optical depth of a layer grows with the slant of the light.
    pub(crate) slanted: bool,
    /// Whether the penumbra extends to both sides of the hard edge.
    pub(crate) centred: bool,
    /// Number of layer-wise maps, skin included.
    pub(crate) map_layers: u32,
    pub(crate) instances: Vec<InstanceKey>,
    /// Revision of the casters, [`crate::Casters::revision`].
    pub(crate) casters: Option<u64>,
}

/// Properties of an instance that the maps depend on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct InstanceKey {
    pub(crate) transform: Mat4,
    /// Revision of the posed shape; unique among all shapes of all owners.
    pub(crate) revision: u64,
    pub(crate) furry: bool,
    /// Indices of the strand sets that are drawn.
    pub(crate) sets: Vec<usize>,
    /// Index list that is drawn: 0 for the mesh's own, otherwise a simplified one.
    pub(crate) list: usize,
}

/// Maximum number of layer-wise maps.
const MAX_MAP_LAYERS: u32 = 256;

impl ShadowKey {
    /// Returns the key of a frame; `None` if it needs no maps.
    ///
    /// * `by_maps`: the layer-wise maps shadow at least one instance
    /// * `deep`: hair properties and device limits, if a deep opacity map shadows strands
    /// * `layers`: layer count of the finest instance, skin included; instances with other counts interpolate between
    ///   the maps
    /// * `hull`: bounds of all objects that cast or receive a shadow
    pub(crate) fn new(
        params: &FrameParams,
        by_maps: bool,
        deep: Option<(DeepMapHair, wgpu::Limits)>,
        layers: u32,
        hull: &Hull,
        instances: Vec<InstanceKey>,
        casters: Option<u64>,
    ) -> Option<Self> {
        // With an environment map, a black key light serves only to measure the depth of hair; it casts no shadows.
        let soft_shadow = params.soft_shadow && !params.is_key_dark();
        let guided = deep.as_ref().is_some_and(|(hair, _)| hair.guided);
        let hair = match params.self_shadow() && (layers > 1 || guided) {
            true if by_maps => HairMapKind::LayerWise,
            true if soft_shadow => HairMapKind::Total,
            _ => HairMapKind::None,
        };
        // Without an environment map, a black light needs no shadow maps.
        let is_black = params.light.color() == Vec3::ZERO && !params.is_key_dark();
        if !(hair != HairMapKind::None || soft_shadow || deep.is_some()) || is_black {
            return None;
        }
        let shadows = params.shadows;
        let view = LightView::new(&params.light, hull, hull.sphere()?);
        Some(Self {
            light: params.light,
            params: shadows,
            hair,
            deep: deep.map(|(hair, limits)| DeepMapSettings::new(params, hair, hull, &view, &limits)),
            view,
            soft_shadow,
            slanted: hair != HairMapKind::None && study::light_is_slanted(params),
            centred: study::penumbra_is_centred(params),
            map_layers: match hair {
                HairMapKind::None => 1,
                HairMapKind::Total => layers.min(TOTAL_MAP_LAYERS),
                HairMapKind::LayerWise => shadows.map_layers.unwrap_or(layers).min(MAX_MAP_LAYERS),
            },
            instances,
            casters,
        })
    }
}

impl ShadowKey {
    /// Whether guided hair casts a shadow.
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
        let layers = (key.hair != HairMapKind::None).then(|| {
            let count = match key.hair {
                // Guided hair has its own array layer.
                HairMapKind::Total => 1 + u32::from(key.guided()),
                _ => key.map_layers,
            };
            // Each layer is initialised with a copy of the layer above.
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
        let deep = key.deep.map(|deep| deep::create_map(gpu, &deep));
        Self { key, nearest, layers, width, deep }
    }

    /// Whether the textures can be reused for another key.
    fn fits(&self, key: &ShadowKey) -> bool {
        let slabs = |k: &ShadowKey| k.deep.map(|deep| (deep.size, deep.slabs));
        let of = |k: &ShadowKey| {
            (k.hair, k.guided(), slabs(k), k.soft_shadow, k.map_layers, k.params.map_size, k.params.shrink)
        };
        of(&self.key) == of(key)
    }
}

/// Returns the maps for `key`, and whether they must be redrawn. Maps that another frame still reads are left
/// unchanged.
pub(crate) fn get_or_create(shelf: &mut Pool<ShadowMaps>, gpu: &Gpu, key: ShadowKey) -> (Arc<ShadowMaps>, bool) {
    if let Some(maps) = shelf.share(|maps| maps.key == key) {
        return (maps, false);
    }
    let maps = match shelf.take(|maps| maps.fits(&key)) {
        Some(maps) => ShadowMaps { key, ..maps },
        None => ShadowMaps::new(gpu, key),
    };
    (shelf.put(maps), true)
}
