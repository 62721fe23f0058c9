//! Cases of models: glTF (both forms) and OBJ.

use super::bases::{Bases, MTL, OBJ, SMALL, glb, glb_of_text};
use super::case::{Case, Entry, OutputCheck, Step};
use super::change;
use super::random::Random;

/// Returns the commands that bake `model` to the smallest possible package, `out.pelage`, which must be valid. Every
/// other bake skips the ink style, which takes as long as the rest of the bake.
pub fn bake(model: &str, more: &[&str], turn: u64) -> Vec<Step> {
    let ink: &[&str] = if turn.is_multiple_of(2) { &["--set", "ink.enabled=false"] } else { &[] };
    let args = [&["bake", model, "-o", "out.pelage"][..], &SMALL, ink, more].concat();
    vec![Step::makes(&args, "out.pelage", OutputCheck::Validates)]
}

/// Makes a case.
pub fn case(bases: &Bases, turn: u64, random: &mut Random) -> Case {
    match random.below(20) {
        0..=8 => {
            let (how, text) = change::json(&bases.model.0, turn, random);
            of_glb(format!("document: {how}"), glb_of_text(&text, &bases.model.1), turn)
        }
        9..=11 => {
            let mut bin = bases.model.1.clone();
            let how = change::bytes(&mut bin, random);
            of_glb(format!("buffer: {how}"), glb(&bases.model.0, &bin), turn)
        }
        12 => {
            let mut file = glb(&bases.model.0, &bases.model.1);
            let how = change_header(&mut file, random);
            of_glb(how, file, turn)
        }
        13..=16 => {
            let (document, files) = bases.gltf();
            let (how, text) = change::json(&document, turn, random);
            let entries = vec![Entry::file("m.gltf", text)];
            Case::new(format!("gltf: {how}"), &files, entries, bake("m.gltf", &[], turn))
        }
        17 => {
            let (document, files) = bases.gltf();
            let model = Entry::file("m.gltf", document.to_string());
            let file = random.pick(&files).name().to_owned();
            let entry = match random.below(4) {
                0 => Entry::Link(file.clone(), "/dev/zero".into()),
                1 => Entry::Link(file.clone(), file.clone()),
                2 => Entry::Folder(file.clone()),
                _ => Entry::file(&file, ""),
            };
            let base = [files, vec![model]].concat();
            Case::new(format!("gltf: {entry:?}"), &base, vec![entry], bake("m.gltf", &[], turn))
        }
        18 => {
            let (how, text) = change::words(MTL, random);
            obj(bases, format!("a.mtl: {how}"), vec![Entry::file("a.mtl", text)], turn)
        }
        _ => {
            let (mut how, mut text) = change::words(OBJ, random);
            for _ in 0..random.below(3) {
                let more = change::words(&text, random);
                how = format!("{how}, {}", more.0);
                text = more.1;
            }
            obj(bases, format!("obj: {how}"), vec![Entry::file("m.obj", text)], turn)
        }
    }
}

fn of_glb(how: String, file: Vec<u8>, turn: u64) -> Case {
    Case::new(how, &[], vec![Entry::File("m.glb".into(), file)], bake("m.glb", &[], turn))
}

fn obj(bases: &Bases, how: String, entries: Vec<Entry>, turn: u64) -> Case {
    let base = [bases.images(), vec![Entry::file("m.obj", OBJ), Entry::file("a.mtl", MTL)]].concat();
    Case::new(how, &base, entries, bake("m.obj", &[], turn))
}

/// Changes the header of the file or of a chunk.
fn change_header(file: &mut Vec<u8>, random: &mut Random) -> String {
    let document = u32::from_le_bytes([file[12], file[13], file[14], file[15]]) as usize;
    let at = *random.pick(&[0, 4, 8, 12, 16, 20 + document, 24 + document]);
    let old = u32::from_le_bytes([file[at], file[at + 1], file[at + 2], file[at + 3]]);
    match random.below(6) {
        0 => {
            file.truncate(at);
            return format!("cut off at byte {at}");
        }
        1 => {
            let chunk = file[12..].to_vec();
            file.extend(chunk);
            let length = (file.len() as u32).to_le_bytes();
            file[8..12].copy_from_slice(&length);
            return "both chunks twice".into();
        }
        _ => {}
    }
    let new = *random.pick(&[0, 1, old.wrapping_add(4), old.wrapping_sub(4), old.wrapping_add(1), u32::MAX, old / 2]);
    file[at..at + 4].copy_from_slice(&new.to_le_bytes());
    format!("{new} in place of {old} at byte {at}")
}
