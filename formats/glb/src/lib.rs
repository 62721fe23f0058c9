//! Writer for binary glTF 2.0: the buffer with its views and accessors, and the container around document and buffer.
//!
//! The caller supplies the document, because meshes, skins and clips differ from writer to writer. This crate holds
//! what the writers share: strands, package meshes and the project's own models are written by crates that do not
//! depend on each other. It does not read glTF; `pelage bake` reads files of any exporter.
//!
//! ```
//! use pelage_glb::{Buffer, Component, ViewTarget, container};
//! use serde_json::json;
//! let mut buffer = Buffer::default();
//! let bytes: Vec<u8> = [0.0f32, 1.0, 2.0].iter().flat_map(|x| x.to_le_bytes()).collect();
//! let times = buffer.push(&bytes, Some(ViewTarget::Vertices), Component::Float, "SCALAR", 3, json!({ "min": [0.0] }));
//! assert_eq!(times, 0);
//! let document = json!({ "asset": { "version": "2.0" }, "accessors": buffer.layout.accessors });
//! assert!(container(&document, &buffer.bytes)?.starts_with(b"glTF"));
//! # Ok::<(), std::io::Error>(())
//! ```

use serde_json::{Value, json};
use std::io::{self, Write};

/// Type of a component, with its number in glTF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// `u8`.
    UnsignedByte = 5121,
    /// `u16`.
    UnsignedShort = 5123,
    /// `u32`.
    UnsignedInt = 5125,
    /// `f32`.
    Float = 5126,
}

/// Purpose of a view's bytes, with its number in glTF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViewTarget {
    /// Vertex attributes.
    Vertices = 34962,
    /// Vertex indices.
    Indices = 34963,
}

/// Views and accessors of a buffer whose bytes are stored elsewhere.
#[derive(Clone, Debug, Default)]
pub struct Layout {
    /// Size of the buffer so far, bytes; a multiple of 4.
    pub length: usize,
    /// Entries of the document's `bufferViews`.
    pub views: Vec<Value>,
    /// Entries of the document's `accessors`.
    pub accessors: Vec<Value>,
}

impl Layout {
    /// Appends a view of `bytes` bytes, padded to a multiple of 4. Returns its index.
    pub fn view(&mut self, bytes: usize, target: Option<ViewTarget>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.length, "byteLength": bytes });
        if let Some(target) = target {
            view["target"] = (target as u32).into();
        }
        self.views.push(view);
        self.length = (self.length + bytes).next_multiple_of(4);
        self.views.len() - 1
    }

    /// Adds an accessor of `count` elements of type `kind`, such as `"VEC3"`, and returns its index. `offset` is its
    /// byte offset within the view; `more` holds further keys.
    pub fn accessor(
        &mut self,
        view: usize,
        offset: Option<u64>,
        component: Component,
        kind: &str,
        count: usize,
        more: Value,
    ) -> usize {
        let mut accessor = json!({ "bufferView": view });
        if let Some(offset) = offset {
            accessor["byteOffset"] = offset.into();
        }
        accessor["componentType"] = (component as u32).into();
        accessor["count"] = count.into();
        accessor["type"] = kind.into();
        if let (Value::Object(accessor), Value::Object(more)) = (&mut accessor, more) {
            accessor.extend(more);
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

/// Buffer with its contents.
#[derive(Clone, Debug, Default)]
pub struct Buffer {
    /// Views and accessors.
    pub layout: Layout,
    /// Contents.
    pub bytes: Vec<u8>,
}

impl Buffer {
    /// Appends bytes in a view of their own. Returns its index.
    pub fn view(&mut self, bytes: &[u8], target: Option<ViewTarget>) -> usize {
        self.bytes.extend_from_slice(bytes);
        let view = self.layout.view(bytes.len(), target);
        self.bytes.resize(self.layout.length, 0);
        view
    }

    /// Appends an accessor in a view of its own. Returns the accessor's index. `more` is as for [`Layout::accessor`].
    pub fn push(
        &mut self,
        bytes: &[u8],
        target: Option<ViewTarget>,
        component: Component,
        kind: &str,
        count: usize,
        more: Value,
    ) -> usize {
        let view = self.view(bytes, target);
        self.layout.accessor(view, None, component, kind, count, more)
    }
}

/// Returns the keys `min` and `max` of an accessor with `width` numbers per element, to be passed as `more` to
/// [`Layout::accessor`].
///
/// * `numbers`: all numbers of the accessor; at least one element, no NaN
pub fn bounds(numbers: &[f32], width: usize) -> Value {
    let column = |k: usize| numbers.iter().copied().skip(k).step_by(width);
    let low: Vec<f32> = (0..width).map(|k| column(k).fold(f32::INFINITY, f32::min)).collect();
    let high: Vec<f32> = (0..width).map(|k| column(k).fold(f32::NEG_INFINITY, f32::max)).collect();
    json!({ "min": low, "max": high })
}

/// Writes the part of the file before the buffer: header, JSON chunk and, unless `length` is 0, the start of the BIN
/// chunk (glTF 2.0, section 4.4). The caller then writes `length` bytes, a multiple of 4.
///
/// Fails with errors of `out`; [`io::ErrorKind::InvalidInput`] if the file would exceed the 4 GiB limit of the
/// container.
pub fn write_head(document: &Value, length: usize, out: &mut dyn Write) -> io::Result<()> {
    write_head_of_text(document.to_string().into_bytes(), length, out)
}

fn write_head_of_text(mut text: Vec<u8>, length: usize, out: &mut dyn Write) -> io::Result<()> {
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + text.len() + if length == 0 { 0 } else { 8 + length };
    let size = u32::try_from(total).map_err(|_| {
        let text = format!("{total} bytes, expected at most {} in this format", u32::MAX);
        io::Error::new(io::ErrorKind::InvalidInput, text)
    })?;
    out.write_all(b"glTF")?;
    for number in [2, size, text.len() as u32] {
        out.write_all(&number.to_le_bytes())?;
    }
    out.write_all(b"JSON")?;
    out.write_all(&text)?;
    if length > 0 {
        out.write_all(&(length as u32).to_le_bytes())?;
        out.write_all(b"BIN\0")?;
    }
    Ok(())
}

/// Returns a whole file. `bytes` is the buffer, padded with zeros to a multiple of 4.
///
/// Fails like [`write_head`] if the file exceeds 4 GiB.
pub fn container(document: &Value, bytes: &[u8]) -> io::Result<Vec<u8>> {
    container_of_text(document.to_string().into_bytes(), bytes)
}

/// Returns a whole file like [`container`], but with arbitrary document text. For tests of readers.
///
/// Fails like [`container`].
pub fn container_of_text(text: Vec<u8>, bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut out = Vec::new();
    let length = bytes.len().next_multiple_of(4);
    write_head_of_text(text, length, &mut out)?;
    out.extend_from_slice(bytes);
    out.resize(out.len() + length - bytes.len(), 0);
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chunk(bytes: &[u8]) -> (usize, &[u8], &[u8]) {
        let length = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as usize;
        (length, &bytes[4..8], &bytes[8..8 + length])
    }

    #[test]
    fn views_are_aligned_and_chunk_lengths_are_consistent() {
        let mut buffer = Buffer::default();
        let colors = buffer.push(&[1, 2, 3], Some(ViewTarget::Vertices), Component::UnsignedByte, "VEC3", 1, json!({}));
        let view = buffer.view(&[4, 0, 5, 0, 6, 0], Some(ViewTarget::Indices));
        let tail = buffer.layout.accessor(view, Some(2), Component::UnsignedShort, "SCALAR", 2, json!({ "name": "t" }));
        let free = buffer.push(&[7; 4], None, Component::Float, "SCALAR", 1, bounds(&[0.5, -1.0], 1));
        assert_eq!((colors, tail, free), (0, 1, 2));
        assert_eq!(buffer.bytes, [1, 2, 3, 0, 4, 0, 5, 0, 6, 0, 0, 0, 7, 7, 7, 7]);
        assert_eq!(buffer.layout.length, buffer.bytes.len());
        assert_eq!(buffer.layout.views[1], json!({ "buffer": 0, "byteOffset": 4, "byteLength": 6, "target": 34963 }));
        assert_eq!(buffer.layout.views[2], json!({ "buffer": 0, "byteOffset": 12, "byteLength": 4 }));
        let expected = r#"{"bufferView":1,"byteOffset":2,"componentType":5123,"count":2,"type":"SCALAR","name":"t"}"#;
        assert_eq!(buffer.layout.accessors[1].to_string(), expected, "keys keep their order");
        assert_eq!(buffer.layout.accessors[2]["min"], json!([-1.0]));
        let document = json!({ "asset": { "version": "2.0" }, "accessors": buffer.layout.accessors });
        let file = container(&document, &buffer.bytes).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((&file[..4], file[4], file.len()), (&b"glTF"[..], 2, file[8] as usize + 256 * file[9] as usize));
        let (text, kind, json) = chunk(&file[12..]);
        assert_eq!((text % 4, kind), (0, &b"JSON"[..]));
        let same = serde_json::from_slice::<Value>(json).is_ok_and(|read| read == document);
        assert!(same);
        let (length, kind, bin) = chunk(&file[20 + text..]);
        assert_eq!((length, kind, bin), (16, &b"BIN\0"[..], &buffer.bytes[..]));
    }

    #[test]
    fn empty_buffer_has_no_bin_chunk_and_oversized_files_are_refused() {
        let file = container(&json!({}), &[]).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(file[20..], *b"{}  ");
        let error = write_head(&json!({}), u32::MAX as usize, &mut io::sink()).err();
        let text = error.map(|e| (e.kind(), e.to_string()));
        let expected = format!("{} bytes, expected at most {} in this format", 32 + u64::from(u32::MAX), u32::MAX);
        assert_eq!(text, Some((io::ErrorKind::InvalidInput, expected)));
    }

    #[test]
    fn bounds_are_per_column() {
        assert_eq!(bounds(&[1.0, 5.0, -2.0, 7.5], 2), json!({ "min": [-2.0, 5.0], "max": [1.0, 7.5] }));
    }
}
