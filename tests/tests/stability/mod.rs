//! Tests of stability: our form of each method stays within its bound where the naive form fails. Includes surfaces
//! that are hard to parameterize.

mod meshes;
mod rows;
mod runtime;
mod silhouettes;
mod surface;
