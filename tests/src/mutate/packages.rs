//! Cases of packages: changes to arbitrary bytes, the section table, and section contents, with valid and invalid
//! checksums.

use super::assemble::{assemble, reseal, sections};
use super::bases::Bases;
use super::case::{Case, Entry, OutputCheck, Step};
use super::change;
use super::random::Random;
use pelage_formats::{Animation, HairGroup, Limits, Manifest, Morphs, Package, Tag};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Interval between drawn cases. Most cases are not drawn, because a frame takes as long as many other commands.
const DRAWN: u64 = 8;
/// Maximum number of attempts to give a field another value of its type. After that, bytes are changed instead.
const TRIES: u64 = 12;

/// Makes a case.
pub fn case(bases: &Bases, turn: u64, random: &mut Random) -> Case {
    let (name, base) = random.pick(&bases.packages);
    let (how, bytes) = match random.below(10) {
        0 => {
            let mut bytes = base.clone();
            (change::bytes(&mut bytes, random), bytes)
        }
        1 | 2 => {
            // Changes the header or the section table, and updates the checksums.
            let mut bytes = base.clone();
            let how = if random.below(2) == 0 {
                change::bytes(&mut bytes, random)
            } else {
                change_header(&mut bytes, random)
            };
            reseal(&mut bytes);
            (format!("{how}, checksums right"), bytes)
        }
        3 => change_table(base, random),
        4..=6 => change_field(base, turn, random),
        _ => change_bytes(base, random),
    };
    let mut steps = vec![
        Step::reads(&["validate", "a.pelage", "--json"]),
        if turn.is_multiple_of(2) {
            Step::reads(&["inspect", "a.pelage"])
        } else {
            Step::reads(&["inspect", "a.pelage", "--json"])
        },
        Step::makes(&["unpack", "a.pelage", "out"], "out", OutputCheck::PacksBack),
    ];
    if turn.is_multiple_of(DRAWN) {
        let style = *random.pick(&["fur", "ink", "bare"]);
        let args = ["render", "a.pelage", "-o", "a.png", "--size", "16x16", "--shadow-map", "16", "--style", style];
        steps.push(Step::makes(&args, "a.png", OutputCheck::Nothing));
    }
    let entries = vec![Entry::File("a.pelage".into(), bytes)];
    Case { package: Some("a.pelage"), ..Case::new(format!("{name}: {how}"), &[], entries, steps) }
}

/// Changes a field of the header or of an entry in the section table.
fn change_header(bytes: &mut [u8], random: &mut Random) -> String {
    let count = bytes.get(12).copied().unwrap_or(0);
    let at = 8 + 4 * random.below(6 + 8 * usize::from(count));
    let Some(field) = bytes.get_mut(at..at + 4) else { return "nothing".into() };
    let old = u32::from_le_bytes([field[0], field[1], field[2], field[3]]);
    let new = match random.below(4) {
        0 => old.wrapping_add(16),
        1 => old.wrapping_sub(16),
        2 => old.wrapping_add(1),
        _ => random.next_u64() as u32,
    };
    field.copy_from_slice(&new.to_le_bytes());
    format!("{new} in place of {old} at byte {at}")
}

/// Removes, duplicates, swaps, empties or renames sections, or changes the version.
fn change_table(base: &[u8], random: &mut Random) -> (String, Vec<u8>) {
    let (mut version, mut list) = sections(base);
    let (a, b) = (random.below(list.len()), random.below(list.len()));
    let tag = |list: &[([u8; 4], Vec<u8>)], at: usize| String::from_utf8_lossy(&list[at].0).into_owned();
    let name = tag(&list, a);
    let how = match random.below(7) {
        0 => {
            list.remove(a);
            format!("without section {a}, {name}")
        }
        1 => {
            let section = list[a].clone();
            list.insert(b, section);
            format!("section {a}, {name}, again at {b}")
        }
        2 => {
            list.swap(a, b);
            format!("sections {a} and {b} exchanged")
        }
        3 => {
            list[a].1.clear();
            format!("section {a}, {name}, empty")
        }
        4 => {
            list[a].0 = list[b].0;
            format!("section {a}, {name}, called {}", tag(&list, b))
        }
        5 => {
            list[a].1 = list[b].1.clone();
            format!("section {a}, {name}, with the contents of {b}")
        }
        _ => {
            version = random.below(5) as u32;
            format!("version {version}")
        }
    };
    (how, assemble(version, &list))
}

/// Changes a field of the manifest, the animation, the morph targets or the guided hair. The new value has the right
/// type, but may be meaningless.
fn change_field(base: &[u8], turn: u64, random: &mut Random) -> (String, Vec<u8>) {
    let (version, mut list) = sections(base);
    let package = Package::open(base, &Limits::default());
    // Manifests of older versions have different fields.
    let Some(package) = package.ok().filter(|package| package.version() == 3) else {
        return change_bytes(base, random);
    };
    let animation = package.animation().ok().flatten().filter(|_| random.below(4) == 0);
    let morphs = package.morphs().ok().flatten().filter(|_| random.below(8) == 0);
    let groups = package.hair_groups().unwrap_or_default();
    let (tag, changed) = match animation {
        _ if morphs.is_some() => {
            (Tag::MORPHS, morphs.and_then(|morphs| encode_changed::<Morphs>(&morphs, turn, random)))
        }
        Some(animation) => (Tag::ANIMATION, encode_changed::<Animation>(&animation, turn, random)),
        None if !groups.is_empty() && random.below(2) == 0 => {
            (Tag::HAIR, encode_changed::<Vec<HairGroup>>(&groups.to_vec(), turn, random))
        }
        None => (Tag::MANIFEST, encode_changed::<Manifest>(package.manifest(), turn, random)),
    };
    let place = list.iter_mut().find(|(found, _)| *found == tag.0);
    let (Some((how, bytes)), Some(place)) = (changed, place) else { return change_bytes(base, random) };
    place.1 = bytes;
    (format!("{tag}: {how}"), assemble(version, &list))
}

/// Changes one field of `value`, and encodes the result as a section.
fn encode_changed<T: Serialize + DeserializeOwned>(
    value: &T,
    turn: u64,
    random: &mut Random,
) -> Option<(String, Vec<u8>)> {
    let document = serde_json::to_value(value).ok()?;
    // `FORMAT.md` specifies this encoding: integers of fixed width, little-endian.
    let config = bincode::config::standard().with_little_endian().with_fixed_int_encoding();
    (0..TRIES).find_map(|_| {
        let (how, text) = change::json(&document, turn, random);
        let changed: T = serde_json::from_str(&text).ok()?;
        Some((how, bincode::serde::encode_to_vec(changed, config).ok()?))
    })
}

/// Changes the bytes of one section. The package is reassembled with the new length, so that the change reaches the
/// section readers.
fn change_bytes(base: &[u8], random: &mut Random) -> (String, Vec<u8>) {
    let (version, mut list) = sections(base);
    // Half of the cases change the manifest, because it has most of the fields.
    let at = if random.below(2) == 0 { 0 } else { random.below(list.len()) };
    let mut how = Vec::new();
    for _ in 0..=random.below(2) {
        how.push(change::bytes(&mut list[at].1, random));
    }
    let tag = String::from_utf8_lossy(&list[at].0).into_owned();
    (format!("section {at}, {tag}: {}", how.join(", ")), assemble(version, &list))
}
