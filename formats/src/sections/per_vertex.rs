//! Sections with a record of `N` bytes for each vertex of the mesh.

use crate::error::FormatError;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;

/// Check of a vertex, by number and record; returns the reason why the record is impossible.
type Check<const N: usize> = fn(usize, [u8; N]) -> Result<(), String>;

fn fault(tag: Tag, at: usize, reason: String) -> FormatError {
    FormatError::Content { tag, offset: at as u64, reason }
}

fn check_all<const N: usize>(tag: Tag, start: usize, bytes: &[u8], check: Check<N>) -> Result<(), FormatError> {
    let mut records = bytes.as_chunks::<N>().0.iter().enumerate();
    records.try_for_each(|(number, record)| {
        check(number, *record).map_err(|reason| fault(tag, start + N * number, reason))
    })
}

impl<'a> Package<'a> {
    /// Returns the records of the section `tag`; `None` without that section.
    ///
    /// Fails if `check` rejects a record, or the number of records is not that of the mesh's vertices.
    pub(crate) fn per_vertex<const N: usize>(
        &self,
        tag: Tag,
        check: Check<N>,
    ) -> Result<Option<&'a [u8]>, FormatError> {
        let Some((index, section)) = self.find(tag, 0) else { return Ok(None) };
        let bytes = self.section_bytes(index)?;
        self.cached(index, || {
            let start = section.offset as usize;
            let vertices = self.mesh()?.map_or(0, |mesh| mesh.vertex_count as usize);
            if bytes.len() != N * vertices {
                let (found, expected) = (bytes.len(), N * vertices);
                let reason = format!("{found} bytes, expected {expected}, {N} for each of {vertices} vertices");
                return Err(fault(tag, start, reason));
            }
            check_all(tag, start, bytes, check)
        })?;
        Ok(Some(bytes))
    }
}

impl PackageWriter<'_> {
    /// Adds the section `tag`, or records that `check` rejects a record.
    pub(crate) fn per_vertex<const N: usize>(
        self,
        tag: Tag,
        records: impl Iterator<Item = [u8; N]>,
        check: Check<N>,
    ) -> Self {
        let bytes = records.collect::<Vec<_>>().concat();
        let checked = check_all(tag, 0, &bytes, check);
        self.encoded(tag, checked.map(|()| bytes))
    }
}
