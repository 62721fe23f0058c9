//! Shell quoting of commands.

/// Quotes a word for a POSIX shell.
pub fn shell_word(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

/// Quotes a whole command.
pub fn shell_line(words: &[String]) -> String {
    words.iter().map(|word| shell_word(word)).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_for_the_shell() {
        for (word, expected) in [
            ("a/b-c.glb", "a/b-c.glb"),
            ("my fox.glb", "'my fox.glb'"),
            ("it's", r"'it'\''s'"),
            ("", "''"),
            ("a[1]", "'a[1]'"),
        ] {
            assert_eq!(shell_word(word), expected);
        }
    }
}
