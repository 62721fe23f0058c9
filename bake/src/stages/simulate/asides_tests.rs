use super::*;
use glam::Vec3;

/// Makes strands that bend along v with the square of their height. `bend` returns the strength of the bend for each
/// strand.
fn bent(bend: impl Fn(usize) -> f32) -> Strands {
    let (count, points) = (400, 9);
    let mut strands = Strands { height: 0.4, offsets: vec![0], ..Strands::default() };
    for i in 0..count {
        let root = Vec3::new((i % 20) as f32 / 20.0, (i / 20) as f32 / 20.0, 0.0);
        for k in 0..points {
            let h = k as f32 / (points - 1) as f32;
            strands.points.push(root + Vec3::new(0.0, bend(i) * h * h, 0.4 * h));
        }
        strands.offsets.push(strands.points.len() as u32);
    }
    strands.radii = vec![0.002; strands.points.len()];
    strands.colors = vec![Vec3::ONE; strands.points.len()];
    strands
}

/// Returns the greatest errors of the estimated offset. The first is with the true directions. The second, for
/// comparison, is with upright directions only.
fn worst(strands: &Strands, asides: &LateralOffsets, bend: impl Fn(usize) -> f32) -> [f32; 2] {
    let mut worst = [0.0f32; 2];
    for i in 0..strands.len() {
        for k in 1..ROOT_HEIGHTS {
            let h = k as f32 / (ROOT_HEIGHTS - 1) as f32;
            let direction = Vec3::new(0.0, 2.0 * bend(i) * h, 0.4).normalize();
            let aside = Vec2::new(0.0, bend(i) * h * h);
            for (worst, direction) in worst.iter_mut().zip([direction, Vec3::Z]) {
                *worst = worst.max(asides.at[k].offset(direction).distance(aside));
            }
        }
    }
    worst
}

#[test]
fn hair_direction_predicts_the_root_offset() {
    // Neighbouring strands bend differently.
    let bend = |i: usize| 0.05 + 0.01 * (i * 7 % 11) as f32;
    let strands = bent(bend);
    let asides = LateralOffsets::from_strands(&strands);
    let [found, upright] = worst(&strands, &asides, bend);
    assert!(found < 0.02 && upright > 0.04, "{found}, with no directions {upright}: {asides:?}");
    assert_eq!((asides.at[0], asides.mean[0]), (RootOffset::default(), Vec2::ZERO));
    let top = asides.mean[ROOT_HEIGHTS - 1];
    assert!((0.08..0.1).contains(&top.y) && top.x.abs() < 1e-6, "{top}");
    assert!((0.1..0.3).contains(&asides.reach()), "{}", asides.reach());
}

#[test]
fn equal_bends_give_exact_root_offsets() {
    let strands = bent(|_| 0.1);
    let asides = LateralOffsets::from_strands(&strands);
    let [found, _] = worst(&strands, &asides, |_| 0.1);
    assert!(found < 0.01, "{found}");
}

#[test]
fn root_offsets_without_hair_are_the_default() {
    assert_eq!(LateralOffsets::from_strands(&Strands { height: 1.0, ..Strands::default() }), LateralOffsets::default());
}
