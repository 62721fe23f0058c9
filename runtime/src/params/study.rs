//! Published forms of the papers' formulas.

/// Effect of a ray's inclination on the opacity of a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SlantForm {
    /// Corrected form (1 − α)^(1/|N·L|), with half of the receiver's own layer. The path through hair grows with the
    /// inclination, for light and view rays alike.
    #[default]
    Corrected,
    /// Constant 1 − α at every angle, as published in Yang 2006, §3.1, and used in all earlier shells.
    Printed,
}

/// Position of the penumbra.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PenumbraForm {
    /// On both sides of the hard edge, as with a round light.
    #[default]
    Centred,
    /// Inside the hard edge, as in Yang 2006, §5, after Kirsch and Döllner 2003.
    Inner,
}

/// Division of the hair's depth in the map by which single strands shadow each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum OpacityForm {
    /// Deep opacity map, Yuksel and Keyser 2008: [`crate::ShadowParams::slabs`] slabs behind the first hair of each
    /// texel.
    #[default]
    Deep,
    /// Opacity shadow map of Nguyen and Donnelly 2005 ("Hair Animation and Rendering in the Nalu Demo"), with corrected
    /// spacing. Instead of slabs, as many equidistant planes span the whole depth of the hair, with linear
    /// interpolation. The first plane is at the start of the hair and the last at its end.
    WholeDepth,
    /// Opacity shadow map with the published spacing, (z_15 − z_0) / 16 for 16 planes. The last plane is before the end
    /// of the hair, and everything behind it is lit.
    Printed,
}

/// Shader stage that computes the key light's diffuse and specular factors of Yang 2006, eq. (1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightingStage {
    /// Per pixel, with the hair direction at that pixel.
    #[default]
    Pixel,
    /// Per vertex, with the mean hair direction of a layer, and interpolated, as in Lengyel 2001. Baseline for
    /// per-pixel lighting. Shadows, Attenu_Back and fill lights are still computed per pixel.
    Vertex,
}

/// Neighbours of a pixel whose normals must differ for a line to run through it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FeatureRule {
    /// The dot product with the normal of at least one of the four neighbours is below the threshold.
    #[default]
    AnyBelow,
    /// The dot products with the normals of all four neighbours are below the threshold, as published in Fang 2006. A
    /// straight edge always has two neighbours on its own side, so hardly any line is found.
    AllBelow,
}

/// Mapping from a normal to coordinates in the stroke texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SphereMapForm {
    /// Normal in the frame perpendicular to the view: the outline maps to the rim of the disc under any perspective.
    #[default]
    Perpendicular,
    /// Reflection R = 2 (N·E) N − E, which the published equations intend. Correct only at the centre of the picture.
    Reflection,
    /// Published form R = (N·E)² E − E, which gives the same coordinates for all normals.
    Printed,
}

/// Reference frame of the noise along lines and in the wash.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Anchoring {
    /// Surface: strokes and wash move with the character.
    #[default]
    Surface,
    /// Screen: the character appears to swim through the texture. For comparison with [`Self::Surface`] only.
    Screen,
}

/// Alternatives to pelage's own forms, for charts, tests and measurements.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Study {
    /// Stage that computes the key light (default per pixel).
    pub lighting: LightingStage,
    /// Opacity of a layer along inclined view rays.
    pub view_slant: SlantForm,
    /// Opacity of a layer along inclined light rays.
    pub light_slant: SlantForm,
    /// Position of the penumbra.
    pub penumbra: PenumbraForm,
    /// Division of the hair's depth in the map by which single strands shadow each other.
    pub opacity: OpacityForm,
    /// Whether the light of a single strand is looked up on its axis rather than on the side facing the eye (default
    /// false).
    pub light_on_axis: bool,
    /// Whether deep opacity maps may have texels narrower than a strand (default false: the map size is halved until
    /// they are wider).
    pub thin_texels: bool,
    /// Maximum number of segments per strand. The number used is the greatest divisor of a strand's segment count that
    /// does not exceed it. `None` (default): depends on the size on screen.
    pub strand_pieces: Option<u32>,
    /// Whether ambient light decreases towards the surface, γ of Yang 2006, eq. (2) (default true).
    pub ambient_attenuation: bool,
    /// Whether direct light ends at the terminator, Attenu_Back of Yang 2006, eq. (3) (default true).
    pub back_attenuation: bool,
    /// Neighbours of a pixel whose normals must differ for an ink line.
    pub features: FeatureRule,
    /// Whether the width of ink lines is limited by a template (default true). Otherwise, the sphere map alone
    /// determines the width, which blackens surfaces seen edge-on.
    pub template: bool,
    /// Lookup of the sphere map.
    pub sphere_map: SphereMapForm,
    /// Whether lines are drawn as by the published algorithm: pixels are either ink or not, and the dilation is square
    /// (default false).
    pub printed_lines: bool,
    /// Reference frame of the noise along lines and in the wash.
    pub anchoring: Anchoring,
}

impl Default for Study {
    fn default() -> Self {
        Self {
            lighting: LightingStage::default(),
            view_slant: SlantForm::default(),
            light_slant: SlantForm::default(),
            penumbra: PenumbraForm::default(),
            opacity: OpacityForm::default(),
            light_on_axis: false,
            thin_texels: false,
            strand_pieces: None,
            ambient_attenuation: true,
            back_attenuation: true,
            features: FeatureRule::default(),
            template: true,
            sphere_map: SphereMapForm::default(),
            printed_lines: false,
            anchoring: Anchoring::default(),
        }
    }
}

impl Study {
    /// Returns the study with changes: `Study::default().with(|s| s.template = false)`.
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }
}
