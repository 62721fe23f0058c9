//! Cem Yuksel's binary hair format. A header of 128 bytes is followed by the arrays: segments of each strand, points,
//! thickness, transparency and colours. All arrays except the points are optional.

use super::source::{Source, points};
use crate::error::BakeError;
use crate::guides::Guides;
use glam::Vec3;

const HEADER_BYTES: u64 = 128;

/// Header bits, one per array: set if the file contains the array.
const PIECES: u32 = 1;
const POINTS: u32 = 2;
const THICKNESS: u32 = 4;
const TRANSPARENCY: u32 = 8;
const COLORS: u32 = 16;

/// A `.hair` file as stored, with all its strands and points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HairFile {
    /// Number of points of each strand, 1 or more.
    pub strands: Vec<u32>,
    /// Points of all strands, each strand from its root.
    pub points: Vec<Vec3>,
    /// Diameter at each point; empty if the file has none.
    pub thickness: Vec<f32>,
    /// Linear RGB of each point; empty if the file has none.
    pub colors: Vec<Vec3>,
}

impl HairFile {
    /// Reads a file; `file` is its name, for errors.
    ///
    /// Fails with [`BakeError::Input`] with the position in the file, the value found and the value expected.
    pub fn read(file: &str, bytes: &[u8]) -> Result<Self, BakeError> {
        read_whole(Source { file, bytes, is_strict: true })
    }

    /// Returns the range of each strand's points in [`HairFile::points`].
    pub fn ranges(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        self.strands.iter().scan(0, |end, points| {
            let first = *end;
            *end += *points as usize;
            Some(first..*end)
        })
    }
}

pub(super) fn read(source: Source<'_>) -> Result<Guides, BakeError> {
    let whole = read_whole(source)?;
    let mut guides = Guides::default();
    for range in whole.ranges() {
        let radii: Vec<f32> = whole.thickness.get(range.clone()).unwrap_or_default().iter().map(|t| 0.5 * t).collect();
        guides.push(&whole.points[range.clone()], &radii, whole.colors.get(range).unwrap_or_default());
    }
    Ok(guides)
}

fn read_whole(source: Source<'_>) -> Result<HairFile, BakeError> {
    let magic = source.slice(0, HEADER_BYTES, "the header")?;
    if &magic[..4] != b"HAIR" {
        let reason = format!("{:?}, expected \"HAIR\"", String::from_utf8_lossy(&magic[..4]));
        return Err(source.fault("byte 0".into(), reason));
    }
    let [strands, count, arrays, pieces] =
        [(4, "strands"), (8, "points"), (12, "arrays"), (16, "pieces")].map(|(at, what)| source.u32(at, what));
    let (strands, count, arrays, pieces) = (strands?, u64::from(count?), arrays?, pieces?);
    if arrays & POINTS == 0 {
        return Err(
            source.fault("byte 12".into(), format!("array flags are {arrays:#x}: no points, expected bit 1 to be set"))
        );
    }
    let mut at = HEADER_BYTES;
    let per_strand = match arrays & PIECES {
        0 => None,
        _ => {
            let bytes = source.slice(at, 2 * u64::from(strands), "segment counts of the strands")?;
            at += bytes.len() as u64;
            Some(bytes.chunks_exact(2).map(|b| u32::from(u16::from_le_bytes([b[0], b[1]]))).collect::<Vec<_>>())
        }
    };
    let sum = match &per_strand {
        Some(of) => of.iter().map(|pieces| u64::from(*pieces) + 1).sum(),
        None => u64::from(strands).saturating_mul(u64::from(pieces) + 1),
    };
    if sum != count {
        let reason = format!("{count} points, expected {sum}, the sum over all strands");
        return Err(source.fault("byte 8".into(), reason));
    }
    let places = points(&source.rows::<3>(at, count, 3, "points")?);
    at += 12 * count;
    let mut thickness = Vec::new();
    if arrays & THICKNESS != 0 {
        thickness = source.rows::<1>(at, count, 1, "thickness")?.into_iter().map(|[thick]| thick).collect();
        at += 4 * count;
    }
    if arrays & TRANSPARENCY != 0 {
        source.slice(at, 4 * count, "transparency")?;
        at += 4 * count;
    }
    let mut colors = Vec::new();
    if arrays & COLORS != 0 {
        colors = points(&source.rows::<3>(at, count, 3, "colours")?);
    }
    // Allocated only after the points are known to be present: a header may claim four billion strands.
    let strands = match per_strand {
        Some(of) => of.iter().map(|pieces| pieces + 1).collect(),
        None => vec![pieces.saturating_add(1); strands as usize],
    };
    Ok(HairFile { strands, points: places, thickness, colors })
}
