//! Packages: bytes anywhere, the table of sections, and what sections hold, with right checksums and with wrong ones.

use super::bases::Bases;
use super::case::{Case, Entry, Step, Then};
use super::change;
use super::lay_out::{lay_out, reseal, sections};
use super::random::Random;

/// Of so many cases one is drawn: a frame takes as long as many of the other commands.
const DRAWN: u64 = 40;

/// Makes a case.
pub fn case(bases: &Bases, turn: u64, random: &mut Random) -> Case {
    let (name, base) = random.pick(&bases.packages);
    let (how, bytes) = match random.below(10) {
        0 => {
            let mut bytes = base.clone();
            (change::bytes(&mut bytes, random), bytes)
        }
        1 | 2 => {
            // Header and table, with checksums that say that all is well.
            let mut bytes = base.clone();
            let how = if random.below(2) == 0 { change::bytes(&mut bytes, random) } else { head(&mut bytes, random) };
            reseal(&mut bytes);
            (format!("{how}, checksums right"), bytes)
        }
        3 => table(base, random),
        _ => contents(base, random),
    };
    let mut steps = vec![
        Step::reads(&["validate", "a.pelage", "--json"]),
        if turn.is_multiple_of(2) {
            Step::reads(&["inspect", "a.pelage"])
        } else {
            Step::reads(&["inspect", "a.pelage", "--json"])
        },
        Step::makes(&["unpack", "a.pelage", "out"], "out", Then::PacksBack),
    ];
    if turn.is_multiple_of(DRAWN) {
        let style = *random.pick(&["fur", "ink", "bare"]);
        let args = ["render", "a.pelage", "-o", "a.png", "--size", "16x16", "--shadow-map", "16", "--style", style];
        steps.push(Step::makes(&args, "a.png", Then::Nothing));
    }
    let entries = vec![Entry::File("a.pelage".into(), bytes)];
    Case { package: Some("a.pelage"), ..Case::new(format!("{name}: {how}"), &[], entries, steps) }
}

/// A field of the header or of an entry of the table.
fn head(bytes: &mut [u8], random: &mut Random) -> String {
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

/// Sections left out, doubled, exchanged, emptied, called something else; another version.
fn table(base: &[u8], random: &mut Random) -> (String, Vec<u8>) {
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
    (how, lay_out(version, &list))
}

/// One section's bytes, laid out anew whatever their length, so that what reads sections sees them.
fn contents(base: &[u8], random: &mut Random) -> (String, Vec<u8>) {
    let (version, mut list) = sections(base);
    // The manifest says most, and is a half of all.
    let at = if random.below(2) == 0 { 0 } else { random.below(list.len()) };
    let mut how = Vec::new();
    for _ in 0..=random.below(2) {
        how.push(change::bytes(&mut list[at].1, random));
    }
    let tag = String::from_utf8_lossy(&list[at].0).into_owned();
    (format!("section {at}, {tag}: {}", how.join(", ")), lay_out(version, &list))
}
