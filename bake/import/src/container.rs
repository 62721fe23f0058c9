//! Detection of the file format, and the two chunks of a GLB (glTF 2.0, chapter 4 "GLB File Format Specification").
//!
//! The format is detected from the contents, because files are often named wrongly. The extension `.obj` counts only if
//! the beginning of a text does not identify the format. Examples of such a beginning are a comment, an empty line, or
//! a mistake in the first statement.

use super::notes::Notes;
use super::obj;
use crate::BakeError;
use std::path::Path;

/// File formats that can be read.
#[derive(Debug, PartialEq)]
pub(super) enum ModelFile<'a> {
    Gltf(Container<'a>),
    Obj,
}

/// Parts of a glTF file.
#[derive(Debug, PartialEq)]
pub(super) struct Container<'a> {
    pub json: &'a [u8],
    /// Byte offset of `json` in the file.
    pub json_offset: usize,
    /// BIN chunk of a GLB.
    pub bin: Option<&'a [u8]>,
}

const CONVERT: &str =
    "expected glTF 2.0 (.gltf or .glb) or OBJ; other formats can be converted, for example with Blender's glTF export";

/// Detects the format of `bytes`, and splits glTF into its parts.
pub(super) fn detect<'a>(file: &str, bytes: &'a [u8], notes: &mut Notes) -> Result<ModelFile<'a>, BakeError> {
    let fail = |at: usize, reason: String| {
        Err(BakeError::Input { file: file.to_owned(), place: format!("byte {at}"), reason })
    };
    if bytes.is_empty() {
        return fail(0, format!("the file is empty, {CONVERT}"));
    }
    if bytes.starts_with(b"glTF") {
        return split_glb(bytes, notes).map(ModelFile::Gltf).or_else(|(at, reason)| fail(at, reason));
    }
    // RFC 8259 forbids a byte order mark and allows readers to skip it.
    let json_offset = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
    let json = &bytes[json_offset..];
    let Some(first) = json.iter().position(|b| !b.is_ascii_whitespace()) else {
        return fail(json_offset, format!("the file contains only whitespace, {CONVERT}"));
    };
    if json[first] == b'{' {
        return Ok(ModelFile::Gltf(Container { json, json_offset, bin: None }));
    }
    let guess = match bytes {
        _ if bytes.starts_with(b"Kaydara FBX Binary") => "an FBX file",
        _ if bytes.starts_with(b"BLENDER") || bytes.starts_with(&[0x28, 0xb5, 0x2f, 0xfd]) => "a Blender file",
        _ if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") => "a PLY file",
        _ if bytes.starts_with(b"PELAGE") => "a pelage package",
        _ if bytes.starts_with(b"PK\x03\x04") => "a ZIP archive (perhaps of a model; unpack it)",
        _ if bytes.starts_with(b"\x89PNG") || bytes.starts_with(b"\xff\xd8\xff") => "an image",
        _ if obj::begins_like_obj(bytes) || has_extension(file, "obj") => return Ok(ModelFile::Obj),
        _ if json[first] == b'<' => "an XML file",
        _ => "neither GLB nor JSON nor OBJ",
    };
    let head: Vec<String> = bytes.iter().take(4).map(|b| format!("{b:02x}")).collect();
    fail(json_offset + first, format!("this is {guess} (it begins with {}), {CONVERT}", head.join(" ")))
}

fn has_extension(file: &str, extension: &str) -> bool {
    Path::new(file).extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

/// Type (four bytes) and contents of a GLB chunk.
type Chunk<'a> = ([u8; 4], &'a [u8]);

fn split_glb<'a>(bytes: &'a [u8], notes: &mut Notes) -> Result<Container<'a>, (usize, String)> {
    let u32_at = |at: usize| {
        let four = bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
        four.ok_or_else(|| (bytes.len(), format!("the file ends here, expected 4 bytes at offset {at} of the GLB")))
    };
    let version = u32_at(4)?;
    if version != 2 {
        return Err((4, format!("GLB version is {version}, expected 2")));
    }
    let length = u32_at(8)? as usize;
    if length > bytes.len() {
        return Err((8, format!("the header says {length} bytes, but the file has {}: it is cut off", bytes.len())));
    }
    if length < 20 {
        return Err((8, format!("the header says {length} bytes, expected at least 20 (header and JSON chunk)")));
    }
    if length < bytes.len() {
        notes.warn(format!("{} bytes after the end of the GLB ignored", bytes.len() - length));
    }
    let chunk = |at: usize| -> Result<Chunk<'a>, (usize, String)> {
        let size = u32_at(at)? as usize;
        let kind = u32_at(at + 4)?.to_le_bytes();
        let body = (at + 8).checked_add(size).filter(|end| *end <= length).and_then(|end| bytes.get(at + 8..end));
        let left = length.saturating_sub(at + 8);
        body.map(|body| (kind, body))
            .ok_or_else(|| (at, format!("a chunk says {size} bytes, but {left} are left: it is cut off")))
    };
    let (kind, json) = chunk(12)?;
    if &kind != b"JSON" {
        return Err((16, format!("the first chunk is {}, expected JSON", kind.escape_ascii())));
    }
    let mut at = 20 + json.len();
    let mut bin = None;
    // The binary chunk must be the second; chunks of unknown type are skipped wherever they are.
    while at < length {
        let (kind, body) = chunk(at)?;
        match &kind {
            b"BIN\0" if bin.is_none() => bin = Some(body),
            b"BIN\0" | b"JSON" => {
                return Err((at + 4, format!("a second {} chunk, expected one", kind.escape_ascii())));
            }
            _ => notes.warn(format!("unknown GLB chunk {} ignored", kind.escape_ascii())),
        }
        at += 8 + body.len();
    }
    // The standard pads JSON with spaces; some exporters pad with zeros.
    let padding = json.iter().rev().take_while(|b| **b == 0).count();
    Ok(Container { json: &json[..json.len() - padding], json_offset: 20, bin })
}
