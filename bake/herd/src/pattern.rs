//! Path patterns: `animals/**/*.glb`.

use fast_glob::glob_match;

/// Inclusion and exclusion patterns. A path must match at least one of the former and none of the latter.
#[derive(Clone, Debug, Default)]
pub struct Patterns {
    fit: Vec<String>,
    except: Vec<String>,
}

impl Patterns {
    /// Parses patterns. `*` matches characters within a name, `**` matches folders. A pattern without a slash matches
    /// names in any folder.
    ///
    /// Fails with the invalid pattern, and the reason.
    pub fn new(fit: &[String]) -> Result<Self, String> {
        Ok(Self { fit: matchers(fit)?, except: Vec::new() })
    }

    /// Adds exclusions: paths that match one of `except` do not match.
    ///
    /// Fails like [`Self::new`].
    pub fn excluding(self, except: &[String]) -> Result<Self, String> {
        Ok(Self { except: matchers(except)?, ..self })
    }

    /// Returns true if the patterns match a path. It must be relative to the herd file's folder, with slashes.
    pub fn fits(&self, path: &str) -> bool {
        let any = |patterns: &[String]| patterns.iter().any(|pattern| glob_match(pattern, path));
        any(&self.fit) && !any(&self.except)
    }
}

fn matchers(patterns: &[String]) -> Result<Vec<String>, String> {
    patterns.iter().map(|pattern| matcher(pattern)).collect()
}

fn matcher(pattern: &str) -> Result<String, String> {
    let whole = if pattern.contains('/') { pattern.to_owned() } else { format!("**/{pattern}") };
    let whole = whole.strip_prefix("./").unwrap_or(&whole);
    for (open, close) in [('[', ']'), ('{', '}')] {
        // Paths rarely contain escaped or nested brackets, so patterns with them are not checked.
        if !whole.contains('\\') && whole.matches(open).count() > whole.matches(close).count() {
            return Err(format!("{pattern:?}: the bracket `{open}` is never closed by `{close}`"));
        }
    }
    Ok(whole.to_owned())
}

/// Returns the longest fixed folder prefix of a pattern; empty for the herd file's own folder.
pub fn base(pattern: &str) -> String {
    let mut steps: Vec<&str> = pattern.split('/').collect();
    // The last component of a pattern is a file name.
    steps.pop();
    let plain = steps.iter().take_while(|step| !step.contains(['*', '?', '[', '{'])).count();
    let base = steps[..plain].join("/");
    // An absolute pattern has an empty first component.
    if base.is_empty() && pattern.starts_with('/') { "/".into() } else { base }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_match_as_shell_globs() {
        let list = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
        let fits = |fit: &[&str], path: &str| {
            Patterns::new(&list(fit)).and_then(|fit| fit.excluding(&list(&["**/wip/**"]))).unwrap().fits(path)
        };
        for (pattern, path, expected) in [
            ("a/*.glb", "a/fox.glb", true),
            ("a/*.glb", "a/b/fox.glb", false),
            ("a/**/*.glb", "a/fox.glb", true),
            ("a/**/*.glb", "a/b/c/fox.glb", true),
            ("a/**/*.glb", "a/wip/fox.glb", false),
            ("*fox*", "a/b/red fox.glb", true),
            ("*fox*", "a/foxes/wolf.glb", false),
            ("*.{glb,obj}", "wolf.obj", true),
            ("**", "a/b.glb", true),
            ("../m/*.glb", "../m/fox.glb", true),
            ("./a/*.glb", "a/fox.glb", true),
        ] {
            assert_eq!(fits(&[pattern], path), expected, "{pattern} {path}");
        }
        assert!(Patterns::new(&list(&["a/[x"])).unwrap_err().contains("a/[x"));
    }

    #[test]
    fn base_folder_of_a_pattern_is_its_literal_prefix() {
        for (pattern, expected) in [
            ("*.glb", ""),
            ("a/*.glb", "a"),
            ("../m/n/**/*.glb", "../m/n"),
            ("a/b.glb", "a"),
            ("/m/*.glb", "/m"),
            ("/*.glb", "/"),
            ("a/*/c/d.glb", "a"),
        ] {
            assert_eq!(base(pattern), expected, "{pattern}");
        }
    }
}
