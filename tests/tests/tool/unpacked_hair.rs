//! Tests of strands and guides in an unpacked package: files for other programs, and the result of packing edited
//! files.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use crate::tool::common::random::Random;
use crate::tool::common::sample_package;
use glam::Vec3;
use pelage_bake::stages::hair_groups::{GuidesAtRest, RestMesh};
use pelage_formats::*;
use pelage_tests::binary::Sandbox;
use serde_json::Value;

const STRANDS: usize = 7;
const POINTS: usize = 4;
const GUIDES: usize = 5;

/// Returns the sample package, with joints, dry and wet hair, and the given strands and groups of hair.
fn package(strands: &StoredStrands, groups: &[HairGroup]) -> Vec<u8> {
    let sample = sample_package();
    let opened = Package::open(&sample, &Limits::default()).unwrap();
    // The recipe is emptied, which makes it valid.
    let manifest = Manifest { recipe: String::new(), ..opened.manifest().clone() };
    let sections = opened.sections().iter().enumerate().skip(1);
    let add = |writer: PackageWriter<'static>, (index, section): (usize, &Section)| {
        writer.section(section.tag, opened.section_bytes(index).unwrap().to_vec())
    };
    let writer = sections.fold(PackageWriter::new(manifest), add);
    writer.hair_groups(groups).stored_strands(strands).finish().unwrap()
}

/// Returns strands that are evenly distributed in the tile, rise from it, and taper.
fn strands() -> StoredStrands {
    let scale = StrandScale { reach: 0.5, radius: 0.01 };
    let point = |i: usize| {
        let (strand, k) = (i / POINTS % STRANDS, i % POINTS);
        StoredStrandPoint {
            aside: [(k * (3000 + strand)) as i16, -(k as i16) * 777],
            height: (k * 65535 / (POINTS - 1)) as u16,
            radius: 65535 - (k * 20_001) as u16,
            color: [strand as u8 * 30, 255 - k as u8, 7],
            visibility: [i as u8, 128, 1, 255],
        }
    };
    StoredStrands {
        points_per_strand: POINTS as u32,
        scale,
        roots: (0..STRANDS).map(|i| [(i * 9000) as u16, 65535 - (i * 4000) as u16]).collect(),
        points: (0..2 * STRANDS * POINTS).map(point).collect(),
    }
}

fn group(name: &str) -> HairGroup {
    let guide = |i: usize| {
        let weights = [0.6, 0.3, 0.1];
        let points = (1..POINTS).map(|k| Vec3::new(0.01 * i as f32, -0.02, 0.1) * k as f32).collect();
        (TrianglePoint { triangle: i as u32 % 4, weights }, points)
    };
    let mut group = HairGroup {
        name: name.into(),
        hairs: 40,
        points: 17,
        seed: 3,
        root_radius_m: 1e-4,
        tip_radius_m: 3e-5,
        root_color: [90, 60, 30],
        tip_color: [200, 180, 90],
        clump: 0.3,
        lock_hairs: 8,
        scalp: vec![(0, 65535), (1, 40_000), (2, 1), (3, 9)],
        ..HairGroup::default()
    };
    group.set_guides(&(0..GUIDES).map(guide).collect::<Vec<_>>());
    group
}

fn groups() -> [HairGroup; 2] {
    [group("mane"), HairGroup { hairs: 0, scalp: Vec::new(), ..group("brow/left") }]
}

/// Unpacks the package into a new sandbox.
fn unpacked(bytes: &[u8]) -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.write("in.pelage", bytes);
    let run = sandbox.run(&["unpack", "in.pelage", "folder"]);
    assert_eq!(run.code, Some(0), "{run:?}");
    sandbox
}

fn packed(sandbox: &Sandbox) -> Vec<u8> {
    let run = sandbox.run(&["pack", "folder", "out.pelage"]);
    assert_eq!(run.code, Some(0), "{run:?}");
    let bytes = std::fs::read(sandbox.path().join("out.pelage")).unwrap();
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    bytes
}

/// Contents of a `.hair` file as written by `unpack`, with all arrays except transparency.
struct Hair {
    bytes: Vec<u8>,
    strands: usize,
    points: usize,
}

impl Hair {
    fn read(sandbox: &Sandbox, name: &str) -> Self {
        let bytes = std::fs::read(sandbox.path().join("folder").join(name)).unwrap();
        let count = |at: usize| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]) as usize;
        let (strands, points) = (count(4), count(8));
        assert_eq!(bytes.len(), 128 + 2 * strands + (12 + 4 + 12) * points, "{name}");
        Self { bytes, strands, points }
    }

    fn write(&self, sandbox: &Sandbox, name: &str) {
        sandbox.write(&format!("folder/{name}"), &self.bytes);
    }

    /// Changes `N` numbers, from index `index` on. Indices begin after the header and the segment counts.
    fn floats<const N: usize>(&mut self, index: usize, change: impl FnOnce(&mut [f32; N])) {
        let at = 128 + 2 * self.strands + 4 * index;
        let bytes = &mut self.bytes[at..at + 4 * N];
        let mut numbers = [0.0; N];
        for (number, bytes) in numbers.iter_mut().zip(bytes.as_chunks::<4>().0) {
            *number = f32::from_le_bytes(*bytes);
        }
        change(&mut numbers);
        bytes.copy_from_slice(&numbers.map(f32::to_le_bytes).concat());
    }

    fn point(&mut self, number: usize, change: impl FnOnce(&mut [f32; 3])) {
        self.floats(3 * number, change);
    }

    fn thickness(&mut self, number: usize, change: impl FnOnce(&mut [f32; 1])) {
        self.floats(3 * self.points + number, change);
    }

    fn color(&mut self, number: usize, change: impl FnOnce(&mut [f32; 3])) {
        self.floats(4 * self.points + 3 * number, change);
    }
}

fn stored(bytes: &[u8]) -> StoredStrands {
    Package::open(bytes, &Limits::default()).unwrap().strands().unwrap().unwrap().stored()
}

/// Returns the points of all guides in a group, on the mesh surface at rest.
fn at_rest(bytes: &[u8], group: usize) -> Vec<Vec<Vec3>> {
    let package = Package::open(bytes, &Limits::default()).unwrap();
    let (skin, groups) = (RestMesh::of(&package).unwrap(), package.hair_groups().unwrap());
    let group = &groups[group];
    let offsets = group.guide_offsets.chunks(group.guide_points as usize - 1);
    let points =
        |(root, offsets): (TrianglePoint, &[[i16; 3]])| GuidesAtRest(&skin).points(&root, offsets, group.reach_m);
    group.roots().zip(offsets).map(points).collect()
}

#[test]
fn strands_and_guides_are_unpacked_to_separate_files() {
    let bytes = package(&strands(), &groups());
    let sandbox = unpacked(&bytes);
    let files = sandbox.files();
    let names =
        ["hair.json", "hair_0_mane.hair", "hair_1_brow_left.hair", "strands.hair", "strands.json", "strands_wet.hair"];
    assert!(names.iter().all(|name| files.contains(&format!("folder/{name}"))), "{files:?}");
    assert!(!files.iter().any(|name| name.contains("STRN") || name.contains("HAIR")), "{files:?}");
    assert!(packed(&sandbox) == bytes, "the bytes differ");
    // The folder contains only files of `unpack`, so `unpack` may replace it.
    assert_eq!(sandbox.run(&["unpack", "in.pelage", "folder"]).code, Some(0));
    // The first strand of the tile is checked in metres, y up: the tile is 0.25 m wide, and the fur is 0.03 m high.
    let mut hair = Hair::read(&sandbox, "strands.hair");
    let made = strands();
    hair.point(POINTS - 1, |p| {
        let tip = made.points[POINTS - 1].decoded(made.scale);
        let root = strand_root(made.roots[0]);
        let expected = Vec3::new(0.25 * (root[0] + tip.aside[0]), 0.03, -0.25 * (root[1] + tip.aside[1]));
        assert!(Vec3::from(*p).distance(expected) < 1e-6, "{p:?}, expected {expected}");
    });
    hair.thickness(0, |t| assert!((t[0] - 2.0 * 0.01 * 0.25).abs() < 1e-7, "{t:?}"));
    // All values can be recovered from the `.hair` files, so the JSON files contain no exact integers.
    for name in ["hair.json", "strands.json"] {
        let text = std::fs::read_to_string(sandbox.path().join("folder").join(name)).unwrap();
        assert_eq!((text.matches("\"exact\": []").count(), text.matches("exact").count()), (2, 2), "{name}: {text}");
    }
}

#[test]
fn arbitrary_hair_sections_survive_a_round_trip() {
    for seed in 0..8 {
        let random = &mut Random(seed);
        let mut made = strands();
        let mut number = |most: u64| (random.next_u64() % most) as u32;
        // The reach varies. With the smallest, hair hardly leaves its root, so its coordinates lose digits; with the
        // largest, hair crosses tiles.
        made.scale = StrandScale { reach: [1e-6, 1e-3, 0.3, 50.0][seed as usize % 4], radius: 1e-3 };
        for root in &mut made.roots {
            *root = [number(1 << 16) as u16, number(1 << 16) as u16];
        }
        for point in &mut made.points {
            point.aside = [0; 2].map(|_| if number(9) == 0 { i16::MIN } else { number(1 << 16) as u16 as i16 });
            (point.height, point.radius) = (number(1 << 16) as u16, number(1 << 16) as u16);
            point.color = [0; 3].map(|_| number(256) as u8);
        }
        let mut groups = groups();
        for group in &mut groups {
            group.reach_m = [1e-7, 0.01, 3.0, 1e5][seed as usize % 4];
            for (triangle, weights) in &mut group.guide_roots {
                *triangle = number(4);
                let b = number(65536) as u16;
                *weights = [b, (number(65536) as u16).min(65535 - b)];
            }
            for offset in &mut group.guide_offsets {
                *offset = [0; 3].map(|_| if number(9) == 0 { i16::MIN } else { number(1 << 16) as u16 as i16 });
            }
        }
        let bytes = package(&made, &groups);
        let sandbox = unpacked(&bytes);
        let files = sandbox.files();
        assert!(
            files.contains(&"folder/hair.json".into()) && files.contains(&"folder/strands.json".into()),
            "{files:?}"
        );
        assert!(packed(&sandbox) == bytes, "seed {seed}: the bytes differ");
    }
}

#[test]
fn edited_tile_strands_are_packed() {
    let (made, bytes) = (strands(), package(&strands(), &groups()));
    let sandbox = unpacked(&bytes);
    let mut hair = Hair::read(&sandbox, "strands.hair");
    // Strand 2 is bent, thinned and coloured, while its root stays; strand 3 is moved as a whole across the border of
    // the tile.
    for k in 1..POINTS {
        hair.point(2 * POINTS + k, |p| p[0] += 0.01);
    }
    hair.thickness(2 * POINTS, |t| t[0] *= 0.5);
    hair.color(2 * POINTS, |c| *c = [1.0, 0.0, 0.0]);
    for k in 0..POINTS {
        hair.point(3 * POINTS + k, |p| p[0] -= 0.25);
    }
    hair.write(&sandbox, "strands.hair");
    let found = stored(&packed(&sandbox));
    assert_eq!(
        (found.scale, &found.roots),
        (made.scale, &made.roots),
        "a move by one tile must not change the stored root"
    );
    for (i, (found, point)) in found.points.iter().zip(&made.points).enumerate() {
        let mut expected = *point;
        if (2 * POINTS + 1..3 * POINTS).contains(&i) {
            // The offset is 0.01 m in a tile of 0.25 m; the integer 32767 represents the reach of 0.5 tile widths.
            expected.aside[0] += (0.01_f32 / 0.25 / 0.5 * 32767.0).round() as i16;
        }
        if i == 2 * POINTS {
            (expected.radius, expected.color) = (32768, [255, 0, 0]);
        }
        let near = |a: i16, b: i16| (i32::from(a) - i32::from(b)).abs() <= 1;
        assert!(near(found.aside[0], expected.aside[0]) && near(found.aside[1], expected.aside[1]), "{i}: {found:?}");
        assert_eq!(
            (found.height, found.radius, found.color),
            (expected.height, expected.radius, expected.color),
            "{i}"
        );
        assert_eq!(found.visibility, expected.visibility, "{i}");
    }
    // Moves the tip of strand 4 beyond all others: the stored reach grows, and all other points keep their positions.
    hair.point(5 * POINTS - 1, |p| p[2] -= 0.5);
    hair.write(&sandbox, "strands.hair");
    let far = stored(&packed(&sandbox));
    assert!(far.scale.reach > 1.9 && far.scale.radius == made.scale.radius, "{:?}", far.scale);
    for (i, (far, found)) in far.points.iter().map(|p| p.decoded(far.scale)).zip(&found.points).enumerate() {
        let found = found.decoded(made.scale);
        let apart = (far.aside[1] - found.aside[1] - if i == 5 * POINTS - 1 { 2.0 } else { 0.0 }).abs();
        assert!(apart < 1e-4 && (far.aside[0] - found.aside[0]).abs() < 1e-4, "{i}: {apart}");
    }
}

#[test]
fn edited_guides_are_packed() {
    let bytes = package(&strands(), &groups());
    let sandbox = unpacked(&bytes);
    let before = at_rest(&bytes, 0);
    let mut hair = Hair::read(&sandbox, "hair_0_mane.hair");
    // Guide 1 is combed sideways. Guide 2 is moved as a whole to the root of guide 1.
    for k in 1..POINTS {
        hair.point(POINTS + k, |p| p[0] += 0.05 * k as f32);
    }
    let apart = before[1][0] - before[2][0];
    for k in 0..POINTS {
        hair.point(2 * POINTS + k, |p| *p = (Vec3::from(*p) + apart).to_array());
    }
    hair.write(&sandbox, "hair_0_mane.hair");
    let edited = packed(&sandbox);
    let after = at_rest(&edited, 0);
    let reach_m = Package::open(&edited, &Limits::default()).unwrap().hair_groups().unwrap()[0].reach_m;
    for (i, (after, before)) in after.iter().zip(&before).enumerate() {
        for (k, (after, before)) in after.iter().zip(before).enumerate() {
            let moved = match i {
                1 => Vec3::X * 0.05 * k as f32,
                2 => apart,
                _ => Vec3::ZERO,
            };
            assert!(after.distance(*before + moved) < reach_m / 10_000.0, "guide {i}, point {k}: {after}");
        }
    }
    let groups = |bytes: &[u8]| Package::open(bytes, &Limits::default()).unwrap().hair_groups().unwrap();
    let (old, new) = (groups(&bytes), groups(&edited));
    assert_eq!(new[0].guide_roots[2].0, old[0].guide_roots[1].0, "the guide must be on the other triangle");
    assert_eq!((&new[0].guide_roots[..2], &new[1]), (&old[0].guide_roots[..2], &old[1]));
    // Changes values that only the JSON file contains.
    let path = sandbox.path().join("folder/hair.json");
    let mut json: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    (json[0]["hairs"], json[1]["name"]) = (77.into(), "brow".into());
    std::fs::write(&path, json.to_string()).unwrap();
    let found = groups(&packed(&sandbox));
    assert_eq!((found[0].hairs, found[1].name.as_str(), &found[1].guide_offsets), (77, "brow", &old[1].guide_offsets));
}

#[test]
fn invalid_unpacked_hair_is_refused_with_the_position() {
    let bytes = package(&strands(), &groups());
    type Change = fn(&Sandbox);
    type Edit<'a> = &'a dyn Fn(&mut Value);
    let json = |sandbox: &Sandbox, name: &str, change: Edit<'_>| {
        let path = sandbox.path().join("folder").join(name);
        let mut value: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        change(&mut value);
        std::fs::write(path, value.to_string()).unwrap();
    };
    let of_json: [(&str, Edit<'_>, &[&str]); 15] = [
        ("strands.json", &|v| drop(v["sets"].as_array_mut().unwrap().pop()), &["/sets", "1 sets, expected 2"]),
        (
            "strands.json",
            &|v| drop(v["sets"][1]["visibility"].as_array_mut().unwrap().pop()),
            &["strands_wet.hair: byte 4", "7 strands, expected 6"],
        ),
        (
            "strands.json",
            &|v| v["sets"][0]["visibility"][3] = "0g".into(),
            &["/sets/0/visibility/3", "expected 32 hexadecimal digits"],
        ),
        ("strands.json", &|v| v["points_per_strand"] = 5.into(), &["strands.hair: strand 0", "4 points, expected 5"]),
        ("strands.json", &|v| v["reach"] = 0.into(), &["/reach", "above 0"]),
        (
            "strands.json",
            &|v| v["height_m"] = 0.02.into(),
            &["strands.hair: strand 0, point 3", "y is 0.03, expected 0 to 0.02"],
        ),
        ("strands.json", &|v| v["with_m"] = 1.into(), &["/with_m", "did you mean \"width_m\"?"]),
        (
            "strands.json",
            &|v| v["sets"][0]["exact"] = serde_json::json!([{ "strand": 7, "root": [0, 0], "points": [] }]),
            &["/sets/0/exact/0/strand", "7, expected less than"],
        ),
        ("hair.json", &|v| drop(v.as_array_mut().unwrap().pop()), &["hair.json", "1 groups, expected 2"]),
        (
            "hair.json",
            &|v| drop(v[0]["guide_roots"].as_array_mut().unwrap().pop()),
            &["hair_0_mane.hair: byte 4", "5 strands, expected 4, the length of /0/guide_roots in hair.json"],
        ),
        (
            "hair.json",
            &|v| v[1]["guide_points"] = 9.into(),
            &["hair_1_brow_left.hair: strand 0", "4 points, expected 9"],
        ),
        (
            "hair.json",
            &|v| v[1]["guide_roots"][0][0] = 4.into(),
            &["/1/guide_roots", "triangle 4, expected less than the mesh's 4"],
        ),
        ("hair.json", &|v| v[0]["clump"] = 2.0.into(), &["hair.json: contents", "group 0 \"mane\": clump is 2"]),
        (
            "hair.json",
            &|v| drop(v[0].as_object_mut().unwrap().remove("seed")),
            &["hair.json: /0", "missing field `seed`"],
        ),
        (
            "manifest.json",
            &|v| {
                let sections = v["sections"].as_array_mut().unwrap();
                let hair = sections.iter_mut().find(|s| s["tag"] == "HAIR").unwrap();
                hair["strands"][1] = "../hair.hair".into();
            },
            &["/strands/1", "expected a file name without folders"],
        ),
    ];
    let of_files: [(Change, &[&str]); 6] = [
        (
            |s| std::fs::remove_file(s.path().join("folder/strands.hair")).unwrap(),
            &["strands.hair", "missing, but manifest.json names it at /sections/"],
        ),
        (
            |s| drop(s.write("folder/hair_0_mane.hair", b"HAIR")),
            &["hair_0_mane.hair: byte 0", "the header: expected 128 bytes"],
        ),
        (
            |s| {
                let mut hair = Hair::read(s, "strands.hair");
                hair.point(6, |p| p[1] = f32::NAN);
                hair.write(s, "strands.hair");
            },
            &["strands.hair: byte ", "row 6 has NaN, expected finite numbers"],
        ),
        (
            |s| {
                let mut hair = Hair::read(s, "strands.hair");
                hair.thickness(9, |t| t[0] = -1.0);
                hair.write(s, "strands.hair");
            },
            &["strands.hair: strand 2, point 1", "thickness is -1, expected 0 or more"],
        ),
        (
            |s| {
                let mut hair = Hair::read(s, "strands.hair");
                hair.bytes[12..16].copy_from_slice(&3u32.to_le_bytes());
                hair.write(s, "strands.hair");
            },
            &["strands.hair: byte 12", "lack thickness or colours"],
        ),
        (
            |s| {
                let mut hair = Hair::read(s, "hair_0_mane.hair");
                hair.point(POINTS, |p| p[1] += 9.0);
                hair.write(s, "hair_0_mane.hair");
            },
            &["hair_0_mane.hair: strand 1", "its root was moved from", "of the scalp"],
        ),
    ];
    let refused = |sandbox: &Sandbox, expected: &[&str]| {
        let run = sandbox.run(&["pack", "folder", "out.pelage"]);
        assert_eq!((run.code, sandbox.path().join("out.pelage").exists()), (Some(3), false), "{expected:?}: {run:?}");
        assert!(expected.iter().all(|words| run.stderr.contains(words)), "{expected:?} in: {}", run.stderr);
    };
    for (name, change, expected) in of_json {
        let sandbox = unpacked(&bytes);
        json(&sandbox, name, change);
        refused(&sandbox, expected);
    }
    for (change, expected) in of_files {
        let sandbox = unpacked(&bytes);
        change(&sandbox);
        refused(&sandbox, expected);
    }
}
