//! Tests of the section list, its use, and the caching of sections.

use super::{SECTIONS, mesh, probe};
use crate::*;
use std::path::{Path, PathBuf};

const WITH_INK: &[u8] = include_bytes!("../../tests/golden/v3-ink.pelage");
const WITH_FINS: &[u8] = include_bytes!("../../tests/golden/v3.pelage");

fn open(bytes: &[u8]) -> Package<'_> {
    Package::open(bytes, &Limits::default()).unwrap()
}

fn meshes_checked(f: impl FnOnce()) -> u32 {
    let before = mesh::CHECKED.get();
    f();
    mesh::CHECKED.get() - before
}

/// Accesses twice everything that a runtime reads from a package for drawing.
fn load(package: &Package<'_>) {
    for _ in 0..2 {
        let mesh = package.mesh().unwrap().unwrap();
        package.animation().unwrap();
        package.fins().unwrap();
        package.fur_textures().unwrap();
        package.wet_textures().unwrap();
        package.fin_textures().unwrap();
        for material in 0..package.manifest().materials.len() {
            package.base_color_texture(material).unwrap();
            package.groom_texture(material).unwrap();
        }
        if let Some(ink) = package.ink().unwrap() {
            assert_eq!(ink.vertices().len(), mesh.geometry().len());
            package.ink_textures().unwrap().unwrap();
        }
    }
}

#[test]
fn a_mesh_is_checked_once_for_each_opened_package() {
    assert_eq!(meshes_checked(|| load(&open(WITH_INK))), 1, "a model with ink");
    assert_eq!(meshes_checked(|| load(&open(WITH_FINS))), 1, "a model with fins and a skeleton");
    assert_eq!(meshes_checked(|| drop(open(WITH_INK))), 0, "opening reads no mesh");
    // Fins and ink use the mesh too, and may be accessed first.
    assert_eq!(meshes_checked(|| assert!(open(WITH_FINS).fins().unwrap().is_some())), 1);
    assert_eq!(meshes_checked(|| assert!(open(WITH_INK).ink_textures().unwrap().is_some())), 1);
    assert_eq!(meshes_checked(|| assert_eq!(Package::validate(WITH_INK, &Limits::default()), [])), 1);
    assert_eq!(meshes_checked(|| (0..3).for_each(|_| drop(open(WITH_INK).mesh()))), 3, "three packages");
}

#[test]
fn section_errors_are_cached() {
    let mut bytes = WITH_INK.to_vec();
    let mesh = *open(&bytes).sections().iter().find(|s| s.tag == Tag::MESH).unwrap();
    // The mesh has five vertices, which exceeds the limit.
    let few = Limits { vertices: 4, ..Limits::default() };
    let package = Package::open(&bytes, &few).unwrap();
    let first = package.mesh().unwrap_err();
    assert!(matches!(first, FormatError::Limit { what: "vertex count", .. }), "{first}");
    let count = meshes_checked(|| assert_eq!(package.mesh().unwrap_err(), first));
    assert_eq!(count, 0);
    bytes[mesh.offset as usize + 64] ^= 1;
    let damaged = open(&bytes);
    for _ in 0..2 {
        assert!(matches!(damaged.mesh().unwrap_err(), FormatError::Checksum { tag: Tag::MESH, .. }));
        assert!(matches!(damaged.ink().unwrap_err(), FormatError::Checksum { tag: Tag::MESH, .. }));
    }
}

#[test]
fn decoded_sections_are_shared() {
    let package = open(WITH_FINS);
    let (first, second) = (package.animation().unwrap().unwrap(), package.animation().unwrap().unwrap());
    assert!(std::sync::Arc::ptr_eq(&first, &second), "decoded once");
    let (first, second) = (package.mesh().unwrap().unwrap(), package.mesh().unwrap().unwrap());
    assert_eq!(first.geometry.as_ptr(), second.geometry.as_ptr());
    // Views borrow from the bytes, not from the package, and outlive it.
    let fins = open(WITH_FINS).fins().unwrap().unwrap();
    assert_eq!(fins.fins().count(), 3);
}

/// Packages can be shared between threads, and a package of long-lived bytes can be used where a shorter lifetime is
/// expected.
#[test]
fn packages_are_shared_and_covariant() {
    fn shared<T: Send + Sync>(_: &T) {}
    fn shorter<'a>(package: Package<'static>, _: &'a u8) -> Package<'a> {
        package
    }
    let package = shorter(open(WITH_INK), &0);
    shared(&package);
    let count = std::thread::scope(|scope| {
        let threads = [(); 4].map(|()| scope.spawn(|| meshes_checked(|| load(&package))));
        threads.map(|thread| thread.join().unwrap()).iter().sum::<u32>()
    });
    assert_eq!(count, 1, "four threads at once");
}

/// The table of tags in `FORMAT.md` has exactly the rows of the list.
#[test]
fn specification_lists_all_sections() {
    let text = include_str!("../../FORMAT.md");
    let (_, section) = text.split_once("\n## Sections\n").unwrap();
    let rows: Vec<&str> = section.lines().skip_while(|l| !l.starts_with('|')).take_while(|l| !l.is_empty()).collect();
    let known = SECTIONS.iter().filter(|kind| kind.tag != Tag::PROBE);
    let row = |kind: &&super::Kind| {
        let row = &kind.row;
        format!("| `{}` | {} | {} | {} | {} |", kind.tag, kind.since, row.what, row.how_many, row.place)
    };
    let mut expected = vec!["| tag | since version | what | how many | place |".into(), "|---|---|---|---|---|".into()];
    expected.extend(known.map(row));
    expected
        .push(format!("| any other | 1 | not defined in version {FORMAT_VERSION} | any number | any, but not first |"));
    assert_eq!(rows, expected);
}

#[test]
fn section_list_is_consistent() {
    for (i, kind) in SECTIONS.iter().enumerate() {
        assert!((1..=FORMAT_VERSION).contains(&kind.since), "{}", kind.tag);
        assert!(SECTIONS[..i].iter().all(|other| other.tag != kind.tag), "{} twice", kind.tag);
        assert_eq!(super::kind(kind.tag, FORMAT_VERSION).map(|k| k.tag), Some(kind.tag));
        assert!(super::kind(kind.tag, kind.since - 1).is_none(), "{} before its version", kind.tag);
    }
    assert!(super::kind(Tag(*b"none"), FORMAT_VERSION).is_none() && super::kind(Tag::HEAD, FORMAT_VERSION).is_none());
}

fn refused(writer: PackageWriter<'_>) -> String {
    writer.finish().unwrap_err().to_string()
}

/// Opening, validating and writing support the probe, although only its line in the list was added.
#[test]
fn adding_a_section_takes_one_file_and_one_line() {
    let bytes = PackageWriter::new(Manifest::default()).probe(&[7, 8, 9]).finish().unwrap();
    let package = open(&bytes);
    let before = probe::CHECKED.get();
    for _ in 0..3 {
        assert_eq!(package.probe().unwrap(), Some((&[7, 8, 9][..], 24)));
    }
    assert_eq!(probe::CHECKED.get() - before, 1);
    let plain = PackageWriter::new(Manifest::default()).finish().unwrap();
    assert_eq!(open(&plain).probe().unwrap(), None);
    // Three errors must be reported: a fault that the section's own check finds, with its position; a second section;
    // and a missing section.
    let zero = refused(PackageWriter::new(Manifest::default()).probe(&[1, 0]));
    assert!(
        zero.starts_with("section PROB at byte") && zero.ends_with("byte 1 is 0, expected any other value"),
        "{zero}"
    );
    let two = refused(PackageWriter::new(Manifest::default()).probe(&[1]).probe(&[1]));
    assert!(two.contains("PROB") && two.ends_with("a second section of this tag, expected at most one"), "{two}");
    let probed = || Manifest { model: "probed".into(), ..Manifest::default() };
    assert!(refused(PackageWriter::new(probed())).ends_with("expected one of a probed model"));
    PackageWriter::new(probed()).probe(&[1]).finish().unwrap();
    // In version 2 the probe's tag is unknown: any number of sections is allowed, and they are kept unread.
    let old = PackageWriter::new(Manifest::default()).version(2).probe(&[0]).probe(&[0]).finish().unwrap();
    assert_eq!(open(&old).probe().unwrap(), None);
    assert_eq!(open(&old).sections().len(), 3);
    // Damage is reported for the section itself.
    let mut damaged = bytes.clone();
    let at = open(&bytes).sections()[1].offset as usize;
    damaged[at] ^= 1;
    let faults = Package::validate(&damaged, &Limits::default());
    assert!(matches!(faults[..], [FormatError::Checksum { tag: Tag::PROBE, .. }]), "{faults:?}");
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] }).collect()
}

/// Returns the code of a source file, line by line, without comments.
fn code(text: &str) -> impl Iterator<Item = &str> {
    text.lines().map(str::trim).filter(|line| !line.starts_with("//"))
}

/// Only the probe's own file, the list and these tests name the probe. The code that opens, validates and writes
/// packages names no section but the manifest, with which every package begins.
#[test]
fn no_other_file_names_a_section() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let own = ["sections/probe.rs", "sections/tests.rs"].map(|file| source.join(file));
    let mut named = Vec::new();
    for file in sources(&source).iter().filter(|file| !own.contains(file)) {
        let text = std::fs::read_to_string(file).unwrap();
        named.extend(code(&text).filter(|line| line.to_lowercase().contains("probe")).map(str::to_owned));
    }
    assert_eq!(named, ["mod probe;", "&probe::KIND,"]);
    let mut tags = Vec::new();
    for file in ["container.rs", "package.rs", "open_validate.rs", "writer.rs"] {
        let text = std::fs::read_to_string(source.join(file)).unwrap();
        for line in code(&text) {
            let name =
                |rest: &str| rest.chars().take_while(|c| c.is_ascii_uppercase() || *c == '_').collect::<String>();
            let names = line.split("Tag::").skip(1).map(name);
            tags.extend(names.filter(|name| !name.is_empty()));
        }
    }
    tags.sort();
    tags.dedup();
    assert_eq!(tags, ["HEAD", "MANIFEST"]);
}
