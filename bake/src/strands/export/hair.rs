//! Export to the binary format of Cem Yuksel's hair models: a header of 128 bytes, number of segments of each strand,
//! positions, thickness, colours.
//!
//! The format has no groups. Instead, the header's text lists the name of each group with the index of its first
//! strand, counted from 0. The list is as long as 88 bytes permit.

use super::{allowed, plain_names, too_many, write_floats};
use crate::strands::Curves;
use std::io::{self, Write};

/// Flags of the arrays in the file: segments, points, thickness and colours.
const ARRAYS: u32 = 1 | 2 | 4 | 16;
/// Length of the header's text, bytes, padded with zeros.
const INFO: usize = 88;

/// Returns the text of the header. It is shorter than [`INFO`], so that it is zero-terminated for readers in C.
fn info(curves: &Curves) -> String {
    const MORE: &str = "; ...";
    let mut text = concat!("pelage ", env!("CARGO_PKG_VERSION"), ": metres, y up, diameters, linear RGB").to_owned();
    let names = plain_names(curves, |name| allowed(name, |c| !c.is_control()));
    for (i, (group, name)) in curves.groups().iter().zip(&names).enumerate() {
        let one = format!("; {name} {}", group.strands.start);
        let room = INFO - 1 - text.len() - if i + 1 < names.len() { MORE.len() } else { 0 };
        if one.len() > room {
            return text + MORE;
        }
        text += &one;
    }
    text
}

/// Writes strands. Thickness is the diameter of the hair; colours are linear RGB.
///
/// Fails with errors of `out`; [`io::ErrorKind::InvalidInput`] if a strand has more than 65 535 segments or all strands
/// together more than 2³² − 1 points, the limits of the format.
pub fn write_hair(curves: &Curves, out: &mut dyn Write) -> io::Result<()> {
    let points =
        u32::try_from(curves.points.len()).map_err(|_| too_many("points", curves.points.len(), u32::MAX.into()))?;
    out.write_all(b"HAIR")?;
    for number in [curves.len() as u32, points, ARRAYS, 0] {
        out.write_all(&number.to_le_bytes())?;
    }
    // Defaults for missing arrays: thickness, transparency and colour.
    write_floats(&[1.0, 0.0, 1.0, 1.0, 1.0], out)?;
    let mut text = info(curves).into_bytes();
    text.resize(INFO, 0);
    out.write_all(&text)?;
    for strand in 0..curves.len() {
        let pieces = curves.strand(strand).len() - 1;
        let pieces = u16::try_from(pieces).map_err(|_| too_many("segments per strand", pieces, u16::MAX.into()))?;
        out.write_all(&pieces.to_le_bytes())?;
    }
    for point in &curves.points {
        write_floats(&point.position_ws.to_array(), out)?;
    }
    for point in &curves.points {
        write_floats(&[2.0 * point.radius_m], out)?;
    }
    for point in &curves.points {
        write_floats(&point.color.to_array(), out)?;
    }
    Ok(())
}
