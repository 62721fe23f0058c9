//! Override constants of the hair shaders. Code that a package or a frame does not need is compiled out. The reason:
//! some rasterisers mask instead of branching, and a branch on a uniform then costs as much as its body.

use super::detail::{InstanceDrawing, StrandSetDrawing};
use crate::gpu::{Constants, flag};
use crate::instance::Instance;
use crate::light::{HairMapKind, ShadowKey};
use crate::model::{Model, Part};
use crate::params::{FrameParams, Scattering};
use crate::shared::skinning;
use glam::Mat3;
use pelage_formats::Shading;

/// Lists the shader sources shared by all hair geometries, followed by the given ones.
macro_rules! hair_wgsl {
    ($($geometry:expr),+ $(,)?) => {
        &[
            include_str!("../../shared/detail.wgsl"),
            include_str!("../../shared/environment.wgsl"),
            include_str!("../../shared/fins.wgsl"),
            include_str!("../../shared/frame.wgsl"),
            include_str!("../../shared/gloss.wgsl"),
            include_str!("../../shared/kajiya_kay.wgsl"),
            include_str!("../../shared/layer_shadow.wgsl"),
            include_str!("../../shared/opacity.wgsl"),
            include_str!("../../shared/scattering.wgsl"),
            include_str!("../../shared/skinning.wgsl"),
            include_str!("../../shared/soft_shadow.wgsl"),
            include_str!("../../shared/tile_frame.wgsl"),
            include_str!("../../shared/visibility.wgsl"),
            include_str!("../../surface/place.wgsl"),
            include_str!("../../light/baked.wgsl"),
            include_str!("../../light/fibre.wgsl"),
            include_str!("../../light/scatter.wgsl"),
            include_str!("../../light/fills.wgsl"),
            include_str!("../../light/environment.wgsl"),
            include_str!("../../light/gloss.wgsl"),
            include_str!("../../shared/tone.wgsl"),
            include_str!("../../debug/false_color.wgsl"),
            $crate::study::form_wgsl!("light/forms.wgsl"),
            include_str!("../../light/key.wgsl"),
            include_str!("../../light/point.wgsl"),
            include_str!("../../light/visibility.wgsl"),
            include_str!("../../hair/hair.wgsl"),
            include_str!("../../hair/vertex.wgsl"),
            $($geometry,)+
        ]
    };
}
pub(crate) use hair_wgsl;

/// Shader variant for an instance in a frame: all settings that select its pipelines.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Variant {
    /// Whether the instance is mirrored, so that its front faces wind clockwise.
    pub(crate) mirrored: bool,
    /// Whether the number of drawn layers differs from that of baked layers.
    pub(crate) resampled: bool,
    /// Whether some layers are skipped or fading.
    pub(crate) detail: bool,
    /// Whether the far fur layer is drawn on the surface.
    pub(crate) coat: bool,
    pub(crate) fins: bool,
    /// Whether single strands are drawn, of fur or of hair groups.
    pub(crate) strands: bool,
    /// Whether strands shadow each other by the deep opacity map.
    pub(crate) deep_shadow: bool,
    /// Whether hair shadows itself by the layer-wise maps.
    self_shadow: bool,
    /// Whether hair shadows itself by data baked into the package.
    baked_shadow: bool,
    /// Whether guided hair casts shadows on the hair, which the baked data does not include.
    guided_shadow: bool,
    /// Whether the layers of the layer-wise maps differ from those drawn.
    pub(crate) maps_between: bool,
    /// Whether the number of layer-wise maps differs from the baked layer count.
    pub(crate) maps_resampled: bool,
    soft_shadow: bool,
    /// Whether there are fill lights, which cast no shadows.
    pub(crate) fill_lights: bool,
    /// Index of the first broad-light table for the model's fibres, if there is an environment map.
    pub(crate) environment: Option<u32>,
    /// Whether the key light is black.
    dark_key: bool,
    /// Scattering mode, if hair is lit with the tables of its fibres.
    pub(crate) scattering: Option<Scattering>,
    /// Constants of the lighting model.
    shading: Shading,
}

impl Variant {
    /// Returns the variant for an instance drawn as `drawing`, with the shadow maps `maps`.
    pub(crate) fn new(
        instance: &Instance,
        params: &FrameParams,
        drawing: &InstanceDrawing,
        sets: &[StrandSetDrawing],
        maps: Option<&ShadowKey>,
        broad_first: u32,
    ) -> Self {
        let manifest = instance.model.manifest();
        let baked = manifest.fur.layers;
        let baked_shadow = instance.reads_baked_shadow(params);
        let self_shadow = !baked_shadow && maps.is_some_and(|key| key.hair == HairMapKind::LayerWise);
        let map_layers = maps.map_or(0, |key| key.map_layers);
        let with_fins = params.style.fur().is_some_and(|fur| fur.fins) && instance.model.fins().is_some();
        Self {
            mirrored: skinning::handedness_of(Mat3::from_mat4(instance.transform)) < 0.0,
            resampled: drawing.layers != baked,
            detail: drawing.is_reduced(),
            coat: drawing.detail.coat > 0.0,
            strands: !sets.is_empty(),
            deep_shadow: !sets.is_empty() && maps.is_some_and(|key| key.deep.is_some()),
            fins: with_fins && drawing.draws_shells() && drawing.detail.fins > 0.0,
            self_shadow,
            baked_shadow,
            guided_shadow: baked_shadow && maps.is_some_and(|key| key.guided() && key.hair != HairMapKind::None),
            // Layers of a reduced level are lit at the height of the hair that is visible in them.
            maps_between: self_shadow && (map_layers != drawing.layers || drawing.is_reduced()),
            maps_resampled: map_layers != baked,
            soft_shadow: maps.is_some_and(|key| key.soft_shadow),
            fill_lights: !params.fill_lights.is_empty(),
            environment: params.environment.as_ref().map(|_| broad_first),
            dark_key: params.is_key_dark(),
            scattering: instance.scattering(params),
            shading: params.shading.unwrap_or(manifest.shading),
        }
    }

    /// Returns whether vertices evaluate the light of hair layers (formulas 4.17). The light of fill lights and shadows
    /// from maps vary too much between vertices.
    pub(crate) fn lit_at_vertices(&self) -> bool {
        self.environment.is_some() && self.scattering.is_some() && !self.self_shadow && !self.fill_lights
    }

    pub(crate) fn lit_surface_constants(&self) -> Constants {
        let mut constants = self.lit_strand_constants();
        constants.push(flag("GUIDED_SHADOW", self.guided_shadow));
        constants
    }

    /// Returns the constants of lit strands. They need no `GUIDED_SHADOW`: the strands' deep opacity map includes
    /// guided hair.
    pub(crate) fn lit_strand_constants(&self) -> Constants {
        vec![
            flag("SQUARED_DIFFUSE", self.shading.diffuse_exponent == 2.0),
            flag("SPECULAR", self.shading.specular != [0.0; 3]),
            flag("SELF_SHADOW", self.self_shadow),
            flag("BAKED_SHADOW", self.baked_shadow),
            flag("SOFT_SHADOW", self.soft_shadow),
            flag("FILL_LIGHTS", self.fill_lights),
            flag("ENVIRONMENT", self.environment.is_some()),
            ("BROAD_FIRST", self.environment.unwrap_or(0)),
            flag("DARK_KEY", self.dark_key),
            flag("SCATTERING", self.scattering.is_some()),
            flag("MULTIPLE", self.scattering == Some(Scattering::Multiple)),
        ]
    }
}

pub(crate) fn material_constants(part: &Part) -> Constants {
    vec![
        flag("BASE_COLOR_TEXTURE", part.has_texture),
        flag("CUTOUT", part.cutout),
        flag("HAIR_COLOR", part.has_hair_color),
    ]
}

/// Returns the constants of shaders that read a part's colour only for its cutout.
pub(crate) fn cutout_constants(part: &Part) -> Constants {
    vec![flag("BASE_COLOR_TEXTURE", part.cutout && part.has_texture), flag("CUTOUT", part.cutout)]
}

/// Returns the constants of shaders that test whether hair grows on a part.
pub(crate) fn growth_constants(model: &Model, part: &Part) -> Constants {
    vec![flag("GROOM_VERTICES", model.varies().groom), flag("GROOM_TEXTURE", part.has_groom_texture)]
}

/// Returns the `growth_constants` and the flag that wet hair is mixed in.
pub(crate) fn growth_and_wetness_constants(model: &Model, part: &Part) -> Constants {
    let mut constants = growth_constants(model, part);
    constants.push(flag("WET", model.manifest().fur.wet.is_some()));
    constants
}

/// Returns the constants of shaders that read the hair of a part; its lean is not included.
pub(crate) fn groom_constants(model: &Model, part: &Part) -> Constants {
    let mut constants = growth_and_wetness_constants(model, part);
    constants.extend([flag("SHORT", model.varies().length), flag("AT_ROOT", part.at_root)]);
    constants
}
