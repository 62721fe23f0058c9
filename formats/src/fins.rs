//! The `FINS` section: quads of hair that stand on the edges of the mesh. Layout in `FORMAT.md`, "FINS".

use crate::container::Tag;
use crate::{FormatError, Limits};
use bytemuck::{Pod, Zeroable};
use std::fmt;

/// A quad that stands on an edge of the mesh, from the skin to the outermost layer (Lengyel 2001). 24 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Fin {
    /// The vertex where the edge begins.
    pub a: u32,
    /// The vertex where it ends; another one than `a`.
    pub b: u32,
    /// Coordinate u of the fin textures at `a`, 0..=1.
    pub start: f32,
    /// From `a` to `b` the coordinate u grows by this much; negative where the edge runs against the slab.
    pub length: f32,
    /// Which array layer of the fin textures it shows, less than [`crate::FinInfo::slabs`].
    pub slab: u32,
    /// Factor of the fin's opacity, 0..=1: less where fins stand close.
    pub opacity: f32,
}

/// Fins to be written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FinData {
    /// How many fins stand on each part of the manifest, in the order of the parts.
    pub part_counts: Vec<u32>,
    /// The fins, part after part.
    pub fins: Vec<Fin>,
}

/// Fins in an opened package: slices of the package's bytes, ready to upload.
#[derive(Clone, Copy)]
pub struct FinsView<'a> {
    /// Number of fins.
    pub count: u32,
    /// `count` [`Fin`], 24 bytes each, part after part.
    pub fins: &'a [u8],
    /// One little-endian u32 per part.
    part_counts: &'a [u8],
}

impl fmt::Debug for FinsView<'_> {
    /// Says how many, not each.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "FinsView({} fins)", self.count)
    }
}

const HEADER_BYTES: u64 = 16;

/// Offset of the first fin and the end, relative to the section.
fn layout(parts: u64, fins: u64) -> [u64; 2] {
    let first = (HEADER_BYTES + 4 * parts).next_multiple_of(16);
    [first, first + fins * size_of::<Fin>() as u64]
}

impl FinData {
    /// Bytes of the section. Fails where the counts of the parts do not add up, or a fin has a number out of its range.
    pub(crate) fn encode(&self) -> Result<Vec<u8>, FormatError> {
        let fail = |reason: &str| FormatError::Content { tag: Tag::FINS, offset: 0, reason: reason.into() };
        if self.fins.len() > u32::MAX as usize || self.part_counts.len() > u32::MAX as usize {
            return Err(fail("more than 2^32 fins or parts"));
        }
        let [first, end] = layout(self.part_counts.len() as u64, self.fins.len() as u64);
        let size = usize::try_from(end).map_err(|_| fail("more bytes than this machine can hold"))?;
        let mut out = Vec::with_capacity(size);
        out.extend_from_slice(&(self.fins.len() as u32).to_le_bytes());
        out.extend_from_slice(&(self.part_counts.len() as u32).to_le_bytes());
        out.extend_from_slice(&first.to_le_bytes());
        out.extend_from_slice(bytemuck::cast_slice(&self.part_counts));
        out.resize(first as usize, 0);
        out.extend_from_slice(bytemuck::cast_slice(&self.fins));
        FinsView::parse(&out, 0, &Limits { fins: u32::MAX, ..Limits::default() })?;
        Ok(out)
    }
}

impl<'a> FinsView<'a> {
    /// Reads the section that begins at `offset` of the package and checks every number in it by itself.
    pub(crate) fn parse(bytes: &'a [u8], offset: u64, limits: &Limits) -> Result<Self, FormatError> {
        let fail = |at: u64, reason: String| FormatError::Content { tag: Tag::FINS, offset: offset + at, reason };
        if (bytes.len() as u64) < HEADER_BYTES {
            let reason = format!("the section has {} bytes, expected a header of {HEADER_BYTES}", bytes.len());
            return Err(fail(0, reason));
        }
        let u32_at = |at: usize| bytemuck::pod_read_unaligned::<u32>(&bytes[at..at + 4]);
        let (count, parts) = (u32_at(0), u32_at(4));
        if count > limits.fins {
            let (found, limit) = (count.into(), limits.fins.into());
            return Err(FormatError::Limit { tag: Tag::FINS, what: "fin count", offset, found, limit });
        }
        let [first, end] = layout(parts.into(), count.into());
        let found = bytemuck::pod_read_unaligned::<u64>(&bytes[8..16]);
        if found != first {
            return Err(fail(8, format!("fin offset is {found}, expected {first} for {parts} parts")));
        }
        if bytes.len() as u64 != end {
            let reason = format!("the section has {} bytes, expected {end} for these counts", bytes.len());
            return Err(fail(0, reason));
        }
        let part_counts = &bytes[HEADER_BYTES as usize..HEADER_BYTES as usize + 4 * parts as usize];
        if let Some(at) = (HEADER_BYTES + part_counts.len() as u64..first).find(|at| bytes[*at as usize] != 0) {
            return Err(fail(at, format!("padding byte is {}, expected 0", bytes[at as usize])));
        }
        let view = Self { count, fins: &bytes[first as usize..], part_counts };
        let sum: u64 = view.part_counts().map(u64::from).sum();
        if sum != u64::from(count) {
            return Err(fail(HEADER_BYTES, format!("the parts have {sum} fins, expected the {count} of the section")));
        }
        let sound = |f: &Fin| {
            let unit = (0.0..=1.0).contains(&f.start) && (0.0..=1.0).contains(&f.opacity);
            f.a != f.b && unit && f.length.is_finite()
        };
        if let Some((i, fin)) = view.fins().enumerate().find(|(_, f)| !sound(f)) {
            let reason =
                format!("fin {i} is {fin:?}, expected two vertices, start and opacity 0..=1 and a finite length");
            return Err(fail(first + i as u64 * size_of::<Fin>() as u64, reason));
        }
        Ok(view)
    }

    /// How many fins stand on each part of the manifest.
    pub fn part_counts(&self) -> impl ExactSizeIterator<Item = u32> + 'a {
        self.part_counts.chunks_exact(4).map(bytemuck::pod_read_unaligned)
    }

    /// The fins, decoded.
    pub fn fins(&self) -> impl ExactSizeIterator<Item = Fin> + 'a {
        self.fins.chunks_exact(size_of::<Fin>()).map(bytemuck::pod_read_unaligned)
    }

    /// Where fin number `index` begins in the section.
    pub(crate) fn offset_of(&self, index: usize) -> u64 {
        layout(self.part_counts.len() as u64 / 4, 0)[0] + index as u64 * size_of::<Fin>() as u64
    }

    /// Copies everything out.
    pub fn to_data(&self) -> FinData {
        FinData { part_counts: self.part_counts().collect(), fins: self.fins().collect() }
    }
}
