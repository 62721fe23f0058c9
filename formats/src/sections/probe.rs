//! `PROB`: a section that exists only in tests, a list of non-zero bytes. It shows what is required to add a section:
//! this file and its line in `mod.rs`.

use super::kind::{Count, Kind, Row, USES_NOTHING};
use crate::error::FormatError;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
use std::cell::Cell;

impl Tag {
    pub(crate) const PROBE: Self = Self(*b"PROB");
}

pub(crate) const KIND: Kind = Kind {
    tag: Tag::PROBE,
    since: 3,
    count: Count::AtMostOne,
    check: |package, _| package.probe().map(drop),
    check_use: USES_NOTHING,
    row: Row { what: "a probe", how_many: "at most one", place: "any, in tests" },
};

thread_local! {
    /// Number of sections of this kind that this thread has read and checked.
    pub(crate) static CHECKED: Cell<u32> = const { Cell::new(0) };
}

impl<'a> Package<'a> {
    /// Returns the bytes and their sum; `None` if the package has no such section. A model named `probed` must have
    /// one.
    pub(crate) fn probe(&self) -> Result<Option<(&'a [u8], u32)>, FormatError> {
        let fail = |offset, reason| FormatError::Content { tag: Tag::PROBE, offset, reason };
        let Some((index, section)) = self.find(Tag::PROBE, 0) else {
            return match self.manifest().model == "probed" {
                true => Err(fail(0, "none, expected one of a probed model".into())),
                false => Ok(None),
            };
        };
        let sum = self.cached(index, || {
            CHECKED.set(CHECKED.get() + 1);
            let bytes = self.section_bytes(index)?;
            match bytes.iter().position(|byte| *byte == 0) {
                Some(at) => Err(fail(section.offset + at as u64, format!("byte {at} is 0, expected any other value"))),
                None => Ok(bytes.iter().copied().map(u32::from).sum()),
            }
        })?;
        Ok(Some((self.section_bytes(index)?, sum)))
    }
}

impl PackageWriter<'_> {
    pub(crate) fn probe(self, bytes: &[u8]) -> Self {
        self.encoded(Tag::PROBE, Ok(bytes.to_vec()))
    }
}
