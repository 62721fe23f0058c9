//! The `FINS` section: quads of hair on the edges of the mesh. Layout in `FORMAT.md`, "FINS".

use super::kind::{Count, Kind, Row, faults};
use super::textures::FurTextures;
use crate::error::FormatError;
use crate::limits::Limits;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
use bytemuck::{Pod, Zeroable};
use std::fmt;

impl Tag {
    /// Fins, since version 2. At most one.
    pub const FINS: Self = Self(*b"FINS");
}

pub(crate) const KIND: Kind = Kind {
    tag: Tag::FINS,
    since: 2,
    count: Count::AtMostOne,
    check: |package, _| package.fins().map(drop),
    check_use: |package| faults([package.fin_textures().err()]),
    row: Row {
        what: "[fins](#fins-hair-on-the-edges)",
        how_many: "one if the manifest's fur has fins, else none",
        place: "any",
    },
};

impl<'a> Package<'a> {
    /// Returns the fins; `None` if the package has none. Every fin is checked once; the result is cached.
    ///
    /// Fails in these cases: the package has only one of fins and fin textures; the number of parts is not that of the
    /// manifest; a fin refers to a missing vertex or to a missing array layer (slab) of the fin textures.
    pub fn fins(&self) -> Result<Option<FinsView<'a>>, FormatError> {
        let (info, (index, section)) = match (&self.manifest().fur.fins, self.find(Tag::FINS, 0)) {
            (None, None) => return Ok(None),
            (Some(info), Some(found)) => (info, found),
            (Some(_), None) => {
                let reason = "the manifest's fur.fins has textures for them".into();
                return Err(FormatError::MissingSection { tag: Tag::FINS, index: 0, reason });
            }
            (None, Some((_, section))) => {
                let reason = "found fins, expected none because the manifest has no fur.fins".into();
                return Err(FormatError::Content { tag: Tag::FINS, offset: section.offset, reason });
            }
        };
        let counts = self.cached(index, || {
            let view = FinsView::parse(self.section_bytes(index)?, section.offset, self.limits())?;
            self.check_fins(&view, info.slabs, section.offset)?;
            Ok(view.counts())
        })?;
        Ok(Some(FinsView::of(self.section_bytes(index)?, counts)))
    }

    /// Checks valid fins against manifest and mesh.
    fn check_fins(&self, view: &FinsView<'_>, slabs: u32, offset: u64) -> Result<(), FormatError> {
        let fail = |at: u64, reason| FormatError::Content { tag: Tag::FINS, offset: offset + at, reason };
        let (found, parts) = (view.part_counts().len(), self.manifest().parts.len());
        if found != parts {
            return Err(fail(4, format!("fins of {found} parts, expected {parts}, the part count of the manifest")));
        }
        let vertices = self.mesh()?.map_or(0, |mesh| mesh.vertex_count);
        let stands = |f: &Fin| f.a < vertices && f.b < vertices && f.slab < slabs;
        if let Some((i, fin)) = view.fins().enumerate().find(|(_, f)| !stands(f)) {
            let reason = format!(
                "fin {i} is {fin:?}, expected vertices less than {vertices} and a slab less than \
                 {slabs}"
            );
            return Err(fail(view.offset_of(i), reason));
        }
        Ok(())
    }

    /// Returns the two fin textures; `None` if the package has no fins.
    ///
    /// Fails if a texture is damaged or inconsistent with [`crate::FinInfo`]. It must have `slabs` array layers of
    /// `width` by `height` texels. Colour needs four components; directions need a format that is not sRGB.
    pub fn fin_textures(&self) -> Result<Option<FurTextures<'a>>, FormatError> {
        let Some(fins) = &self.manifest().fur.fins else { return Ok(None) };
        let size = (fins.width, fins.height, fins.slabs);
        self.hair_textures("fur.fins", size, fins.color_texture, fins.direction_texture).map(Some)
    }
}

impl PackageWriter<'_> {
    /// Adds the fins.
    pub fn fins(self, fins: &FinData) -> Self {
        self.encoded(Tag::FINS, fins.encode())
    }
}

/// Quad on an edge of the mesh, from the surface to the outermost layer (Lengyel 2001). 24 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Fin {
    /// Vertex at which the edge begins.
    pub a: u32,
    /// Vertex at which the edge ends; not equal to `a`.
    pub b: u32,
    /// Coordinate u of the fin textures at `a`, 0..=1.
    pub start: f32,
    /// Increase of the coordinate u from `a` to `b`. Negative if the edge runs against the direction of u in the fin's
    /// array layer.
    pub length: f32,
    /// Array layer of the fin textures, less than [`crate::FinInfo::slabs`]. Each layer is a slab: a slice through the
    /// tile.
    pub slab: u32,
    /// Factor on the fin's opacity, 0..=1; smaller where fins are dense.
    pub opacity: f32,
}

/// Fins to be written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FinData {
    /// Number of fins on each part of the manifest, in the order of the parts.
    pub part_counts: Vec<u32>,
    /// Fins, part after part.
    pub fins: Vec<Fin>,
}

/// Fins in an opened package: slices of the package's bytes, ready to upload.
#[derive(Clone, Copy)]
pub struct FinsView<'a> {
    /// Number of fins.
    pub count: u32,
    /// `count` [`Fin`], 24 bytes each, part after part.
    pub fins: &'a [u8],
    /// Number of fins on each part, little-endian u32.
    part_counts: &'a [u8],
}

impl fmt::Debug for FinsView<'_> {
    /// Formats the number of fins.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "FinsView({} fins)", self.count)
    }
}

const HEADER_BYTES: u64 = 16;

/// Counts that determine the layout of the section.
#[derive(Clone, Copy)]
struct Counts {
    parts: u32,
    fins: u32,
}

/// Returns the offset of the first fin, and the end of the section, relative to its start.
fn layout(parts: u64, fins: u64) -> [u64; 2] {
    let first = (HEADER_BYTES + 4 * parts).next_multiple_of(16);
    [first, first + fins * size_of::<Fin>() as u64]
}

impl FinData {
    /// Returns the bytes of the section. Fails if the counts of the parts do not add up, or a fin has a number out of
    /// range.
    fn encode(&self) -> Result<Vec<u8>, FormatError> {
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
    /// Reads the section at `offset` of the package and checks every number in it, independently of other sections.
    fn parse(bytes: &'a [u8], offset: u64, limits: &Limits) -> Result<Self, FormatError> {
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
        let view = Self::of(bytes, Counts { parts, fins: count });
        if let Some(at) = (HEADER_BYTES + view.part_counts.len() as u64..first).find(|at| bytes[*at as usize] != 0) {
            return Err(fail(at, format!("padding byte is {}, expected 0", bytes[at as usize])));
        }
        let sum: u64 = view.part_counts().map(u64::from).sum();
        if sum != u64::from(count) {
            return Err(fail(
                HEADER_BYTES,
                format!(
                    "the parts have {sum} fins, expected {count}, the fin count of the \
                 section"
                ),
            ));
        }
        let sound = |f: &Fin| {
            let unit = (0.0..=1.0).contains(&f.start) && (0.0..=1.0).contains(&f.opacity);
            f.a != f.b && unit && f.length.is_finite()
        };
        if let Some((i, fin)) = view.fins().enumerate().find(|(_, f)| !sound(f)) {
            let reason = format!(
                "fin {i} is {fin:?}, expected two different vertices, start and opacity 0..=1 and a finite \
                     length"
            );
            return Err(fail(first + i as u64 * size_of::<Fin>() as u64, reason));
        }
        Ok(view)
    }

    /// Returns the view of a section with the given counts; its length must match them.
    fn of(bytes: &'a [u8], counts: Counts) -> Self {
        let [first, end] = layout(counts.parts.into(), counts.fins.into());
        Self {
            count: counts.fins,
            fins: &bytes[first as usize..end as usize],
            part_counts: &bytes[HEADER_BYTES as usize..HEADER_BYTES as usize + 4 * counts.parts as usize],
        }
    }

    fn counts(&self) -> Counts {
        Counts { parts: self.part_counts().len() as u32, fins: self.count }
    }

    /// Returns the number of fins on each part of the manifest.
    pub fn part_counts(&self) -> impl ExactSizeIterator<Item = u32> + 'a {
        self.part_counts.chunks_exact(4).map(bytemuck::pod_read_unaligned)
    }

    /// Decodes the fins.
    pub fn fins(&self) -> impl ExactSizeIterator<Item = Fin> + 'a {
        self.fins.chunks_exact(size_of::<Fin>()).map(bytemuck::pod_read_unaligned)
    }

    fn offset_of(&self, index: usize) -> u64 {
        layout(self.part_counts.len() as u64 / 4, 0)[0] + index as u64 * size_of::<Fin>() as u64
    }

    /// Copies the data out of the package.
    pub fn to_data(&self) -> FinData {
        FinData { part_counts: self.part_counts().collect(), fins: self.fins().collect() }
    }
}
