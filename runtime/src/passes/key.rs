//! Which pipelines surfaces are drawn with: shader, overrides, culling and what they draw to.

use crate::model::{Model, Part};
use crate::renderer::Pipelines;
use crate::shadow::{CasterPass, ShadowMaps};
use crate::{Lighting, RendererOptions, Style};
use pelage_formats::Shading;

/// What distinguishes the pipelines of surfaces. A shader of which no package needs a variant is never compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct SurfaceKey {
    pub(crate) shader: SurfaceShader,
    pub(crate) variant: Variant,
    /// Back faces are drawn.
    pub(crate) double_sided: bool,
    /// The instance mirrors: its front faces wind clockwise.
    pub(crate) mirrored: bool,
}

/// Overrides of the shader: what a package or a frame does not need is compiled away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Variant {
    /// The material has a base-colour texture.
    pub(crate) base_color_texture: bool,
    /// The material cuts away transparent texels.
    pub(crate) cutout: bool,
    /// The direction texture has two components.
    pub(crate) planar_directions: bool,
    /// The diffuse exponent is 2.
    pub(crate) squared_diffuse: bool,
    /// There is a highlight.
    pub(crate) specular: bool,
    /// Other than the baked number of layers is drawn.
    pub(crate) resampled: bool,
    /// Layers are left out, or fade.
    pub(crate) detail: bool,
    /// The far coat lies on the skin.
    pub(crate) coat: bool,
    /// Some vertex leans more than the tile's strands.
    pub(crate) lean: bool,
    /// Some vertex is bare or wet.
    pub(crate) groom_vertices: bool,
    /// The material has a groom texture.
    pub(crate) groom_texture: bool,
    /// There is wet hair to mix in.
    pub(crate) wet: bool,
    /// A layer blocks more of a look that goes through it at a slant.
    pub(crate) view_slanted: bool,
    /// How the key light's shadows fall.
    pub(crate) shadows: ShadowLook,
    /// There are lights without shadow.
    pub(crate) fill_lights: bool,
    /// The key light is computed at vertices.
    pub(crate) vertex_lighting: bool,
}

/// How the key light's shadows fall, as far as the choice of pipelines goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct ShadowLook {
    /// Hair shadows hair.
    pub(crate) self_shadow: bool,
    /// The light's way through a layer grows with its slant.
    pub(crate) slanted: bool,
    /// The layer-wise maps are of other layers than are drawn.
    pub(crate) maps_between: bool,
    /// Things throw soft shadows.
    pub(crate) soft_shadow: bool,
    /// The penumbra lies on both sides of the hard edge.
    pub(crate) centred: bool,
}

/// How a frame draws an instance, as far as the choice of pipelines goes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Look {
    pub(crate) style: Style,
    pub(crate) yardstick: bool,
    /// The instance mirrors.
    pub(crate) mirrored: bool,
    /// Other than the baked number of layers is drawn.
    pub(crate) resampled: bool,
    /// Layers are left out, or fade.
    pub(crate) detail: bool,
    /// The far coat lies on the skin.
    pub(crate) coat: bool,
    /// Fins are drawn.
    pub(crate) fins: bool,
    /// A layer blocks more of a look that goes through it at a slant.
    pub(crate) view_slanted: bool,
    /// How the key light's shadows fall.
    pub(crate) shadows: ShadowLook,
    /// There are lights without shadow.
    pub(crate) fill_lights: bool,
    /// Where the key light is computed.
    pub(crate) lighting: Lighting,
    /// Constants of the lighting equation.
    pub(crate) shading: Shading,
}

impl Look {
    /// The pipeline of a part of a model.
    pub(crate) fn key(&self, shader: SurfaceShader, model: &Model, part: &Part) -> SurfaceKey {
        let variant = Variant {
            base_color_texture: part.has_texture,
            cutout: part.cutout,
            planar_directions: match shader {
                SurfaceShader::Fins => model.fins().is_some_and(|fins| fins.planar_directions),
                _ => model.planar_directions(),
            },
            squared_diffuse: self.shading.diffuse_exponent == 2.0,
            specular: self.shading.specular != [0.0; 3],
            resampled: self.resampled,
            detail: self.detail,
            coat: self.coat,
            lean: model.varies().lean,
            groom_vertices: model.varies().groom,
            groom_texture: part.has_groom_texture,
            wet: model.manifest().fur.wet.is_some(),
            view_slanted: self.view_slanted,
            shadows: self.shadows,
            fill_lights: self.fill_lights,
            vertex_lighting: self.lighting == Lighting::Vertex,
        };
        let variant = shader.relevant(variant);
        // Fins are seen from both sides, and back faces throw shadows too.
        let both = matches!(shader, SurfaceShader::Fins | SurfaceShader::Caster(CasterPass::Nearest));
        SurfaceKey { shader, variant, double_sided: part.double_sided || both, mirrored: self.mirrored && !both }
    }
}

/// Numbers of the `wanted` parts of a model and the pipelines that draw them.
pub(crate) fn plan_parts(
    device: &wgpu::Device,
    pipelines: &mut Pipelines,
    model: &Model,
    look: &Look,
    shader: SurfaceShader,
    wanted: impl Fn(&Part) -> bool,
) -> Vec<(usize, wgpu::RenderPipeline)> {
    let parts = model.parts().iter().enumerate().filter(|(_, part)| wanted(part));
    parts.map(|(index, part)| (index, pipelines.surface(device, look.key(shader, model, part)))).collect()
}

impl Variant {
    /// Shells need more than the plain varyings.
    fn is_mapped(self) -> bool {
        let material = self.base_color_texture || self.cutout || self.groom_texture;
        material || self.lean || self.groom_vertices || self.wet || self.resampled || self.shadows.maps_between
    }

    /// Layers that the key light sees need more than the plain varyings.
    fn is_mapped_to_light(self) -> bool {
        self.cutout || self.groom_texture || self.groom_vertices || self.wet
    }

    pub(crate) fn constants(self) -> [(&'static str, f64); 20] {
        [
            ("BASE_COLOR_TEXTURE", self.base_color_texture),
            ("CUTOUT", self.cutout),
            ("PLANAR_DIRECTIONS", self.planar_directions),
            ("SQUARED_DIFFUSE", self.squared_diffuse),
            ("SPECULAR", self.specular),
            ("RESAMPLED", self.resampled),
            ("DETAIL", self.detail),
            ("COAT", self.coat),
            ("LEAN", self.lean),
            ("GROOM_VERTICES", self.groom_vertices),
            ("GROOM_TEXTURE", self.groom_texture),
            ("WET", self.wet),
            ("VIEW_SLANTED", self.view_slanted),
            ("SELF_SHADOW", self.shadows.self_shadow),
            ("SLANTED", self.shadows.slanted),
            ("MAPS_BETWEEN", self.shadows.maps_between),
            ("SOFT_SHADOW", self.shadows.soft_shadow),
            ("CENTRED", self.shadows.centred),
            ("FILL_LIGHTS", self.fill_lights),
            ("VERTEX_LIGHTING", self.vertex_lighting),
        ]
        .map(|(name, value)| (name, f64::from(u8::from(value))))
    }
}

/// Shader of a surface pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum SurfaceShader {
    SkinBare,
    SkinFurred,
    Fins,
    Shells,
    Yardstick,
    /// A layer seen from the key light.
    LayerShadow,
    /// The skin seen from the key light.
    Caster(CasterPass),
}

/// What is there times what is drawn.
const MULTIPLIED: wgpu::BlendState = {
    let times = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::Zero,
        dst_factor: wgpu::BlendFactor::Src,
        operation: wgpu::BlendOperation::Add,
    };
    wgpu::BlendState { color: times, alpha: wgpu::BlendComponent { dst_factor: wgpu::BlendFactor::SrcAlpha, ..times } }
};

/// What is nearer, or with `strictly` not as far as well, is drawn.
pub(crate) fn depth_compare(strictly: bool, reversed_depth: bool) -> wgpu::CompareFunction {
    match (strictly, reversed_depth) {
        (true, false) => wgpu::CompareFunction::Less,
        (true, true) => wgpu::CompareFunction::Greater,
        (false, false) => wgpu::CompareFunction::LessEqual,
        (false, true) => wgpu::CompareFunction::GreaterEqual,
    }
}

/// What a pipeline draws to.
pub(crate) struct Target {
    pub(crate) color: Option<wgpu::ColorTargetState>,
    pub(crate) depth_format: wgpu::TextureFormat,
    pub(crate) depth_write: bool,
    pub(crate) depth_compare: wgpu::CompareFunction,
    pub(crate) sample_count: u32,
}

impl SurfaceShader {
    /// The variant without what this shader does not look at, so that pipelines are shared.
    fn relevant(self, variant: Variant) -> Variant {
        // Light on a surface without layers of its own.
        let on_skin = ShadowLook { slanted: false, maps_between: false, ..variant.shadows };
        let surface =
            Variant { base_color_texture: variant.base_color_texture, cutout: variant.cutout, ..Variant::default() };
        // Of the colour only what is cut away matters.
        let holes = Variant { base_color_texture: variant.base_color_texture && variant.cutout, ..surface };
        match self {
            Self::SkinBare => Variant { shadows: on_skin, fill_lights: variant.fill_lights, ..surface },
            Self::SkinFurred => Variant {
                resampled: false,
                detail: false,
                // Skin leans nowhere, unless it is raised.
                lean: variant.lean && variant.coat,
                view_slanted: false,
                shadows: on_skin,
                ..variant
            },
            Self::Fins => Variant {
                resampled: false,
                detail: false,
                coat: false,
                view_slanted: false,
                shadows: on_skin,
                ..variant
            },
            Self::Shells => Variant { coat: false, ..variant },
            Self::Yardstick => Variant { lean: variant.lean, detail: variant.detail, ..Variant::default() },
            Self::LayerShadow => Variant {
                resampled: variant.resampled,
                lean: variant.lean,
                groom_vertices: variant.groom_vertices,
                groom_texture: variant.groom_texture,
                wet: variant.wet,
                shadows: ShadowLook { slanted: variant.shadows.slanted, ..ShadowLook::default() },
                ..holes
            },
            Self::Caster(_) => holes,
        }
    }

    /// Vertex and fragment entry point.
    pub(crate) fn entry_points(self, variant: Variant) -> (&'static str, &'static str) {
        match self {
            Self::SkinBare => ("vs_bare", "fs_bare"),
            Self::SkinFurred => ("vs_furred", "fs_furred"),
            Self::Fins => ("vs_fins", "fs_fins"),
            Self::Shells if variant.fill_lights => ("vs_shells_filled", "fs_shells_filled"),
            Self::Shells if variant.is_mapped() => ("vs_shells_mapped", "fs_shells_mapped"),
            Self::Shells => ("vs_shells", "fs_shells"),
            Self::Yardstick => ("vs_yardstick", "fs_yardstick"),
            Self::LayerShadow if variant.is_mapped_to_light() => ("vs_layer_mapped", "fs_layer_mapped"),
            Self::LayerShadow => ("vs_layer", "fs_layer"),
            Self::Caster(_) => ("vs_caster", "fs_caster"),
        }
    }

    /// Hair over the skin: blended.
    fn is_blended(self) -> bool {
        matches!(self, Self::Fins | Self::Shells | Self::Yardstick)
    }

    pub(crate) fn target(self, options: &RendererOptions) -> Target {
        match self {
            Self::LayerShadow => Target {
                color: Some(wgpu::ColorTargetState {
                    format: ShadowMaps::LAYER_FORMAT,
                    blend: Some(MULTIPLIED),
                    write_mask: wgpu::ColorWrites::ALL,
                }),
                depth_format: ShadowMaps::DEPTH_FORMAT,
                depth_write: false,
                // Layers that coincide with the skin take no light.
                depth_compare: wgpu::CompareFunction::Less,
                sample_count: 1,
            },
            Self::Caster(pass) => Target {
                color: None,
                depth_format: ShadowMaps::DEPTH_FORMAT,
                depth_write: true,
                depth_compare: pass.compare(),
                sample_count: 1,
            },
            _ => Target {
                color: Some(wgpu::ColorTargetState {
                    format: options.color_format,
                    // The layers hold premultiplied colour.
                    blend: self.is_blended().then_some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                    write_mask: wgpu::ColorWrites::ALL,
                }),
                depth_format: options.depth_format,
                depth_write: self != Self::Fins,
                // Layers that coincide with the skin (fur of height 0) stay hidden: strictly nearer only.
                depth_compare: depth_compare(self.is_blended(), options.reversed_depth),
                sample_count: options.sample_count,
            },
        }
    }
}
