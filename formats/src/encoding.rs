//! Bincode configuration of packages: little-endian, fixed-width integers, so that one table can specify the layout.

use crate::error::FormatError;
use crate::tag::Tag;
use bincode::config::{Configuration, Fixint, LittleEndian};
use bincode::de::read::Reader;
use bincode::de::{Decode, Decoder, DecoderImpl};
use bincode::error::DecodeError;
use bincode::serde::Compat;
use serde::Serialize;
use serde::de::DeserializeOwned;

const CONFIG: Configuration<LittleEndian, Fixint> =
    bincode::config::standard().with_little_endian().with_fixed_int_encoding();

/// Reader of a section that tracks its position for error messages.
struct SectionReader<'a> {
    bytes: &'a [u8],
    position: usize,
}

impl Reader for SectionReader<'_> {
    fn read(&mut self, out: &mut [u8]) -> Result<(), DecodeError> {
        let left = &self.bytes[self.position..];
        let Some(found) = left.get(..out.len()) else {
            return Err(DecodeError::UnexpectedEnd { additional: out.len() - left.len() });
        };
        out.copy_from_slice(found);
        self.position += out.len();
        Ok(())
    }

    fn peek_read(&mut self, count: usize) -> Option<&[u8]> {
        self.bytes[self.position..].get(..count)
    }

    fn consume(&mut self, count: usize) {
        self.position = (self.position + count).min(self.bytes.len());
    }
}

/// Decodes a bincode section to its last byte. `offset` is the position of `bytes` in the package.
///
/// Memory stays proportional to `bytes`, which the caller has bounded by [`crate::Limits`]. Serde reserves at most 1
/// MiB for a list beyond the elements already read. Bincode allocates whatever length a string states, up to its limit.
/// The limit in effect is the smallest of 1, 16 and 256 MiB that the section does not exceed.
///
/// Bincode's limit is a compile-time constant, and a decoder for each value would enlarge the WebAssembly download. So
/// the only decoder has the limit 256 MiB. The difference to the limit in effect is counted as already read before
/// decoding begins.
pub(crate) fn decode_section<T: DeserializeOwned>(tag: Tag, offset: u64, bytes: &[u8]) -> Result<T, FormatError> {
    const MOST: usize = 0x1000_0000;
    let step = [0x10_0000, 0x100_0000, MOST].into_iter().find(|step| bytes.len() <= *step);
    let Some(step) = step else {
        let (what, found, limit) = ("section length", bytes.len() as u64, MOST as u64);
        return Err(FormatError::Limit { tag, what, offset, found, limit });
    };
    let reader = SectionReader { bytes, position: 0 };
    let mut decoder = DecoderImpl::new(reader, CONFIG.with_limit::<MOST>(), ());
    let decoded = decoder.claim_bytes_read(MOST - step).and_then(|()| Compat::<T>::decode(&mut decoder));
    let reader = decoder.reader();
    let at = offset + reader.position as u64;
    let Compat(value) = decoded.map_err(|error| FormatError::Content { tag, offset: at, reason: in_words(&error) })?;
    match bytes.len() - reader.position {
        0 => Ok(value),
        rest => Err(FormatError::Content {
            tag,
            offset: at,
            reason: format!("{rest} bytes follow the value, expected none"),
        }),
    }
}

fn in_words(error: &DecodeError) -> String {
    match error {
        DecodeError::UnexpectedEnd { additional } => {
            format!("the section ends inside a value, {additional} more bytes expected")
        }
        DecodeError::LimitExceeded => "a length is greater than the section, expected at most its size".into(),
        DecodeError::InvalidBooleanValue(found) => format!("a bool is {found}, expected 0 or 1"),
        DecodeError::UnexpectedVariant { found, .. } => {
            format!("an option or enum is {found}, expected a known variant")
        }
        DecodeError::OutsideUsizeRange(found) => format!("a length is {found}, more than this machine can hold"),
        DecodeError::Utf8 { inner } => format!("a string is not UTF-8: {inner}"),
        DecodeError::OtherString(reason) => reason.clone(),
        DecodeError::Other(reason) => (*reason).into(),
        // Omit bincode's own messages: they would pull the text of all its errors into the WebAssembly download.
        _ => "bytes that are not a value of this type".into(),
    }
}

pub(crate) fn encode_section<T: Serialize>(tag: Tag, value: &T) -> Result<Vec<u8>, FormatError> {
    bincode::serde::encode_to_vec(value, CONFIG).map_err(|error| FormatError::Content {
        tag,
        offset: 0,
        reason: error.to_string(),
    })
}
