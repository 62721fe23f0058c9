//! The `OPEN` section: the directions that the body does not hide from the hair at each vertex. Layout in `FORMAT.md`,
//! "OPEN".

use super::kind::{Count, Kind, Row, USES_NOTHING};
use crate::error::FormatError;
use crate::meaning::openness::Openness;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;

impl Tag {
    /// Openness of the hair, since version 3. At most one.
    pub const OPENNESS: Self = Self(*b"OPEN");
}

pub(crate) const KIND: Kind = Kind {
    tag: Tag::OPENNESS,
    since: 3,
    count: Count::AtMostOne,
    check: |package, _| package.openness().map(drop),
    check_use: USES_NOTHING,
    row: Row {
        what: "[what the body leaves open](#open-what-the-body-leaves-open)",
        how_many: "at most one",
        place: "any",
    },
};

/// Size of a vertex, bytes.
const VERTEX_BYTES: usize = 4;

fn fault(at: usize, reason: String) -> FormatError {
    FormatError::Content { tag: Tag::OPENNESS, offset: at as u64, reason }
}

/// Checks that these four bytes are a possible result of [`Openness::to_bytes`].
fn check_vertex(number: usize, bytes: [u8; 4]) -> Result<(), String> {
    let [_, u, v, spare] = bytes;
    let [u, v] = [u, v].map(|x| i32::from(x as i8));
    if spare != 0 || u * u + v * v > 127 * 127 {
        return Err(format!(
            "vertex {number} has bytes {bytes:?}, expected a vector of length at most 127 in the second and third, \
             and 0 in the fourth"
        ));
    }
    Ok(())
}

impl<'a> Package<'a> {
    /// Returns the openness of the hair at each vertex, four bytes each ([`Openness::from_bytes`]); `None` if the
    /// package has no such section.
    ///
    /// Fails if the section is damaged, or its vertex count is not that of the mesh.
    pub fn openness(&self) -> Result<Option<&'a [u8]>, FormatError> {
        let Some((index, section)) = self.find(Tag::OPENNESS, 0) else { return Ok(None) };
        let bytes = self.section_bytes(index)?;
        self.cached(index, || {
            let start = section.offset as usize;
            let vertices = self.mesh()?.map_or(0, |mesh| mesh.vertex_count as usize);
            if bytes.len() != VERTEX_BYTES * vertices {
                let (found, expected) = (bytes.len(), VERTEX_BYTES * vertices);
                return Err(fault(
                    start,
                    format!("{found} bytes, expected {expected}, 4 for each of {vertices} vertices"),
                ));
            }
            for (number, vertex) in bytes.chunks_exact(VERTEX_BYTES).enumerate() {
                check_vertex(number, bytemuck::pod_read_unaligned(vertex))
                    .map_err(|reason| fault(start + VERTEX_BYTES * number, reason))?;
            }
            Ok(())
        })?;
        Ok(Some(bytes))
    }
}

impl PackageWriter<'_> {
    /// Adds the openness of the hair at each vertex of the mesh.
    pub fn openness(self, vertices: &[Openness]) -> Self {
        let encode = || {
            let mut out = Vec::with_capacity(VERTEX_BYTES * vertices.len());
            for (number, vertex) in vertices.iter().enumerate() {
                let bytes = vertex.to_bytes();
                check_vertex(number, bytes).map_err(|reason| fault(VERTEX_BYTES * number, reason))?;
                out.extend(bytes);
            }
            Ok(out)
        };
        self.encoded(Tag::OPENNESS, encode())
    }
}
