//! Environment maps: panoramas, the lights fitted to them ([`Environment`]), their TOML format, and a built-in
//! studio ([`studio()`]).
//!
//! [`Panorama`] holds an equirectangular picture in linear radiance. [`Panorama::fit`] finds the uniform light, the
//! spherical Gaussians and the sun that approximate it best. An application need ship only the fit:
//! [`environment_to_toml`] and [`environment_from_toml`].

mod fit;
mod lobes;
mod panorama;
mod squares;
mod studio;
mod sun;
mod text;

pub use fit::{FitParams, FitResult};
pub use panorama::Panorama;
pub use pelage_formats::meaning::environment::{Environment, LightLobe, Sun};
pub use studio::studio;
pub use text::{environment_from_toml, environment_to_toml};

#[cfg(test)]
mod tests;
