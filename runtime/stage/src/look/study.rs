//! Looks of the laboratory: the forms that the papers print, in place of those that pelage draws with.

use pelage_params::{params, words};
use pelage_runtime::{Anchoring, FeatureRule, Lighting, PenumbraForm, SlantForm, SphereMapForm, Study};

words! {
    /// Where a soft shadow's edge lies.
    LookPenumbra {
        /// On both sides of the hard edge.
        #[default]
        Centred = "centred",
        /// Inside the hard edge.
        Inner = "inner",
    }
}

words! {
    /// What the slant of a ray does to the opacity of a layer.
    LookSlant {
        /// The way through a layer grows with the slant.
        #[default]
        Corrected = "corrected",
        /// A layer takes the same at every angle, as printed in Yang 2006.
        Printed = "printed",
    }
}

words! {
    /// Where hair is lit.
    LookLighting {
        /// At every pixel, with the direction texture.
        #[default]
        Pixel = "pixel",
        /// At the vertices.
        Vertex = "vertex",
    }
}

words! {
    /// Which neighbours of a pixel must differ for a line of ink.
    LookRule {
        /// Any of the four.
        #[default]
        AnyBelow = "any",
        /// All four, as printed in Fang 2006.
        AllBelow = "all",
    }
}

words! {
    /// How the sphere map is looked up.
    LookSphereMap {
        /// In the frame perpendicular to the view.
        #[default]
        Perpendicular = "perpendicular",
        /// By reflection of the eye.
        Reflection = "reflection",
        /// As printed in Fang 2006: one place for all normals.
        Printed = "printed",
    }
}

words! {
    /// What varies is tied to the surface or to the picture.
    LookAnchoring {
        /// Strokes and wash move with the surface.
        #[default]
        Surface = "surface",
        /// They stay where they are in the picture.
        Screen = "screen",
    }
}

params! {
    /// `[study]`: forms as the papers print them, for charts and measurements.
    /// Only the laboratory's build, `pelage-lab`, has these keys.
    LookStudy in study {
        /// What the light's slant does to the opacity of a layer.
        slant: LookSlant = LookSlant::Corrected, was "shadow.slant";
        /// What the slant of the look does to the opacity of a layer.
        view_slant: LookSlant = LookSlant::Corrected, was "fur.view_slant";
        /// Where a soft shadow's edge lies.
        penumbra_form: LookPenumbra = LookPenumbra::Centred, was "shadow.penumbra_form";
        /// Where hair is lit.
        lighting: LookLighting = LookLighting::Pixel, was "fur.lighting";
        /// Whether ambient light fades towards the skin, as γ of Yang 2006, eq. (2).
        ambient_attenuation: bool = true, was "fur.ambient_attenuation";
        /// Whether the light ends behind the body, as Attenu_Back of Yang 2006, eq. (3).
        back_attenuation: bool = true, was "fur.back_attenuation";
        /// Which neighbours of a pixel must differ for a line of ink.
        ink_rule: LookRule = LookRule::AnyBelow, was "ink.rule";
        /// How the sphere map of ink is looked up.
        ink_sphere_map: LookSphereMap = LookSphereMap::Perpendicular, was "ink.sphere_map";
        /// Whether lines of ink keep to their width; without, the sphere map alone decides.
        ink_template: bool = true, was "ink.template";
        /// Whether lines of ink are as the printed algorithm draws them, pixels that are ink or not.
        ink_printed_lines: bool = false, was "ink.printed_lines";
        /// What varies in ink is tied to the surface, or to the picture.
        ink_anchoring: LookAnchoring = LookAnchoring::Surface, was "ink.anchoring";
    }
}

impl LookStudy {
    /// Forms that a frame is drawn with.
    pub(super) fn params(&self) -> Study {
        let slant = |slant| same!(slant, LookSlant => SlantForm: Corrected, Printed);
        Study::default().with(|study| {
            study.light_slant = slant(self.slant);
            study.look_slant = slant(self.view_slant);
            study.penumbra = same!(self.penumbra_form, LookPenumbra => PenumbraForm: Centred, Inner);
            study.lighting = same!(self.lighting, LookLighting => Lighting: Pixel, Vertex);
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
