//! Hair files of other programs from the test data: what they hold, and how near hair grown between a tenth of their strands comes to the rest.
#![allow(clippy::unwrap_used, reason = "in tests a panic is the report")]

use glam::Vec3;
use pelage_bake::guides::Guides;
use pelage_bake::guides::read::GuideFormat;
use pelage_formats::meaning::hair_groups::{Followed, smoothed};
use pelage_needs::data;

/// File, strands, points of each, and the most that hair between every tenth strand may be off, RMS in shares of its length.
const FILES: [(&str, usize, usize, f64); 5] = [
    ("straight.hair", 10_000, 16, 0.075),
    ("ponytail_back.tfx", 517, 16, 0.18),
    ("ponytail_front_top.tfx", 876, 16, 0.58),
    ("ponytail_tail.tfx", 474, 16, 0.15),
    ("Ratboy_mohawk.tfx", 2228, 32, 0.25),
];

/// Points that strands are compared at.
const POINTS: usize = 24;

/// RMS distance between strands and what grows from their roots when every tenth is a guide, over the mean length of all.
fn off_between_guides(guides: &Guides) -> f64 {
    let shapes: Vec<Vec<Vec3>> = (0..guides.len()).map(|i| even(guides.strand(i))).collect();
    let followed = Followed::new(shapes.iter().step_by(10).cloned().collect());
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

/// Points equally far apart along a strand.
fn even(strand: &[Vec3]) -> Vec<Vec3> {
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
fn hair_between_guides_is_near_the_combed_one() {
    let Some(data) = data("hair_between_guides_is_near_the_combed_one") else { return };
    for (name, strands, points, most) in FILES {
        let bytes = std::fs::read(data.join("hair").join(name)).unwrap();
        let extension = name.rsplit('.').next().unwrap();
        let guides = GuideFormat::of_extension(extension).unwrap().read(name, &bytes).unwrap();
        assert_eq!(guides.len() + guides.left_out, strands, "{name}");
        let lengths: Vec<usize> = (0..guides.len()).map(|i| guides.strand(i).len()).collect();
        println!("{name}: {} strands, {} left out, {:?} points", guides.len(), guides.left_out, lengths.iter().max());
        assert!(lengths.iter().all(|n| *n <= points), "{name}");
        let off = off_between_guides(&guides);
        println!("{name}: off by {:.2} % of the length", 100.0 * off);
        assert!(off < most, "{name}: {off}");
    }
}
