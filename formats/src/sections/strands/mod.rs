//! The `STRN` section: the strands of the tile, one by one. Layout in `FORMAT.md`, "STRN".

mod data;

pub use data::{StoredStrandPoint, StoredStrands, StrandPoint, StrandScale, StrandsData, strand_root};

use super::kind::Kind;
use crate::error::FormatError;
use crate::limits::Limits;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
use std::fmt;

impl Tag {
    /// Strands of the tile, since version 3. At most one.
    pub const STRANDS: Self = Self(*b"STRN");
}

pub(crate) const KIND: Kind =
    Kind::optional(Tag::STRANDS, 3, "[strands of the tile](#strn-strands-of-the-tile)", |package, _| {
        package.strands().map(drop)
    });

impl<'a> Package<'a> {
    /// Returns the strands of the tile; `None` if the package has none. Every number is checked once.
    ///
    /// Fails if the section is damaged, or is inconsistent with the manifest's fur.
    pub fn strands(&self) -> Result<Option<StrandsView<'a>>, FormatError> {
        let Some((index, section)) = self.find(Tag::STRANDS, 0) else { return Ok(None) };
        let header = self.cached(index, || {
            let view = StrandsView::parse(self.section_bytes(index)?, section.offset, self.limits())?;
            let fail = |at: u64, reason: String| {
                let offset = section.offset + at;
                Err(FormatError::Content { tag: Tag::STRANDS, offset, reason })
            };
            let fur = &self.manifest().fur;
            if fur.layers == 0 {
                return fail(0, "strands of a package without fur, expected none".into());
            }
            let expected = if fur.wet.is_some() { 2 } else { 1 };
            if view.header.sets != expected {
                let reason = format!(
                    "{} sets of points, expected {expected} because of the manifest's \
                         fur.wet",
                    view.header.sets
                );
                return fail(8, reason);
            }
            Ok(view.header)
        })?;
        Ok(Some(StrandsView::of(self.section_bytes(index)?, header)))
    }
}

impl PackageWriter<'_> {
    /// Adds the strands of the tile.
    pub fn strands(self, strands: &StrandsData) -> Self {
        let stored = set_count(strands.roots.len(), strands.points_per_strand, strands.points.len())
            .and_then(|_| StoredStrands::of(strands).map_err(fault));
        self.encoded(Tag::STRANDS, stored.and_then(|stored| encode(&stored)))
    }

    /// Adds the strands of the tile, given as integers of the section.
    pub fn stored_strands(self, strands: &StoredStrands) -> Self {
        self.encoded(Tag::STRANDS, encode(strands))
    }
}

/// Strands in an opened package: slices of the package's bytes.
#[derive(Clone, Copy)]
pub struct StrandsView<'a> {
    header: Header,
    roots: &'a [u8],
    points: &'a [u8],
}

impl fmt::Debug for StrandsView<'_> {
    /// Formats the header only.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "StrandsView({:?})", self.header)
    }
}

const HEADER_BYTES: u64 = 32;
const ROOT_BYTES: u64 = 4;
const POINT_BYTES: u64 = 16;
/// Maximum number of points of a strand.
const MOST_POINTS: u32 = 33;

/// Header, which determines the layout and scale of the section.
#[derive(Clone, Copy, Debug)]
struct Header {
    strands: u32,
    points: u32,
    sets: u32,
    scale: StrandScale,
}

/// Returns the offset of the first point and the end, relative to the section.
fn layout(header: Header) -> [u64; 2] {
    let [strands, points, sets] = [header.strands, header.points, header.sets].map(u64::from);
    let first = (HEADER_BYTES + ROOT_BYTES * strands).next_multiple_of(16);
    [first, first + POINT_BYTES * strands * points * sets]
}

/// Returns an error for strands to be written.
fn fault(reason: String) -> FormatError {
    FormatError::Content { tag: Tag::STRANDS, offset: 0, reason }
}

/// Returns the number of sets of points: 1, or 2 with wet strands. Fails if the counts are inconsistent.
fn set_count(strands: usize, per_strand: u32, points: usize) -> Result<u32, FormatError> {
    match strands.checked_mul(per_strand as usize) {
        Some(of_set) if of_set > 0 && points == of_set => Ok(1),
        Some(of_set) if of_set > 0 && points / 2 == of_set && points.is_multiple_of(2) => Ok(2),
        _ => Err(fault(format!(
            "{points} points for {strands} strands of {per_strand} points, expected one set or \
             two"
        ))),
    }
}

/// Returns the bytes of the section. Fails if counts are inconsistent, or a number is out of range.
fn encode(data: &StoredStrands) -> Result<Vec<u8>, FormatError> {
    let header = Header {
        strands: u32::try_from(data.roots.len()).map_err(|_| fault("more than 2^32 strands".into()))?,
        points: data.points_per_strand,
        sets: set_count(data.roots.len(), data.points_per_strand, data.points.len())?,
        scale: data.scale,
    };
    let [first, end] = layout(header);
    let mut out =
        Vec::with_capacity(usize::try_from(end).map_err(|_| fault("more than this machine can hold".into()))?);
    out.extend([header.strands, header.points, header.sets, 0].into_iter().flat_map(u32::to_le_bytes));
    out.extend([header.scale.reach, header.scale.radius, 0.0, 0.0].into_iter().flat_map(f32::to_le_bytes));
    out.extend(data.roots.iter().flatten().flat_map(|x| x.to_le_bytes()));
    out.resize(first as usize, 0);
    for point in &data.points {
        out.extend(point.aside.into_iter().flat_map(i16::to_le_bytes));
        out.extend([point.height, point.radius].into_iter().flat_map(u16::to_le_bytes));
        out.extend(point.color);
        out.push(0);
        out.extend(point.visibility);
    }
    StrandsView::parse(&out, 0, &Limits::NONE)?;
    Ok(out)
}

impl<'a> StrandsView<'a> {
    /// Reads the section at `offset` of the package and checks every number in it, independently of other sections.
    fn parse(bytes: &'a [u8], offset: u64, limits: &Limits) -> Result<Self, FormatError> {
        let fail = |at: u64, reason: String| FormatError::Content { tag: Tag::STRANDS, offset: offset + at, reason };
        if (bytes.len() as u64) < HEADER_BYTES {
            let reason = format!("the section has {} bytes, expected a header of {HEADER_BYTES}", bytes.len());
            return Err(fail(0, reason));
        }
        let words: [u32; 8] = bytemuck::pod_read_unaligned(&bytes[..HEADER_BYTES as usize]);
        let [strands, points, sets, reserved, reach, radius, more @ ..] = words;
        let scale = StrandScale { reach: f32::from_bits(reach), radius: f32::from_bits(radius) };
        let header = Header { strands, points, sets, scale };
        if strands == 0 || !(2..=MOST_POINTS).contains(&points) || !(1..=2).contains(&sets) {
            let reason = format!(
                "{sets} sets of {strands} strands of {points} points, expected 1 or 2 sets of 1 or more strands of \
                 2..={MOST_POINTS} points"
            );
            return Err(fail(0, reason));
        }
        if strands > limits.strands {
            let (found, limit) = (strands.into(), limits.strands.into());
            return Err(FormatError::Limit { tag: Tag::STRANDS, what: "strand count", offset, found, limit });
        }
        if let Some(at) = [reserved, more[0], more[1]].iter().position(|word| *word != 0) {
            return Err(fail([12, 24, 28][at], "a reserved number is not 0, expected 0".into()));
        }
        for (at, name, found) in [(16, "reach", scale.reach), (20, "radius", scale.radius)] {
            if !(found > 0.0 && found.is_finite()) {
                return Err(fail(at, format!("{name} is {found}, expected a finite number above 0")));
            }
        }
        let [first, end] = layout(header);
        if bytes.len() as u64 != end {
            let reason = format!("the section has {} bytes, expected {end} for these counts", bytes.len());
            return Err(fail(0, reason));
        }
        let after_roots = HEADER_BYTES + ROOT_BYTES * u64::from(strands);
        if let Some(at) = (after_roots..first).find(|at| bytes[*at as usize] != 0) {
            return Err(fail(at, format!("padding byte is {}, expected 0", bytes[at as usize])));
        }
        let view = Self::of(bytes, header);
        if let Some(at) = view.points.chunks_exact(POINT_BYTES as usize).position(|point| point[11] != 0) {
            return Err(fail(first + POINT_BYTES * at as u64 + 11, format!("point {at}: the reserved byte is not 0")));
        }
        Ok(view)
    }

    /// Returns the strands of a section with the given header; its length must match it.
    fn of(bytes: &'a [u8], header: Header) -> Self {
        let first = layout(header)[0] as usize;
        let roots = &bytes[HEADER_BYTES as usize..(HEADER_BYTES + ROOT_BYTES * u64::from(header.strands)) as usize];
        Self { header, roots, points: &bytes[first..] }
    }

    /// Returns the number of strands.
    pub fn strand_count(&self) -> u32 {
        self.header.strands
    }

    /// Returns the number of points of each strand.
    pub fn points_per_strand(&self) -> u32 {
        self.header.points
    }

    /// Whether a second set of points describes the strands when wet.
    pub fn has_wet(&self) -> bool {
        self.header.sets == 2
    }

    /// Returns the offset along u or v that the largest integer of a point represents, widths of the tile.
    pub fn reach(&self) -> f32 {
        self.header.scale.reach
    }

    /// Returns the radius that the largest integer of a point represents, widths of the tile.
    pub fn radius(&self) -> f32 {
        self.header.scale.radius
    }

    /// Returns the stored points, 16 bytes each, ready to upload.
    pub fn point_bytes(&self) -> &'a [u8] {
        self.points
    }

    /// Returns the positions of the roots in the tile, 0..1.
    pub fn roots(&self) -> impl ExactSizeIterator<Item = [f32; 2]> + 'a {
        self.stored_roots().map(strand_root)
    }

    /// Decodes all points: those of each strand, root first; then those of the wet strands.
    pub fn points(&self) -> impl ExactSizeIterator<Item = StrandPoint> + 'a {
        let scale = self.header.scale;
        self.stored_points().map(move |point| point.decoded(scale))
    }

    /// Returns the contents as the integers of the section.
    pub fn stored(&self) -> StoredStrands {
        StoredStrands {
            points_per_strand: self.header.points,
            scale: self.header.scale,
            roots: self.stored_roots().collect(),
            points: self.stored_points().collect(),
        }
    }

    fn stored_roots(&self) -> impl ExactSizeIterator<Item = [u16; 2]> + 'a {
        self.roots.chunks_exact(ROOT_BYTES as usize).map(bytemuck::pod_read_unaligned)
    }

    fn stored_points(&self) -> impl ExactSizeIterator<Item = StoredStrandPoint> + 'a {
        self.points.chunks_exact(POINT_BYTES as usize).map(|bytes| {
            let [height, radius] = bytemuck::pod_read_unaligned(&bytes[4..8]);
            StoredStrandPoint {
                aside: bytemuck::pod_read_unaligned(&bytes[..4]),
                height,
                radius,
                color: [bytes[8], bytes[9], bytes[10]],
                visibility: [bytes[12], bytes[13], bytes[14], bytes[15]],
            }
        })
    }
}
