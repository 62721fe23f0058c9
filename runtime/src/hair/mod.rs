//! Hair: how much of an instance's hair is drawn, the constants of its shaders, and the shaders shared by all hair
//! geometries.

mod detail;
mod strand_lod;
mod variant;

pub(crate) use detail::{InstanceDrawing, StrandSetDrawing};
pub(crate) use variant::{
    Variant, cutout_constants, groom_constants, growth_and_wetness_constants, growth_constants, hair_wgsl,
    material_constants,
};
