//! Patterns of paths: `animals/**/*.glb`.

use fast_glob::glob_match;

/// Patterns of which one has to fit, and others of which none may.
#[derive(Clone, Debug, Default)]
pub struct Patterns {
    fit: Vec<String>,
    except: Vec<String>,
}

impl Patterns {
    /// Reads patterns. `*` stands for letters of a name, `**` for folders; a pattern without a slash is one of names, in whatever folder.
    ///
    /// # Errors
    ///
    /// Which of them is none, and why.
    pub fn new(fit: &[String]) -> Result<Self, String> {
        Ok(Self { fit: matchers(fit)?, except: Vec::new() })
    }

    /// The same, but for what fits one of `except`.
    ///
    /// # Errors
    ///
    /// As [`Self::new`].
    pub fn but(self, except: &[String]) -> Result<Self, String> {
        Ok(Self { except: matchers(except)?, ..self })
    }

    /// Whether a path fits, as it is written from the herd file's folder, with slashes.
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
        // A bracket behind a backslash, or one inside the others, is rare in paths; a pattern that has one is taken as it is.
        if !whole.contains('\\') && whole.matches(open).count() > whole.matches(close).count() {
            return Err(format!("{pattern:?}: the bracket `{open}` is never closed by `{close}`"));
        }
    }
    Ok(whole.to_owned())
}

/// The folder that all paths of a pattern are in, as far as it names one; empty for the herd file's own.
pub fn base(pattern: &str) -> String {
    let mut steps: Vec<&str> = pattern.split('/').collect();
    // What is left is a name.
    steps.pop();
    let plain = steps.iter().take_while(|step| !step.contains(['*', '?', '[', '{'])).count();
    let base = steps[..plain].join("/");
    // An absolute pattern begins with nothing before its slash.
    if base.is_empty() && pattern.starts_with('/') { "/".into() } else { base }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;

    #[test]
    fn paths_fit_as_in_a_shell() {
        let list = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
        let fits = |fit: &[&str], path: &str| {
            Patterns::new(&list(fit)).and_then(|fit| fit.but(&list(&["**/wip/**"]))).unwrap().fits(path)
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
    fn a_pattern_knows_where_to_look() {
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
