//! Cases of strand files that recipes name: `.hair`, `.tfx`, text, USD as text, and lines in glTF.

use super::bases::{Bases, SMALL, chunks, glb, glb_of_text};
use super::case::{Case, Entry, OutputCheck, Step};
use super::change;
use super::hair_files::recipe_of;
use super::random::Random;

/// Byte offsets of the numbers in the headers of strand files.
const HEADS: [(&str, &[usize]); 3] =
    [("g.hair", &[0, 4, 8, 12, 16]), ("g3.tfx", &[0, 4, 8, 144, 148]), ("g4.tfx", &[0, 4, 8, 12])];

/// Makes a case.
pub fn case(bases: &Bases, turn: u64, random: &mut Random) -> Case {
    let Entry::File(file, bytes) = random.pick(&bases.guides) else {
        unreachable!("guide files have no other entries")
    };
    let (how, entries) = match file.as_str() {
        "g.glb" => lines(bytes, turn, random),
        "g.txt" | "g.usda" => {
            let (how, text) = change::words(&String::from_utf8_lossy(bytes), random);
            (how, vec![Entry::file(file, text)])
        }
        _ => {
            let mut changed = bytes.clone();
            let how = match HEADS.iter().find(|(name, _)| name == file).filter(|_| random.below(2) == 0) {
                Some((_, places)) => change_header(&mut changed, *random.pick(places), random),
                None => change::bytes(&mut changed, random),
            };
            (how, vec![Entry::file(file, changed)])
        }
    };
    let named = entries[0].name().to_owned();
    let recipe = Entry::file("r.toml", recipe_of(&named));
    let args = [&["bake", "m.glb", "-o", "out.pelage", "--recipe", "r.toml", "--set", "ink.enabled=false"][..], &SMALL];
    let steps = vec![Step::makes(&args.concat(), "out.pelage", OutputCheck::Validates)];
    Case::new(format!("{named}: {how}"), &[bases.glb(), recipe], entries, steps)
}

/// Changes a number of a header.
fn change_header(bytes: &mut [u8], at: usize, random: &mut Random) -> String {
    let field = &mut bytes[at..at + 4];
    let old = u32::from_le_bytes([field[0], field[1], field[2], field[3]]);
    let new = *random.pick(&[0, 1, 2, old.wrapping_add(1), old.wrapping_sub(1), old | 1 << 31, u32::MAX, 0x7fc0_0000]);
    field.copy_from_slice(&new.to_le_bytes());
    format!("{new} in place of {old} at byte {at}")
}

/// Changes a glTF file that contains lines. The buffer is in the same file or in a second one.
fn lines(file: &[u8], turn: u64, random: &mut Random) -> (String, Vec<Entry>) {
    let Some((mut document, mut bin)) = chunks(file) else { unreachable!("the guide file is a valid .glb") };
    match random.below(4) {
        0 => {
            let how = change::bytes(&mut bin, random);
            (format!("buffer: {how}"), vec![Entry::file("g.glb", glb(&document, &bin))])
        }
        1 => {
            document["buffers"][0]["uri"] = "g.bin".into();
            let (how, text) = change::json(&document, turn, random);
            (how, vec![Entry::file("g.gltf", text), Entry::file("g.bin", bin)])
        }
        _ => {
            let (how, text) = change::json(&document, turn, random);
            (how, vec![Entry::file("g.glb", glb_of_text(&text, &bin))])
        }
    }
}
