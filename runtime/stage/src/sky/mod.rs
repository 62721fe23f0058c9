//! Skies and rooms as light: panoramas, what they are taken for ([`Environment`]), and that as TOML.
//!
//! [`Panorama`] holds an equirectangular picture in linear radiance, [`Panorama::fit`] finds the even light, the spherical Gaussians and the sun that come nearest to
//! it. An application may as well ship the fit alone: [`environment_to_toml`] and [`environment_from_toml`].

mod fit;
mod lobes;
mod panorama;
mod squares;
mod sun;
mod text;

pub use fit::{FitParams, Fitted};
pub use panorama::Panorama;
pub use pelage_formats::meaning::environment::{Environment, LightLobe, Sun};
pub use text::{environment_from_toml, environment_to_toml};

#[cfg(test)]
mod tests;
