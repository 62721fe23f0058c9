//! Tests of hair files of other programs, from the test data. They check the contents, and the error of hair that is
//! interpolated with every tenth strand as a guide.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use crate::import::support::Bytes as _;
use crate::import::support::{Doc, F32, U16};
use glam::{Vec2, Vec3};
use pelage_bake::strands::export::StrandFormat;
use pelage_bake::strands::{CurvePoint, Curves};
use pelage_formats::meaning::hair_groups::{GuideInterpolator, smoothed};
use pelage_import::BakeError;
use pelage_import::guides::Guides;
use pelage_import::guides::read::GuideFormat;
use pelage_import::import_strands;
use pelage_needs::data;
use serde_json::{Value, json};

/// File, strands, points per strand, and largest allowed interpolation error (see [`interpolation_error`]).
const FILES: [(&str, usize, usize, f64); 5] = [
    ("straight.hair", 10_000, 16, 0.075),
    ("ponytail_back.tfx", 517, 16, 0.18),
    ("ponytail_front_top.tfx", 876, 16, 0.58),
    ("ponytail_tail.tfx", 474, 16, 0.15),
    ("Ratboy_mohawk.tfx", 2228, 32, 0.25),
];

/// Number of points per strand that are compared.
const POINTS: usize = 24;

/// Returns the RMS distance between all strands and hair grown from the same roots, with every tenth strand as a guide.
/// It is relative to the mean length of all strands.
fn interpolation_error(guides: &Guides) -> f64 {
    let shapes: Vec<Vec<Vec3>> = (0..guides.len()).map(|i| resampled(guides.strand(i))).collect();
    let followed = GuideInterpolator::new(shapes.iter().step_by(10).cloned().collect());
    let length = |shape: &[Vec3]| shape.windows(2).map(|ends| f64::from(ends[0].distance(ends[1]))).sum::<f64>();
    let mean = shapes.iter().map(|shape| length(shape)).sum::<f64>() / shapes.len() as f64;
    let guide = |i: usize, k: usize| shapes[10 * i][k] - shapes[10 * i][0];
    let (mut sum, mut count) = (0.0, 0);
    for shape in shapes.iter().enumerate().filter(|(i, _)| i % 10 != 0).map(|(_, shape)| shape) {
        let follow = followed.follow(shape[0]).unwrap();
        for (k, point) in shape.iter().enumerate() {
            let grown = shape[0] + follow.mix(|i| guide(i, k));
            sum += f64::from(grown.distance_squared(*point));
            count += 1;
        }
    }
    (sum / f64::from(count)).sqrt() / mean
}

/// Resamples a strand at equal arc lengths.
fn resampled(strand: &[Vec3]) -> Vec<Vec3> {
    let curve = smoothed(strand, 8 * POINTS);
    let mut along = vec![0.0f32];
    along.extend(curve.windows(2).scan(0.0, |sum, ends| {
        *sum += ends[0].distance(ends[1]);
        Some(*sum)
    }));
    let at = |k: usize| {
        let wanted = along[along.len() - 1] * k as f32 / (POINTS - 1) as f32;
        let after = along.partition_point(|a| *a < wanted).clamp(1, along.len() - 1);
        let t =
            ((wanted - along[after - 1]) / (along[after] - along[after - 1]).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        curve[after - 1].lerp(curve[after], t)
    };
    (0..POINTS).map(at).collect()
}

#[test]
fn interpolated_hair_is_near_the_combed_hair() {
    let Some(data) = data("interpolated_hair_is_near_the_combed_hair") else { return };
    for (name, strands, points, most) in FILES {
        let bytes = std::fs::read(data.join("hair").join(name)).unwrap();
        let extension = name.rsplit('.').next().unwrap();
        let guides = GuideFormat::of_extension(extension).unwrap().read(name, &bytes).unwrap();
        assert_eq!(guides.len() + guides.left_out.total(), strands, "{name}");
        let lengths: Vec<usize> = (0..guides.len()).map(|i| guides.strand(i).len()).collect();
        assert_eq!((guides.left_out.far_point, &guides.warnings[..]), (0, &[][..]), "{name}");
        println!(
            "{name}: {} strands, {} left out, {:?} points",
            guides.len(),
            guides.left_out.total(),
            lengths.iter().max()
        );
        assert!(lengths.iter().all(|n| *n <= points), "{name}");
        let off = interpolation_error(&guides);
        println!("{name}: off by {:.2} % of the length", 100.0 * off);
        assert!(off < most, "{name}: {off}");
    }
}

/// Reads the strands of a glTF file without external files.
fn import_lines(bytes: &[u8]) -> Result<Guides, BakeError> {
    let mut resolve = |uri: &str, _: u64| -> Result<Vec<u8>, BakeError> { panic!("unexpected request for {uri}") };
    let (guides, inputs) = import_strands("folder/hair.glb", bytes, &mut resolve)?;
    assert_eq!((inputs[0].role.as_str(), inputs[0].name.as_str()), ("strands", "hair.glb"));
    Ok(guides)
}

#[test]
fn exported_strands_are_imported_unchanged() {
    let mut curves = Curves::default();
    for strand in 0..50u32 {
        curves.begin_group(if strand < 20 { "coat" } else { "mane" });
        let point = |k: u32| CurvePoint {
            position_ws: Vec3::new(0.01 * strand as f32, 0.3 * k as f32, -0.1 * (k * k) as f32),
            radius_m: 1e-4 / (k + 1) as f32,
            color: Vec3::new(0.5, 0.25, 0.01 * strand as f32),
            ..CurvePoint::default()
        };
        curves.push(&(0..2 + strand % 5).map(point).collect::<Vec<_>>(), false, Vec2::ZERO);
    }
    for extension in ["glb", "usda", "hair"] {
        let mut written = Vec::new();
        StrandFormat::of_extension(extension).unwrap().write(&curves, &mut written).unwrap();
        let guides = match GuideFormat::of_extension(extension) {
            Some(format) => format.read("hair", &written).unwrap(),
            None => import_lines(&written).unwrap(),
        };
        assert_eq!((guides.len(), guides.left_out.total(), &guides.warnings[..]), (50, 0, &[][..]), "{extension}");
        for (i, found) in (0..50).map(|i| (i, guides.strand(i))) {
            let expected: Vec<Vec3> = curves.strand(i).iter().map(|p| p.position_ws).collect();
            assert_eq!(found, expected, "{extension}: strand {i}");
        }
        assert_eq!(guides.radii, curves.points.iter().map(|p| p.radius_m).collect::<Vec<_>>(), "{extension}");
        assert_eq!(guides.colors, curves.points.iter().map(|p| p.color).collect::<Vec<_>>(), "{extension}");
    }
}

/// Returns a document with a node for each of `primitives`, which share six points on the x axis.
fn line_doc(primitives: &[Value]) -> Doc {
    let mut doc = Doc::new();
    let points: Vec<f32> = (0..6).flat_map(|i| [i as f32, 0.0, 0.0]).collect();
    let position = doc.floats(&points, "VEC3");
    for primitive in primitives {
        let mut primitive = primitive.clone();
        primitive["attributes"] = json!({ "POSITION": position });
        if let Some(list) = primitive["indices"].as_array() {
            let indices: Vec<u16> = list.iter().map(|i| i.as_u64().unwrap() as u16).collect();
            primitive["indices"] = doc.accessor(&indices.bytes(), U16, "SCALAR", indices.len()).into();
        }
        doc.show(primitive);
    }
    doc
}

/// Returns the x coordinates of the points of each strand.
fn point_xs(guides: &Guides) -> Vec<Vec<f32>> {
    (0..guides.len()).map(|i| guides.strand(i).iter().map(|p| p.x).collect()).collect()
}

#[test]
fn lines_of_all_modes_are_strands() {
    let mut doc = line_doc(&[
        json!({ "mode": 1, "indices": [4, 5, 0, 1, 3, 2, 2, 1] }),
        json!({ "mode": 3 }),
        json!({ "mode": 3, "indices": [2, 0, 4] }),
        json!({ "mode": 2, "indices": [1, 2, 5] }),
        json!({ "mode": 1 }),
        json!({ "mode": 4 }),
        json!({ "mode": 3, "indices": [3] }),
    ]);
    let guides = import_lines(&doc.glb()).unwrap();
    let expected: [&[f32]; 8] = [
        &[4.0, 5.0],
        // Two of the three lines run downwards.
        &[3.0, 2.0, 1.0, 0.0],
        &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0],
        &[2.0, 0.0, 4.0],
        &[1.0, 2.0, 5.0, 1.0],
        &[0.0, 1.0],
        &[2.0, 3.0],
        &[4.0, 5.0],
    ];
    assert_eq!((point_xs(&guides), guides.left_out.no_length), (expected.map(<[f32]>::to_vec).to_vec(), 1));
    assert!(guides.radii.is_empty() && guides.colors.is_empty());
    // Checks that nodes transform the lines.
    let nodes = doc.json["nodes"].as_array_mut().unwrap();
    nodes[1]["translation"] = json!([0, 7, 0]);
    nodes[1]["scale"] = json!([-2, 1, 1]);
    nodes[2]["children"] = json!([1]);
    nodes[2]["translation"] = json!([100, 0, 0]);
    doc.json["scenes"] = json!([{ "nodes": [2] }]);
    let guides = import_lines(&doc.gltf()).unwrap();
    assert_eq!(point_xs(&guides), [[102.0, 100.0, 104.0].to_vec(), (0..6).map(|i| 100.0 - 2.0 * i as f32).collect()]);
    assert_eq!(guides.strand(1)[0].y, 7.0);
    // Checks that a separate segment continues a strand if it begins at the last end point.
    let mut doc = Doc::new();
    let ends =
        doc.floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 9.0, 0.0, 0.0, 8.0, 0.0, 0.0], "VEC3");
    doc.show(json!({ "mode": 1, "attributes": { "POSITION": ends } }));
    assert_eq!(point_xs(&import_lines(&doc.glb()).unwrap()), [vec![0.0, 1.0, 2.0], vec![9.0, 8.0]]);
}

#[test]
fn invalid_strand_files_are_refused_with_the_position() {
    let fault = |doc: &Doc, expected: [&str; 2]| match import_lines(&doc.glb()) {
        Err(BakeError::Input { place, reason, .. }) => {
            assert!(
                place.contains(expected[0]) && reason.contains(expected[1]),
                "{place}: {reason}, expected {expected:?}"
            );
        }
        other => panic!("{expected:?}: {other:?}"),
    };
    fault(&line_doc(&[json!({}), json!({ "mode": 0 })]), ["", "the scene has no lines, expected primitives of mode 1"]);
    fault(
        &line_doc(&[json!({ "mode": 1, "indices": [0, 1, 2] })]),
        ["/meshes/0/primitives/0", "3 line ends, expected an even number"],
    );
    fault(
        &line_doc(&[json!({ "mode": 3, "indices": [0, 6] })]),
        ["/meshes/0/primitives/0/indices", "element 1 is 6, expected less than the 6"],
    );
    let mut doc = line_doc(&[json!({ "mode": 3 })]);
    doc.bin[16..20].copy_from_slice(&f32::NAN.to_le_bytes());
    fault(&doc, ["strands", "no strand in the file can be used: 1 with a coordinate that is not a finite number"]);
    let mut doc = line_doc(&[json!({ "mode": 3 })]);
    doc.json["accessors"][0]["count"] = 4_000_000_000u32.into();
    fault(&doc, ["/meshes/0/primitives/0", "4000000000 vertices"]);
    let mut doc = line_doc(&[json!({ "mode": 3 })]);
    let radii = doc.accessor(&[1.0f32, 2.0].bytes(), F32, "SCALAR", 2);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["_RADIUS"] = radii.into();
    fault(&doc, ["/_RADIUS", "has 2 elements, expected 6"]);
    let mut resolve = |_: &str, _: u64| -> Result<Vec<u8>, BakeError> { Ok(Vec::new()) };
    let obj = import_strands("hair.glb", b"v 0 0 0\nl 1 1\n", &mut resolve).unwrap_err().to_string();
    assert!(obj.contains("hair.glb") && obj.contains("this is an OBJ, expected glTF 2.0"), "{obj}");
}
