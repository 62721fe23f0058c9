//! Slow truths that only charts and stability rows are measured against.
//!
//! * [`SampledVolume`]: transmittance along the true light ray through the volume that the layers were sampled from.
//!   What is left between it and the layer-wise shadow maps is the error of the maps.
//! * [`StrandField`]: the same strands as round, opaque hairs. What is left between it and the volume is the error of
//!   slicing.
//! * [`Occluder`]: a mesh between its points and a light that is a disc, for soft shadows.
//! * [`TrueLines`]: contours, creases and borders of a posed skin as edges of its mesh, hidden parts removed by rays:
//!   what ink lines should be.
//! * [`TrueGuide`]: hair on guides that swings, by its equations and steps as short as it takes: what Verlet and its
//!   lengths should come to.

mod disc_light;
mod hair_motion;
mod ink_lines;
mod strands;
mod volume;

pub use disc_light::{DiscLight, Occluder};
pub use hair_motion::{Followed, SkinMotion, TrueGuide, TrueSwing};
pub use ink_lines::{ContourForm, LineKind, LineParams, LineSegment, TrueLines, VisibleLines};
pub use strands::StrandField;
pub use volume::SampledVolume;
