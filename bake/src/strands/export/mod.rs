//! Export of strands and mesh to formats of other programs. The hair is the same as in the ray-traced reference, so
//! that other renderers can be compared with it.
//!
//! Each writer streams to any [`Write`]. Lengths are metres in world space, y up, as in the package. All formats name
//! the [groups](Curves::groups), except text, which only stores points.

mod glb;
mod hair;
mod obj;
mod pbrt;
mod text;
mod usda;

pub use glb::write_glb;
pub use hair::write_hair;
pub use obj::{write_mtl, write_obj};
pub use pbrt::write_pbrt;
pub use text::write_text;
pub use usda::write_usda;

use crate::strands::{CurveGroup, Curves};
use std::collections::BTreeSet;
use std::io::{self, Write};

/// File formats for strands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StrandFormat {
    /// Text: a line `x y z radius` per point, root first. A blank line separates strands.
    Text,
    /// Curves of pbrt-v4.
    Pbrt,
    /// Binary glTF with lines.
    Glb,
    /// Cem Yuksel's binary format.
    Hair,
    /// USD as text, with curves.
    Usda,
}

impl StrandFormat {
    /// All formats with their file extensions.
    pub const EXTENSIONS: [(&'static str, Self); 5] =
        [("txt", Self::Text), ("pbrt", Self::Pbrt), ("glb", Self::Glb), ("hair", Self::Hair), ("usda", Self::Usda)];

    /// Returns the format of a file extension, ignoring case.
    pub fn of_extension(extension: &str) -> Option<Self> {
        let named = Self::EXTENSIONS.iter().find(|(e, _)| extension.eq_ignore_ascii_case(e));
        named.map(|(_, format)| *format)
    }

    /// Writes strands.
    ///
    /// Fails with errors of `out`, and [`io::ErrorKind::InvalidInput`] if there are more strands than the format
    /// permits.
    pub fn write(self, curves: &Curves, out: &mut dyn Write) -> io::Result<()> {
        match self {
            Self::Text => write_text(curves, out),
            Self::Pbrt => write_pbrt(curves, out),
            Self::Glb => write_glb(curves, out),
            Self::Hair => write_hair(curves, out),
            Self::Usda => write_usda(curves, out),
        }
    }
}

/// Writes numbers as little-endian binary32.
fn write_floats(numbers: &[f32], out: &mut dyn Write) -> io::Result<()> {
    numbers.iter().try_for_each(|number| out.write_all(&number.to_le_bytes()))
}

/// Returns the names of the groups, converted by `plain` to the form that a format permits. A repeated name gets a
/// number.
fn plain_names(curves: &Curves, plain: impl Fn(&str) -> String) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let mut name = |group: &CurveGroup| {
        let plain = plain(&group.name);
        let (mut name, mut number) = (plain.clone(), 2);
        while !taken.insert(name.clone()) {
            name = format!("{plain}_{number}");
            number += 1;
        }
        name
    };
    curves.groups().iter().map(&mut name).collect()
}

/// Replaces all characters that `is_allowed` rejects by `_`.
fn allowed(text: &str, is_allowed: impl Fn(char) -> bool) -> String {
    text.chars().map(|c| if is_allowed(c) { c } else { '_' }).collect()
}

/// Returns the error for more items than a format permits.
fn too_many(what: &str, found: usize, most: u64) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, format!("{found} {what}, expected at most {most} in this format"))
}

#[cfg(test)]
mod tests;
