//! Forms as the papers print them.

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

/// Which slabs hold the hair that shadows single strands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum OpacityForm {
    /// [`crate::ShadowParams::slabs`] behind the first hair of each texel: a deep opacity map, Yuksel and Keyser 2008.
    #[default]
    Deep,
    /// As many planes at equal distances over the whole depth of the hair, the first where it begins and the last where it ends, and straight between
    /// them: the opacity shadow map of Nguyen and Donnelly 2005 ("Hair Animation and Rendering in the Nalu Demo") with its spacing mended.
    WholeDepth,
    /// The same with the spacing as printed, (z_15 − z_0) / 16 for 16 planes: the last lies before the end, and what is behind it is lit.
    Printed,
}

/// Where the key light's diffuse and specular factors, Yang 2006, eq. (1), are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lighting {
    /// At every pixel, with the direction of its hair.
    #[default]
    Pixel,
    /// At the vertices, with the mean direction of a layer's hairs, and interpolated, as in Lengyel 2001: the baseline that light per
    /// pixel is held against. Shadows, Attenu_Back and fill lights stay per pixel.
    Vertex,
}

/// Which neighbours of a pixel must differ in their normal for a line to run through it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FeatureRule {
    /// Any of the four.
    #[default]
    AnyBelow,
    /// All four, as Fang 2006 is printed: a straight edge always has two neighbours on its own side, so that hardly a line is found.
    AllBelow,
}

/// How a normal finds its place in the stroke's texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SphereMapForm {
    /// In the frame perpendicular to the view: the outline is the rim of the disc whatever the perspective.
    #[default]
    Perpendicular,
    /// By reflection, R = 2 (N·E) N − E: what the printed equations mean, right at the middle of the picture alone.
    Reflection,
    /// As printed, R = (N·E)² E − E: one place for all normals.
    Printed,
}

/// What varies is tied to the surface or to the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Anchoring {
    /// To the surface: strokes and wash move with the character.
    #[default]
    Surface,
    /// To the picture, through which the character then seems to swim: for measuring what the other saves.
    Screen,
}

/// Forms that a frame is drawn with instead of those of pelage, for charts, tests and measurements.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Study {
    /// Where the key light is computed (default per pixel).
    pub lighting: Lighting,
    /// How opaque a layer is to a look that goes through it at a slant.
    pub look_slant: SlantForm,
    /// How much of the key light a layer takes.
    pub light_slant: SlantForm,
    /// Where the penumbra lies.
    pub penumbra: PenumbraForm,
    /// Which slabs hold the hair that shadows single strands.
    pub opacity: OpacityForm,
    /// Whether the light of single strands is looked up on their axis, and not on the side that the eye sees (default false).
    pub light_on_axis: bool,
    /// Whether maps of strands' shadows may have texels narrower than a strand (default false: such maps are halved).
    pub thin_texels: bool,
    /// Pieces that every strand is drawn in: the most that divide its points, up to so many; `None` (default) by its size on screen.
    pub strand_pieces: Option<u32>,
    /// Whether ambient light fades towards the skin, γ of Yang 2006, eq. (2) (default true).
    pub ambient_attenuation: bool,
    /// Whether the light ends past the terminator, Attenu_Back of Yang 2006, eq. (3) (default true).
    pub back_attenuation: bool,
    /// Which of the four neighbours must differ for a line of ink.
    pub features: FeatureRule,
    /// Whether lines of ink keep to their width (default true). Without it the sphere map alone decides, which blackens what is seen edge on.
    pub template: bool,
    /// How the sphere map is looked up.
    pub sphere_map: SphereMapForm,
    /// Whether lines are the pixels that the printed algorithm draws, ink or not, with squares for the dilation (default false).
    pub printed_lines: bool,
    /// What varies along lines and in the wash is tied to this.
    pub anchoring: Anchoring,
}

impl Default for Study {
    fn default() -> Self {
        Self {
            lighting: Lighting::default(),
            look_slant: SlantForm::default(),
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
    /// The same with changes: `Study::default().with(|s| s.template = false)`.
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }
}
