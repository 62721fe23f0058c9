//! Random changes to bytes, JSON, TOML and words, with tables of replacement values.

use super::random::Random;
use serde_json::Value;

/// Replacement values for fields of 4 or 8 bytes: limits of integers; NaN, infinities, and very large or small floats.
const NUMBERS: [u64; 24] = [
    0,
    1,
    2,
    3,
    0x7f,
    0xff,
    0xffff,
    0x0001_0000,
    0x0100_0000,
    0x7fff_ffff,
    0x8000_0000, // -0 as a float
    0xffff_ffff,
    0x0000_0001_0000_0000,
    0x7fff_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    0xffff_ffff_ffff_ffff,
    0x7f80_0000,           // infinity
    0xff80_0000,           // -infinity
    0x7fc0_0000,           // NaN
    0x7f7f_ffff,           // the largest float
    0x0000_0800,           // the smallest floats
    0x7149_f2ca,           // 1e30
    0xbf80_0000,           // -1
    0x7ff8_0000_0000_0000, // NaN of 64 bits
];

/// Changes some bytes, and returns a description of the change.
pub fn bytes(bytes: &mut Vec<u8>, random: &mut Random) -> String {
    if bytes.is_empty() {
        bytes.push(random.next_u64() as u8);
        return "a byte appended".into();
    }
    // Half of the changes are in the first 128 bytes, where most files have their headers.
    let reach = if random.below(2) == 0 { bytes.len() } else { bytes.len().min(128) };
    let at = random.below(reach);
    let most = *random.pick(&[4, 64, 1024]);
    let count = random.below(most).min(bytes.len() - at);
    match random.below(10) {
        0 | 1 => {
            let bit = random.below(8);
            bytes[at] ^= 1 << bit;
            format!("bit {bit} of byte {at} flipped")
        }
        2 => {
            bytes[at] = random.next_u64() as u8;
            format!("byte {at} is {}", bytes[at])
        }
        3..=5 => {
            // Fields are aligned to four bytes in sections that are read in place, but not in encoded data.
            let at = if random.below(2) == 0 { at & !3 } else { at };
            let (number, width) = (*random.pick(&NUMBERS), *random.pick(&[4, 8]));
            for (byte, new) in bytes[at..].iter_mut().zip(&number.to_le_bytes()[..width]) {
                *byte = *new;
            }
            format!("{width} bytes at {at} are {number:#x}")
        }
        6 => {
            bytes[at..at + count].fill(0);
            format!("{count} bytes at {at} zeroed")
        }
        7 => {
            bytes.drain(at..at + count);
            format!("{count} bytes at {at} cut out")
        }
        8 => {
            let piece = bytes[at..at + count].to_vec();
            bytes.splice(at..at, piece);
            format!("{count} bytes at {at} doubled")
        }
        _ => {
            bytes.truncate(at);
            format!("cut off at byte {at}")
        }
    }
}

/// Replacement values for JSON; some are invalid.
const JSON: [&str; 44] = [
    "null",
    "true",
    "false",
    "-1",
    "0",
    "1",
    "2",
    "3",
    "7",
    "0.5",
    "-0.0",
    "1e-45",
    "255",
    "256",
    "65535",
    "65536",
    "2147483648",
    "4294967295",
    "4294967296",
    "9007199254740993",
    "18446744073709551615",
    "18446744073709551616",
    "1e30",
    "-1e30",
    "1e39",
    "1e300",
    "1e999",
    "NaN",
    "Infinity",
    "01",
    "\"\"",
    "\"x\"",
    "\"NaN\"",
    "\"..\"",
    "\"../x.bin\"",
    "\"/dev/zero\"",
    "\"a\\u0000b\"",
    "\"\\ud800\"",
    "[]",
    "[0]",
    "[0, 0, 0]",
    "[1e38, 1e38, 1e38, 1e38]",
    "{}",
    "{\"a\": 1}",
];

/// Placeholder for a replacement that is inserted as text; it does not occur in any valid input.
const MARK: &str = "\u{fffd}changed\u{fffd}";

/// Collects the JSON pointers of all values in a document except the root.
fn pointers(value: &Value, here: &str, out: &mut Vec<String>) {
    let mut add = |key: &str, value: &Value| {
        let key = key.replace('~', "~0").replace('/', "~1");
        let place = format!("{here}/{key}");
        pointers(value, &place, out);
        out.push(place);
    };
    match value {
        Value::Array(list) => list.iter().enumerate().for_each(|(i, v)| add(&i.to_string(), v)),
        Value::Object(map) => map.iter().for_each(|(k, v)| add(k, v)),
        _ => {}
    }
}

/// Returns a number close to `value` or of similar magnitude, as in typical errors of indices, counts and offsets.
fn near_number(value: &Value, random: &mut Random) -> Option<String> {
    let number = value.as_f64()?;
    let whole = |x: f64| if number.fract() == 0.0 && x.fract() == 0.0 { format!("{x:.0}") } else { format!("{x:e}") };
    Some(whole(*random.pick(&[number + 1.0, number - 1.0, number * 2.0, -number, number / 2.0, number * 1e6])))
}

/// Changes one value of a document. Returns a description and the text of the changed document. The value is chosen by
/// `turn`, so that consecutive cases cover all values.
pub fn json(document: &Value, turn: u64, random: &mut Random) -> (String, String) {
    let mut all = Vec::new();
    pointers(document, "", &mut all);
    if all.is_empty() {
        return ("nothing to change".into(), document.to_string());
    }
    let place = &all[(turn % all.len() as u64) as usize];
    let (parent, key) = place.rsplit_once('/').unwrap_or(("", place));
    let mut changed = document.clone();
    let old = document.pointer(place).cloned().unwrap_or_default();
    // The replacement is inserted as text, because a JSON tree cannot hold invalid values.
    let text = match random.below(10) {
        0 => {
            match changed.pointer_mut(parent) {
                Some(Value::Object(map)) => drop(map.shift_remove(key)),
                Some(Value::Array(list)) => drop(list.remove(key.parse().unwrap_or(0))),
                _ => {}
            }
            return (format!("{place} removed"), changed.to_string());
        }
        1 => match changed.pointer_mut(parent) {
            Some(Value::Object(map)) => {
                map.shift_remove(key);
                map.insert(format!("{key}s"), old);
                return (format!("{place} renamed"), changed.to_string());
            }
            Some(Value::Array(list)) => {
                list.push(old);
                return (format!("{place} doubled at the end"), changed.to_string());
            }
            _ => old.to_string(),
        },
        // An object gets the same key twice; a list gets an additional element.
        2 => format!("{old}, {}{}", if key.parse::<usize>().is_ok() { "" } else { "@" }, random.pick(&JSON)),
        3 => {
            let other = random.pick(&all);
            document.pointer(other).cloned().unwrap_or_default().to_string()
        }
        4 if random.below(4) == 0 => {
            let depth = *random.pick(&[64, 200, 100_000]);
            format!("{}{}", "[".repeat(depth), "]".repeat(depth))
        }
        4 if random.below(4) == 0 => format!("\"{}\"", "long ".repeat(20_000)),
        4..=6 => near_number(&old, random).unwrap_or_else(|| (*random.pick(&JSON)).to_owned()),
        _ => (*random.pick(&JSON)).to_owned(),
    };
    let text = text.replacen('@', &format!("{}: ", Value::from(key)), 1);
    if let Some(slot) = changed.pointer_mut(place) {
        *slot = MARK.into();
    }
    let short: String = text.chars().take(60).collect();
    (format!("{place} = {short}"), changed.to_string().replacen(&Value::from(MARK).to_string(), &text, 1))
}

/// Replacement values for TOML; some are invalid.
const TOML: [&str; 50] = [
    "nan",
    "-nan",
    "inf",
    "-inf",
    "-1",
    "0",
    "1",
    "2",
    "3",
    "0.5",
    "1.0",
    "-0.0",
    "1e-45",
    "1e30",
    "1e39",
    "1e999",
    "255",
    "4294967296",
    "9223372036854775807",
    "-9223372036854775808",
    "99999999999999999999",
    "0x7f",
    "1_000",
    "true",
    "false",
    "\"\"",
    "\"x\"",
    "\"vertex\"",
    "\"vertex#g\"",
    "\"a.png\"",
    "\"a.png#q\"",
    "\"../x.png\"",
    "\"/dev/zero\"",
    "\".\"",
    "\"#12\"",
    "\"#ffffff\"",
    "\"*\"",
    "\"\\u0000\"",
    "\"\\ud800\"",
    "[]",
    "[0]",
    "[0, 0, 0]",
    "[nan, 0, 0]",
    "[1e38, 1e38, 1e38]",
    "[\"\"]",
    "{}",
    "{ a = 1 }",
    "1979-05-27",
    "'''",
    "",
];

/// Changes one line of a TOML text. The line is chosen by `turn`, as in [`json`]. A value must end on the line on which
/// it begins.
pub fn toml(text: &str, turn: u64, random: &mut Random) -> (String, String) {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let with_words = |line: &String| !line.trim().is_empty() && !line.starts_with('#');
    let places: Vec<usize> = (0..lines.len()).filter(|i| with_words(&lines[*i])).collect();
    let at = places[(turn % places.len() as u64) as usize];
    let line = lines[at].clone();
    let (key, value) = line.split_once('=').unwrap_or((&line, ""));
    let (key, value) = (key.trim(), value.trim());
    let number: Option<f64> = value.parse().ok();
    let changed = match random.below(20) {
        // Scales the number by a small factor, which often keeps it within its range.
        16.. if number.is_some_and(|number| number != 0.0) => {
            let factor = *random.pick(&[0.1, 0.5, 2.0, 3.0, 10.0, -1.0]);
            let whole = value.parse::<i64>().is_ok();
            let new = number.unwrap_or_default() * factor;
            format!("{key} = {}", if whole { format!("{:.0}", new.trunc()) } else { format!("{new:?}") })
        }
        0 => String::new(),
        1 => format!("{line}\n{line}"),
        2 if value.is_empty() => key.replace(']', "x]"),
        2 => format!("{key}s = {value}"),
        3 if value.is_empty() => format!("[{key}]"),
        3 => format!("{key} = [{value}, {value}]"),
        4 if value.is_empty() => key.replacen("[[", "[", 1).replacen("]]", "]", 1),
        4 => format!("{key} = {{ {key} = {value} }}"),
        5 => lines[*random.pick(&places)].clone(),
        6 => {
            let other = random.pick(&places);
            let other = lines[*other].split_once('=').map_or("0", |(_, value)| value.trim());
            format!("{key} = {other}")
        }
        7 => {
            // Changes one digit of the value, which may be deep inside a list.
            let digits: Vec<usize> = value.match_indices(|c: char| c.is_ascii_digit()).map(|(at, _)| at).collect();
            let new = *random.pick(&["nan", "-", "e", "9", "999999999999", ".", "\"x\""]);
            let place = if digits.is_empty() { value.len() } else { *random.pick(&digits) };
            let end = (place + 1).min(value.len());
            format!("{key} = {}{new}{}", &value[..place], value.get(end..).unwrap_or_default())
        }
        8 if random.below(4) == 0 => {
            let depth = *random.pick(&[64, 200, 50_000]);
            format!("{key} = {}{}", "[".repeat(depth), "]".repeat(depth))
        }
        8 => {
            // Truncates the text in this line, at a character boundary.
            let cut = random.below(line.len());
            let cut = (0..=cut).rev().find(|i| line.is_char_boundary(*i)).unwrap_or(0);
            lines.truncate(at + 1);
            line[..cut].to_owned()
        }
        _ => format!("{key} = {}", random.pick(&TOML)),
    };
    let short: String = changed.chars().take(60).collect();
    lines[at] = changed;
    (format!("line {}: {short:?} for {line:?}", at + 1), lines.join("\n") + "\n")
}

/// Replacement words for a text such as an OBJ file.
const WORDS: [&str; 26] = [
    "",
    "-1",
    "0",
    "1",
    "3",
    "9",
    "99999999999",
    "-99999999999999999999",
    "1/",
    "1//",
    "//",
    "1/1/1/1",
    "nan",
    "inf",
    "1e39",
    "1e38",
    "1e-45",
    "v",
    "f",
    "g",
    "usemtl",
    "mtllib",
    "/dev/zero",
    "\\",
    "#",
    "ä",
];

/// Removes, duplicates or replaces a word or line of a text.
pub fn words(text: &str, random: &mut Random) -> (String, String) {
    let by_line = random.below(3) == 0;
    let mut pieces: Vec<&str> = text.split_inclusive(if by_line { &['\n'][..] } else { &[' ', '\n'] }).collect();
    let at = random.below(pieces.len());
    let what = match random.below(4) {
        0 => {
            let piece = pieces.remove(at);
            format!("without {piece:?}")
        }
        1 => {
            let piece = pieces[random.below(pieces.len())];
            pieces.insert(at, piece);
            format!("{piece:?} again")
        }
        _ => {
            let word = random.pick(&WORDS);
            let end = if pieces[at].ends_with('\n') { "\n" } else { " " };
            let old = pieces[at];
            pieces.splice(at..=at, [*word, end]).for_each(drop);
            format!("{word:?} for {old:?}")
        }
    };
    (format!("piece {at}: {what}"), pieces.concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_json_mutation_differs_and_reaches_every_value() {
        let document = json!({ "a": [1, { "b/c": "d" }], "e": null });
        let mut seen = std::collections::BTreeSet::new();
        for turn in 0..400 {
            let (what, text) = json(&document, turn, &mut Random::for_case(1, 2, turn));
            assert!(!text.contains(MARK), "{what}: {text}");
            seen.extend(what.split(' ').next().map(str::to_owned));
        }
        assert_eq!(seen.len(), 5, "{seen:?}");
        let doubled = (0..400).map(|turn| json(&document, turn, &mut Random::for_case(1, 2, turn)).1);
        assert!(doubled.filter(|text| text.matches("\"e\":").count() == 2).count() > 0, "no key was doubled");
    }

    #[test]
    fn text_and_byte_mutations_mostly_differ() {
        let text = "[a]\nb = 1\nc = [1, 2]\n";
        let differs = |i: u64| toml(text, i, &mut Random::for_case(3, 4, i)).1 != text;
        assert!((0..100).filter(|i| differs(*i)).count() > 80);
        let changed = |i: u64| {
            let mut bytes = text.as_bytes().to_vec();
            super::bytes(&mut bytes, &mut Random::for_case(5, 6, i));
            bytes != text.as_bytes()
        };
        assert!((0..100).filter(|i| changed(*i)).count() > 70);
        assert!((0..100).filter(|i| words(text, &mut Random::for_case(7, 8, *i)).1 != text).count() > 80);
    }
}
