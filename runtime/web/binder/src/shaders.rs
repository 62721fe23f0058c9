//! Shader sources in a module's data: lines of text among other bytes.

/// Replaces comment lines by spaces. A comment line has only spaces before `//` or `//!`, and a space after it. The
/// position and length of every text stay the same, so that references stay valid. Spaces compress to almost nothing.
pub fn blank_comments(data: &mut [u8]) {
    // Text before the first end of line, or after the last, may be part of another text.
    let ends = line_ends(data);
    for pair in ends.windows(2) {
        let line = &mut data[pair[0] + 1..pair[1]];
        if is_comment(line) {
            line.fill(b' ');
        }
    }
}

/// Removes indentation and blank lines between a line that ends in an opening brace and a line that begins with the
/// closing brace. Such lines always belong to a single text. The removed spaces are moved behind the last line, so that
/// the text keeps its position and length. A run of spaces compresses to almost nothing.
pub fn remove_indentation(data: &mut [u8]) {
    let ends = line_ends(data);
    let mut open = None;
    for (number, pair) in ends.windows(2).enumerate() {
        let line = &data[pair[0] + 1..pair[1]];
        match open {
            Some(first) if line.starts_with(b"}") => {
                if number > first {
                    remove_line_starts(&mut data[ends[first] + 1..pair[0]]);
                }
                open = None;
            }
            Some(_) if is_indented(line) => continue,
            _ => open = (line.ends_with(b"{") && is_text(line)).then_some(number + 1),
        }
    }
}

/// Removes indentation and blank lines, and fills the end with spaces.
fn remove_line_starts(lines: &mut [u8]) {
    let left: Vec<&[u8]> =
        lines.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii_start).filter(|line| !line.is_empty()).collect();
    let mut left = left.join(&b'\n');
    left.resize(lines.len(), b' ');
    lines.copy_from_slice(&left);
}

fn line_ends(data: &[u8]) -> Vec<usize> {
    data.iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(at, _)| at).collect()
}

fn is_indented(line: &[u8]) -> bool {
    line.starts_with(b"    ") && is_text(line)
}

fn is_text(line: &[u8]) -> bool {
    std::str::from_utf8(line).is_ok_and(|text| !text.contains(char::is_control))
}

fn is_comment(line: &[u8]) -> bool {
    let begins = |text: &str| text.starts_with("// ") || text.starts_with("//! ");
    std::str::from_utf8(line).is_ok_and(|text| begins(text.trim_start_matches(' ')) && !text.contains(char::is_control))
}

#[cfg(test)]
mod tests {
    use super::{blank_comments, remove_indentation};

    #[test]
    fn comment_lines_are_blanked_in_place() {
        let mut data = "// first\nfn a() {\n    // why: γ\n//! d\n    b(); // c\n//\n}\n// last".as_bytes().to_vec();
        let before = data.clone();
        blank_comments(&mut data);
        assert_eq!(data.len(), before.len());
        let text = String::from_utf8(data).unwrap_or_default();
        assert_eq!(text, "// first\nfn a() {\n              \n     \n    b(); // c\n//\n}\n// last");
    }

    #[test]
    fn indentation_is_removed_without_changing_the_length() {
        let text = "fn a() {\n    b();\n            \n    if c {\n        d();\n    }\n}\n    e {\n  f\n}";
        let mut data = text.as_bytes().to_vec();
        data.insert(0, b'\n');
        remove_indentation(&mut data);
        let found = String::from_utf8(data).unwrap_or_default();
        assert_eq!(found.len(), text.len() + 1);
        assert_eq!(found, format!("\nfn a() {{\nb();\nif c {{\nd();\n}}{}\n}}\n    e {{\n  f\n}}", " ".repeat(33)));
    }

    #[test]
    fn non_utf8_bytes_are_unchanged() {
        let before = b"\n// a\0b\n// \xff\n".to_vec();
        let mut data = before.clone();
        blank_comments(&mut data);
        remove_indentation(&mut data);
        assert_eq!(data, before);
    }
}
