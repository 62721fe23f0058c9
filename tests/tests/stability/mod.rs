//! Stability tests: the naive form of each method fails where ours stays within its bound; and surfaces that are hard
//! to parameterize.

mod meshes;
mod rows;
mod runtime;
mod silhouettes;
mod surface;
