//! Hair between guides at a parting: the average of guides that fall to opposite sides is upright.

use super::row::{Finding, Row};
use glam::Vec3;
use pelage_formats::meaning::hair_groups::GuideInterpolator;
use pelage_import::BakeError;

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "hair on guides",
    cliff: "guides that fall to both sides of a parting",
    naive: "mix the nearest guides with equal weights",
    safe: "leave out guides whose shape differs from the nearest one's by more than 0.6 of its length",
    drive,
};

/// Points per guide.
const POINTS: usize = 9;

/// Returns guides on both sides of the plane x = 0, one centimetre (one unit) apart. They rise by `rise` and fall away
/// from the plane.
fn guides(rise: f32) -> Vec<Vec<Vec3>> {
    let sides = (-6..6).flat_map(|i| (0..12).map(move |j| (i as f32 + 0.5, j as f32)));
    let guide = |(x, z): (f32, f32)| {
        let side = x.signum();
        let point = |k: usize| {
            let s = k as f32 / (POINTS - 1) as f32;
            Vec3::new(x + side * 8.0 * s, rise * s * (1.0 - s), z - 6.0 * s * s)
        };
        (0..POINTS).map(point).collect()
    };
    sides.map(guide).collect()
}

/// Returns how much shorter a hair is than its guides, measured straight from root to tip. The result is a fraction of
/// the guides' length, and the maximum over roots at the parting.
fn shortened(guides: &[Vec<Vec3>], way: &dyn Fn(Vec3) -> Vec3) -> f64 {
    let whole = guides[0][POINTS - 1].distance(guides[0][0]);
    let roots = (0..200).map(|k| Vec3::new((k % 20) as f32 * 0.05 - 0.475, 0.0, 3.0 + (k / 20) as f32 * 0.37));
    roots.map(|root| f64::from(1.0 - way(root).length() / whole)).fold(0.0, f64::max)
}

fn drive() -> Result<Vec<Finding>, BakeError> {
    let finding = |rise: f32| {
        let guides = guides(rise);
        let followed = GuideInterpolator::new(guides.clone());
        let tip = |guide: usize| guides[guide][POINTS - 1] - guides[guide][0];
        let ours = |root: Vec3| followed.follow(root).map_or(Vec3::ZERO, |follow| follow.mix(tip));
        let naive = |root: Vec3| {
            let mut near: Vec<usize> = (0..guides.len()).collect();
            near.sort_by(|a, b| guides[*a][0].distance(root).total_cmp(&guides[*b][0].distance(root)));
            near[..4].iter().map(|guide| 0.25 * tip(*guide)).sum::<Vec3>()
        };
        Finding {
            case: format!("a parting whose hair rises {rise:.0} cm"),
            measure: "largest relative loss of hair length",
            naive: shortened(&guides, &naive),
            safe: shortened(&guides, &ours),
            bound: 0.02,
            fails_above: 0.2,
        }
    };
    Ok(vec![finding(2.0), finding(12.0)])
}
