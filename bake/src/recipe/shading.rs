//! `[shading]`: shading of hair and gloss of bare surface.

use super::material_groom::MaterialGloss;
use pelage_params::{params, words};

words! {
    /// Shading model of hair.
    ShadingModel {
        /// `marschner`; `kajiya-kay` if the recipe changes a constant that only `kajiya-kay` uses.
        #[default]
        Auto = "auto",
        /// Two lobes with constant coefficients (Kajiya and Kay).
        KajiyaKay = "kajiya-kay",
        /// Scattering by fibres (Marschner et al.).
        Marschner = "marschner",
    }
}

params! {
    /// `[shading]`: shading of hair, with the constants of Yang 2006, eqs. (1)–(3). Colours are linear RGB.
    ShadingParams in shading {
        /// Shading model: `kajiya-kay` uses two lobes and the constants below (Yang 2006). `marschner` uses scattering
        /// tables of the fibres in `[fibre]`, with multiple scattering between hairs. With `marschner`, hair colours
        /// are those of deep fur in uniform light, without a gain for shadows, and only the ambient constants are used.
        model: ShadingModel = ShadingModel::Auto;
        /// Ambient coefficient ka, multiplied by the hair's colour.
        ambient: [f32; 3] = pelage_formats::Shading::default().ambient, in 0.0..=100.0;
        /// Diffuse coefficient kd.
        diffuse: [f32; 3] = pelage_formats::Shading::default().diffuse, in 0.0..=100.0;
        /// Specular coefficient ks. The highlight is white for any hair colour, so on combed dark hair a high value
        /// looks like dust.
        specular: [f32; 3] = [0.09; 3], in 0.0..=100.0;
        /// Diffuse exponent pd: with 0, all directions of hair are lit equally; higher values darken hair that points
        /// to the light.
        diffuse_exponent: f32 = pelage_formats::Shading::default().diffuse_exponent,
            in pelage_formats::Shading::EXPONENT;
        /// Specular exponent ps: higher values give a narrower highlight.
        specular_exponent: f32 = 60.0, in pelage_formats::Shading::EXPONENT;
        /// Share of the ambient light that reaches the mesh surface: 0 gives black roots, values near 1 look flat.
        ambient_floor: f32 = pelage_formats::Shading::default().ambient_floor, in 0.0..=0.999;
        /// Range of −N·L over which light reaches beyond the terminator. Small values give a hard edge.
        back_light_range: f32 = pelage_formats::Shading::default().back_light_range, in 0.001..=0.999;
        /// Whether bare surface is glossy: eyes are wet, noses moist, and other bare materials have the roughness and
        /// metalness of the model. A roughness of 1, the default of glTF, gives no gloss.
        gloss: bool = true;
        /// Gloss of single materials: `[[shading.material]]` with a `name`, in which `*` matches any characters and
        /// `?` one, and any of `roughness` and `reflectance`. Later tables take precedence.
        material: Vec<MaterialGloss> = Vec::new(), needs "shading.gloss=true";
    }
}

impl ShadingParams {
    /// Returns whether hair is shaded by the scattering of its fibres.
    pub fn scatters(&self) -> bool {
        self.model != ShadingModel::KajiyaKay
    }

    /// Sets the automatic model to `kajiya-kay` if a constant that only this model uses has been changed.
    pub(super) fn settle(&mut self) {
        let default = Self::default();
        let lobes = |s: &Self| (s.diffuse, s.specular, s.diffuse_exponent, s.specular_exponent, s.back_light_range);
        if self.model == ShadingModel::Auto && lobes(self) != lobes(&default) {
            self.model = ShadingModel::KajiyaKay;
        }
    }
}

impl From<&ShadingParams> for pelage_formats::Shading {
    fn from(params: &ShadingParams) -> Self {
        let ShadingParams { ambient, diffuse, specular, diffuse_exponent, specular_exponent, .. } = *params;
        let ShadingParams { ambient_floor, back_light_range, .. } = *params;
        Self { ambient, diffuse, specular, diffuse_exponent, specular_exponent, ambient_floor, back_light_range }
    }
}
