//! Binary data of a model: buffers and URIs, and the record of the files that were read.

use super::elements::Elements;
use super::json::{JsonNode, shorten};
use super::notes::{Notes, why_unreadable};
use crate::BakeError;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use base64::{Engine as _, alphabet};
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_decode_str, utf8_percent_encode};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::ErrorKind;

/// Bytes that are percent-encoded in the path of a URI (RFC 3986, section 2.3).
const OUTSIDE_PATHS: &AsciiSet = &NON_ALPHANUMERIC.remove(b'/').remove(b'-').remove(b'.').remove(b'_').remove(b'~');

/// Returns a relative path with slashes as a URI.
pub fn path_as_uri(path: &str) -> String {
    utf8_percent_encode(path, OUTSIDE_PATHS).to_string()
}

/// Maximum size of all decompressed data of a model, bytes. A limit is needed because many views can name the same
/// compressed bytes.
pub(super) const MAX_UNPACKED: u64 = 1 << 30;

/// Callback that fetches the contents of a relative URI; the second argument is the maximum number of bytes.
pub type Resolve<'r> = dyn FnMut(&str, u64) -> Result<Vec<u8>, BakeError> + 'r;

/// Maximum size of an external file whose length the model does not declare, bytes: an image or a material file.
pub(super) const MAX_BESIDE: u64 = 256 << 20;

/// Maximum size of all external files of a glTF, bytes. A limit is needed because many buffers can name the same large
/// file.
const MAX_FILES: u64 = 2 << 30;

/// Fetches the first `most` bytes of the file that a URI names. If the file does not exist, tries its other
/// [`spellings`]; the use of one is a warning. The error text lacks a subject: the caller puts the name before it.
fn fetch(uri: &str, most: u64, resolve: &mut Resolve<'_>, notes: &mut Notes) -> Result<Vec<u8>, String> {
    let is_missing =
        |error: &BakeError| matches!(error, BakeError::Io { source, .. } if source.kind() == ErrorKind::NotFound);
    let missing = match resolve(uri, most) {
        Err(error) if is_missing(&error) => error,
        found => return found.map_err(why_unreadable),
    };
    for path in spellings(uri) {
        match resolve(&path_as_uri(&path), most) {
            Err(error) if is_missing(&error) => {}
            found => {
                let (named, read) = (shorten(&percent_decode_str(uri).decode_utf8_lossy()), shorten(&path));
                notes.warn(format!("the file \"{named}\" does not exist; \"{read}\" is read instead"));
                return found.map_err(why_unreadable);
            }
        }
    }
    Err(why_unreadable(missing))
}

/// Returns the paths that a URI may stand for if the file that it names does not exist:
///
/// * with slashes for the backslashes of Windows
/// * as it is written, because some exporters do not percent-encode names
/// * decoded twice, because some exporters percent-encode names twice
fn spellings(uri: &str) -> Vec<String> {
    let decode = |text: &str| percent_decode_str(text).decode_utf8_lossy().into_owned();
    let decoded = decode(uri);
    let mut paths = Vec::new();
    for path in [&decoded, uri, &decode(&decoded)].map(|path| path.replace('\\', "/")) {
        if path != decoded && !paths.contains(&path) {
            paths.push(path);
        }
    }
    paths
}

/// Fetches a file of at most [`MAX_BESIDE`] bytes, as [`fetch`] does.
pub(super) fn fetch_file(uri: &str, resolve: &mut Resolve<'_>, notes: &mut Notes) -> Result<Vec<u8>, String> {
    let bytes = fetch(uri, MAX_BESIDE + 1, resolve, notes)?;
    if bytes.len() as u64 > MAX_BESIDE {
        return Err(format!("it is larger than {MAX_BESIDE} bytes"));
    }
    Ok(bytes)
}

/// A model being read.
pub(super) struct Source<'a, 'r> {
    /// The JSON document.
    pub root: JsonNode<'a>,
    bin: Option<&'a [u8]>,
    resolve: &'r mut Resolve<'r>,
    buffers: BTreeMap<usize, Cow<'a, [u8]>>,
    /// Buffer views that were decompressed.
    pub unpacked: BTreeMap<usize, Vec<u8>>,
    /// Decoded elements of accessors that have no bytes of their own. The next read of an accessor removes its entry.
    pub supplied: BTreeMap<usize, Elements>,
    /// Size of all decompressed data, bytes.
    unpacked_bytes: u64,
    /// Size of all buffer files read, bytes.
    file_bytes: u64,
    /// Warnings, and records of the files read.
    pub notes: Notes,
}

// Base64 encoders differ in padding and in the unused bits of the last character. All variants are accepted, because
// they decode to the same data.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

impl<'a, 'r> Source<'a, 'r> {
    pub fn new(root: JsonNode<'a>, bin: Option<&'a [u8]>, resolve: &'r mut Resolve<'r>, notes: Notes) -> Self {
        let (unpacked, supplied) = (BTreeMap::new(), BTreeMap::new());
        Self {
            root,
            bin,
            resolve,
            buffers: BTreeMap::new(),
            unpacked,
            supplied,
            unpacked_bytes: 0,
            file_bytes: 0,
            notes,
        }
    }

    /// Records a repair, omission or guess.
    pub fn warn(&mut self, text: impl Into<String>) {
        self.notes.warn(text);
    }

    /// Returns the value of `result`, or `None` with a warning; see [`Notes::or_warn`].
    pub fn or_warn<T>(&mut self, result: Result<T, BakeError>, consequence: &str) -> Option<T> {
        self.notes.or_warn(result, consequence)
    }

    /// Records a file or an embedded image.
    pub fn record(&mut self, role: &str, name: &str, bytes: &[u8]) {
        self.notes.record(role, name, bytes);
    }

    /// Returns the data of a `data:` URI, or the contents of the file that the URI names. If the model declares a
    /// length, at most `declared` bytes are returned. `role` is stored in the record.
    pub fn uri(&mut self, at: &JsonNode<'a>, role: &str, declared: Option<u64>) -> Result<Vec<u8>, BakeError> {
        let uri = at.string()?;
        if let Some(data) = uri.get(..5).filter(|s| s.eq_ignore_ascii_case("data:")).and_then(|_| uri.get(5..)) {
            let bytes = decode_data(data).map_err(|reason| at.fault(reason))?;
            if role == "image" {
                self.record(role, "", &bytes);
            }
            return Ok(bytes);
        }
        let left = MAX_FILES - self.file_bytes;
        if let Some(bytes) = declared.filter(|bytes| *bytes > left) {
            let reason = format!(
                "declares {bytes} bytes, which makes the model's files larger than {MAX_FILES} bytes \
                 in total"
            );
            return Err(at.fault(reason));
        }
        let fetched = match declared {
            Some(bytes) => fetch(uri, bytes, self.resolve, &mut self.notes),
            None => fetch_file(uri, self.resolve, &mut self.notes),
        };
        let bytes =
            fetched.map_err(|cause| at.fault(format!("names the {role} file \"{}\": {cause}", shorten(uri))))?;
        // Only buffers have a declared length and stay in memory; images are dropped after decoding.
        self.file_bytes += declared.map_or(0, |_| bytes.len() as u64);
        let name = percent_decode_str(uri).decode_utf8().unwrap_or(Cow::Borrowed(uri));
        self.record(role, &name, &bytes);
        Ok(bytes)
    }

    /// Returns the size of all buffers loaded so far, bytes.
    pub fn buffer_bytes(&self) -> u64 {
        self.buffers.values().map(|buffer| buffer.len() as u64).sum()
    }

    /// Loads the buffer that `reference` names, and returns its index.
    pub(super) fn buffer(&mut self, reference: &JsonNode<'a>) -> Result<usize, BakeError> {
        let (index, at) = self.root.follow("buffers", reference)?;
        if self.buffers.contains_key(&index) {
            return Ok(index);
        }
        let expected = at.require("byteLength")?.unsigned()?;
        let (bytes, origin) = match (at.get("uri"), self.bin) {
            (Some(uri), _) => (Cow::Owned(self.uri(&uri, "buffer", Some(expected))?), uri),
            (None, Some(bin)) if index == 0 => (Cow::Borrowed(bin), at.clone()),
            (None, _) => {
                let only = if index == 0 { "the file has no BIN chunk" } else { "only buffer 0 can be the BIN chunk" };
                return Err(at.fault(format!("has no `uri`, and {only}; export the model again")));
            }
        };
        if (bytes.len() as u64) < expected {
            let found = bytes.len();
            return Err(origin.fault(format!(
                "buffer {index} holds {found} bytes, but byteLength says {expected}: it is cut \
                     off"
            )));
        }
        self.buffers.insert(index, bytes);
        Ok(index)
    }

    /// Adds `bytes` to the size of the model's decompressed data.
    ///
    /// Fails with [`BakeError::Input`] at `at` if the sum exceeds `MAX_UNPACKED`.
    pub fn count_unpacked(&mut self, at: &JsonNode<'_>, bytes: u64) -> Result<(), BakeError> {
        self.unpacked_bytes = self.unpacked_bytes.saturating_add(bytes);
        if self.unpacked_bytes > MAX_UNPACKED {
            return Err(at.fault(format!(
                "makes the model's decompressed data larger than {MAX_UNPACKED} bytes in \
                 total"
            )));
        }
        Ok(())
    }

    /// Returns the bytes that the object `at` names by `buffer`, `byteOffset` and `byteLength`.
    pub fn buffer_range(&mut self, at: &JsonNode<'a>) -> Result<&[u8], BakeError> {
        let index = self.buffer(&at.require("buffer")?)?;
        let (offset, length) = (at.unsigned_or("byteOffset", 0)?, at.require("byteLength")?.unsigned()?);
        let have = self.buffers.get(&index).map_or(0, |b| b.len()) as u64;
        if offset > have {
            return Err(at.fault(format!("begins at byte {offset} of buffer {index}, which has {have} bytes")));
        }
        let end = offset.saturating_add(length);
        if end > have {
            // The missing bytes may be unused, so this is only a warning: each accessor is checked against the
            // available bytes.
            self.warn(format!(
                "{} extends to byte {end} of buffer {index}, which has {have} bytes; it is read up to \
                 there",
                at.place
            ));
        }
        let buffer = self.buffers.get(&index).map(Cow::as_ref).unwrap_or_default();
        Ok(buffer.get(offset as usize..end.min(have) as usize).unwrap_or_default())
    }
}

/// Decodes the data of a `data:` URI (RFC 2397) after the scheme.
fn decode_data(data: &str) -> Result<Vec<u8>, String> {
    let (header, body) =
        data.split_once(',').ok_or("is a data URI without a comma, expected data:[type][;base64],data")?;
    let body: Cow<'_, [u8]> = percent_decode_str(body).into();
    if header.to_ascii_lowercase().ends_with(";base64") {
        let text: Vec<u8> = body.iter().copied().filter(|b| !b.is_ascii_whitespace()).collect();
        BASE64.decode(text).map_err(|e| format!("is a data URI with invalid base64: {e}"))
    } else {
        Ok(body.into_owned())
    }
}
