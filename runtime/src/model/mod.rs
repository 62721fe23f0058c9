//! Package in GPU memory.

mod bounds;
mod contours;
mod ink;
mod load;
mod painting;
mod resources;
mod strands;
mod upload;

pub(crate) use contours::ModelContours;
pub(crate) use ink::ModelInk;
pub(crate) use load::load;
pub(crate) use painting::{ModelPainting, PoolPoint, PoolStroke};
pub use resources::Model;
pub(crate) use resources::Part;
pub(crate) use strands::{
    CORNER_BYTES, Guided, HairRoot, Strand, StrandConstants, StrandSet, StrandSource, SurfacePoint,
};
