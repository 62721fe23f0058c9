//! Suggestions for mistyped names.

/// Minimum edit similarity, 0..=1. A candidate below both this and `MIN_WINKLER_SIMILARITY` is not suggested, because
/// it would mislead.
const MIN_EDIT_SIMILARITY: f64 = 0.4;
const MIN_WINKLER_SIMILARITY: f64 = 0.85;

/// Returns the similarity of two names, 0..=1, and whether it is high enough for a suggestion.
fn similarity(name: &str, candidate: &str) -> (f64, bool) {
    let (winkler, edits) =
        (strsim::jaro_winkler(name, candidate), strsim::normalized_damerau_levenshtein(name, candidate));
    (winkler.max(edits), winkler >= MIN_WINKLER_SIMILARITY || edits >= MIN_EDIT_SIMILARITY)
}

/// Returns the candidate most similar to `name`, the first among equals; `None` if none is similar enough.
pub fn nearest<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let mut best: Option<(f64, &str)> = None;
    for candidate in candidates {
        let (score, true) = similarity(name, candidate) else { continue };
        if best.is_none_or(|(top, _)| score > top) {
            best = Some((score, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}

/// Returns up to `most` candidates, most similar to `name` first. Equally similar candidates keep their order.
pub fn closest<'a>(name: &str, candidates: impl Iterator<Item = &'a str>, most: usize) -> Vec<&'a str> {
    let mut scored: Vec<(f64, &str)> = candidates.map(|candidate| (similarity(name, candidate).0, candidate)).collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    scored.into_iter().take(most).map(|(_, candidate)| candidate).collect()
}

/// Returns the message for a key that is not in `known`.
pub fn unknown_key(key: &str, known: &[&str]) -> String {
    match nearest(key, known.iter().copied()) {
        Some(near) => format!("unknown key; did you mean {near}?"),
        None => format!("unknown key, expected one of {}", known.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dissimilar_names_have_no_suggestion() {
        let names = ["hair.seed", "hair.length_m", "hair.density"];
        let near = |name| nearest(name, names.into_iter());
        assert_eq!(near("a"), None);
        assert_eq!(near("camera.fov"), None);
        assert_eq!(near("hair.densty"), Some("hair.density"));
        assert_eq!(near("hiar.lenght_m"), Some("hair.length_m"));
    }

    #[test]
    fn the_closest_names_come_first() {
        let names = ["tail", "ear.L", "nose_tip", "nose"];
        assert_eq!(closest("noes", names.into_iter(), 2), ["nose", "nose_tip"]);
        assert_eq!(closest("", names.into_iter(), 9), names);
    }
}
