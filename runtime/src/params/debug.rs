//! Debug views of a frame.

/// Image that a fur frame shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FurDebugView {
    /// Lit picture, no debug view.
    #[default]
    Picture,
    /// Geometry kind of each fragment: skin grey, far fur layer violet, shells green, fins yellow, single strands red.
    Geometry,
    /// Number of overlapping fragments: blended ones add up, opaque ones count as one.
    Overdraw,
}

/// Image that an ink frame shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum InkDebugView {
    /// Finished painting.
    #[default]
    Painting,
    /// Lines, black on white.
    Lines,
    /// Feature pixels, through which lines run, black on white.
    Features,
    /// Wash only.
    Wash,
}

/// Debug view shown instead of the picture (default: none). A frame without one has no extra cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct DebugView {
    /// Image that a fur frame shows.
    pub fur: FurDebugView,
    /// Image that an ink frame shows.
    pub ink: InkDebugView,
    /// Draws the shells with one texture read and no lighting, as a baseline for `pelage bench`.
    pub yardstick: bool,
    /// Draws only this shell layer, from 1 up; used to count fragments.
    pub only_layer: Option<u32>,
}
