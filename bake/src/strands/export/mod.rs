//! Strands and skin in the formats of other programs: the same hair that the traced truth is made of, so that others can judge it.
//!
//! Each writer streams to any [`Write`]; lengths are metres in world space, y up, as in the package.

mod glb;
mod hair;
mod obj;
mod pbrt;
mod text;

pub use glb::write_glb;
pub use hair::write_hair;
pub use obj::{write_mtl, write_obj};
pub use pbrt::write_pbrt;
pub use text::write_text;

use crate::strands::Curves;
use std::io::{self, Write};

/// Formats of strands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StrandFormat {
    /// A line `x y z radius` per point, root first, a blank line between strands.
    Text,
    /// Curves of pbrt-v4.
    Pbrt,
    /// Binary glTF with lines.
    Glb,
    /// Cem Yuksel's binary format.
    Hair,
}

impl StrandFormat {
    /// All of them with the extension that stands for each.
    pub const EXTENSIONS: [(&'static str, Self); 4] =
        [("txt", Self::Text), ("pbrt", Self::Pbrt), ("glb", Self::Glb), ("hair", Self::Hair)];

    /// The format of a file with that extension, in any case.
    pub fn of_extension(extension: &str) -> Option<Self> {
        let named = Self::EXTENSIONS.iter().find(|(e, _)| extension.eq_ignore_ascii_case(e));
        named.map(|(_, format)| *format)
    }

    /// Writes strands.
    ///
    /// # Errors
    /// Those of `out`, and [`io::ErrorKind::InvalidInput`] where there are more strands than the format can count.
    pub fn write(self, curves: &Curves, out: &mut dyn Write) -> io::Result<()> {
        match self {
            Self::Text => write_text(curves, out),
            Self::Pbrt => write_pbrt(curves, out),
            Self::Glb => write_glb(curves, out),
            Self::Hair => write_hair(curves, out),
        }
    }
}

/// Little-endian binary32.
fn write_floats(numbers: &[f32], out: &mut dyn Write) -> io::Result<()> {
    numbers.iter().try_for_each(|number| out.write_all(&number.to_le_bytes()))
}

/// More than a format can count.
fn too_many(what: &str, found: usize, most: u64) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, format!("{found} {what}, expected at most {most} in this format"))
}

#[cfg(test)]
mod tests;
