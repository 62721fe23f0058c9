//! The `SIMP` section: index lists with fewer triangles over the mesh's vertices. Layout in `FORMAT.md`, "SIMP".

use super::kind::Kind;
use crate::error::FormatError;
use crate::limits::Limits;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
use std::fmt;

impl Tag {
    /// Simplified index lists, since version 3. At most one.
    pub const SIMPLIFIED: Self = Self(*b"SIMP");
}

pub(crate) const KIND: Kind =
    Kind::optional(Tag::SIMPLIFIED, 3, "[fewer triangles](#simp-fewer-triangles)", |package, _| {
        package.simplified().map(drop)
    });

impl<'a> Package<'a> {
    /// Returns the simplified index lists; `None` if the package has none. Every index is checked once; the result is
    /// cached.
    ///
    /// Fails if the section is damaged, or is inconsistent with the manifest's parts or the mesh's vertices.
    pub fn simplified(&self) -> Result<Option<SimplifiedView<'a>>, FormatError> {
        let Some((index, section)) = self.find(Tag::SIMPLIFIED, 0) else { return Ok(None) };
        let counts = self.cached(index, || {
            let view = SimplifiedView::parse(self.section_bytes(index)?, section.offset, self.limits())?;
            self.check_simplified(&view, section.offset)?;
            Ok(view.counts())
        })?;
        Ok(Some(SimplifiedView::of(self.section_bytes(index)?, counts)))
    }

    /// Checks valid lists against manifest and mesh.
    fn check_simplified(&self, view: &SimplifiedView<'_>, offset: u64) -> Result<(), FormatError> {
        let fail = |at: u64, reason| FormatError::Content { tag: Tag::SIMPLIFIED, offset: offset + at, reason };
        let parts = &self.manifest().parts;
        let (found, expected) = (view.part_count as usize, parts.len());
        if found != expected {
            return Err(fail(
                4,
                format!("lists of {found} parts, expected {expected}, the part count of the manifest"),
            ));
        }
        for level in 0..view.level_count as usize {
            let more = view.part_counts(level).zip(parts).position(|(found, part)| found > part.index_count);
            if let Some(part) = more {
                let reason = format!("part {part} of list {level} has more indices than that part of the mesh");
                return Err(fail(HEADER_BYTES, reason));
            }
        }
        let vertices = self.mesh()?.map_or(0, |mesh| mesh.vertex_count);
        if let Some(at) = view.indices().position(|index| index >= vertices) {
            let reason = format!("index {at} is out of range, expected less than {vertices}, the vertex count");
            let first = layout(view.counts())[1];
            return Err(fail(first + 4 * at as u64, reason));
        }
        Ok(())
    }
}

impl PackageWriter<'_> {
    /// Adds simplified index lists.
    pub fn simplified(self, levels: &[SimplifiedLevel]) -> Self {
        self.encoded(Tag::SIMPLIFIED, encode(levels))
    }
}

/// Index list with fewer triangles, to be written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SimplifiedLevel {
    /// Maximum deviation of surface and outermost layer from the mesh, metres; above 0, and more than in the previous
    /// list.
    pub deviation_m: f32,
    /// Number of indices in each part of the manifest, multiples of 3, in the order of the parts.
    pub part_counts: Vec<u32>,
    /// Vertex indices, three per triangle, part after part.
    pub indices: Vec<u32>,
}

/// Index lists in an opened package: slices of the package's bytes, ready to upload.
#[derive(Clone, Copy)]
pub struct SimplifiedView<'a> {
    /// Number of lists.
    pub level_count: u32,
    /// Number of parts.
    pub part_count: u32,
    /// Vertex indices, little-endian u32; list after list, each part after part.
    pub indices: &'a [u8],
    deviations: &'a [u8],
    part_counts: &'a [u8],
}

impl fmt::Debug for SimplifiedView<'_> {
    /// Formats the counts only.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SimplifiedView({} lists, {} indices)", self.level_count, self.indices.len() / 4)
    }
}

const HEADER_BYTES: u64 = 16;

/// Maximum number of lists in a package; each has fewer triangles than the one before.
const MOST_LEVELS: u32 = 64;

/// Counts that determine the layout of the section.
#[derive(Clone, Copy)]
struct Counts {
    levels: u32,
    parts: u32,
    indices: u32,
}

/// Returns the offsets of the part counts and of the first index, and the end, relative to the section.
fn layout(counts: Counts) -> [u64; 3] {
    let [levels, parts, indices] = [counts.levels, counts.parts, counts.indices].map(u64::from);
    let of_parts = HEADER_BYTES + 4 * levels;
    let first = (of_parts + 4 * levels * parts).next_multiple_of(16);
    [of_parts, first, first + 4 * indices]
}

fn numbers(bytes: &[u8]) -> impl ExactSizeIterator<Item = u32> {
    bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned)
}

/// Returns the bytes of the section. Fails if the counts do not add up, or a number is out of range.
fn encode(levels: &[SimplifiedLevel]) -> Result<Vec<u8>, FormatError> {
    let fail = |reason: &str| FormatError::Content { tag: Tag::SIMPLIFIED, offset: 0, reason: reason.into() };
    let count = |n: usize| u32::try_from(n).map_err(|_| fail("more than 2^32 lists, parts or indices"));
    let parts = levels.first().map_or(0, |level| level.part_counts.len());
    if levels.iter().any(|level| level.part_counts.len() != parts) {
        return Err(fail("lists with different numbers of parts"));
    }
    let indices = count(levels.iter().map(|level| level.indices.len()).sum())?;
    let counts = Counts { levels: count(levels.len())?, parts: count(parts)?, indices };
    let [_, first, end] = layout(counts);
    let mut out = Vec::with_capacity(usize::try_from(end).map_err(|_| fail("more bytes than this machine can hold"))?);
    out.extend([counts.levels, counts.parts, counts.indices, 0].into_iter().flat_map(u32::to_le_bytes));
    out.extend(levels.iter().flat_map(|level| level.deviation_m.to_le_bytes()));
    out.extend(levels.iter().flat_map(|level| &level.part_counts).flat_map(|n| n.to_le_bytes()));
    out.resize(first as usize, 0);
    levels.iter().for_each(|level| out.extend_from_slice(bytemuck::cast_slice(&level.indices)));
    SimplifiedView::parse(&out, 0, &Limits::NONE)?;
    Ok(out)
}

impl<'a> SimplifiedView<'a> {
    /// Reads the section at `offset` of the package and checks every number in it, independently of other sections.
    fn parse(bytes: &'a [u8], offset: u64, limits: &Limits) -> Result<Self, FormatError> {
        let fail = |at: u64, reason: String| FormatError::Content { tag: Tag::SIMPLIFIED, offset: offset + at, reason };
        if (bytes.len() as u64) < HEADER_BYTES {
            let reason = format!("the section has {} bytes, expected a header of {HEADER_BYTES}", bytes.len());
            return Err(fail(0, reason));
        }
        let header: [u32; 4] = bytemuck::pod_read_unaligned(&bytes[..HEADER_BYTES as usize]);
        let [levels, parts, indices, reserved] = header;
        if indices > limits.indices {
            let (found, limit) = (indices.into(), limits.indices.into());
            return Err(FormatError::Limit { tag: Tag::SIMPLIFIED, what: "index count", offset, found, limit });
        }
        if !(1..=MOST_LEVELS).contains(&levels) {
            return Err(fail(0, format!("{levels} lists, expected 1..={MOST_LEVELS}")));
        }
        if reserved != 0 {
            return Err(fail(12, format!("the reserved number is {reserved}, expected 0")));
        }
        let counts = Counts { levels, parts, indices };
        let [of_parts, first, end] = layout(counts);
        if bytes.len() as u64 != end {
            let reason = format!("the section has {} bytes, expected {end} for these counts", bytes.len());
            return Err(fail(0, reason));
        }
        let view = Self::of(bytes, counts);
        if let Some(at) = (of_parts + view.part_counts.len() as u64..first).find(|at| bytes[*at as usize] != 0) {
            return Err(fail(at, format!("padding byte is {}, expected 0", bytes[at as usize])));
        }
        let mut least = 0.0;
        for (level, deviation) in view.deviations().enumerate() {
            // The condition is written so that NaN fails.
            if !(deviation > least && deviation.is_finite()) {
                let reason = format!("deviation {level} is {deviation}, expected a finite number above {least}");
                return Err(fail(HEADER_BYTES + 4 * level as u64, reason));
            }
            least = deviation;
        }
        if let Some(at) = numbers(view.part_counts).position(|n| n % 3 != 0) {
            return Err(fail(of_parts + 4 * at as u64, format!("index count {at} is not a multiple of 3")));
        }
        let sum: u64 = numbers(view.part_counts).map(u64::from).sum();
        if sum != u64::from(indices) {
            let reason = format!("the lists have {sum} indices, expected {indices}, the index count of the section");
            return Err(fail(of_parts, reason));
        }
        Ok(view)
    }

    /// Returns the lists of a section with the given counts; its length must match them.
    fn of(bytes: &'a [u8], counts: Counts) -> Self {
        let [of_parts, first, end] = layout(counts).map(|at| at as usize);
        let part_counts = &bytes[of_parts..of_parts + 4 * counts.levels as usize * counts.parts as usize];
        Self {
            level_count: counts.levels,
            part_count: counts.parts,
            indices: &bytes[first..end],
            deviations: &bytes[HEADER_BYTES as usize..of_parts],
            part_counts,
        }
    }

    fn counts(&self) -> Counts {
        Counts { levels: self.level_count, parts: self.part_count, indices: (self.indices.len() / 4) as u32 }
    }

    /// Returns [`SimplifiedLevel::deviation_m`] of each list.
    pub fn deviations(&self) -> impl ExactSizeIterator<Item = f32> + 'a {
        self.deviations.chunks_exact(4).map(bytemuck::pod_read_unaligned)
    }

    /// Returns the number of indices in each part, for list number `level`, less than `level_count`.
    pub fn part_counts(&self, level: usize) -> impl ExactSizeIterator<Item = u32> + 'a {
        let bytes = 4 * self.part_count as usize;
        numbers(&self.part_counts[level * bytes..(level + 1) * bytes])
    }

    /// Decodes all indices.
    pub fn indices(&self) -> impl ExactSizeIterator<Item = u32> + 'a {
        numbers(self.indices)
    }
}
