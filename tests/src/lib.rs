//! Code shared by the tests and the developer chores.

pub mod binary;
pub mod chores;
pub mod compute;
pub mod desktop;
pub mod documents;
pub mod gpu;
pub mod likeness;
pub mod mutate;
pub mod packages;
pub mod pages;
pub mod pictures;
pub mod plane;
pub mod schema;
pub mod silhouette;
pub mod specks;

/// Furry sphere and ground of the runtime's examples.
#[path = "../../runtime/examples/support/mod.rs"]
pub mod support;
