//! Access to a file's bytes; every range is checked against the file's length.

use crate::error::BakeError;
use glam::Vec3;
use std::borrow::Cow;

/// Name and bytes of a file.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) file: &'a str,
    pub(super) bytes: &'a [u8],
    /// Whether numbers that are not finite are errors. Otherwise, the strands that contain them are left out.
    pub(super) is_strict: bool,
}

impl<'a> Source<'a> {
    pub(super) fn fault(&self, place: String, reason: impl Into<String>) -> BakeError {
        BakeError::Input { file: self.file.to_owned(), place, reason: reason.into() }
    }

    /// Returns the `len` bytes that begin at offset `at`; `what` names them in errors.
    pub(super) fn slice(&self, at: u64, len: u64, what: &str) -> Result<&'a [u8], BakeError> {
        let end = at.checked_add(len).filter(|end| *end <= self.bytes.len() as u64);
        let Some(end) = end else {
            let reason = format!("{what}: expected {len} bytes from here, the file ends at byte {}", self.bytes.len());
            return Err(self.fault(format!("byte {at}"), reason));
        };
        Ok(&self.bytes[at as usize..end as usize])
    }

    pub(super) fn u32(&self, at: u64, what: &str) -> Result<u32, BakeError> {
        let bytes = self.slice(at, 4, what)?;
        Ok(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
    }

    pub(super) fn f32(&self, at: u64, what: &str) -> Result<f32, BakeError> {
        self.u32(at, what).map(f32::from_bits)
    }

    /// Returns the text of a file in UTF-8, with or without a byte order mark, or in UTF-16 with one.
    pub(super) fn text(&self) -> Result<Cow<'a, str>, BakeError> {
        let utf16 = |unit: fn([u8; 2]) -> u16| {
            let units = self.bytes[2..].chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
            char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect::<String>()
        };
        match self.bytes {
            [0xff, 0xfe, ..] => return Ok(utf16(u16::from_le_bytes).into()),
            [0xfe, 0xff, ..] => return Ok(utf16(u16::from_be_bytes).into()),
            _ => {}
        }
        let text = std::str::from_utf8(self.bytes)
            .map_err(|error| self.fault(format!("byte {}", error.valid_up_to()), "not text, expected UTF-8"))?;
        Ok(text.strip_prefix('\u{feff}').unwrap_or(text).into())
    }

    /// Reads `count` rows of `width` floats that begin at offset `at`, and keeps the first `N` of each row. In a strict
    /// source, a number that is not finite is an error.
    pub(super) fn rows<const N: usize>(
        &self,
        at: u64,
        count: u64,
        width: u64,
        what: &str,
    ) -> Result<Vec<[f32; N]>, BakeError> {
        let bytes = self.slice(at, count.saturating_mul(4 * width), what)?;
        let mut rows = Vec::with_capacity(count as usize);
        for (k, row) in bytes.chunks_exact(4 * width as usize).enumerate() {
            let mut numbers = [0.0; N];
            for (i, number) in numbers.iter_mut().enumerate() {
                *number = f32::from_le_bytes([row[4 * i], row[4 * i + 1], row[4 * i + 2], row[4 * i + 3]]);
                if self.is_strict && !number.is_finite() {
                    let place = format!("byte {}", at + k as u64 * 4 * width + 4 * i as u64);
                    return Err(self.fault(place, format!("{what}: row {k} has {number}, expected finite numbers")));
                }
            }
            rows.push(numbers);
        }
        Ok(rows)
    }
}

pub(super) fn points(rows: &[[f32; 3]]) -> Vec<Vec3> {
    rows.iter().copied().map(Vec3::from).collect()
}
