//! One pass is one folder: what it needs, its pipelines, and how it is recorded.

pub(crate) mod fins;
pub(crate) mod pose;
pub(crate) mod shells;
pub(crate) mod skin;
pub(crate) mod surface;

/// A pass of the frame, in the order in which they run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PassId {
    /// Compute: poses the vertices. Recorded by [`crate::Renderer::prepare`].
    Pose,
    /// The opaque base mesh and bare parts.
    Skin,
    /// Quads of hair on the edges of the skin, where they are seen face on.
    Fins,
    /// The layers of hair, inside to outside.
    Shells,
}

impl PassId {
    /// All of them, in order.
    pub const ALL: [Self; 4] = [Self::Pose, Self::Skin, Self::Fins, Self::Shells];

    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pose => "pose",
            Self::Skin => "skin",
            Self::Fins => "fins",
            Self::Shells => "shells",
        }
    }
}
