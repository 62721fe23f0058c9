//! Cases of unpacked folders: changed fields of the manifest, the animation and the mesh, and replaced files.

use super::bases::{Bases, chunks, glb, glb_of_text};
use super::case::{Case, Entry, OutputCheck, Step};
use super::change;
use super::random::Random;
use serde_json::Value;

/// Targets of symbolic links: an endless device, the link itself, a missing file, a folder, and a file of another type.
const TARGETS: [&str; 5] = ["/dev/zero", "", "gone", "..", "manifest.json"];

/// Makes a case.
pub fn case(bases: &Bases, turn: u64, random: &mut Random) -> Case {
    let (name, base) = random.pick(&bases.folders);
    let (file, how, entry) = match random.below(13) {
        0..=4 => document(base, "in/manifest.json", turn, random),
        5 => document(base, "in/animation.json", turn, random),
        6 => mesh(base, turn, random),
        7 => recipe(base, turn, random),
        8 => change_bytes(base, random),
        9 => document(base, "in/hair.json", turn, random),
        10 => document(base, "in/strands.json", turn, random),
        11 => strands(base, random),
        _ => replacement(base, random),
    };
    // The entry is removed from the base, so that a removed file stays removed.
    let base: Vec<Entry> = base.iter().filter(|entry| entry.name() != file).cloned().collect();
    let steps = vec![Step::makes(&["pack", "in", "out.pelage"], "out.pelage", OutputCheck::Validates)];
    Case::new(format!("{name}: {file}: {how}"), &base, entry.into_iter().collect(), steps)
}

/// Name of a file, description of the change, and the replacement.
type FileChange = (String, String, Option<Entry>);

fn bytes_of<'a>(base: &'a [Entry], name: &str) -> Option<&'a [u8]> {
    base.iter().find_map(|entry| match entry {
        Entry::File(file, bytes) if file == name => Some(bytes.as_slice()),
        _ => None,
    })
}

fn document(base: &[Entry], name: &str, turn: u64, random: &mut Random) -> FileChange {
    let Some(document) = bytes_of(base, name).and_then(|bytes| serde_json::from_slice::<Value>(bytes).ok()) else {
        return change_bytes(base, random);
    };
    let (how, text) = change::json(&document, turn, random);
    (name.into(), how, Some(Entry::file(name, text)))
}

/// Changes the mesh file, either its document or its buffer.
fn mesh(base: &[Entry], turn: u64, random: &mut Random) -> FileChange {
    const NAME: &str = "in/mesh.glb";
    let Some((document, mut bin)) = bytes_of(base, NAME).and_then(chunks) else { return change_bytes(base, random) };
    if random.below(3) == 0 {
        let how = change::bytes(&mut bin, random);
        return (NAME.into(), format!("buffer: {how}"), Some(Entry::File(NAME.into(), glb(&document, &bin))));
    }
    let (how, text) = change::json(&document, turn, random);
    (NAME.into(), how, Some(Entry::File(NAME.into(), glb_of_text(&text, &bin))))
}

fn recipe(base: &[Entry], turn: u64, random: &mut Random) -> FileChange {
    const NAME: &str = "in/recipe.toml";
    let text = bytes_of(base, NAME).and_then(|bytes| std::str::from_utf8(bytes).ok()).filter(|text| !text.is_empty());
    let (how, text) = change::toml(text.unwrap_or("[hair]\ndensity = 20\n"), turn, random);
    (NAME.into(), how, Some(Entry::file(NAME, text)))
}

/// Changes bytes of a random file.
fn change_bytes(base: &[Entry], random: &mut Random) -> FileChange {
    let name = random.pick(base).name().to_owned();
    let mut bytes = bytes_of(base, &name).unwrap_or_default().to_vec();
    let how = change::bytes(&mut bytes, random);
    (name.clone(), how, Some(Entry::File(name, bytes)))
}

/// Changes bytes of a strand file, mostly in its header.
fn strands(base: &[Entry], random: &mut Random) -> FileChange {
    let files: Vec<&str> = base.iter().map(Entry::name).filter(|name| name.ends_with(".hair")).collect();
    if files.is_empty() {
        return change_bytes(base, random);
    }
    let name = (*random.pick(&files)).to_owned();
    let mut bytes = bytes_of(base, &name).unwrap_or_default().to_vec();
    let how = if random.below(2) == 0 {
        change::bytes(&mut bytes, random)
    } else {
        let at = 4 * random.below(5);
        let new = *random.pick(&[0, 1, 3, 0xff, u32::MAX]);
        bytes[at..at + 4].copy_from_slice(&new.to_le_bytes());
        format!("{new} at byte {at}")
    };
    (name.clone(), how, Some(Entry::File(name, bytes)))
}

/// Replaces a file with a different entry, or removes it.
fn replacement(base: &[Entry], random: &mut Random) -> FileChange {
    let name = random.pick(base).name().to_owned();
    let (how, entry) = match random.below(5) {
        0 => ("deleted".to_owned(), None),
        1 => ("empty".into(), Some(Entry::file(&name, ""))),
        2 => ("a folder".into(), Some(Entry::Folder(name.clone()))),
        3 => {
            let target = *random.pick(&TARGETS);
            let own = name.trim_start_matches("in/");
            let target = if target.is_empty() { own } else { target };
            (format!("a link to {target}"), Some(Entry::Link(name.clone(), target.into())))
        }
        _ => {
            let from = random.pick(base).name();
            let bytes = bytes_of(base, from).unwrap_or_default();
            (format!("the contents of {from}"), Some(Entry::file(&name, bytes)))
        }
    };
    (name, how, entry)
}
