//! Shaders as they lie in a module's data: texts of lines among other bytes.

/// Puts spaces in the place of lines that are comments, `//` after nothing but spaces. Every text keeps its place and length, so that what points to it
/// still does, and spaces take no room once compressed.
pub fn blank_comments(data: &mut [u8]) {
    // What stands before the first end of a line may be part of another text, and so may what stands behind the last.
    let ends: Vec<usize> = data.iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(at, _)| at).collect();
    for pair in ends.windows(2) {
        let line = &mut data[pair[0] + 1..pair[1]];
        if is_comment(line) {
            line.fill(b' ');
        }
    }
}

fn is_comment(line: &[u8]) -> bool {
    std::str::from_utf8(line)
        .is_ok_and(|text| text.trim_start_matches(' ').starts_with("// ") && !text.contains(char::is_control))
}

#[cfg(test)]
mod tests {
    use super::blank_comments;

    #[test]
    fn whole_lines_of_comment_are_blank_and_all_else_keeps_its_place() {
        let mut data = "// first\nfn a() {\n    // why: γ\n    b(); // c\n//\n}\n// last".as_bytes().to_vec();
        let before = data.clone();
        blank_comments(&mut data);
        assert_eq!(data.len(), before.len());
        let text = String::from_utf8(data).unwrap_or_default();
        assert_eq!(text, "// first\nfn a() {\n              \n    b(); // c\n//\n}\n// last");
    }

    #[test]
    fn bytes_that_are_no_text_stay() {
        let before = b"\n// a\0b\n// \xff\n".to_vec();
        let mut data = before.clone();
        blank_comments(&mut data);
        assert_eq!(data, before);
    }
}
