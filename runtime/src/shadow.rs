//! Shadows of the key light: what is asked for, what is drawn, and when it must be drawn again.

use crate::light_view::{LightView, Sphere};
use crate::shared::receiver::ShadowReceiver;
use crate::shared::soft_shadow::SoftShadow;
use crate::{Light, Motion, RuntimeError};
use glam::Mat4;

/// How the shadows of the key light are made; [`crate::FrameParams::self_shadow`] and [`crate::FrameParams::soft_shadow`] say which are.
/// Set per frame; a change draws the maps anew. [`ShadowMaps::gpu_bytes`] tells what they take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowParams {
    /// Width and height of every shadow map, texels, 16..=8192 (default 512, as in Yang 2006, §6). One map covers all that is drawn
    /// and [`Casters::bounds`]: its texels are [`LightView::extent`] / `map_size` wide.
    pub map_size: u32,
    /// Layers of the layer-wise maps, skin counted, 2..=256; `None` (default) for as many as are drawn. Fewer cost less, and
    /// what lies between two is interpolated.
    pub map_layers: Option<u32>,
    /// Share of the layers' optical depth that the light meets, 0..=4 (default 1, as they are drawn).
    pub density: f32,
    /// How much of the light a layer takes (default [`SlantForm::Corrected`]).
    pub slant: SlantForm,
    /// Width of the penumbra over the distance between what throws a shadow and where it falls, 0..=2 (default 0.15): 1 / C_scale of
    /// Yang 2006, §5; 2 tan of the light's angular radius. The sun has 0.009; 0 is a hard shadow. `shrink` says how wide it can
    /// get. The shadow of hair on other things is blurred by `shrink` texels at every distance.
    pub penumbra: f32,
    /// Where the penumbra lies (default [`PenumbraForm::Centred`]).
    pub penumbra_form: PenumbraForm,
    /// How far the shadow-width map is shrunk before it is stretched again, 2..=32 (default 4, as in Yang 2006, §4): the widest
    /// penumbra is 4/3 of as many texels (2/3 for [`PenumbraForm::Inner`]), and things much thinner throw no shadow.
    pub shrink: u32,
}

/// What the slant of a ray does to the opacity of a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SlantForm {
    /// (1 − α)^(1/|N·L|), and half of the receiver's own layer: the way through hair grows with its slant, that of light and that of a look.
    #[default]
    Corrected,
    /// 1 − α at every angle, as printed in Yang 2006, §3.1, and as all shells before.
    Printed,
}

/// Where the penumbra lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PenumbraForm {
    /// On both sides of the hard edge, where a round light has it.
    #[default]
    Centred,
    /// Inside the hard edge, as in Yang 2006, §5, after Kirsch and Döllner 2003.
    Inner,
}

impl Default for ShadowParams {
    fn default() -> Self {
        Self {
            map_size: 512,
            map_layers: None,
            density: 1.0,
            slant: SlantForm::default(),
            penumbra: 0.15,
            penumbra_form: PenumbraForm::default(),
            shrink: 4,
        }
    }
}

impl ShadowParams {
    pub(crate) fn check(&self, limits: &wgpu::Limits) -> Result<(), RuntimeError> {
        let fail = |field, found: String, expected: &str| {
            Err(RuntimeError::Params { field, found, expected: expected.into() })
        };
        if !(16..=8192).contains(&self.map_size) {
            return fail("ShadowParams::map_size", self.map_size.to_string(), "16..=8192");
        }
        if self.map_size > limits.max_texture_dimension_2d {
            return Err(RuntimeError::DeviceLimit {
                what: "ShadowParams::map_size".into(),
                found: self.map_size.into(),
                limit: "max_texture_dimension_2d",
                allowed: limits.max_texture_dimension_2d.into(),
            });
        }
        if let Some(layers) = self.map_layers
            && !(2..=256).contains(&layers)
        {
            return fail("ShadowParams::map_layers", layers.to_string(), "2..=256");
        }
        if !(0.0..=4.0).contains(&self.density) {
            return fail("ShadowParams::density", self.density.to_string(), "0..=4");
        }
        if !(0.0..=2.0).contains(&self.penumbra) {
            return fail("ShadowParams::penumbra", self.penumbra.to_string(), "0..=2");
        }
        if !(2..=32).contains(&self.shrink) {
            return fail("ShadowParams::shrink", self.shrink.to_string(), "2..=32");
        }
        Ok(())
    }
}

/// The application's own geometry among the shadows: it throws shadows on the fur, and the fur on it. Give it to
/// [`crate::Renderer::prepare_with_casters`] in every frame.
///
/// What only receives, such as a ground, belongs to it as well: the maps must know where a shadow falls. The application's own shader
/// then reads them with [`crate::shared::receiver`]. `cargo run --example shadows_on_your_ground` shows all of it.
///
/// `draw` records the geometry into a pass of depth alone, with pipelines of the application's own, one for each [`CasterPass`]:
/// depth format [`ShadowMaps::DEPTH_FORMAT`], depth written, [`CasterPass::compare`], [`CasterPass::cull_mode`] with
/// counter-clockwise fronts, one sample, no colour target, and positions put through [`LightView::clip_from_world`]. It is called
/// while the frame is prepared, once for each of the maps that are drawn anew, and not at all where they are kept. Keep the matrix
/// in a buffer made there: one that is written for several frames of one submission would hold the last of them for all.
///
/// ```no_run
/// # use pelage_runtime::{wgpu, *};
/// # fn f(renderer: &mut Renderer, device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder, params: &FrameParams,
/// #      fox: &mut Instance, scene_bounds: Sphere, frames_with_changes: u64,
/// #      draw_scene_depth: &dyn Fn(&mut wgpu::RenderPass<'_>, glam::Mat4, CasterPass)) -> Result<(), RuntimeError> {
/// let mut draw = |pass: &mut wgpu::RenderPass<'_>, view: &LightView, which: CasterPass| {
///     draw_scene_depth(pass, view.clip_from_world, which);
/// };
/// let mut casters = Casters { bounds: Some(scene_bounds), revision: frames_with_changes, draw: &mut draw };
/// let frame = renderer.prepare_with_casters(device, encoder, params, &mut [fox], &mut casters)?;
/// // For a bind group of the application's own pipeline, whose shader calls `light_received`:
/// let (uniform, texture) = (frame.shadow_receiver(), frame.shadow_map());
/// # Ok(()) }
/// ```
pub struct Casters<'a> {
    /// What the maps must cover besides the furry things: whatever throws a shadow or receives one. What lies beyond throws none
    /// and is lit. Keep them to the fur's surroundings: the larger they are, the larger the maps' texels, and things nearer to what
    /// they shade than a thousandth of the bounds throw no shadow on it. `None` adds nothing.
    pub bounds: Option<Sphere>,
    /// A number that is another whenever the geometry is; the maps are kept while it stays the same.
    pub revision: u64,
    /// Records the draws, as said above.
    pub draw: &'a mut dyn FnMut(&mut wgpu::RenderPass<'_>, &LightView, CasterPass),
}

impl std::fmt::Debug for Casters<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Casters")
            .field("bounds", &self.bounds)
            .field("revision", &self.revision)
            .finish_non_exhaustive()
    }
}

/// The two depth maps that casters are drawn into. Both get the same geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CasterPass {
    /// What the light reaches first: it throws the shadows.
    Nearest,
    /// The farthest surface that faces the light: it receives them. Drawn only for soft shadows.
    Farthest,
}

impl CasterPass {
    /// Depth comparison of the pipeline, which writes depth.
    pub fn compare(self) -> wgpu::CompareFunction {
        match self {
            Self::Nearest => wgpu::CompareFunction::LessEqual,
            Self::Farthest => wgpu::CompareFunction::GreaterEqual,
        }
    }

    /// Which faces of closed things to leave out. Sheets that are seen from both sides leave out none, and receive on both.
    pub fn cull_mode(self) -> Option<wgpu::Face> {
        match self {
            Self::Nearest => None,
            Self::Farthest => Some(wgpu::Face::Back),
        }
    }

    /// What depth is cleared to.
    pub(crate) fn clear(self) -> f32 {
        match self {
            Self::Nearest => 1.0,
            Self::Farthest => 0.0,
        }
    }
}

/// The key light's shadow maps of a frame: [`crate::Frame::shadows`]. They belong to the renderer and are kept while nothing in them
/// changes.
///
/// All are square, of [`ShadowParams::map_size`] texels a side, seen from the light as [`LightView`] says, and have the usages
/// `TEXTURE_BINDING` and `COPY_SRC`. A shader that only wants to know how much light arrives needs none of this:
/// [`crate::Frame::shadow_receiver`] and [`crate::shared::receiver`] do that.
#[derive(Debug)]
pub struct ShadowMaps {
    pub(crate) key: ShadowKey,
    pub(crate) nearest: wgpu::Texture,
    pub(crate) layers: Option<wgpu::Texture>,
    pub(crate) width: Option<WidthMaps>,
}

/// Textures of the soft shadow.
#[derive(Debug)]
pub(crate) struct WidthMaps {
    pub(crate) farthest: wgpu::Texture,
    pub(crate) deepest: wgpu::Texture,
    pub(crate) shrunk: wgpu::Texture,
    pub(crate) width: wgpu::Texture,
}

impl ShadowMaps {
    /// Format of the depth maps that [`Casters::draw`] records into.
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
            centred: u32::from(self.key.params.penumbra_form == PenumbraForm::Centred),
            reserved: [0; 3],
        })
    }

    /// The layer-wise maps, [`Self::LAYER_FORMAT`]: array layer k holds the transmittance of the hair above map layer k; layer 0 is what
    /// reaches the skin, the last is 1. `None` without self-shadow.
    pub fn layers(&self) -> Option<&wgpu::Texture> {
        self.layers.as_ref()
    }

    /// The shadow-width map, [`Self::WIDTH_FORMAT`], for a linear filter; `None` without soft shadow. Channels:
    ///
    /// * x - occlusion, blurred: 0 where nothing near is in shadow, 1 deep in it, 1/2 at the edge
    /// * y - depth of what throws the shadow, blurred, times x
    /// * z - depth of the first surface
    /// * w - transmittance of the hair above that surface, blurred but for places beside deeper ones; 1 without self-shadow
    ///
    /// Depths are those of [`LightView::map_from_world`]; [`crate::shared::soft_shadow`] makes light of x, y and z.
    pub fn width(&self) -> Option<&wgpu::Texture> {
        self.width.as_ref().map(|w| &w.width)
    }

    /// The depth maps, nearest surface and farthest one that faces the light, [`Self::DEPTH_FORMAT`], depth of
    /// [`LightView::clip_from_world`]. `None` without soft shadow.
    pub fn depths(&self) -> Option<[&wgpu::Texture; 2]> {
        self.width.as_ref().map(|w| [&self.nearest, &w.farthest])
    }

    /// Size of a texel, metres; of a point light's maps in the middle of their range.
    pub(crate) fn texel_m(&self) -> f32 {
        let view = &self.key.view;
        let distance = view.near_m.map_or(1.0, |near| near + 0.5 * view.range_m);
        view.extent / self.key.params.map_size as f32 * distance
    }

    /// Bytes on the GPU.
    pub fn gpu_bytes(&self) -> u64 {
        let of = |t: &wgpu::Texture| {
            let texels = u64::from(t.width()) * u64::from(t.height()) * u64::from(t.depth_or_array_layers());
            texels * u64::from(t.format().block_copy_size(None).unwrap_or(4))
        };
        let width = self.width.iter().flat_map(|w| [&w.farthest, &w.deepest, &w.shrunk, &w.width]);
        std::iter::once(&self.nearest).chain(&self.layers).chain(width).map(of).sum()
    }
}

/// Half the width of the blur, in texels: what 2·occlusion − 1 is multiplied with to give a distance from the edge. A box of `shrink`
/// texels stretched by a tent of twice that width has this slope at a straight edge.
fn blur_texels(shrink: u32) -> f32 {
    2.0 / 3.0 * shrink as f32
}

/// Everything that the maps depend on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ShadowKey {
    pub(crate) light: Light,
    pub(crate) view: LightView,
    pub(crate) params: ShadowParams,
    pub(crate) self_shadow: bool,
    pub(crate) soft_shadow: bool,
    /// Layers of the layer-wise maps, skin counted.
    pub(crate) map_layers: u32,
    pub(crate) instances: Vec<InstanceKey>,
    pub(crate) casters: Option<u64>,
}

/// What the maps see of an instance.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct InstanceKey {
    pub(crate) model: u64,
    pub(crate) transform: Mat4,
    /// `None` for models without skeleton.
    pub(crate) motion: Option<Motion>,
    pub(crate) furry: bool,
}

impl ShadowMaps {
    pub(crate) fn new(device: &wgpu::Device, key: ShadowKey) -> Self {
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC;
        let texture = |label, size: u32, layers: u32, format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
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
        let map = |label, size, format| texture(label, size, 1, format, attachment);
        let small = size.div_ceil(key.params.shrink);
        // Each layer starts as a copy of the one above.
        let copied = attachment | wgpu::TextureUsages::COPY_DST;
        let layers =
            key.self_shadow.then(|| texture("pelage layer shadow", size, key.map_layers, Self::LAYER_FORMAT, copied));
        let width = key.soft_shadow.then(|| WidthMaps {
            farthest: map("pelage farthest depth", size, Self::DEPTH_FORMAT),
            deepest: map("pelage deepest", small, Self::WIDTH_FORMAT),
            shrunk: map("pelage occlusion", small, Self::WIDTH_FORMAT),
            width: map("pelage shadow width", size, Self::WIDTH_FORMAT),
        });
        let nearest = map("pelage nearest depth", size, Self::DEPTH_FORMAT);
        Self { key, nearest, layers, width }
    }

    /// Whether its textures fit another key.
    pub(crate) fn fits(&self, key: &ShadowKey) -> bool {
        let of = |k: &ShadowKey| (k.self_shadow, k.soft_shadow, k.map_layers, k.params.map_size, k.params.shrink);
        of(&self.key) == of(key)
    }
}
