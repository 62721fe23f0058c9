//! Support for the examples and tests: an application's own scene, and a small furry package made in code.

#![allow(clippy::unwrap_used, reason = "examples and tests stop at the first surprise")]

#[allow(dead_code, reason = "not every example has a ground")]
pub mod ground;
pub mod ktx2;
pub mod sphere;

/// Returns the bytes of the package at that path; without a path, of a small furry sphere.
pub fn package_or_sphere(path: Option<String>) -> Vec<u8> {
    match path {
        Some(path) => std::fs::read(&path).unwrap_or_else(|e| panic!("{path}: {e}")),
        None => sphere::package(&sphere::SphereParams::default()),
    }
}
