//! Pattern matching of names.

/// Whether a pattern matches a name: `*` matches any run of characters, `?` a single one. Only ASCII letters are
/// compared case-insensitively, because Unicode case tables would enlarge the WebAssembly download.
pub fn glob(pattern: &str, name: &str) -> bool {
    let [pattern, name] = [pattern, name].map(|text| text.to_ascii_lowercase().chars().collect::<Vec<_>>());
    // `star` holds the position of the last `*` and the number of characters before its match ends. After a mismatch,
    // matching resumes there with one more character covered. Backtracking to an earlier `*` never helps.
    let (mut p, mut n, mut star) = (0, 0, None);
    while n < name.len() {
        match pattern.get(p) {
            Some('*') => {
                star = Some((p, n));
                p += 1;
            }
            Some(c) if *c == '?' || *c == name[n] => (p, n) = (p + 1, n + 1),
            _ => {
                let Some((at, swallowed)) = star else { return false };
                star = Some((at, swallowed + 1));
                (p, n) = (at + 1, swallowed + 1);
            }
        }
    }
    pattern[p..].iter().all(|c| *c == '*')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn globs_match_as_in_a_shell() {
        for (pattern, name, expected) in [
            ("Eye", "eye", true),
            ("Eye", "Eyes", false),
            ("eye*", "Eye_L", true),
            ("*", "", true),
            ("*hoof*", "front hoof L", true),
            ("a*b", "ab", true),
            ("a*b*", "axxbyy", true),
            ("a*b", "abc", false),
            ("a*a", "a", false),
            ("a*ab", "aaab", true),
            ("Eye?", "eyeL", true),
            ("Eye?", "eye", false),
            ("?*", "", false),
            ("*é?", "Öéx", true),
            ("", "", true),
            ("", "x", false),
        ] {
            assert_eq!(glob(pattern, name), expected, "{pattern:?} on {name:?}");
        }
    }
}
