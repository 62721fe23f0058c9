//! Cem Yuksel's binary format: a header of 128 bytes, then pieces of each strand, points, thickness, transparency and colours, of which all but the
//! points may be missing.

use super::source::{Source, points};
use crate::error::BakeError;
use crate::guides::Guides;
use glam::Vec3;

const HEADER_BYTES: u64 = 128;

/// Bits of the arrays that a file has.
const PIECES: u32 = 1;
const POINTS: u32 = 2;
const THICKNESS: u32 = 4;
const TRANSPARENCY: u32 = 8;
const COLORS: u32 = 16;

pub(super) fn read(source: Source<'_>) -> Result<Guides, BakeError> {
    let magic = source.slice(0, HEADER_BYTES, "the header")?;
    if &magic[..4] != b"HAIR" {
        let reason = format!("{:?}, expected \"HAIR\"", String::from_utf8_lossy(&magic[..4]));
        return Err(source.fault("byte 0".into(), reason));
    }
    let [strands, count, arrays, pieces] =
        [(4, "strands"), (8, "points"), (12, "arrays"), (16, "pieces")].map(|(at, what)| source.u32(at, what));
    let (strands, count, arrays, pieces) = (strands?, u64::from(count?), arrays?, pieces?);
    if arrays & POINTS == 0 {
        return Err(source.fault("byte 12".into(), format!("arrays {arrays:#x} without points, expected bit 1")));
    }
    let mut at = HEADER_BYTES;
    let per_strand = match arrays & PIECES {
        0 => None,
        _ => {
            let bytes = source.slice(at, 2 * u64::from(strands), "pieces of the strands")?;
            at += bytes.len() as u64;
            Some(bytes.chunks_exact(2).map(|b| u64::from(u16::from_le_bytes([b[0], b[1]]))).collect::<Vec<_>>())
        }
    };
    let of = |strand: usize| 1 + per_strand.as_ref().map_or(u64::from(pieces), |of| of[strand]);
    let sum = match &per_strand {
        Some(of) => of.iter().map(|pieces| pieces + 1).sum(),
        None => u64::from(strands).saturating_mul(u64::from(pieces) + 1),
    };
    if sum != count {
        let reason = format!("{count} points, expected {sum}: those of all strands together");
        return Err(source.fault("byte 8".into(), reason));
    }
    let places = points(&source.rows::<3>(at, count, 3, "points")?);
    at += 12 * count;
    let mut radii = Vec::new();
    if arrays & THICKNESS != 0 {
        radii = source.rows::<1>(at, count, 1, "thickness")?.iter().map(|[thick]| 0.5 * thick).collect();
        at += 4 * count;
    }
    if arrays & TRANSPARENCY != 0 {
        source.slice(at, 4 * count, "transparency")?;
        at += 4 * count;
    }
    let mut colors = Vec::new();
    if arrays & COLORS != 0 {
        colors = source.rows::<3>(at, count, 3, "colours")?.into_iter().map(Vec3::from).collect();
    }
    let mut guides = Guides::default();
    let mut first = 0;
    for strand in 0..strands as usize {
        let range = first..first + of(strand) as usize;
        first = range.end;
        let part = |of: &[f32]| of.get(range.clone()).unwrap_or_default().to_vec();
        guides.push(&places[range.clone()], &part(&radii), colors.get(range.clone()).unwrap_or_default());
    }
    Ok(guides)
}
