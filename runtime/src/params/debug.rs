//! Debug views of a frame.

/// What a frame of fur shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FurShow {
    /// Its light.
    #[default]
    Picture,
    /// Geometry of each fragment: skin grey, the far coat violet, shells green, fins yellow, single strands red.
    Geometry,
    /// How many fragments lie over each other: what blends adds up, what is opaque is one.
    Overdraw,
}

/// What an ink frame shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum InkShow {
    /// The painting.
    #[default]
    Painting,
    /// Its lines, black on white.
    Lines,
    /// The pixels that lines run through, black on white.
    Features,
    /// The wash alone.
    Wash,
}

/// Debug view: what a frame shows instead of its picture (default: nothing). A frame without one pays nothing for it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct DebugView {
    /// What a frame of fur shows.
    pub fur: FurShow,
    /// What of an ink painting is shown.
    pub ink: InkShow,
    /// Draws the shells with one texture read and no lighting: the baseline of `pelage bench`.
    pub yardstick: bool,
    /// Draws this layer of the shells alone, 1.. ; used to count fragments.
    pub only_layer: Option<u32>,
}
