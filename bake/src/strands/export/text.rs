//! Export of curves as text: a line `x y z radius` per point, metres in world space, root first; a blank line between
//! strands.
//!
//! Groups are not named, because readers of this form, such as Mitsuba's `linearcurve`, reject every line that is not a
//! point. Their strands are in the order of [`Curves::groups`].

use crate::strands::Curves;
use std::io::{self, Write};

/// Writes strands as text. Numbers read back to the same bits.
///
/// # Errors
/// Errors of `out`.
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
