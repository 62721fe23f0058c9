//! The `NORM` section: normals by which bare surface is lit. Layout in `FORMAT.md`, "NORM".

use super::kind::Kind;
use crate::error::FormatError;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;

impl Tag {
    /// Normals of bare surface, since version 3. At most one.
    pub const BARE_NORMALS: Self = Self(*b"NORM");
}

pub(crate) const KIND: Kind =
    Kind::optional(Tag::BARE_NORMALS, 3, "[normals of bare surface](#norm-normals-of-bare-surface)", |package, _| {
        package.bare_normals().map(drop)
    });

/// Checks that a record is a possible result of [`crate::meaning::encode_bare_normal`].
fn check_vertex(number: usize, record: [u8; 4]) -> Result<(), String> {
    let stored = components(record);
    let [u, v] = stored.map(i64::from);
    if u * u + v * v > 32_767 * 32_767 {
        return Err(format!("vertex {number} has {stored:?}, expected a vector of length at most 32767"));
    }
    Ok(())
}

fn components([a, b, c, d]: [u8; 4]) -> [i16; 2] {
    [[a, b], [c, d]].map(i16::from_le_bytes)
}

impl<'a> Package<'a> {
    /// Returns the normal of the bare surface at each vertex, two little-endian i16 each
    /// ([`crate::meaning::decode_bare_normal`]); `None` if bare surface has the normals of the hair.
    ///
    /// Fails if the section is damaged, or its vertex count is not that of the mesh.
    pub fn bare_normals(&self) -> Result<Option<&'a [u8]>, FormatError> {
        self.per_vertex(Tag::BARE_NORMALS, check_vertex)
    }
}

/// Returns the numbers of each vertex in the bytes of [`Package::bare_normals`].
pub fn stored_bare_normals(bytes: &[u8]) -> impl Iterator<Item = [i16; 2]> {
    bytes.as_chunks().0.iter().copied().map(components)
}

impl PackageWriter<'_> {
    /// Adds the normal of the bare surface at each vertex of the mesh
    /// ([`crate::meaning::encode_bare_normal`]).
    pub fn bare_normals(self, vertices: &[[i16; 2]]) -> Self {
        let record = |[u, v]: &[i16; 2]| bytemuck::cast([u.to_le_bytes(), v.to_le_bytes()]);
        self.per_vertex(Tag::BARE_NORMALS, vertices.iter().map(record), check_vertex)
    }
}
