//! Methods driven over their cliffs: the naive form fails where ours stays within its bound; and surfaces that are hard to lay out.

mod meshes;
mod rows;
mod runtime;
mod silhouettes;
mod surface;
