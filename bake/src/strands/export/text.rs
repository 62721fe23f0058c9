//! Export of curves as text: a line `x y z radius` per point, metres in world space, root first. A blank line separates
//! strands.
//!
//! Groups are not named, because readers of this format, such as Mitsuba's `linearcurve`, reject all lines that are not
//! points. Strands are in the order of [`Curves::groups`].

use crate::strands::Curves;
use std::io::{self, Write};

/// Writes strands as text. Parsing the numbers gives the same bits.
///
/// Fails with errors of `out`.
pub fn write_text(curves: &Curves, out: &mut dyn Write) -> io::Result<()> {
    for strand in 0..curves.len() {
        if strand > 0 {
            writeln!(out)?;
        }
        for point in curves.strand(strand) {
            let p = point.position_ws;
            writeln!(out, "{} {} {} {}", p.x, p.y, p.z, point.radius_m)?;
        }
    }
    Ok(())
}
