//! Forms of the formulas as printed in the papers.

/// Effect of a ray's slant on the opacity of a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SlantForm {
    /// Corrected form (1 − α)^(1/|N·L|), and half of the receiver's own layer. The path through hair grows with the
    /// slant, for light and view rays alike.
    #[default]
    Corrected,
    /// Constant 1 − α at every angle, as printed in Yang 2006, §3.1, and in all earlier shells.
    Printed,
}

/// Position of the penumbra.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PenumbraForm {
    /// Both sides of the hard edge, as with a round light.
    #[default]
    Centred,
    /// Inside the hard edge, as in Yang 2006, §5, after Kirsch and Döllner 2003.
    Inner,
}

/// Slabs that hold the hair for shadows of single strands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum OpacityForm {
    /// Deep opacity map, Yuksel and Keyser 2008: [`crate::ShadowParams::slabs`] slabs behind the first hair of each
    /// texel.
    #[default]
    Deep,
    /// Opacity shadow map of Nguyen and Donnelly 2005 ("Hair Animation and Rendering in the Nalu Demo"), with corrected
    /// spacing. As many planes at equal distances over the whole depth of the hair, the first at its start and the last
    /// at its end, with linear interpolation.
    WholeDepth,
    /// Opacity shadow map with the spacing as printed, (z_15 − z_0) / 16 for 16 planes. The last plane is before the
    /// end, and everything behind it is lit.
    Printed,
}

/// Stage that computes the key light's diffuse and specular factors, Yang 2006, eq. (1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightingStage {
    /// Per pixel, with the direction of its hair.
    #[default]
    Pixel,
    /// Per vertex, with the mean hair direction of a layer, and interpolated, as in Lengyel 2001: the baseline for
    /// lighting per pixel. Shadows, Attenu_Back and fill lights stay per pixel.
    Vertex,
}

/// Neighbours of a pixel whose normals must differ for a line to run through it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FeatureRule {
    /// Any of the four neighbours.
    #[default]
    AnyBelow,
    /// All four neighbours, as printed in Fang 2006. A straight edge always has two neighbours on its own side, so
    /// hardly any line is found.
    AllBelow,
}

/// Mapping from a normal to coordinates in the stroke texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SphereMapForm {
    /// Normal in the frame perpendicular to the view: the outline is the rim of the disc for any perspective.
    #[default]
    Perpendicular,
    /// Reflection R = 2 (N·E) N − E: the intended meaning of the printed equations, correct only at the centre of the
    /// picture.
    Reflection,
    /// Printed form R = (N·E)² E − E: the same coordinates for all normals.
    Printed,
}

/// Reference frame of noise along lines and in the wash.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Anchoring {
    /// Surface: strokes and wash move with the character.
    #[default]
    Surface,
    /// Screen: the character appears to swim through the texture. For comparison with [`Self::Surface`].
    Screen,
}

/// Forms used instead of pelage's own, for charts, tests and measurements.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Study {
    /// Stage that computes the key light (default per pixel).
    pub lighting: LightingStage,
    /// Opacity of a layer for slanted view rays.
    pub view_slant: SlantForm,
    /// Opacity of a layer for slanted light.
    pub light_slant: SlantForm,
    /// Position of the penumbra.
    pub penumbra: PenumbraForm,
    /// Slabs that hold the hair for shadows of single strands.
    pub opacity: OpacityForm,
    /// Whether the light of single strands is looked up on their axis instead of the side facing the eye (default
    /// false).
    pub light_on_axis: bool,
    /// Whether deep opacity maps may have texels narrower than a strand (default false: such maps are halved in size).
    pub thin_texels: bool,
    /// Maximum number of segments per strand; the greatest divisor of its segments up to this is used. `None`
    /// (default): by size on screen.
    pub strand_pieces: Option<u32>,
    /// Whether ambient light fades towards the surface, γ of Yang 2006, eq. (2) (default true).
    pub ambient_attenuation: bool,
    /// Whether light ends past the terminator, Attenu_Back of Yang 2006, eq. (3) (default true).
    pub back_attenuation: bool,
    /// Neighbours that must differ for an ink line.
    pub features: FeatureRule,
    /// Whether ink lines keep their width (default true). Otherwise the sphere map alone determines it, which blackens
    /// surfaces seen edge-on.
    pub template: bool,
    /// Lookup of the sphere map.
    pub sphere_map: SphereMapForm,
    /// Whether lines are the pixels that the printed algorithm draws, inked or not, with square dilation (default
    /// false).
    pub printed_lines: bool,
    /// Reference frame of noise along lines and in the wash.
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
