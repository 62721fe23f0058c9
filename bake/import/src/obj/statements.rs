//! Text of .obj and .mtl files: encodings, logical lines, keywords, numbers.

use super::fault::fault;
use crate::BakeError;
use crate::json::shorten;
use std::borrow::Cow;

/// Keywords that can begin a line of an OBJ file; deprecated ones are omitted.
pub(super) const KEYWORDS: &[&str] = &[
    "v",
    "vt",
    "vn",
    "vp",
    "f",
    "fo",
    "l",
    "p",
    "o",
    "g",
    "s",
    "mg",
    "usemtl",
    "mtllib",
    "usemap",
    "maplib",
    "cstype",
    "deg",
    "bmat",
    "step",
    "curv",
    "curv2",
    "surf",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "con",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "shadow_obj",
    "trace_obj",
    "ctech",
    "stech",
    "call",
    "csh",
];

/// Returns whether the first statement with arguments in `bytes` is an OBJ statement.
pub(crate) fn begins_like_obj(bytes: &[u8]) -> bool {
    // Header comments are rarely longer than this part of the text. If it has no statement, the file extension decides.
    let head = &bytes[..bytes.len().min(1 << 16)];
    // The cut may split a 16-bit character; then the last byte is dropped.
    let Ok(text) = decode("", head).or_else(|_| decode("", &head[..head.len() - 1])) else { return false };
    Statements::new(&text).find(|s| s.words().next().is_some()).is_some_and(|s| KEYWORDS.contains(&s.keyword()))
}

/// Decodes the text of a file: UTF-16 if it begins with a byte order mark, else UTF-8. Invalid UTF-8 (names in older
/// encodings) is replaced; it cannot be part of a number.
pub(super) fn decode<'a>(file: &str, bytes: &'a [u8]) -> Result<Cow<'a, str>, BakeError> {
    let from_bytes: fn([u8; 2]) -> u16 = match bytes {
        [0xfe, 0xff, ..] => u16::from_be_bytes,
        [0xff, 0xfe, ..] => u16::from_le_bytes,
        _ => return Ok(String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))),
    };
    let (pairs, rest) = bytes[2..].as_chunks::<2>();
    if !rest.is_empty() {
        let (at, reason) = (bytes.len() - 1, "the UTF-16 text ends in the middle of a character: it is cut off");
        return Err(BakeError::Input { file: file.into(), place: format!("byte {at}"), reason: reason.into() });
    }
    Ok(char::decode_utf16(pairs.iter().map(|p| from_bytes(*p))).map(|c| c.unwrap_or('\u{fffd}')).collect())
}

/// A logical line that is neither empty nor a comment.
#[derive(Debug, PartialEq)]
pub(super) struct Statement<'a> {
    /// Line in which the statement begins, counted from 1.
    pub line: usize,
    text: Cow<'a, str>,
}

impl Statement<'_> {
    pub fn keyword(&self) -> &str {
        self.text.split_whitespace().next().unwrap_or_default()
    }

    /// Returns the words after the keyword.
    pub fn words(&self) -> impl Iterator<Item = &str> {
        self.text.split_whitespace().skip(1)
    }

    /// Returns the text after the keyword as one name that may have spaces.
    pub fn name(&self) -> &str {
        self.text.split_once(char::is_whitespace).map_or("", |(_, rest)| rest.trim())
    }

    /// Parses the finite numbers after the keyword: at least `least`, at most `N`. Returns the numbers, padded with 0,
    /// and their count.
    pub fn numbers<const N: usize>(&self, file: &str, least: usize) -> Result<([f32; N], usize), BakeError> {
        let (numbers, count) = self.floats::<N>(file, least)?;
        match numbers.iter().position(|x| !x.is_finite()) {
            Some(i) => {
                let word = self.words().nth(i).unwrap_or_default();
                Err(self.unexpected(file, word, "a finite 32-bit number"))
            }
            None => Ok((numbers, count)),
        }
    }

    /// Parses numbers as [`Self::numbers`] does, but accepts infinities and NaN.
    pub fn floats<const N: usize>(&self, file: &str, least: usize) -> Result<([f32; N], usize), BakeError> {
        let (mut out, mut count) = ([0.0; N], 0);
        for word in self.words() {
            let Some(slot) = out.get_mut(count) else { return Err(self.miscounted(file, least, N)) };
            *slot = word.parse().map_err(|_| self.unexpected(file, word, "a number"))?;
            count += 1;
        }
        if count < least {
            return Err(self.miscounted(file, least, N));
        }
        Ok((out, count))
    }

    fn miscounted(&self, file: &str, least: usize, most: usize) -> BakeError {
        let found = self.words().count();
        self.fault(file, format!("`{}` has {found} numbers, expected {least} to {most}", shorten(self.keyword())))
    }

    /// Returns an error with the text `found` and the text `expected`.
    pub fn unexpected(&self, file: &str, found: &str, expected: &str) -> BakeError {
        self.fault(file, format!("`{}` has `{}`, expected {expected}", shorten(self.keyword()), shorten(found)))
    }

    pub fn fault(&self, file: &str, reason: impl Into<String>) -> BakeError {
        fault(file, self.line, reason)
    }
}

/// Iterator over the statements of a text. A backslash at the end of a line joins it with the next.
pub(super) struct Statements<'a> {
    rest: &'a str,
    line: usize,
}

impl<'a> Statements<'a> {
    pub fn new(text: &'a str) -> Self {
        Self { rest: text, line: 0 }
    }

    /// Returns the next line of the file, without its line end: LF, CR LF, or the lone CR of old systems.
    fn physical(&mut self) -> Option<&'a str> {
        if self.rest.is_empty() {
            return None;
        }
        self.line += 1;
        let end = self.rest.find(['\n', '\r']).unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(end);
        self.rest = rest.strip_prefix("\r\n").or_else(|| rest.strip_prefix(['\n', '\r'])).unwrap_or(rest);
        Some(line)
    }

    /// Returns the next logical line, without its comment.
    fn logical(&mut self) -> Option<Statement<'a>> {
        let first = self.physical()?;
        let line = self.line;
        let text = without_comment(first);
        let Some(head) = text.strip_suffix('\\') else { return Some(Statement { line, text: text.trim().into() }) };
        let mut joined = head.to_owned();
        // A backslash at the end of the last line has no effect.
        while let Some(next) = self.physical().map(without_comment) {
            joined.push(' ');
            let Some(head) = next.strip_suffix('\\') else {
                joined.push_str(next);
                break;
            };
            joined.push_str(head);
        }
        Some(Statement { line, text: joined.trim().to_owned().into() })
    }
}

/// Removes the comment from a line. A `#` begins a comment at the start of a word; within a word it is part of a name.
fn without_comment(line: &str) -> &str {
    let mut before = ' ';
    for (i, c) in line.char_indices() {
        if c == '#' && before.is_whitespace() {
            return line[..i].trim_end();
        }
        before = c;
    }
    line.trim_end()
}

impl<'a> Iterator for Statements<'a> {
    type Item = Statement<'a>;

    fn next(&mut self) -> Option<Statement<'a>> {
        loop {
            let statement = self.logical()?;
            if !statement.text.is_empty() {
                return Some(statement);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_line_endings_and_continuations_are_read() {
        let text = "# a\r\nv 1 2 \\\r\n 3\r\rf 1 #x\n\n  usemtl a#b c \ng \\";
        let found: Vec<_> = Statements::new(text).map(|s| (s.line, s.text.into_owned())).collect();
        let expected = [(2, "v 1 2   3"), (5, "f 1"), (7, "usemtl a#b c"), (8, "g")];
        assert_eq!(found, expected.map(|(line, text)| (line, text.to_owned())));
        assert_eq!(Statements::new("usemtl  a b ").next().map(|s| s.name().to_owned()), Some("a b".to_owned()));
    }

    #[test]
    fn continued_lines_take_linear_time() {
        // If each join copied the text, this would take 10¹¹ steps.
        let text = "f 1 2 3 \\\n".repeat(300_000);
        assert_eq!(Statements::new(&text).next().map(|s| s.words().count()), Some(1_199_999));
    }

    #[test]
    fn texts_are_recognised_by_their_first_statement() {
        for (text, expected) in [
            (&b"# Blender\n\nmtllib a.mtl\n"[..], true),
            (b"\xef\xbb\xbfv 1 2 3", true),
            (b"\xfe\xff\0v\0 \x001", true),
            (b"solid cube\nfacet normal 0 0 1\n", false),
            (b"g\nusemtl a", true),
            (b"g", false),
            (b"OFF\n3 1 0\n", false),
            (b"vertex 1 2 3", false),
            (b"# only a comment", false),
            (b"", false),
        ] {
            assert_eq!(begins_like_obj(text), expected, "{:?}", text.escape_ascii().to_string());
        }
    }
}
