//! Interpretation of the names of materials, nodes and meshes: whether they stand for furred or bare parts.

use super::words::{
    BARE, BareWords, EYES, FURRED, FURRED_WITHIN, INSIDE, MOUTH, NOSE, POSITION_CHARACTERS, POSITION_WORDS, SNOUT,
};

/// Meaning of a name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NameMeaning {
    /// Nothing about hair.
    Nothing,
    /// Furred: `EyeFur`, `Body`.
    Furred,
    /// Bare, if the part with this name covers at most `most` of the mesh's area.
    Bare {
        /// Maximum share of the mesh's area, 0..=1.
        most: f32,
    },
}

/// Script of a character, for splitting words.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Script {
    /// Letters, whose words end at non-letters and before capitals.
    Letters { upper: bool },
    /// Katakana, whose words are written without separators.
    Katakana,
    /// Kanji and hiragana, whose words are written without separators. Kanji have hiragana as endings, so both are one
    /// class.
    HanAndHiragana,
    /// Character that is not part of a word.
    None,
}

fn script(c: char) -> Script {
    match c {
        '\u{30a0}'..='\u{30ff}' => Script::Katakana,
        '\u{3005}' | '\u{3041}'..='\u{309f}' | '\u{3400}'..='\u{4dbf}' | '\u{4e00}'..='\u{9fff}' => {
            Script::HanAndHiragana
        }
        _ if c.is_alphabetic() => Script::Letters { upper: c.is_uppercase() },
        _ => Script::None,
    }
}

/// Splits a name into words in lower case without accents, except that `ñ` keeps its tilde. `LeftEye.001`, `left_eye`
/// and `LEFT-EYE2` give the same two words.
pub(super) fn words(name: &str) -> Vec<String> {
    let narrow = |c: char| match c {
        // Full-width forms of ASCII become ASCII.
        '\u{ff01}'..='\u{ff5e}' => char::from_u32(c as u32 - 0xfee0).unwrap_or(c),
        _ => c,
    };
    // Combining accents belong to the preceding letter and do not split words.
    let is_accent = |c: &char| ('\u{300}'..='\u{36f}').contains(c);
    let all: Vec<char> = name.chars().map(narrow).collect();
    let mut chars: Vec<char> = Vec::new();
    for c in all {
        match chars.last_mut() {
            Some(last) if c == '\u{303}' && matches!(*last, 'n' | 'N') => *last = 'ñ',
            _ if is_accent(&c) => {}
            _ => chars.push(c),
        }
    }
    let mut words = vec![String::new()];
    let mut before = Script::None;
    for (i, c) in chars.iter().enumerate() {
        let here = script(*c);
        let next_is_lower = chars.get(i + 1).is_some_and(|c| script(*c) == Script::Letters { upper: false });
        let goes_on = match (before, here) {
            (_, Script::None) => false,
            (Script::Letters { upper: false }, Script::Letters { upper: true }) => false,
            // The last capital of a run begins a word, as in `LODEye`.
            (Script::Letters { upper: true }, Script::Letters { upper: true }) => !next_is_lower,
            (Script::Letters { .. }, Script::Letters { .. }) => true,
            (before, here) => before == here,
        };
        if !goes_on {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut().filter(|_| here != Script::None) {
            c.to_lowercase().for_each(|c| fold(c, word));
        }
        before = here;
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Appends a letter without its accent.
fn fold(c: char, word: &mut String) {
    word.push_str(match c {
        'à'..='å' | 'ā' | 'ă' | 'ǎ' => "a",
        'ç' => "c",
        'è'..='ë' | 'ē' | 'ě' => "e",
        'ì'..='ï' | 'ī' | 'ǐ' => "i",
        'ò'..='ö' | 'ø' | 'ō' | 'ǒ' => "o",
        'ù'..='ü' | 'ū' | 'ǔ' | 'ǖ' | 'ǘ' | 'ǚ' | 'ǜ' => "u",
        'æ' => "ae",
        'œ' => "oe",
        'ß' => "ss",
        other => return word.push(other),
    });
}

/// Interprets words from [`words`] as one name. A word for fur outweighs all others, because a bald body is worse than
/// a furred claw.
pub(super) fn meaning_of_words<W: AsRef<str>>(words: &[W]) -> NameMeaning {
    let words: Vec<&str> = words.iter().map(AsRef::as_ref).collect();
    let is_furred = |word: &&str| is_one_of(word, FURRED) || FURRED_WITHIN.iter().any(|within| word.contains(within));
    if words.iter().any(is_furred) {
        return NameMeaning::Furred;
    }
    let is_inside = words.iter().any(|word| INSIDE.contains(word));
    let limits = words.iter().filter_map(|word| {
        let of_mouth = (is_inside && is_one_of(word, MOUTH.words)).then_some(MOUTH.most);
        bare_word_kind(word).map(|kind| kind.most).or(of_mouth)
    });
    limits.reduce(f32::min).map_or(NameMeaning::Nothing, |most| NameMeaning::Bare { most })
}

/// Whether words from [`words`] name eyes or parts of eyes.
pub(super) fn are_names_of_eyes(words: &[String]) -> bool {
    let is_eye = |word: &String| bare_word_kind(word).is_some_and(|kind| kind.words == EYES);
    matches!(meaning_of_words(words), NameMeaning::Bare { .. }) && words.iter().any(is_eye)
}

/// Whether a material's name says that it belongs to eyes.
pub(crate) fn name_of_eyes(name: &str) -> bool {
    are_names_of_eyes(&words(name))
}

/// Whether words from [`words`] name a bare nose or snout.
pub(super) fn are_names_of_nose(words: &[String]) -> bool {
    let is_nose = |word: &String| bare_word_kind(word).is_some_and(|kind| kind.most == NOSE);
    meaning_of_words(words) != NameMeaning::Furred && (words.iter().any(is_nose) || are_names_of_snout(words))
}

/// Whether one of the words names a snout, which may be furred or bare.
pub(super) fn are_names_of_snout(words: &[String]) -> bool {
    words.iter().any(|word| is_one_of(word, SNOUT))
}

/// Returns the kind of bare part that a word names.
fn bare_word_kind(word: &str) -> Option<&'static BareWords> {
    let of = |word: &str| BARE.iter().find(|kind| is_one_of(word, kind.words));
    let without_place = || {
        let cut =
            POSITION_WORDS.iter().find_map(|place| word.strip_prefix(place).or_else(|| word.strip_suffix(place)))?;
        of(cut.trim_matches(POSITION_CHARACTERS))
    };
    let characters = word.trim_matches(POSITION_CHARACTERS);
    of(word)
        .or_else(without_place)
        .or_else(|| of(characters))
        // Split at genitive particles, as in 犬の目 and 狗的眼睛.
        .or_else(|| characters.split(['の', '的']).filter(|run| *run != characters).find_map(of))
}

/// Whether a word, or its stem without a plural ending, is in the list.
fn is_one_of(word: &str, list: &[&str]) -> bool {
    let singular = |ending: &str| word.strip_suffix(ending).filter(|stem| stem.len() > 2);
    [Some(word), singular("s"), singular("es")].into_iter().flatten().any(|word| list.contains(&word))
}

#[cfg(test)]
#[path = "names_tests.rs"]
mod tests;
