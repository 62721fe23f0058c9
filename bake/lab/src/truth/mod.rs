//! Slow truths for charts and stability rows.
//!
//! * [`SampledVolume`]: transmittance along the true light ray through the volume that the layers were sampled from.
//!   Its difference from the layer-wise shadow maps is the error of the maps.
//! * [`StrandField`]: the same strands as round, opaque hairs. Its difference from the volume is the error of slicing.
//! * [`Occluder`]: a mesh between its points and a disc light, for soft shadows.
//! * [`TrueLines`]: contours, creases and borders of a posed mesh surface as edges of its mesh, hidden parts removed by
//!   rays: the truth for ink lines.
//! * [`TrueGuide`]: hair on guides by its equations, with steps as short as needed: the limit for Verlet with its
//!   lengths.

mod disc_light;
mod hair_motion;
mod ink_lines;
mod strands;
mod volume;

pub use disc_light::{DiscLight, Occluder};
pub use hair_motion::{GuideState, RootMotion, TrueGuide, TrueMotion};
pub use ink_lines::{ContourForm, LineKind, LineParams, LineSegment, TrueLines, VisibleLines};
pub use strands::StrandField;
pub use volume::SampledVolume;
