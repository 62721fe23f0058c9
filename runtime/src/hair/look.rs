//! What the shaders of hair are told by override constants: what a package or a frame does not need is compiled away. A branch on a uniform
//! costs its body on rasterisers that mask instead of jump.

use super::detail::{Drawing, DrawnSet};
use crate::gpu::{Constants, on};
use crate::instance::Instance;
use crate::light::{HairMaps, ShadowKey};
use crate::model::{Model, Part};
use crate::params::{FrameParams, Scattering};
use crate::shared::skinning;
use glam::Mat3;
use pelage_formats::Shading;

/// Source of what geometries of hair share, joined before each.
macro_rules! hair_wgsl {
    ($($geometry:expr),+ $(,)?) => {
        &[
            include_str!("../../shared/detail.wgsl"),
            include_str!("../../shared/environment.wgsl"),
            include_str!("../../shared/fins.wgsl"),
            include_str!("../../shared/frame.wgsl"),
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
            include_str!("../../debug/shown.wgsl"),
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

/// How a frame draws an instance, as far as the choice of pipelines goes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Look {
    /// The instance mirrors: its front faces wind clockwise.
    pub(crate) mirrored: bool,
    /// Other than the baked number of layers is drawn.
    pub(crate) resampled: bool,
    /// Layers are left out, or fade.
    pub(crate) detail: bool,
    /// The far coat lies on the skin.
    pub(crate) coat: bool,
    /// Fins are drawn.
    pub(crate) fins: bool,
    /// Single strands are drawn, of the coat or of groups of hair.
    pub(crate) strands: bool,
    /// They shadow each other by the deep opacity map.
    pub(crate) deep_shadow: bool,
    /// Hair shadows hair, by the layer-wise maps.
    self_shadow: bool,
    /// Hair shadows hair, as the package knows it.
    baked_shadow: bool,
    /// What the package does not know: hair on guides shadows it too.
    guided_shadow: bool,
    /// The layer-wise maps are of other layers than are drawn.
    pub(crate) maps_between: bool,
    /// The layer-wise maps have another number of layers than were baked.
    pub(crate) maps_resampled: bool,
    /// Things throw soft shadows.
    soft_shadow: bool,
    /// There are lights without shadow.
    pub(crate) fill_lights: bool,
    /// There is light from all around: the first of the tables of broad light that is of the model's fibres.
    pub(crate) environment: Option<u32>,
    /// The key light is black.
    dark_key: bool,
    /// How hair scatters light by tables of its fibres, where it does.
    scattering: Option<Scattering>,
    /// Constants of the lighting equation.
    shading: Shading,
}

impl Look {
    /// Of an instance of which `drawing` is drawn, under the shadow maps of `maps`.
    pub(crate) fn new(
        instance: &Instance,
        params: &FrameParams,
        drawing: &Drawing,
        sets: &[DrawnSet],
        maps: Option<&ShadowKey>,
        broad_first: u32,
    ) -> Self {
        let manifest = instance.model.manifest();
        let baked = manifest.fur.layers;
        let baked_shadow = instance.reads_baked_shadow(params);
        let self_shadow = !baked_shadow && maps.is_some_and(|key| key.hair == HairMaps::LayerWise);
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
            guided_shadow: baked_shadow && maps.is_some_and(|key| key.guided() && key.hair != HairMaps::None),
            // Reduced layers are lit at the height of the hair seen in them.
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

    /// What surfaces that are lit are told.
    pub(crate) fn lights(&self) -> Constants {
        let mut constants = self.strand_lights();
        constants.push(on("GUIDED_SHADOW", self.guided_shadow));
        constants
    }

    /// What strands that are lit are told: their own map has hair on guides too.
    pub(crate) fn strand_lights(&self) -> Constants {
        vec![
            on("SQUARED_DIFFUSE", self.shading.diffuse_exponent == 2.0),
            on("SPECULAR", self.shading.specular != [0.0; 3]),
            on("SELF_SHADOW", self.self_shadow),
            on("BAKED_SHADOW", self.baked_shadow),
            on("SOFT_SHADOW", self.soft_shadow),
            on("FILL_LIGHTS", self.fill_lights),
            on("ENVIRONMENT", self.environment.is_some()),
            ("BROAD_FIRST", self.environment.unwrap_or(0)),
            on("DARK_KEY", self.dark_key),
            on("SCATTERING", self.scattering.is_some()),
            on("MULTIPLE", self.scattering == Some(Scattering::Multiple)),
        ]
    }
}

/// What all that looks at a part's material is told.
pub(crate) fn material(part: &Part) -> Constants {
    vec![on("BASE_COLOR_TEXTURE", part.has_texture), on("CUTOUT", part.cutout)]
}

/// What all that sees of a part's colour only what is cut away is told.
pub(crate) fn holes(part: &Part) -> Constants {
    vec![on("BASE_COLOR_TEXTURE", part.cutout && part.has_texture), on("CUTOUT", part.cutout)]
}

/// What all that asks whether hair of a part grows is told.
pub(crate) fn grown_by(model: &Model, part: &Part) -> Constants {
    vec![on("GROOM_VERTICES", model.varies().groom), on("GROOM_TEXTURE", part.has_groom_texture)]
}

/// The same, and whether wet hair is mixed in.
pub(crate) fn grown(model: &Model, part: &Part) -> Constants {
    let mut constants = grown_by(model, part);
    constants.push(on("WET", model.manifest().fur.wet.is_some()));
    constants
}

/// What all that reads the hair of a part is told, but for how it leans.
pub(crate) fn groom(model: &Model, part: &Part) -> Constants {
    let mut constants = grown(model, part);
    constants.extend([on("SHORT", model.varies().length), on("AT_ROOT", part.at_root)]);
    constants
}
