//! Slow truths for charts and stability rows.
//!
//! * [`SampledVolume`]: transmittance along the true light ray through the volume of which the layers are samples. Its
//!   difference from the layer-wise shadow maps is the error of the maps.
//! * [`StrandField`]: the same strands as round, opaque hairs. Its difference from the volume is the error of slicing.
//! * [`Occluder`]: a mesh that hides parts of a disc light from its points, for soft shadows.
//! * [`TrueLines`]: contours, creases and borders of a posed mesh, with hidden parts removed by rays. The truth for ink
//!   lines.
//! * [`TrueGuide`]: motion of guided hair by its equations, with steps as short as needed. Verlet integration with
//!   length constraints converges to it.

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
