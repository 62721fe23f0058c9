//! The `CNTR` section: round trip and rejected contents.

use crate::common::{furless_manifest, sample_mesh, section_bytes};
use pelage_formats::*;

/// Returns a package of a square of four triangles, without hair, with a section.
fn package(add: impl FnOnce(PackageWriter<'static>) -> PackageWriter<'static>) -> Result<Vec<u8>, FormatError> {
    let parts = vec![Part { material: 0, first_index: 0, index_count: 12 }];
    let manifest = Manifest { parts, ..furless_manifest() };
    add(PackageWriter::new(manifest).mesh(&sample_mesh(false))).finish()
}

fn contours() -> ContourMesh {
    let face = |edges, flags| ContourFace { edges, flags };
    let point = |a, b, share, next| CreasePoint { vertices: [a, b], share, kind: CreasePoint::BOUNDARY, next };
    ContourMesh {
        edges: vec![[0, 1], [1, 4], [0, 4], [1, 2], [2, 4]],
        faces: vec![face([0, 1, 2], 0b100), face([3, 4, 1], 0b100)],
        creases: vec![point(0, 1, 0, 1), point(0, 1, 32_768, 2), point(1, 1, 0, CreasePoint::NONE)],
        marks: (0..5).map(|i| ContourMark { line: 255, emphasis: i, darkness: 9, reserved: 0 }).collect(),
        most_nodes: 512,
    }
}

#[test]
fn contours_survive_a_round_trip() {
    let bytes = package(|writer| writer.contours(&contours())).unwrap();
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    let opened = Package::open(&bytes, &Limits::default()).unwrap();
    assert_eq!(opened.contours().unwrap().unwrap().to_data(), contours());
    // Bytes that a reader in another language depends on.
    let section = section_bytes(&opened, Tag::CONTOURS);
    let u32_at = |at: usize| u32::from_le_bytes(section[at..at + 4].try_into().unwrap());
    assert_eq!(std::array::from_fn(|k| u32_at(4 * k)), [5, 2, 3, 5, 512, 0, 0, 0]);
    assert_eq!([32, 36, 72, 76, 80, 92].map(u32_at), [0, 1, 0, 0, 0, 4]);
    assert_eq!((section.len(), &section[177..180]), (80 + 2 * 16 + 3 * 16 + 5 * 4, &[4, 9, 0][..]));
    let few = Limits { vertices: 4, ..Limits::default() };
    let opened = Package::open(&bytes, &few).unwrap();
    assert!(opened.contours().unwrap_err().to_string().contains("vertex count"));
}

#[test]
fn contour_contents_are_checked() {
    let with = |change: &dyn Fn(&mut ContourMesh)| {
        let mut data = contours();
        change(&mut data);
        data
    };
    for (data, expected) in [
        (with(&|d| d.marks.truncate(4)), "edge 1 is [1, 4]"),
        (with(&|d| d.marks.push(ContourMark::default())), "marks of 6 vertices, expected the 5 of the mesh"),
        (with(&|d| d.edges[3] = [2, 2]), "edge 3 is [2, 2]"),
        (with(&|d| d.faces[0].edges[1] = 5), "face 0 has an edge out of range"),
        (with(&|d| d.faces[1].flags = 8), "face 1 has unknown flags"),
        (with(&|d| d.faces[1].flags = 0b101), "face 1 has edges that do not meet"),
        (with(&|d| d.faces[1] = d.faces[0]), "face 1 uses an edge in the same direction"),
        (with(&|d| d.creases[0].vertices[1] = 5), "crease point 0 has a vertex out of range"),
        (with(&|d| d.creases[1].kind = 2), "crease point 1 has an unknown kind"),
        (with(&|d| d.creases[1].next = 3), "crease point 1 has a next point out of range"),
        (with(&|d| d.creases[2].next = 1), "crease point 2 has the next point of another"),
        (with(&|d| d.marks[2].reserved = 1), "mark 2 is"),
        (with(&|d| d.most_nodes = 100), "most_nodes is 100"),
        (with(&|d| d.most_nodes = 32_768), "most_nodes is 32768"),
    ] {
        let error = package(|writer| writer.contours(&data)).unwrap_err().to_string();
        assert!(error.contains(expected), "expected {expected:?} in: {error}");
    }
}

#[test]
fn every_truncation_and_changed_header_of_contours_is_detected() {
    let bytes = package(|writer| writer.contours(&contours())).unwrap();
    let opened = Package::open(&bytes, &Limits::default()).unwrap();
    let good = section_bytes(&opened, Tag::CONTOURS).to_vec();
    let rewrite = |section: Vec<u8>| package(|writer| writer.section(Tag::CONTOURS, section));
    assert_eq!(rewrite(good.clone()).unwrap(), bytes);
    for length in 0..good.len() {
        assert_eq!(rewrite(good[..length].to_vec()).unwrap_err().section(), Some(Tag::CONTOURS), "cut to {length}");
    }
    for at in (0..32).chain(72..80) {
        let mut damaged = good.clone();
        damaged[at] ^= 0x81;
        assert_eq!(rewrite(damaged).unwrap_err().section(), Some(Tag::CONTOURS), "byte {at}");
    }
}
