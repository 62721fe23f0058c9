//! Stability table: tests that bring each method to its numerical failure, in the naive form and in pelage's.
//!
//! `pelage chart stability` prints the results. `tests/tests/stability/rows.rs` requires that pelage's form stays
//! within its bound and that the naive form fails; data on which the naive form does not fail would prove nothing. The
//! naive forms exist nowhere else.

pub mod animation;
pub mod direction_textures;
pub mod environment;
pub mod hair_motion;
pub mod hair_simulation;
pub mod ink;
pub mod kajiya_kay;
mod knot;
pub mod layer_shadows;
pub mod layers;
pub mod light_in_fur;
mod measures;
pub mod mip_levels;
pub mod opacity_product;
pub mod opacity_shadow;
pub mod painted_strokes;
pub mod parting;
mod row;
pub mod scattering;
pub mod shells;
pub mod short_fur;
pub mod silhouette;
pub mod soft_shadow;
pub mod solver;
pub mod sphere_map;
pub mod strand_light;
pub mod strand_order;
pub mod strand_width;
pub mod surface;

pub use measures::{grow, mean, natural_hair, opacity, slice, texels, transmittances};
pub use row::{DrawCallback, Drawing, DrawnRowTest};
pub use row::{Finding, Row, RowTest};

/// Rows that need no pictures, in the order of the stages of bake and frame.
pub const ROWS: &[Row] = &[
    surface::ROW,
    solver::ROW,
    hair_simulation::ROW,
    parting::ROW,
    opacity_product::ROW,
    layers::ROW,
    mip_levels::ROW,
    direction_textures::ROW,
    kajiya_kay::ROW,
    layer_shadows::ROW,
    short_fur::ROW,
    soft_shadow::ROW,
    animation::ROW,
    sphere_map::ROW,
    opacity_shadow::ROW,
    strand_order::ROW,
    hair_motion::ROW,
    scattering::ROW,
    light_in_fur::ROW,
    environment::ROW,
];

/// Rows that need pictures.
pub const DRAWN_ROWS: &[Row<DrawnRowTest>] =
    &[shells::ROW, ink::ROW, painted_strokes::ROW, strand_width::ROW, strand_light::ROW];
