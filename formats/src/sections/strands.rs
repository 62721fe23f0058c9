//! The `STRN` section: the strands of the tile, one by one. Layout in `FORMAT.md`, "STRN".

use super::kind::{Count, Kind, Row, USES_NOTHING};
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

pub(crate) const KIND: Kind = Kind {
    tag: Tag::STRANDS,
    since: 3,
    count: Count::AtMostOne,
    check: |package, _| package.strands().map(drop),
    check_use: USES_NOTHING,
    row: Row { what: "[strands of the tile](#strn-strands-of-the-tile)", how_many: "at most one", place: "any" },
};

impl<'a> Package<'a> {
    /// The strands of the tile; `None` for a package without. Every number is checked once.
    ///
    /// Fails where the section is damaged, or does not fit the manifest's fur.
    pub fn strands(&self) -> Result<Option<StrandsView<'a>>, FormatError> {
        let Some((index, section)) = self.find(Tag::STRANDS, 0) else { return Ok(None) };
        let header = self.keep(index, || {
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
                let reason =
                    format!("{} sets of points, expected {expected}: the manifest's fur.wet", view.header.sets);
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
        self.encoded(Tag::STRANDS, encode(strands))
    }
}

/// A point of a strand as a package stores it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StrandPoint {
    /// Way from the root along u and v, widths of the tile.
    pub aside: [f32; 2],
    /// Share of the fur's height, 0..=1.
    pub height: f32,
    /// Widths of the tile.
    pub radius: f32,
    /// sRGB, times the skin's colour at the root.
    pub color: [u8; 3],
    /// How much light reaches it, as in a texel of [`crate::VisibilityInfo`].
    pub visibility: [u8; 4],
}

/// Strands to be written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StrandsData {
    /// Points of each strand, 2..=33, equally far from each other along it.
    pub points_per_strand: u32,
    /// Place of each root in the tile, 0..1. The first few are an even sample of all, however many.
    pub roots: Vec<[f32; 2]>,
    /// Of each strand, root first; then those of the same strands when they are wet, where dry and wet hair mix.
    pub points: Vec<StrandPoint>,
}

/// Strands in an opened package: slices of the package's bytes.
#[derive(Clone, Copy)]
pub struct StrandsView<'a> {
    header: Header,
    roots: &'a [u8],
    points: &'a [u8],
}

impl fmt::Debug for StrandsView<'_> {
    /// Says how many, not each.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "StrandsView({:?})", self.header)
    }
}

const HEADER_BYTES: u64 = 32;
const ROOT_BYTES: u64 = 4;
const POINT_BYTES: u64 = 16;
/// Most points of a strand.
const MOST_POINTS: u32 = 33;

/// What the layout and the numbers of the section follow from.
#[derive(Clone, Copy, Debug)]
struct Header {
    strands: u32,
    points: u32,
    sets: u32,
    /// Way along u or v that the largest number stands for, widths of the tile.
    reach: f32,
    /// Radius that the largest number stands for, widths of the tile.
    radius: f32,
}

/// Offsets of the first point, and the end, relative to the section.
fn layout(header: Header) -> [u64; 2] {
    let [strands, points, sets] = [header.strands, header.points, header.sets].map(u64::from);
    let first = (HEADER_BYTES + ROOT_BYTES * strands).next_multiple_of(16);
    [first, first + POINT_BYTES * strands * points * sets]
}

/// Bytes of the section. Fails where counts do not fit each other, or a number is out of its range.
fn encode(data: &StrandsData) -> Result<Vec<u8>, FormatError> {
    let fail = |reason: String| FormatError::Content { tag: Tag::STRANDS, offset: 0, reason };
    let (strands, per_strand) = (data.roots.len(), data.points_per_strand as usize);
    let of_set = strands * per_strand;
    if of_set == 0 || data.points.len() != of_set && data.points.len() != 2 * of_set {
        let reason =
            format!("{} points for {strands} strands of {per_strand}, expected one set or two", data.points.len());
        return Err(fail(reason));
    }
    let sane = data.points.iter().all(|p| {
        p.aside.iter().all(|x| x.is_finite())
            && (0.0..=1.0).contains(&p.height)
            && p.radius.is_finite()
            && p.radius >= 0.0
    });
    if !sane || !data.roots.iter().flatten().all(|x| (0.0..1.0).contains(x)) {
        return Err(fail("a root outside the tile, or a point that is not finite or outside the fur".into()));
    }
    let most = |of: &dyn Fn(&StrandPoint) -> f32| data.points.iter().map(of).fold(0.0, f32::max);
    let header = Header {
        strands: u32::try_from(strands).map_err(|_| fail("more than 2^32 strands".into()))?,
        points: data.points_per_strand,
        sets: (data.points.len() / of_set) as u32,
        reach: most(&|p| p.aside[0].abs().max(p.aside[1].abs())).max(f32::MIN_POSITIVE),
        radius: most(&|p| p.radius).max(f32::MIN_POSITIVE),
    };
    let [first, end] = layout(header);
    let mut out = Vec::with_capacity(usize::try_from(end).map_err(|_| fail("more than this machine can hold".into()))?);
    out.extend([header.strands, header.points, header.sets, 0].into_iter().flat_map(u32::to_le_bytes));
    out.extend([header.reach, header.radius, 0.0, 0.0].into_iter().flat_map(f32::to_le_bytes));
    let unorm = |x: f32| (x * 65535.0 + 0.5) as u16;
    let root = |x: &f32| ((x * 65536.0) as u32).min(65535) as u16;
    out.extend(data.roots.iter().flatten().map(root).flat_map(u16::to_le_bytes));
    out.resize(first as usize, 0);
    for point in &data.points {
        let aside = point.aside.map(|x| (x / header.reach * 32767.0).round() as i16);
        out.extend(aside.into_iter().flat_map(i16::to_le_bytes));
        out.extend([unorm(point.height), unorm(point.radius / header.radius)].into_iter().flat_map(u16::to_le_bytes));
        out.extend(point.color);
        out.push(0);
        out.extend(point.visibility);
    }
    StrandsView::parse(&out, 0, &Limits::NONE)?;
    Ok(out)
}

impl<'a> StrandsView<'a> {
    /// Reads the section that begins at `offset` of the package and checks every number in it by itself.
    fn parse(bytes: &'a [u8], offset: u64, limits: &Limits) -> Result<Self, FormatError> {
        let fail = |at: u64, reason: String| FormatError::Content { tag: Tag::STRANDS, offset: offset + at, reason };
        if (bytes.len() as u64) < HEADER_BYTES {
            let reason = format!("the section has {} bytes, expected a header of {HEADER_BYTES}", bytes.len());
            return Err(fail(0, reason));
        }
        let words: [u32; 8] = bytemuck::pod_read_unaligned(&bytes[..HEADER_BYTES as usize]);
        let [strands, points, sets, reserved, reach, radius, more @ ..] = words;
        let header = Header { strands, points, sets, reach: f32::from_bits(reach), radius: f32::from_bits(radius) };
        if strands == 0 || !(2..=MOST_POINTS).contains(&points) || !(1..=2).contains(&sets) {
            let reason = format!(
                "{sets} sets of {strands} strands of {points} points, expected one or two of 1 or more of 2..={MOST_POINTS}"
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
        for (at, name, found) in [(16, "reach", header.reach), (20, "radius", header.radius)] {
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

    /// The strands of a section of that header, which is as long as it asks for.
    fn of(bytes: &'a [u8], header: Header) -> Self {
        let first = layout(header)[0] as usize;
        let roots = &bytes[HEADER_BYTES as usize..(HEADER_BYTES + ROOT_BYTES * u64::from(header.strands)) as usize];
        Self { header, roots, points: &bytes[first..] }
    }

    /// Number of strands.
    pub fn strand_count(&self) -> u32 {
        self.header.strands
    }

    /// Points of each strand.
    pub fn points_per_strand(&self) -> u32 {
        self.header.points
    }

    /// Whether the same strands follow as they are when wet.
    pub fn has_wet(&self) -> bool {
        self.header.sets == 2
    }

    /// Way along u or v that the largest number of a point stands for, widths of the tile.
    pub fn reach(&self) -> f32 {
        self.header.reach
    }

    /// Radius that the largest number of a point stands for, widths of the tile.
    pub fn radius(&self) -> f32 {
        self.header.radius
    }

    /// Points as they are stored, 16 bytes each, ready to upload.
    pub fn point_bytes(&self) -> &'a [u8] {
        self.points
    }

    /// Places of the roots in the tile, 0..1.
    pub fn roots(&self) -> impl ExactSizeIterator<Item = [f32; 2]> + 'a {
        self.roots.chunks_exact(ROOT_BYTES as usize).map(|bytes| {
            let [u, v]: [u16; 2] = bytemuck::pod_read_unaligned(bytes);
            // The middle of what the number stands for.
            [u, v].map(|x| (f32::from(x) + 0.5) / 65536.0)
        })
    }

    /// All points, decoded: of each strand, root first; then of the wet ones.
    pub fn points(&self) -> impl ExactSizeIterator<Item = StrandPoint> + 'a {
        let Header { reach, radius, .. } = self.header;
        self.points.chunks_exact(POINT_BYTES as usize).map(move |bytes| {
            let [u, v]: [i16; 2] = bytemuck::pod_read_unaligned(&bytes[..4]);
            let [height, thickness]: [u16; 2] = bytemuck::pod_read_unaligned(&bytes[4..8]);
            StrandPoint {
                aside: [u, v].map(|x| f32::from(x.max(-32767)) / 32767.0 * reach),
                height: f32::from(height) / 65535.0,
                radius: f32::from(thickness) / 65535.0 * radius,
                color: [bytes[8], bytes[9], bytes[10]],
                visibility: [bytes[12], bytes[13], bytes[14], bytes[15]],
            }
        })
    }
}
