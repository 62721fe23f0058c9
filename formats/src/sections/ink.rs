//! The `INKW` section: data for drawing a package as an ink-wash painting (Fang 2006). Layout in `FORMAT.md`, "INKW".

use super::kind::{Kind, faults};
use super::textures::TextureView;
use crate::encoding::{decode_section, encode_section};
use crate::error::FormatError;
use crate::limits::Limits;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::RangeInclusive;

impl Tag {
    /// The ink style, since version 3. At most one.
    pub const INK: Self = Self(*b"INKW");
}

pub(crate) const KIND: Kind = Kind {
    check_use: |package| faults([package.ink_textures().err()]),
    ..Kind::optional(Tag::INK, 3, "[the ink style](#inkw-the-ink-style)", |package, _| package.ink().map(drop))
};

impl<'a> Package<'a> {
    /// Returns the ink style; `None` if the package has none. Every vertex is checked once; the result is cached.
    ///
    /// Fails if the section is damaged, or its vertex count is not that of the mesh.
    pub fn ink(&self) -> Result<Option<InkView<'a>>, FormatError> {
        let Some((index, section)) = self.find(Tag::INK, 0) else { return Ok(None) };
        let (info, first) = self.cached(index, || {
            let bytes = self.section_bytes(index)?;
            let view = InkView::parse(bytes, section.offset, self.limits())?;
            let (found, expected) = (view.vertices().len(), self.mesh()?.map_or(0, |mesh| mesh.vertex_count));
            if found != expected as usize {
                let reason = format!("{found} vertices, expected the {expected} of the mesh");
                return Err(FormatError::Content { tag: Tag::INK, offset: section.offset, reason });
            }
            let first = bytes.len() - view.vertices.len();
            Ok((view.info, first))
        })?;
        Ok(Some(InkView { info, vertices: &self.section_bytes(index)?[first..] }))
    }

    /// Returns the textures of the ink style; `None` if the package has none.
    ///
    /// Fails if a texture is damaged, or its layers, components or colour space are inconsistent with
    /// [`crate::InkInfo`].
    pub fn ink_textures(&self) -> Result<Option<InkTextures<'a>>, FormatError> {
        let Some(ink) = self.ink()? else { return Ok(None) };
        let read = |what: &str, index: u32, layers: u32| {
            let view = self.image_texture(index)?;
            if view.layers != layers || view.format.components() != 4 || view.format.is_srgb() {
                let reason = format!(
                    "has format {} and layer count {}, expected four components, not sRGB, and layer count {layers} \
                     for {what} of the ink style",
                    view.format.name(),
                    view.layers
                );
                return Err(self.texture_fault(index, &reason));
            }
            Ok(view)
        };
        Ok(Some(InkTextures {
            stroke: read("stroke", ink.info.stroke_texture, 1)?,
            wash: read("wash", ink.info.wash_texture, 1)?,
            paper: read("paper", ink.info.paper_texture, 1)?,
            fur: ink.info.fur_texture.map(|index| read("fur", index, 2)).transpose()?,
        }))
    }
}

/// Textures of the ink style, see [`Package::ink_textures`] and [`InkInfo`].
#[derive(Clone, Copy, Debug)]
pub struct InkTextures<'a> {
    /// Stroke texture, which is used as a sphere map.
    pub stroke: TextureView<'a>,
    /// Wash, a tile on the surface.
    pub wash: TextureView<'a>,
    /// Paper, a tile.
    pub paper: TextureView<'a>,
    /// Strokes of fur in the hair's tile, if the package has fur.
    pub fur: Option<TextureView<'a>>,
}

impl PackageWriter<'_> {
    /// Adds the ink style.
    pub fn ink(self, ink: &InkData) -> Self {
        self.encoded(Tag::INK, ink.encode())
    }
}

/// Textures and constants of the ink style.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct InkInfo {
    /// Index into the manifest's `textures`: the stroke. One layer, four components, not sRGB. It is looked up by the
    /// normal in the frame perpendicular to the view, so that the rim of the unit disc is the outline. Red is the grey
    /// value of the stroke, from 0 for black to 1 for no ink. Green is the same stroke drawn with a dry brush. Blue
    /// varies its width (mean 0.5).
    pub stroke_texture: u32,
    /// Index into `textures`: a periodic tile on the surface. One layer, four components, not sRGB. Red is the grain of
    /// the wash, green its blotches, blue the pressure of lines (each with mean 0.5). Alpha is a threshold for dry
    /// brushes, with a uniform histogram.
    pub wash_texture: u32,
    /// Index into `textures`: a periodic tile of the paper. One layer, four components, not sRGB. Red is the relief of
    /// the paper's fibres, green its absorption (each with mean 0.5), blue its tone (1 for clean paper). Alpha is a
    /// threshold with a uniform histogram.
    pub paper_texture: u32,
    /// Index into `textures`: strokes of fur in the hair's tile. Two array layers, four components, not sRGB. The first
    /// layer is seen from above and periodic in both directions; the second is seen from the side, like the fin
    /// textures. Each component is the ink at one density, from few strokes in red to all strokes in alpha. Ink in one
    /// component is also in the next.
    pub fur_texture: Option<u32>,
    /// Period of the wash texture on the surface, metres, above 0.
    pub grain_size_m: f32,
    /// Style constants.
    pub shading: InkShading,
}

/// Constants of the ink style of a model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct InkShading {
    /// Parameter a of Fang 2006, §3, finite (default 0.8): how fast the wash fades from its centre.
    pub wash_speed: f32,
    /// Parameter b of Fang 2006, §3, finite (default 0.66): grey value at the centre, 0 for black to 1 for white.
    pub wash_range: f32,
    /// Whether the wash depends only on the angle between normal and direction from the centre, instead of on the
    /// published product (default false). `InkVertex::wash` defines both.
    pub normalised: bool,
    /// Weight of the wash texture in the wash, 0..=1 (default 0.5).
    pub grain: f32,
    /// Share of the base colour's darkness that is added to the wash, 0..=1 (default 0.6).
    pub tone: f32,
    /// Strength of the fur's strokes, 0..=1 (default 1).
    pub fur: f32,
    /// Factor on the width of lines, 0..=4 (default 1).
    pub line: f32,
}

impl Default for InkShading {
    fn default() -> Self {
        Self { wash_speed: 0.8, wash_range: 0.66, normalised: false, grain: 0.5, tone: 0.6, fur: 1.0, line: 1.0 }
    }
}

impl InkShading {
    /// Range of the factor `line`.
    pub const LINE: RangeInclusive<f32> = 0.0..=4.0;

    /// Checks every number; returns the field, what was found and what was expected.
    ///
    /// Fails with the first number that is out of its range.
    pub fn check(&self) -> Result<(), String> {
        for (what, value) in [("wash_speed", self.wash_speed), ("wash_range", self.wash_range)] {
            if !value.is_finite() {
                return Err(format!("{what} is {value}, expected a finite number"));
            }
        }
        for (what, value, range) in [
            ("grain", self.grain, 0.0..=1.0),
            ("tone", self.tone, 0.0..=1.0),
            ("fur", self.fur, 0.0..=1.0),
            ("line", self.line, Self::LINE),
        ] {
            // NaN is outside every range.
            if !range.contains(&value) {
                return Err(format!("{what} is {value}, expected {}..={}", range.start(), range.end()));
            }
        }
        Ok(())
    }
}

/// Data of the ink style for a vertex, in the order of the mesh's vertices. 8 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct InkVertex {
    /// The two terms of the wash of Fang 2006, §3, at rest, in units of 1/32767; each −32767..=32767. The first is half
    /// of ((V − CP)·N)/ρ, where ρ is the radius of the manifest's bounds. The second is ((V − CP)/|V − CP|)·N. V is the
    /// vertex, N its unit normal, and CP the centre of the wash.
    pub wash: [i16; 2],
    /// Share of the wash that is applied, in units of 1/255; with 0, the paper is left blank.
    pub amount: u8,
    /// Share of full ink that is applied, in units of 1/255.
    pub solid: u8,
    /// Factor on the width of lines, in units of 1/255.
    pub line: u8,
    /// Reserved, 0.
    pub reserved: u8,
}

/// Ink style of a package to be written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InkData {
    /// Textures and constants.
    pub info: InkInfo,
    /// Vertex data, one per vertex of the mesh.
    pub vertices: Vec<InkVertex>,
}

/// Ink style of an opened package; vertices are a slice of the package's bytes, ready to upload.
#[derive(Clone)]
pub struct InkView<'a> {
    /// Textures and constants.
    pub info: InkInfo,
    /// [`InkVertex`] of each vertex of the mesh, 8 bytes each.
    pub vertices: &'a [u8],
}

impl fmt::Debug for InkView<'_> {
    /// Formats the constants and the number of vertices.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "InkView({:?}, {} vertices)", self.info, self.vertices.len() / size_of::<InkVertex>())
    }
}

const HEADER_BYTES: u64 = 16;

/// Returns the offset of the first vertex, relative to the section.
fn first_vertex(info_bytes: u64) -> u64 {
    (HEADER_BYTES + info_bytes).next_multiple_of(16)
}

impl InkData {
    /// Returns the bytes of the section.
    fn encode(&self) -> Result<Vec<u8>, FormatError> {
        let fail = |reason: &str| FormatError::Content { tag: Tag::INK, offset: 0, reason: reason.into() };
        let info = encode_section(Tag::INK, &self.info)?;
        let count = u32::try_from(self.vertices.len()).map_err(|_| fail("more than 2^32 vertices"))?;
        let first = first_vertex(info.len() as u64);
        let mut out = Vec::new();
        out.extend_from_slice(&count.to_le_bytes());
        out.extend_from_slice(&(info.len() as u32).to_le_bytes());
        out.extend_from_slice(&first.to_le_bytes());
        out.extend_from_slice(&info);
        out.resize(first as usize, 0);
        out.extend_from_slice(bytemuck::cast_slice(&self.vertices));
        InkView::parse(&out, 0, &Limits { vertices: u32::MAX, ..Limits::default() })?;
        Ok(out)
    }
}

impl<'a> InkView<'a> {
    /// Reads the section at `offset` of the package and checks every number in it, independently of other sections.
    fn parse(bytes: &'a [u8], offset: u64, limits: &Limits) -> Result<Self, FormatError> {
        let fail = |at: u64, reason: String| FormatError::Content { tag: Tag::INK, offset: offset + at, reason };
        if (bytes.len() as u64) < HEADER_BYTES {
            let reason = format!("the section has {} bytes, expected a header of {HEADER_BYTES}", bytes.len());
            return Err(fail(0, reason));
        }
        let u32_at = |at: usize| bytemuck::pod_read_unaligned::<u32>(&bytes[at..at + 4]);
        let (count, info_bytes) = (u32_at(0), u32_at(4));
        if count > limits.vertices {
            let (found, limit) = (count.into(), limits.vertices.into());
            return Err(FormatError::Limit { tag: Tag::INK, what: "vertex count", offset, found, limit });
        }
        let first = first_vertex(info_bytes.into());
        let found = bytemuck::pod_read_unaligned::<u64>(&bytes[8..16]);
        if found != first {
            return Err(fail(8, format!("vertex offset is {found}, expected {first} after {info_bytes} bytes")));
        }
        let end = first + u64::from(count) * size_of::<InkVertex>() as u64;
        if bytes.len() as u64 != end {
            let reason = format!("the section has {} bytes, expected {end} for these counts", bytes.len());
            return Err(fail(0, reason));
        }
        let info_end = HEADER_BYTES + u64::from(info_bytes);
        let info: InkInfo =
            decode_section(Tag::INK, offset + HEADER_BYTES, &bytes[HEADER_BYTES as usize..info_end as usize])?;
        if let Some(at) = (info_end..first).find(|at| bytes[*at as usize] != 0) {
            return Err(fail(at, format!("padding byte is {}, expected 0", bytes[at as usize])));
        }
        info.shading.check().map_err(|reason| fail(HEADER_BYTES, format!("shading.{reason}")))?;
        if !(info.grain_size_m > 0.0 && info.grain_size_m.is_finite()) {
            let reason = format!("grain_size_m is {}, expected a finite number above 0", info.grain_size_m);
            return Err(fail(HEADER_BYTES, reason));
        }
        let view = Self { info, vertices: &bytes[first as usize..] };
        let sound = |v: &InkVertex| v.reserved == 0 && v.wash.iter().all(|w| *w > i16::MIN);
        if let Some((i, vertex)) = view.vertices().enumerate().find(|(_, v)| !sound(v)) {
            let reason = format!("vertex {i} is {vertex:?}, expected wash -32767..=32767 and reserved 0");
            return Err(fail(first + i as u64 * size_of::<InkVertex>() as u64, reason));
        }
        Ok(view)
    }

    /// Decodes the vertices.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = InkVertex> + 'a {
        self.vertices.chunks_exact(size_of::<InkVertex>()).map(bytemuck::pod_read_unaligned)
    }

    /// Copies the data out of the package.
    pub fn to_data(&self) -> InkData {
        InkData { info: self.info.clone(), vertices: self.vertices().collect() }
    }
}
