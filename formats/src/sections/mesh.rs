//! The `MESH` section: vertex streams and indices in GPU layout. Layout in `FORMAT.md`, "MESH".

use super::kind::{Count, Kind, Row, USES_NOTHING};
use crate::container::FORMAT_VERSION;
use crate::error::FormatError;
use crate::limits::Limits;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
use bytemuck::{Pod, Zeroable};
use std::fmt;

impl Tag {
    /// Vertex and index data, ready to upload. At most one.
    pub const MESH: Self = Self(*b"MESH");
}

pub(crate) const KIND: Kind = Kind {
    tag: Tag::MESH,
    since: 1,
    count: Count::AtMostOne,
    check: |package, _| package.mesh().map(drop),
    check_use: USES_NOTHING,
    row: Row {
        what: "[vertices and indices](#mesh-vertices-and-indices)",
        how_many: "at most one; one if the manifest has parts",
        place: "any",
    },
};

impl<'a> Package<'a> {
    /// Returns the mesh; `None` if the package has none. Every vertex and index is checked once; the result is cached.
    ///
    /// Fails if the manifest's parts do not cover the index buffer, or if only one of joint weights and skeleton is
    /// present.
    pub fn mesh(&self) -> Result<Option<MeshView<'a>>, FormatError> {
        let Some((index, section)) = self.find(Tag::MESH, 0) else {
            let parts = self.manifest().parts.len();
            if parts == 0 {
                return Ok(None);
            }
            let reason = format!("the manifest lists parts of the mesh: {parts}, expected 0 without a mesh");
            return Err(FormatError::MissingSection { tag: Tag::MESH, index: 0, reason });
        };
        let counts = self.cached(index, || {
            let view = MeshView::parse(self.section_bytes(index)?, section.offset, self.version(), self.limits())?;
            self.check_mesh(&view, section.offset)?;
            Ok(view.counts())
        })?;
        Ok(Some(MeshView::of(self.section_bytes(index)?, counts)))
    }

    /// Checks a valid mesh against manifest and skeleton.
    fn check_mesh(&self, view: &MeshView<'_>, offset: u64) -> Result<(), FormatError> {
        let fail = |reason| FormatError::Content { tag: Tag::MESH, offset, reason };
        let covered: u64 = self.manifest().parts.iter().map(|p| u64::from(p.index_count)).sum();
        if covered != u64::from(view.index_count) {
            let n = view.index_count;
            return Err(fail(format!("{n} indices, expected the {covered} that the manifest's parts cover")));
        }
        let joints = self.skeleton()?.map_or(0, |a| a.joints.len());
        if view.skin.is_empty() {
            if joints > 0 && view.vertex_count > 0 {
                return Err(fail(format!(
                    "vertices have no joints, expected joints and weights because the skeleton has {joints} joints"
                )));
            }
        } else {
            let top = view.skin().flat_map(|v| v.joints).map(usize::from).max().unwrap_or(0);
            if top >= joints {
                return Err(fail(format!("a vertex follows joint {top}, expected less than the {joints} joints")));
            }
        }
        Ok(())
    }

    /// Fails if the mesh is damaged or has nothing to draw.
    pub(crate) fn triangles(&self) -> Result<(), FormatError> {
        let offset = self.find(Tag::MESH, 0).map_or(0, |(_, section)| section.offset);
        match self.mesh()? {
            None => {
                let reason = "there is nothing to draw".into();
                Err(FormatError::MissingSection { tag: Tag::MESH, index: 0, reason })
            }
            Some(mesh) if mesh.index_count == 0 => {
                let reason = "no triangles, expected at least one to draw".into();
                Err(FormatError::Content { tag: Tag::MESH, offset, reason })
            }
            Some(_) => Ok(()),
        }
    }
}

impl PackageWriter<'_> {
    /// Adds the mesh.
    pub fn mesh(self, mesh: &MeshData) -> Self {
        self.encoded(Tag::MESH, mesh.encode())
    }
}

/// First vertex stream: attributes that posing changes. 48 bytes.
///
/// Positions and directions are in mesh space if the package has a skeleton, else in world space at rest.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct GeometryVertex {
    /// Position, metres when posed.
    pub position: [f32; 3],
    /// Height of the outermost layer above the surface in the posed state, metres; 0 where the surface is bare.
    pub fur_height: f32,
    /// Outward unit normal.
    pub normal: [f32; 3],
    /// Lean of the hair beyond that of the tile's strands, 0..=1. The outermost layer is shifted along the bitangent by
    /// `lean * fur_height`. A layer at the share h of the fur's height is shifted by h² times as much. 0 in packages of
    /// version 1.
    pub lean: f32,
    /// Tangent and handedness. The first three components are the unit tangent along +u of the tile. The fourth is the
    /// handedness ±1: bitangent (along +v) = handedness · normal × tangent. Readers check that all numbers are finite,
    /// but not that vectors have unit length or that the handedness is ±1.
    pub tangent: [f32; 4],
}

/// Second vertex stream: attributes that posing does not change. 24 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct AttributeVertex {
    /// Coordinates in the hair tile; 1 is one tile, and the texture repeats.
    pub tile_uv: [f32; 2],
    /// Texture coordinates of the model, for the base colour.
    pub base_uv: [f32; 2],
    /// Vertex colour, linear RGBA, 0..=255 for 0..=1.
    pub color: [u8; 4],
    /// Bareness and wetness, followed by 0, 0; 0..=255 for 0..=1. With bareness 1, a vertex has no hair. With wetness
    /// 1, its hair uses only the wet textures. All 0 in packages of version 1.
    pub groom: [u8; 4],
}

/// Third vertex stream, present in packages with a skeleton. 24 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SkinVertex {
    /// Indices into [`crate::Animation::joints`].
    pub joints: [u16; 4],
    /// Weights, each 0..=1, summing to 1.
    pub weights: [f32; 4],
}

/// Mesh to be written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// First vertex stream, one entry per vertex.
    pub geometry: Vec<GeometryVertex>,
    /// Second vertex stream, one entry per vertex.
    pub attributes: Vec<AttributeVertex>,
    /// Third vertex stream, one entry per vertex; empty for a mesh without skeleton.
    pub skin: Vec<SkinVertex>,
    /// Indices, three per triangle, counter-clockwise seen from outside.
    pub indices: Vec<u32>,
}

/// Mesh in an opened package: slices of the package's bytes, ready to upload.
#[derive(Clone, Copy)]
pub struct MeshView<'a> {
    /// Number of vertices.
    pub vertex_count: u32,
    /// Number of indices, a multiple of 3.
    pub index_count: u32,
    /// `vertex_count` [`GeometryVertex`], 48 bytes each.
    pub geometry: &'a [u8],
    /// `vertex_count` [`AttributeVertex`], 24 bytes each.
    pub attributes: &'a [u8],
    /// `vertex_count` [`SkinVertex`], 24 bytes each, or empty.
    pub skin: &'a [u8],
    /// `index_count` little-endian u32.
    pub indices: &'a [u8],
}

impl MeshView<'_> {
    /// Returns the size of all vertices and indices, bytes.
    pub fn bytes(&self) -> u64 {
        (self.geometry.len() + self.attributes.len() + self.skin.len() + self.indices.len()) as u64
    }
}

impl fmt::Debug for MeshView<'_> {
    /// Formats the counts only.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { vertex_count, index_count, .. } = self;
        let skin = if self.skin.is_empty() { "no skin" } else { "skin" };
        write!(f, "MeshView({vertex_count} vertices, {index_count} indices, {skin})")
    }
}

const HEADER_BYTES: u64 = 64;
const FLAG_SKIN: u32 = 1;

/// Counts that determine the layout of a mesh.
#[derive(Clone, Copy)]
struct Counts {
    vertices: u32,
    indices: u32,
    skinned: bool,
}

/// Returns the offsets of the four streams and the end of the last one, relative to the section. The file does not
/// store them, because the counts determine them.
fn layout(vertices: u64, indices: u64, skinned: bool) -> [u64; 5] {
    let align = |offset: u64| offset.next_multiple_of(16);
    let geometry = HEADER_BYTES;
    let attributes = align(geometry + vertices * size_of::<GeometryVertex>() as u64);
    let skin = align(attributes + vertices * size_of::<AttributeVertex>() as u64);
    let skin_bytes = if skinned { vertices * size_of::<SkinVertex>() as u64 } else { 0 };
    let index = align(skin + skin_bytes);
    [geometry, attributes, skin, index, index + indices * 4]
}

// Number of meshes that this thread has read and checked.
#[cfg(test)]
thread_local! {
    pub(crate) static CHECKED: std::cell::Cell<u32> = const { std::cell::Cell::new(0) };
}

impl MeshData {
    /// Returns the bytes of the section. Fails if the streams differ in length or an index is out of range.
    fn encode(&self) -> Result<Vec<u8>, FormatError> {
        let fail = |reason: String| FormatError::Content { tag: Tag::MESH, offset: 0, reason };
        let vertices = self.geometry.len();
        let skinned = !self.skin.is_empty();
        if self.attributes.len() != vertices || (skinned && self.skin.len() != vertices) {
            return Err(fail(format!(
                "{vertices} positions, {} attributes, {} skin entries: expected one of each per vertex",
                self.attributes.len(),
                self.skin.len()
            )));
        }
        if vertices > u32::MAX as usize || self.indices.len() > u32::MAX as usize {
            return Err(fail("more than 2^32 vertices or indices".into()));
        }
        let [geometry, attributes, skin, index, end] = layout(vertices as u64, self.indices.len() as u64, skinned);
        let size = usize::try_from(end).map_err(|_| fail(format!("{end} bytes, more than this machine can hold")))?;
        let mut out = vec![0u8; size];
        out[0..4].copy_from_slice(&(vertices as u32).to_le_bytes());
        out[4..8].copy_from_slice(&(self.indices.len() as u32).to_le_bytes());
        out[8..12].copy_from_slice(&(if skinned { FLAG_SKIN } else { 0 }).to_le_bytes());
        for (slot, offset) in [(16, geometry), (24, attributes), (32, skin), (40, index)] {
            out[slot..slot + 8].copy_from_slice(&offset.to_le_bytes());
        }
        let mut put = |offset: u64, bytes: &[u8]| {
            out[offset as usize..offset as usize + bytes.len()].copy_from_slice(bytes);
        };
        put(geometry, bytemuck::cast_slice(&self.geometry));
        put(attributes, bytemuck::cast_slice(&self.attributes));
        put(skin, bytemuck::cast_slice(&self.skin));
        put(index, bytemuck::cast_slice(&self.indices));
        let limits = Limits { vertices: u32::MAX, indices: u32::MAX, ..Limits::default() };
        MeshView::parse(&out, 0, FORMAT_VERSION, &limits)?;
        Ok(out)
    }
}

impl<'a> MeshView<'a> {
    /// Reads the section at `offset` of a package of format version `version`. Checks every index and number in it.
    fn parse(bytes: &'a [u8], offset: u64, version: u32, limits: &Limits) -> Result<Self, FormatError> {
        #[cfg(test)]
        CHECKED.with(|checked| checked.set(checked.get() + 1));
        let fail = |at: u64, reason: String| FormatError::Content { tag: Tag::MESH, offset: offset + at, reason };
        if (bytes.len() as u64) < HEADER_BYTES {
            let reason = format!("the section has {} bytes, expected a header of {HEADER_BYTES}", bytes.len());
            return Err(fail(0, reason));
        }
        let u32_at = |at: usize| bytemuck::pod_read_unaligned::<u32>(&bytes[at..at + 4]);
        let u64_at = |at: usize| bytemuck::pod_read_unaligned::<u64>(&bytes[at..at + 8]);
        let (vertex_count, index_count, flags) = (u32_at(0), u32_at(4), u32_at(8));
        for (what, at, found, limit) in
            [("vertex count", 0, vertex_count, limits.vertices), ("index count", 4, index_count, limits.indices)]
        {
            if found > limit {
                let (found, limit) = (found.into(), limit.into());
                return Err(FormatError::Limit { tag: Tag::MESH, what, offset: offset + at, found, limit });
            }
        }
        if flags & !FLAG_SKIN != 0 {
            return Err(fail(8, format!("flags are {flags:#x}, expected only bit 0 (skin)")));
        }
        if index_count % 3 != 0 {
            return Err(fail(4, format!("{index_count} indices, expected a multiple of 3")));
        }
        let skinned = flags & FLAG_SKIN != 0;
        let ends = layout(vertex_count.into(), index_count.into(), skinned);
        for (slot, expected) in [(16, ends[0]), (24, ends[1]), (32, ends[2]), (40, ends[3])] {
            let found = u64_at(slot);
            if found != expected {
                let reason = format!("stream offset is {found}, expected {expected} for these counts");
                return Err(fail(slot as u64, reason));
            }
        }
        for at in (12..16).chain(48..64) {
            if bytes[at] != 0 {
                return Err(fail(at as u64, format!("reserved byte is {}, expected 0", bytes[at])));
            }
        }
        let [geometry, attributes, skin, index, end] = ends;
        if bytes.len() as u64 != end {
            let reason = format!("the section has {} bytes, expected {end} for these counts", bytes.len());
            return Err(fail(0, reason));
        }
        let view = Self::of(bytes, Counts { vertices: vertex_count, indices: index_count, skinned });
        let used = |from: u64, part: &[u8]| from + part.len() as u64;
        for (from, to) in [
            (used(geometry, view.geometry), attributes),
            (used(attributes, view.attributes), skin),
            (used(skin, view.skin), index),
        ] {
            if let Some(at) = (from..to).find(|at| bytes[*at as usize] != 0) {
                return Err(fail(at, format!("padding byte is {}, expected 0", bytes[at as usize])));
            }
        }
        view.check(version, |reason, at| fail(at, reason), [geometry, attributes, skin, index])?;
        Ok(view)
    }

    /// Returns the streams of a section with the given counts. The section must be long enough for them.
    fn of(bytes: &'a [u8], counts: Counts) -> Self {
        let Counts { vertices, indices, skinned } = counts;
        let [geometry, attributes, skin, index, _] = layout(vertices.into(), indices.into(), skinned);
        let stream =
            |from: u64, count: u32, stride: usize| &bytes[from as usize..from as usize + count as usize * stride];
        Self {
            vertex_count: vertices,
            index_count: indices,
            geometry: stream(geometry, vertices, size_of::<GeometryVertex>()),
            attributes: stream(attributes, vertices, size_of::<AttributeVertex>()),
            skin: stream(skin, if skinned { vertices } else { 0 }, size_of::<SkinVertex>()),
            indices: stream(index, indices, 4),
        }
    }

    fn counts(&self) -> Counts {
        Counts { vertices: self.vertex_count, indices: self.index_count, skinned: !self.skin.is_empty() }
    }

    fn check(
        &self,
        version: u32,
        fail: impl Fn(String, u64) -> FormatError,
        [geometry, attributes, skin, index]: [u64; 4],
    ) -> Result<(), FormatError> {
        let finite = |values: &[f32]| values.iter().all(|v| v.is_finite());
        for (i, v) in self.geometry().enumerate() {
            let at = geometry + i as u64 * size_of::<GeometryVertex>() as u64;
            let numbers = finite(&v.position) && finite(&v.normal) && finite(&v.tangent);
            // Fields that are reserved in version 1 must be 0 there, to the bit.
            let lean = if version == 1 { v.lean.to_bits() == 0 } else { (0.0..=1.0).contains(&v.lean) };
            if !numbers || !v.fur_height.is_finite() || v.fur_height < 0.0 || !lean {
                let lean = if version == 1 { "0 in version 1" } else { "0..=1" };
                let reason = format!("vertex {i} is {v:?}, expected finite numbers, fur_height >= 0 and lean {lean}");
                return Err(fail(reason, at));
            }
        }
        for (i, v) in self.attributes().enumerate() {
            let (used, spare) = v.groom.split_at(if version == 1 { 0 } else { 2 });
            if !finite(&v.tile_uv) || !finite(&v.base_uv) || spare.iter().any(|b| *b != 0) {
                let at = attributes + i as u64 * size_of::<AttributeVertex>() as u64;
                let n = used.len();
                let reason = format!(
                    "vertex {i} is {v:?}, expected finite numbers and a groom of 0 after its first \
                     {n} bytes"
                );
                return Err(fail(reason, at));
            }
        }
        for (i, v) in self.skin().enumerate() {
            let sum: f32 = v.weights.iter().sum();
            if !v.weights.iter().all(|w| (0.0..=1.0).contains(w)) || (sum - 1.0).abs() > 1e-3 {
                let at = skin + i as u64 * size_of::<SkinVertex>() as u64;
                return Err(fail(
                    format!("weights of vertex {i} are {:?}, expected 0..=1 summing to 1", v.weights),
                    at,
                ));
            }
        }
        for (i, v) in self.indices().enumerate() {
            if v >= self.vertex_count {
                let reason = format!("index {i} is {v}, expected less than the {} vertices", self.vertex_count);
                return Err(fail(reason, index + i as u64 * 4));
            }
        }
        Ok(())
    }

    /// Decodes the first vertex stream.
    pub fn geometry(&self) -> impl ExactSizeIterator<Item = GeometryVertex> + 'a {
        self.geometry.chunks_exact(size_of::<GeometryVertex>()).map(bytemuck::pod_read_unaligned)
    }

    /// Decodes the second vertex stream.
    pub fn attributes(&self) -> impl ExactSizeIterator<Item = AttributeVertex> + 'a {
        self.attributes.chunks_exact(size_of::<AttributeVertex>()).map(bytemuck::pod_read_unaligned)
    }

    /// Decodes the third vertex stream; empty for a mesh without skeleton.
    pub fn skin(&self) -> impl ExactSizeIterator<Item = SkinVertex> + 'a {
        self.skin.chunks_exact(size_of::<SkinVertex>()).map(bytemuck::pod_read_unaligned)
    }

    /// Decodes the indices.
    pub fn indices(&self) -> impl ExactSizeIterator<Item = u32> + 'a {
        self.indices.chunks_exact(4).map(bytemuck::pod_read_unaligned)
    }

    /// Copies the data out of the package.
    pub fn to_data(&self) -> MeshData {
        MeshData {
            geometry: self.geometry().collect(),
            attributes: self.attributes().collect(),
            skin: self.skin().collect(),
            indices: self.indices().collect(),
        }
    }
}
