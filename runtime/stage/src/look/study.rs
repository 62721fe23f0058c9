//! Look keys of the laboratory: published forms of the papers' formulas, instead of those that pelage uses.

use pelage_params::{params, words};
use pelage_runtime::{Anchoring, FeatureRule, LightingStage, PenumbraForm, SlantForm, SphereMapForm, Study};

words! {
    /// Position of a soft shadow's penumbra.
    LookPenumbra {
        /// On both sides of the hard edge.
        #[default]
        Centred = "centred",
        /// Inside the hard edge.
        Inner = "inner",
    }
}

words! {
    /// Effect of the angle between ray and layer on the opacity of the layer.
    LookSlant {
        /// The path through a layer lengthens with the slant.
        #[default]
        Corrected = "corrected",
        /// The opacity of a layer is the same at every angle, as published in Yang 2006.
        Printed = "printed",
    }
}

words! {
    /// Shader stage that computes the lighting of hair.
    LookLighting {
        /// Per pixel, with the direction texture.
        #[default]
        Pixel = "pixel",
        /// Per vertex.
        Vertex = "vertex",
    }
}

words! {
    /// Condition on the neighbours of a pixel for an ink line.
    LookRule {
        /// Any of the four neighbours differs.
        #[default]
        AnyBelow = "any",
        /// All four neighbours differ, as published in Fang 2006.
        AllBelow = "all",
    }
}

words! {
    /// Texture coordinates of the sphere map.
    LookSphereMap {
        /// Normal in the frame perpendicular to the view direction.
        #[default]
        Perpendicular = "perpendicular",
        /// Reflection of the view direction.
        Reflection = "reflection",
        /// Published form of Fang 2006: the same coordinates for all normals.
        Printed = "printed",
    }
}

words! {
    /// Reference frame of noise along lines and in the wash.
    LookAnchoring {
        /// Strokes and wash move with the surface.
        #[default]
        Surface = "surface",
        /// Strokes and wash stay fixed on the screen.
        Screen = "screen",
    }
}

params! {
    /// `[study]`: published forms of the papers' formulas, for charts and measurements. Only the laboratory's build,
    /// `pelage-lab`, has these keys.
    LookStudy in study {
        /// Opacity of a layer for slanted light.
        slant: LookSlant = LookSlant::Corrected, was "shadow.slant";
        /// Opacity of a layer for slanted view rays.
        view_slant: LookSlant = LookSlant::Corrected, was "fur.view_slant";
        /// Position of a soft shadow's penumbra.
        penumbra_form: LookPenumbra = LookPenumbra::Centred, was "shadow.penumbra_form";
        /// Stage that lights hair.
        lighting: LookLighting = LookLighting::Pixel, was "fur.lighting";
        /// Whether ambient light fades towards the surface: γ in Yang 2006, eq. (2).
        ambient_attenuation: bool = true, was "fur.ambient_attenuation";
        /// Whether the key light fades on the side of the body away from it: Attenu_Back in Yang 2006, eq. (3).
        back_attenuation: bool = true, was "fur.back_attenuation";
        /// Condition on the neighbours of a pixel for an ink line.
        ink_rule: LookRule = LookRule::AnyBelow, was "ink.rule";
        /// Texture coordinates of the ink style's sphere map.
        ink_sphere_map: LookSphereMap = LookSphereMap::Perpendicular, was "ink.sphere_map";
        /// Whether ink lines keep their width; otherwise the sphere map alone determines it.
        ink_template: bool = true, was "ink.template";
        /// Whether ink lines are drawn by the published algorithm, in which a pixel is either inked or not.
        ink_printed_lines: bool = false, was "ink.printed_lines";
        /// Reference frame of noise in ink: the surface or the screen.
        ink_anchoring: LookAnchoring = LookAnchoring::Surface, was "ink.anchoring";
    }
}

impl LookStudy {
    /// Returns the runtime's study parameters.
    pub(super) fn params(&self) -> Study {
        let slant = |slant| same!(slant, LookSlant => SlantForm: Corrected, Printed);
        Study::default().with(|study| {
            study.light_slant = slant(self.slant);
            study.view_slant = slant(self.view_slant);
            study.penumbra = same!(self.penumbra_form, LookPenumbra => PenumbraForm: Centred, Inner);
            study.lighting = same!(self.lighting, LookLighting => LightingStage: Pixel, Vertex);
            study.ambient_attenuation = self.ambient_attenuation;
            study.back_attenuation = self.back_attenuation;
            study.features = same!(self.ink_rule, LookRule => FeatureRule: AnyBelow, AllBelow);
            study.sphere_map =
                same!(self.ink_sphere_map, LookSphereMap => SphereMapForm: Perpendicular, Reflection, Printed);
            study.template = self.ink_template;
            study.printed_lines = self.ink_printed_lines;
            study.anchoring = same!(self.ink_anchoring, LookAnchoring => Anchoring: Surface, Screen);
        })
    }
}
