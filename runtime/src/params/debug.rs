//! Debug views of a frame.

/// Contents of a fur frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FurDebugView {
    /// Lit picture.
    #[default]
    Picture,
    /// Geometry kind of each fragment: skin grey, far fur layer violet, shells green, fins yellow, single strands red.
    Geometry,
    /// Number of overlapping fragments: blended ones add up, opaque ones count as one.
    Overdraw,
}

/// Contents of an ink frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum InkDebugView {
    /// Finished painting.
    #[default]
    Painting,
    /// Lines, black on white.
    Lines,
    /// Feature pixels that lines run through, black on white.
    Features,
    /// Wash only.
    Wash,
}

/// Debug view shown instead of the picture (default: none). A frame without one has no extra cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct DebugView {
    /// Contents of a fur frame.
    pub fur: FurDebugView,
    /// Contents of an ink frame.
    pub ink: InkDebugView,
    /// Draws the shells with one texture read and no lighting: the baseline of `pelage bench`.
    pub yardstick: bool,
    /// Draws only this shell layer, 1.. ; used to count fragments.
    pub only_layer: Option<u32>,
}
