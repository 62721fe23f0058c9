//! The `NORM` section: normals by which bare surface is lit. Layout in `FORMAT.md`, "NORM".

use super::kind::{Count, Kind, Row, USES_NOTHING};
use crate::error::FormatError;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;

impl Tag {
    /// Normals of bare surface, since version 3. At most one.
    pub const BARE_NORMALS: Self = Self(*b"NORM");
}

pub(crate) const KIND: Kind = Kind {
    tag: Tag::BARE_NORMALS,
    since: 3,
    count: Count::AtMostOne,
    check: |package, _| package.bare_normals().map(drop),
    check_use: USES_NOTHING,
    row: Row {
        what: "[normals of bare surface](#norm-normals-of-bare-surface)",
        how_many: "at most one",
        place: "any",
    },
};

/// Size of a vertex, bytes.
const VERTEX_BYTES: usize = 4;

fn fault(at: usize, reason: String) -> FormatError {
    FormatError::Content { tag: Tag::BARE_NORMALS, offset: at as u64, reason }
}

/// Checks that these two numbers are a possible result of [`crate::meaning::encode_bare_normal`].
fn check_vertex(number: usize, stored: [i16; 2]) -> Result<(), String> {
    let [u, v] = stored.map(i64::from);
    // A rounded unit vector may be slightly longer than 1.
    if u * u + v * v > 32_768 * 32_768 {
        return Err(format!("vertex {number} has {stored:?}, expected a vector of length at most 32768"));
    }
    Ok(())
}

impl<'a> Package<'a> {
    /// Returns the normal of the bare surface at each vertex, two little-endian i16 each
    /// ([`crate::meaning::decode_bare_normal`]); `None` if bare surface has the normals of the hair.
    ///
    /// Fails if the section is damaged, or its vertex count is not that of the mesh.
    pub fn bare_normals(&self) -> Result<Option<&'a [u8]>, FormatError> {
        let Some((index, section)) = self.find(Tag::BARE_NORMALS, 0) else { return Ok(None) };
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
            for (number, vertex) in stored_bare_normals(bytes).enumerate() {
                check_vertex(number, vertex).map_err(|reason| fault(start + VERTEX_BYTES * number, reason))?;
            }
            Ok(())
        })?;
        Ok(Some(bytes))
    }
}

/// Returns the numbers of each vertex in the bytes of [`Package::bare_normals`].
pub fn stored_bare_normals(bytes: &[u8]) -> impl Iterator<Item = [i16; 2]> {
    bytes.chunks_exact(VERTEX_BYTES).map(|of| [i16::from_le_bytes([of[0], of[1]]), i16::from_le_bytes([of[2], of[3]])])
}

impl PackageWriter<'_> {
    /// Adds the normal of the bare surface at each vertex of the mesh
    /// ([`crate::meaning::encode_bare_normal`]).
    pub fn bare_normals(self, vertices: &[[i16; 2]]) -> Self {
        let encode = || {
            let mut out = Vec::with_capacity(VERTEX_BYTES * vertices.len());
            for (number, vertex) in vertices.iter().enumerate() {
                check_vertex(number, *vertex).map_err(|reason| fault(VERTEX_BYTES * number, reason))?;
                out.extend(vertex.iter().flat_map(|x| x.to_le_bytes()));
            }
            Ok(out)
        };
        self.encoded(Tag::BARE_NORMALS, encode())
    }
}
