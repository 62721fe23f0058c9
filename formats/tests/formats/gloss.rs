//! The `GLOS` section: round trip and rejected contents.

use crate::common::{open, sample_manifest, sample_with, section_bytes};
use pelage_formats::*;

/// Returns gloss for the first material only.
fn gloss() -> Vec<Option<Gloss>> {
    let mut gloss = vec![None; sample_manifest().materials.len()];
    gloss[0] = Some(Gloss { roughness: 0.06, reflectance: 0.025, metalness: 0.0, wet: true });
    gloss
}

#[test]
fn gloss_survives_a_round_trip() {
    let bytes = sample_with(|writer| writer.gloss(&gloss())).unwrap();
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    let opened = Package::open(&bytes, &Limits::default()).unwrap();
    assert_eq!(opened.gloss().unwrap(), gloss());
    // Bytes that a reader in another language depends on: a list of options of three f32 and a boolean.
    let first = [vec![1], [0.06f32, 0.025, 0.0].map(f32::to_le_bytes).concat(), vec![1]].concat();
    let count = gloss().len();
    let expected = [(count as u64).to_le_bytes().to_vec(), first, vec![0; count - 1]].concat();
    assert_eq!(section_bytes(&opened, Tag::GLOSS), expected);
}

#[test]
fn gloss_is_checked() {
    let change = |of: fn(&mut Gloss)| {
        let mut gloss = gloss();
        gloss[0].as_mut().map(of);
        gloss
    };
    for (gloss, expected) in [
        (change(|g| g.roughness = 0.0), "entry 0: roughness is 0, expected 0.04 to 1"),
        (change(|g| g.reflectance = f32::NAN), "entry 0: reflectance is NaN, expected 0 to 1"),
        (change(|g| g.metalness = 1.5), "entry 0: metalness is 1.5, expected 0 to 1"),
        ([gloss(), vec![None]].concat(), "entries, expected one for each of"),
    ] {
        let error = sample_with(|writer| writer.gloss(&gloss)).unwrap_err().to_string();
        assert!(error.contains(expected), "expected {expected:?} in: {error}");
    }
    let count = sample_manifest().materials.len();
    let long = sample_with(|writer| writer.section(Tag::GLOSS, vec![0; 9 + 14 * count])).unwrap_err().to_string();
    assert!(long.contains("too many for"), "{long}");
}

/// Checks that no changed byte of the section makes a reader panic, or accept a value out of range.
#[test]
fn damaged_gloss_is_rejected_or_in_range() {
    let bytes = sample_with(|writer| writer.gloss(&gloss())).unwrap();
    let stored = section_bytes(&open(&bytes), Tag::GLOSS);
    let (mut kept, mut refused) = (0, 0);
    for (at, value) in (0..stored.len()).flat_map(|at| [0, 1, 0x3f, 0x7f, 0x80, 0xff].map(|value| (at, value))) {
        let mut changed = stored.to_vec();
        changed[at] = value;
        match sample_with(|writer| writer.section(Tag::GLOSS, changed)) {
            Ok(bytes) => {
                kept += 1;
                let gloss = Package::open(&bytes, &Limits::default()).unwrap().gloss().unwrap();
                let sound = |g: &Gloss| Gloss::ROUGHNESS.contains(&g.roughness) && g.reflectance <= 1.0;
                assert!(gloss.iter().flatten().all(sound), "{gloss:?}");
            }
            Err(_) => refused += 1,
        }
    }
    assert!(kept > 0 && refused > 0, "{kept} {refused}");
}
