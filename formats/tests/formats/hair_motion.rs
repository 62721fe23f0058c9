//! The `HMOV` section: round trip and rejected contents.

use crate::common::{Refusal, assert_refused, furless_manifest, sample_animation, sample_mesh};
use pelage_formats::*;

fn group() -> HairGroup {
    let mut group = HairGroup { points: 3, lock_hairs: 1, root_radius_m: 1e-4, ..HairGroup::default() };
    let root = TrianglePoint { triangle: 0, weights: [0.5, 0.25, 0.25] };
    group.set_guides(&[(root, vec![glam::Vec3::Z * 0.1, glam::Vec3::Z * 0.2])]);
    group
}

fn packed(groups: &[HairGroup], motion: &HairMotion) -> Result<Vec<u8>, FormatError> {
    let writer = PackageWriter::new(furless_manifest()).mesh(&sample_mesh(true)).animation(&sample_animation());
    let writer = if groups.is_empty() { writer } else { writer.hair_groups(groups) };
    writer.hair_motion(motion).finish()
}

fn sample() -> HairMotion {
    let collider = BodyCollider { joint: 1, from: [0.0, 1.0, 0.0], to: [0.5, 1.0, 0.0], radius: 0.25 };
    let (groups, freedom) = (vec![GroupMotion::default(), GroupMotion::STIFF], vec![vec![128], Vec::new()]);
    HairMotion { groups, freedom, colliders: vec![collider] }
}

#[test]
fn hair_motion_survives_a_round_trip() {
    let bytes = packed(&[group(), group()], &sample()).unwrap();
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    assert_eq!(*package.hair_motion().unwrap().unwrap(), sample());
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
}

#[test]
fn invalid_hair_motion_is_refused_with_the_reason() {
    let cases: [Refusal<HairMotion>; 11] = [
        (|m| m.groups.truncate(1), "1 groups, expected the 2 of the section HAIR"),
        (|m| m.freedom.clear(), "0 lists of freedom, expected the 2 of the section HAIR"),
        (|m| m.freedom[1] = vec![1, 2], "freedom[1] has 2 values, expected none, or one for each of 1 guides"),
        (|m| m.groups[1].held = 1.5, "groups[1].held is 1.5, expected 0 to 1"),
        (|m| m.groups[0].free = -0.5, "groups[0].free is -0.5, expected 0 to 1"),
        (|m| m.groups[0].drag_per_s = f32::NAN, "groups[0].drag_per_s is NaN"),
        (|m| m.groups[0].bend_hz = 101.0, "groups[0].bend_hz is 101"),
        (|m| m.colliders[0].joint = 2, "colliders[0].joint is 2, expected less than 2"),
        (|m| m.colliders[0].radius = 0.0, "colliders[0].radius is 0, expected above 0"),
        (|m| m.colliders[0].to[1] = f32::INFINITY, "colliders[0] is"),
        (|m| m.colliders = vec![m.colliders[0]; 65], "65 colliders, expected at most 64"),
    ];
    assert_refused(Tag::HAIR_MOTION, sample, &cases, |motion| packed(&[group(), group()], motion));
    let bald = packed(&[], &HairMotion { groups: vec![GroupMotion::default()], ..HairMotion::default() });
    assert!(bald.is_err_and(|error| error.to_string().contains("expected the 0 of the section HAIR")));
}

#[test]
fn hair_is_held_at_its_root_and_free_at_its_tip() {
    let motion = GroupMotion { held: 0.25, free: 0.75, ..GroupMotion::default() };
    let found = [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| motion.freedom(share));
    assert_eq!(found, [0.0, 0.0, 0.5, 1.0, 1.0]);
    assert_eq!(GroupMotion { held: 0.0, free: 0.0, ..motion }.freedom(0.1), 1.0);
    assert!([0.0, 0.5, 1.0].iter().all(|share| GroupMotion::STIFF.freedom(*share) == 0.0));
}
