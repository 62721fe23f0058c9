//! Guides from a file: placed on the model, and attached to the scalp.

use super::body::{SurfaceIndex, SurfacePoint};
use super::ground::{GroomTarget, GroupError};
use crate::recipe::HairGroupParams;
use glam::{EulerRot, Mat4, Quat, Vec3};
use pelage_formats::meaning::hair_groups::smoothed;
use pelage_formats::{HairGroup, TrianglePoint};
use pelage_import::guides::Guides;
use rayon::prelude::*;

/// Largest distance between a file's guide roots and the scalp, as a share of the model's radius. Guides that are
/// farther away are omitted.
const MAX_ROOT_DISTANCE: f32 = 0.1;
/// Largest distance of a guide's points from its root, as a multiple of the model's radius. Longer guides are omitted.
const MAX_REACH: f32 = 100.0;
/// Share of a guide, from the root, that is moved along when its root is moved to the scalp.
const MOVED_SHARE: f32 = 0.4;
/// Maximum number of guides per group.
const MOST_GUIDES: usize = 1 << 16;
/// Number of guides whose ends are compared to find those on the scalp.
const COMPARED: usize = 256;
/// Distance of the first points from the scalp divided by that of the last points, above which the guides are turned.
const TURNED_RATIO: f32 = 4.0;

/// Scalp, and the maximum distance of a root from it.
struct Scalp<'a> {
    body: &'a SurfaceIndex<'a>,
    /// Whether each triangle of the body belongs to the scalp.
    has: Vec<bool>,
    loose_m: f32,
}

impl Scalp<'_> {
    fn nearest(&self, p: Vec3) -> Option<SurfacePoint> {
        self.body.nearest(p, self.loose_m, |triangle| self.has[triangle as usize])
    }

    /// Returns whether the last points of guides are on the scalp, and not the first.
    ///
    /// * `guide`: points of a guide
    fn is_at_tips(&self, count: usize, guide: &(dyn Fn(usize) -> Vec<Vec3> + Sync)) -> bool {
        let step = count.div_ceil(COMPARED).max(1);
        let ends: Vec<[f32; 2]> = (0..count)
            .into_par_iter()
            .step_by(step)
            .map(|i| {
                let points = guide(i);
                // An end that is not near counts as twice as far as the farthest that is.
                let share = |p: Vec3| self.nearest(p).map_or(2.0, |near| near.distance_m / self.loose_m.max(1e-9));
                [share(points[0]), share(points[points.len() - 1])]
            })
            .collect();
        let sum = |end: usize| ends.iter().map(|shares| shares[end]).sum::<f32>();
        let near = |end: usize| ends.iter().filter(|shares| shares[end] < 2.0).count();
        sum(0) > TURNED_RATIO * sum(1) || (near(0) == 0 && 2 * near(1) > ends.len())
    }
}

/// Reads the guides of a file. The root of each guide is moved to the nearest scalp point. The first 40 % of the
/// guide's points move with it, less and less towards the tip; the others keep their positions. Guides that begin at
/// their tips are turned.
pub(super) fn read_guides(
    params: &HairGroupParams,
    group: &HairGroup,
    strands: &Guides,
    ground: &GroomTarget<'_>,
    body: &SurfaceIndex<'_>,
    warnings: &mut Vec<String>,
) -> Result<Vec<(TrianglePoint, Vec<Vec3>)>, GroupError> {
    let [x, y, z] = params.turn_deg().map(f32::to_radians);
    let turn = Quat::from_euler(EulerRot::ZYX, z, y, x);
    let placed = Mat4::from_scale_rotation_translation(Vec3::splat(params.scale_m()), turn, params.at().into());
    let mut has = vec![false; body.triangles.len()];
    group.scalp.iter().for_each(|(triangle, _)| has[*triangle as usize] = true);
    let scalp = Scalp { body, has, loose_m: params.loose_m.unwrap_or(MAX_ROOT_DISTANCE * ground.radius_m) };
    let chosen: Vec<usize> = (0..strands.len()).step_by(params.every() as usize).collect();
    let in_place =
        |i: usize| -> Vec<Vec3> { strands.strand(chosen[i]).iter().map(|p| placed.transform_point3(*p)).collect() };
    let is_turned = scalp.is_at_tips(chosen.len(), &in_place);
    let guide = |i: usize| {
        let mut points = in_place(i);
        if is_turned {
            points.reverse();
        }
        let root = scalp.nearest(points[0])?;
        let last = (points.len() - 1) as f32;
        let led = |(k, p): (usize, &Vec3)| {
            let left = (1.0 - k as f32 / (MOVED_SHARE * last)).max(0.0);
            *p + (root.place - points[0]) * (left * left)
        };
        let moved: Vec<Vec3> = points.iter().enumerate().map(led).collect();
        Some((root.at, smoothed(&moved, group.guide_points as usize)))
    };
    let mut guides: Vec<_> = (0..chosen.len()).into_par_iter().filter_map(guide).collect();
    let loose_m = scalp.loose_m;
    if guides.is_empty() {
        let bounds = strands.points.iter().map(|p| placed.transform_point3(*p));
        let (low, high) = bounds.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let reason = format!(
            "none of the {} strands in the file has its root within {loose_m:.3} m of the scalp: they extend from \
             {low} to {high}; set scale_m, turn_deg and `at` to place them on the model, whose radius is {:.3} m",
            chosen.len(),
            ground.radius_m
        );
        return Err(GroupError::Here(reason));
    }
    let mut warn = |text: String| warnings.push(format!("strands.group {:?}: {text}", params.name));
    if is_turned {
        warn("the strands in the file begin at their tips: their last points are on the scalp; they are turned".into());
    }
    if guides.len() < chosen.len() {
        let gone = chosen.len() - guides.len();
        warn(format!(
            "{gone} of {} guides have roots farther than {loose_m:.3} m from the scalp and are left out",
            chosen.len()
        ));
    }
    let reach_m = (MAX_REACH * ground.radius_m).min(HairGroup::MOST_REACH_M);
    let near = guides.len();
    guides.retain(|(_, points)| points.iter().all(|p| (*p - points[0]).abs().max_element() <= reach_m));
    if guides.is_empty() {
        let reason = format!(
            "all strands in the file reach farther than {reach_m} m from their roots, expected a smaller scale_m for \
             this model, whose radius is {:.3} m",
            ground.radius_m
        );
        return Err(GroupError::Here(reason));
    }
    if guides.len() < near {
        warn(format!(
            "{} guides reach farther than {reach_m} m from their roots and are left out",
            near - guides.len()
        ));
    }
    if guides.len() > MOST_GUIDES {
        let reason = format!("{} guides, expected at most {MOST_GUIDES}: set `every` to take fewer", guides.len());
        return Err(GroupError::Here(reason));
    }
    if strands.left_out.total() > 0 {
        let (gone, reasons) = (strands.left_out.total(), strands.left_out);
        warn(format!("{gone} of {} strands in the file are left out: {reasons}", gone + strands.len()));
    }
    strands.warnings.iter().for_each(|text| warn(format!("file: {text}")));
    Ok(guides)
}
