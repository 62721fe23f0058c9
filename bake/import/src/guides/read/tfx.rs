//! TressFX: strands with equal numbers of points.
//!
//! * Version 3 has three numbers per point, and a 64-bit offset of the points at byte 144.
//! * Version 4 has four numbers per point, and a 32-bit offset at byte 12. The fourth number is 0 for points that do
//!   not move.

use super::source::{Source, points};
use crate::error::BakeError;
use crate::guides::Guides;

/// Maximum number of points of a strand in TressFX.
const MOST_POINTS: u32 = 64;

pub(super) fn read(source: Source<'_>) -> Result<Guides, BakeError> {
    let version = source.f32(0, "the version")?;
    let (strands, per_strand) = (source.u32(4, "strands")?, source.u32(8, "points per strand")?);
    if !(2..=MOST_POINTS).contains(&per_strand) {
        let reason = format!("{per_strand} points per strand, expected 2..={MOST_POINTS}");
        return Err(source.fault("byte 8".into(), reason));
    }
    let (offset, width) = match version {
        v if (3.0..4.0).contains(&v) => {
            let [low, high] = [144, 148].map(|at| source.u32(at, "offset of the points"));
            (u64::from(low?) | u64::from(high?) << 32, 3)
        }
        v if (4.0..5.0).contains(&v) => (u64::from(source.u32(12, "offset of the points")?), 4),
        _ => return Err(source.fault("byte 0".into(), format!("TressFX version is {version}, expected 3 or 4"))),
    };
    let count = u64::from(strands) * u64::from(per_strand);
    let places = points(&source.rows::<3>(offset, count, width, "points")?);
    let mut guides = Guides::default();
    places.chunks_exact(per_strand as usize).for_each(|strand| guides.push(strand, &[], &[]));
    Ok(guides)
}
