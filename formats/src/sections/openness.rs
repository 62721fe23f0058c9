//! The `OPEN` section: the directions that the body does not hide from the hair at each vertex. Layout in `FORMAT.md`,
//! "OPEN".

use super::kind::Kind;
use crate::error::FormatError;
use crate::meaning::openness::Openness;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;

impl Tag {
    /// Openness of the hair, since version 3. At most one.
    pub const OPENNESS: Self = Self(*b"OPEN");
}

pub(crate) const KIND: Kind =
    Kind::optional(Tag::OPENNESS, 3, "[what the body leaves open](#open-what-the-body-leaves-open)", |package, _| {
        package.openness().map(drop)
    });

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
        self.per_vertex(Tag::OPENNESS, check_vertex)
    }
}

impl PackageWriter<'_> {
    /// Adds the openness of the hair at each vertex of the mesh.
    pub fn openness(self, vertices: &[Openness]) -> Self {
        self.per_vertex(Tag::OPENNESS, vertices.iter().map(|vertex| vertex.to_bytes()), check_vertex)
    }
}
