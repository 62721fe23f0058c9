//! The `CNTR` section: edges and faces of the welded mesh, from which the ink style extracts contour lines. Layout in
//! `FORMAT.md`, "CNTR".

use super::kind::Kind;
use crate::error::FormatError;
use crate::limits::Limits;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
use bytemuck::{Pod, Zeroable};
use std::fmt;

impl Tag {
    /// Contour mesh of the ink style, since version 3. At most one.
    pub const CONTOURS: Self = Self(*b"CNTR");
}

pub(crate) const KIND: Kind = Kind::optional(
    Tag::CONTOURS,
    3,
    "[contour mesh of the ink style](#cntr-contour-mesh-of-the-ink-style)",
    |package, _| package.contours().map(drop),
);

impl<'a> Package<'a> {
    /// Returns the contour mesh of the ink style; `None` if the package has none. Every number is checked once; the
    /// result is cached.
    ///
    /// Fails if the section is damaged, or its vertex count is not that of the mesh.
    pub fn contours(&self) -> Result<Option<ContourView<'a>>, FormatError> {
        let Some((index, section)) = self.find(Tag::CONTOURS, 0) else { return Ok(None) };
        let counts = self.cached(index, || {
            let view = ContourView::parse(self.section_bytes(index)?, section.offset, self.limits())?;
            let (found, expected) = (view.counts.vertices, self.mesh()?.map_or(0, |mesh| mesh.vertex_count));
            if found != expected {
                let reason = format!("marks of {found} vertices, expected the {expected} of the mesh");
                return Err(FormatError::Content { tag: Tag::CONTOURS, offset: section.offset + 12, reason });
            }
            Ok(view.counts)
        })?;
        Ok(Some(ContourView::of(self.section_bytes(index)?, counts)))
    }
}

impl PackageWriter<'_> {
    /// Adds the contour mesh of the ink style.
    pub fn contours(self, contours: &ContourMesh) -> Self {
        self.encoded(Tag::CONTOURS, contours.encode())
    }
}

/// Edge of the contour mesh: indices of two different mesh vertices. 8 bytes.
pub type ContourEdge = [u32; 2];

/// Face of the contour mesh. 16 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct ContourFace {
    /// Indices of edges in the face's winding order: edge k connects corners k and k + 1.
    pub edges: [u32; 3],
    /// Bit k is set if edge k is stored against the winding order, from corner k + 1 to corner k. Others are 0.
    pub flags: u32,
}

/// Point of a static line: a sharp edge or an open boundary of the mesh. 16 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct CreasePoint {
    /// Two mesh vertices; the point is on the line between them.
    pub vertices: [u32; 2],
    /// Share of the second vertex, in units of 1/65535.
    pub share: u16,
    /// Kind of line, [`Self::SHARP`] or [`Self::BOUNDARY`].
    pub kind: u16,
    /// Index of the next point of the line; [`Self::NONE`] at its end. No two points have the same next point.
    pub next: u32,
}

impl CreasePoint {
    /// Kind of an edge between two faces that meet at a sharp angle.
    pub const SHARP: u16 = 0;
    /// Kind of an edge with a single face.
    pub const BOUNDARY: u16 = 1;
    /// Value of `next` at the end of a line.
    pub const NONE: u32 = u32::MAX;
}

/// Marks of a mesh vertex. 4 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct ContourMark {
    /// Amount of lines, in units of 1/255; with 0, no line is drawn.
    pub line: u8,
    /// Emphasis, such as on the head, in units of 1/255.
    pub emphasis: u8,
    /// Darkness of the surface's colour, in units of 1/255; 255 is black.
    pub darkness: u8,
    /// Reserved, 0.
    pub reserved: u8,
}

/// Contour mesh to be written: connectivity of the welded mesh. Positions and normals are those of the package's mesh,
/// at one representative vertex for each welded one.
///
/// A contour enters and leaves each face through two of its edges. An edge has at most one face in each direction;
/// where more faces meet, it is stored several times.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ContourMesh {
    /// Edges.
    pub edges: Vec<ContourEdge>,
    /// Faces.
    pub faces: Vec<ContourFace>,
    /// Points of sharp edges and open boundaries.
    pub creases: Vec<CreasePoint>,
    /// Marks, one per vertex of the mesh.
    pub marks: Vec<ContourMark>,
    /// Maximum number of crossed edges that a renderer should expect in a frame, a multiple of
    /// [`Self::NODE_STEP`], at most [`Self::MOST_NODES`].
    pub most_nodes: u32,
}

/// Contour mesh of an opened package: slices of the package's bytes, ready to upload.
#[derive(Clone, Copy)]
pub struct ContourView<'a> {
    /// [`ContourEdge`] array.
    pub edges: &'a [u8],
    /// [`ContourFace`] array.
    pub faces: &'a [u8],
    /// [`CreasePoint`] array.
    pub creases: &'a [u8],
    /// [`ContourMark`] of each vertex of the mesh.
    pub marks: &'a [u8],
    /// See [`ContourMesh::most_nodes`].
    pub most_nodes: u32,
    counts: Counts,
}

impl fmt::Debug for ContourView<'_> {
    /// Formats the counts only.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Counts { edges, faces, creases, .. } = self.counts;
        write!(f, "ContourView({edges} edges, {faces} faces, {creases} crease points)")
    }
}

const HEADER_BYTES: u64 = 32;

/// Counts that determine the layout of the section.
#[derive(Clone, Copy, Debug)]
struct Counts {
    edges: u32,
    faces: u32,
    creases: u32,
    vertices: u32,
    most_nodes: u32,
}

/// Returns the offsets of edges, faces, crease points and marks, and the end, relative to the section.
fn layout(counts: Counts) -> [u64; 5] {
    let Counts { edges, faces, creases, vertices, .. } = counts;
    let [edges, faces, creases, vertices] = [edges, faces, creases, vertices].map(u64::from);
    let of_faces = (HEADER_BYTES + 8 * edges).next_multiple_of(16);
    let of_creases = of_faces + 16 * faces;
    let of_marks = of_creases + 16 * creases;
    [HEADER_BYTES, of_faces, of_creases, of_marks, of_marks + 4 * vertices]
}

fn values<'b, T: Pod>(bytes: &'b [u8]) -> impl ExactSizeIterator<Item = T> + 'b {
    bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned)
}

impl ContourMesh {
    /// Unit of [`Self::most_nodes`].
    pub const NODE_STEP: u32 = 256;
    /// Maximum of [`Self::most_nodes`], and of the number of crease points.
    pub const MOST_NODES: u32 = 16_384;

    /// Returns the bytes of the section.
    fn encode(&self) -> Result<Vec<u8>, FormatError> {
        let fail = |reason: &str| FormatError::Content { tag: Tag::CONTOURS, offset: 0, reason: reason.into() };
        let count = |n: usize| u32::try_from(n).map_err(|_| fail("more than 2^32 edges, faces or vertices"));
        let counts = Counts {
            edges: count(self.edges.len())?,
            faces: count(self.faces.len())?,
            creases: count(self.creases.len())?,
            vertices: count(self.marks.len())?,
            most_nodes: self.most_nodes,
        };
        let Counts { edges, faces, creases, vertices, most_nodes } = counts;
        let mut out = Vec::new();
        out.extend([edges, faces, creases, vertices, most_nodes, 0, 0, 0].into_iter().flat_map(u32::to_le_bytes));
        out.extend_from_slice(bytemuck::cast_slice(&self.edges));
        out.resize(layout(counts)[1] as usize, 0);
        out.extend_from_slice(bytemuck::cast_slice(&self.faces));
        out.extend_from_slice(bytemuck::cast_slice(&self.creases));
        out.extend_from_slice(bytemuck::cast_slice(&self.marks));
        ContourView::parse(&out, 0, &Limits::NONE)?;
        Ok(out)
    }
}

impl<'a> ContourView<'a> {
    /// Reads the section at `offset` of the package and checks every number in it, independently of other sections.
    fn parse(bytes: &'a [u8], offset: u64, limits: &Limits) -> Result<Self, FormatError> {
        let fail = |at: u64, reason: String| FormatError::Content { tag: Tag::CONTOURS, offset: offset + at, reason };
        if (bytes.len() as u64) < HEADER_BYTES {
            let reason = format!("the section has {} bytes, expected a header of {HEADER_BYTES}", bytes.len());
            return Err(fail(0, reason));
        }
        let header: [u32; 8] = bytemuck::pod_read_unaligned(&bytes[..HEADER_BYTES as usize]);
        let [edges, faces, creases, vertices, most_nodes, reserved @ ..] = header;
        let counts = Counts { edges, faces, creases, vertices, most_nodes };
        for (what, found, limit) in
            [("vertex count", vertices, limits.vertices), ("face count", faces, limits.indices / 3)]
        {
            if found > limit {
                let (found, limit) = (found.into(), limit.into());
                return Err(FormatError::Limit { tag: Tag::CONTOURS, what, offset, found, limit });
            }
        }
        if let Some(at) = reserved.iter().position(|number| *number != 0) {
            return Err(fail(20 + 4 * at as u64, format!("reserved number is {}, expected 0", reserved[at])));
        }
        let (step, most) = (ContourMesh::NODE_STEP, ContourMesh::MOST_NODES);
        if most_nodes % step != 0 || most_nodes > most {
            let reason = format!("most_nodes is {most_nodes}, expected a multiple of {step}, at most {most}");
            return Err(fail(16, reason));
        }
        if creases > most {
            return Err(fail(8, format!("{creases} crease points, expected at most {most}")));
        }
        let [of_edges, of_faces, of_creases, of_marks, end] = layout(counts);
        if bytes.len() as u64 != end {
            let reason = format!("the section has {} bytes, expected {end} for these counts", bytes.len());
            return Err(fail(0, reason));
        }
        let view = Self::of(bytes, counts);
        if let Some(at) = (of_edges + view.edges.len() as u64..of_faces).find(|at| bytes[*at as usize] != 0) {
            return Err(fail(at, format!("padding byte is {}, expected 0", bytes[at as usize])));
        }
        let is_edge = |[a, b]: &[u32; 2]| a != b && *a < vertices && *b < vertices;
        if let Some((i, edge)) = view.edges().enumerate().find(|(_, edge)| !is_edge(edge)) {
            let reason = format!("edge {i} is {edge:?}, expected two different vertices less than {vertices}");
            return Err(fail(of_edges + 8 * i as u64, reason));
        }
        view.check_faces().map_err(|(i, reason)| fail(of_faces + 16 * i as u64, format!("face {i} {reason}")))?;
        view.check_creases()
            .map_err(|(i, reason)| fail(of_creases + 16 * i as u64, format!("crease point {i} {reason}")))?;
        if let Some((i, mark)) = view.marks().enumerate().find(|(_, mark)| mark.reserved != 0) {
            let reason = format!("mark {i} is {mark:?}, expected reserved 0");
            return Err(fail(of_marks + 4 * i as u64, reason));
        }
        Ok(view)
    }

    /// Checks that edges of faces meet at the corners, and that each edge has at most one face in each direction.
    fn check_faces(&self) -> Result<(), (usize, &'static str)> {
        let count = self.counts.edges;
        let edge = |i: u32| -> ContourEdge { bytemuck::pod_read_unaligned(&self.edges[8 * i as usize..][..8]) };
        // Bit 0: used in its own direction; bit 1: used against it.
        let mut used = vec![0u8; count as usize];
        for (i, face) in self.faces().enumerate() {
            if face.edges.iter().any(|e| *e >= count) {
                return Err((i, "has an edge out of range"));
            }
            if face.flags > 7 {
                return Err((i, "has unknown flags"));
            }
            let sides: [[u32; 2]; 3] = std::array::from_fn(|k| {
                let [a, b] = edge(face.edges[k]);
                if face.flags >> k & 1 == 1 { [b, a] } else { [a, b] }
            });
            if (0..3).any(|k| sides[k][1] != sides[(k + 1) % 3][0]) {
                return Err((i, "has edges that do not meet at its corners"));
            }
            for k in 0..3 {
                let (state, bit) = (&mut used[face.edges[k] as usize], 1 + (face.flags >> k & 1) as u8);
                if *state & bit != 0 {
                    return Err((i, "uses an edge in the same direction as another face"));
                }
                *state |= bit;
            }
        }
        Ok(())
    }

    fn check_creases(&self) -> Result<(), (usize, &'static str)> {
        let Counts { creases, vertices, .. } = self.counts;
        let mut reached = vec![false; creases as usize];
        for (i, point) in self.creases().enumerate() {
            if point.vertices.iter().any(|v| *v >= vertices) {
                return Err((i, "has a vertex out of range"));
            }
            if ![CreasePoint::SHARP, CreasePoint::BOUNDARY].contains(&point.kind) {
                return Err((i, "has an unknown kind"));
            }
            if point.next == CreasePoint::NONE {
                continue;
            }
            if point.next >= creases || point.next as usize == i {
                return Err((i, "has a next point out of range"));
            }
            if std::mem::replace(&mut reached[point.next as usize], true) {
                return Err((i, "has the next point of another"));
            }
        }
        Ok(())
    }

    /// Returns the parts of a section with the given counts; its length must match them.
    fn of(bytes: &'a [u8], counts: Counts) -> Self {
        let [of_edges, of_faces, of_creases, of_marks, end] = layout(counts).map(|at| at as usize);
        Self {
            edges: &bytes[of_edges..of_edges + 8 * counts.edges as usize],
            faces: &bytes[of_faces..of_creases],
            creases: &bytes[of_creases..of_marks],
            marks: &bytes[of_marks..end],
            most_nodes: counts.most_nodes,
            counts,
        }
    }

    /// Decodes the edges.
    pub fn edges(&self) -> impl ExactSizeIterator<Item = ContourEdge> + 'a {
        values(self.edges)
    }

    /// Decodes the faces.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = ContourFace> + 'a {
        values(self.faces)
    }

    /// Decodes the crease points.
    pub fn creases(&self) -> impl ExactSizeIterator<Item = CreasePoint> + 'a {
        values(self.creases)
    }

    /// Decodes the marks.
    pub fn marks(&self) -> impl ExactSizeIterator<Item = ContourMark> + 'a {
        values(self.marks)
    }

    /// Copies the data out of the package.
    pub fn to_data(&self) -> ContourMesh {
        ContourMesh {
            edges: self.edges().collect(),
            faces: self.faces().collect(),
            creases: self.creases().collect(),
            marks: self.marks().collect(),
            most_nodes: self.most_nodes,
        }
    }
}
