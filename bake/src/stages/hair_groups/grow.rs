//! Growth of guides. Each guide leaves the surface along its normal, turns towards the direction in which it falls or
//! is combed, and does not enter the body.

use super::body::SurfaceIndex;
use crate::noise::{noise_1d, uniform};
use crate::stages::simulate::GuideForces;
use glam::{Quat, Vec3};
use pelage_formats::TrianglePoint;
use pelage_formats::meaning::hair_groups::smoothed;

/// Number of growth steps of a guide.
const STEPS: usize = 48;
/// Maximum number of times that a step is pushed out of the body.
const PUSHES: usize = 3;

/// Parameters of growing guides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Growth {
    pub(super) forces: GuideForces,
    /// Direction in which guides fall, a unit vector.
    pub(super) fall: Vec3,
    /// Direction in which guides are combed at the root, a unit vector or zero.
    pub(super) comb: Vec3,
    /// x of the plane from which guides are combed to both sides, metres.
    pub(super) parting_m: Option<f32>,
    /// Steepness at which combed hair leaves the surface: weight of the normal relative to the direction along the
    /// surface.
    pub(super) rise: f32,
    pub(super) length_m: f32,
    /// Length over which hair keeps its initial direction, as a share of the hair's length.
    pub(super) stiffness: f32,
    /// Maximum distance from the surface, as a share of the hair's length.
    pub(super) lift: f32,
    pub(super) guide_points: usize,
}

/// Weight of the falling direction relative to the combed one.
const FALLING: f32 = 0.35;
/// Number of waves of messy hair over its length.
const WAVES: f32 = 3.0;
/// Number of turns of curly hair over its length.
const TURNS: f32 = 4.0;

impl Growth {
    /// Grows a guide from `root` and returns its points, root first.
    pub(super) fn guide(&self, body: &SurfaceIndex<'_>, root: &TrianglePoint, seed: u64) -> Vec<Vec3> {
        let start = root.position(body.corners(root.triangle));
        let step_m = self.length_m / STEPS as f32;
        // Hair lies on other hair, so each guide keeps a different distance from the surface.
        let lift_m = self.lift * self.length_m * (0.25 + 0.75 * uniform(seed, 1));
        let forces = self.forces;
        let turned = 1.0 - libm::expf(-1.0 / (STEPS as f32 * self.stiffness * forces.stiffness));
        let reach_m = (2.0 * lift_m).max(4.0 * step_m);
        let mut way = self.initial_direction(start, body.normal(root), seed);
        let mut points = vec![start];
        for k in 1..=STEPS {
            let at = points[k - 1];
            let share = k as f32 / STEPS as f32;
            let mut target = self.fall;
            if forces.follows_skin
                && let Some((_, near)) = body.signed_distance(at, reach_m)
            {
                target = target.reject_from_normalized(near.normal);
            }
            target += forces.waves * noise_1d(seed, WAVES * share);
            way = way.lerp(target.try_normalize().unwrap_or(way), turned).try_normalize().unwrap_or(way);
            // Minimum distance of the hair from the surface: 0 at the root, full from a quarter of the hair's length
            // on.
            let clear_m = lift_m * (4.0 * share).min(1.0) * forces.lift;
            let mut next = at + way * step_m;
            for _ in 0..PUSHES {
                let Some((depth_m, near)) =
                    body.signed_distance(next, reach_m).filter(|(depth_m, _)| *depth_m < clear_m)
                else {
                    break;
                };
                next += near.normal * (clear_m - depth_m).min(step_m);
                let along_skin = (next - at).try_normalize().unwrap_or(near.normal);
                next = at + along_skin * step_m;
            }
            // Continues a deflected guide in its new direction.
            way = (next - at).try_normalize().unwrap_or(way);
            points.push(next);
        }
        if forces.curl > 0.0 {
            points = self.curl(&points, seed);
        }
        smoothed(&points, self.guide_points)
    }

    /// Returns the initial direction of hair: the combed direction, or else the component of its fall direction along
    /// the surface.
    fn initial_direction(&self, root: Vec3, normal: Vec3, seed: u64) -> Vec3 {
        let aside = self.parting_m.map_or(Vec3::ZERO, |x| if root.x < x { Vec3::NEG_X } else { Vec3::X });
        // If hair is combed straight away from the surface, the fall direction decides.
        let wanted = self.comb + aside + FALLING * self.fall;
        let along_skin = wanted.reject_from_normalized(normal);
        // At the crown, no direction along the surface is preferred, so each hair gets a random one.
        let chance = 0.15 * noise_1d(seed, 0.5).reject_from_normalized(normal);
        (along_skin + chance)
            .normalize_or_zero()
            .lerp(normal, self.rise / (1.0 + self.rise))
            .try_normalize()
            .unwrap_or(normal)
    }

    /// Winds the points into a helix around their curve. Its radius increases from the root.
    fn curl(&self, points: &[Vec3], seed: u64) -> Vec<Vec3> {
        let begin = std::f32::consts::TAU * uniform(seed, 2);
        let mut before = (points[1] - points[0]).normalize_or(Vec3::Y);
        let mut side = before.any_orthonormal_vector();
        let last = points.len() - 1;
        (0..points.len())
            .map(|k| {
                let along = points[(k + 1).min(last)] - points[k.max(1) - 1];
                let axis = along.try_normalize().unwrap_or(before);
                side = Quat::from_rotation_arc(before, axis) * side;
                before = axis;
                let share = k as f32 / last as f32;
                let angle = begin + std::f32::consts::TAU * TURNS * share;
                let about = side * libm::cosf(angle) + axis.cross(side) * libm::sinf(angle);
                points[k] + about * (self.forces.curl * self.length_m * (3.0 * share).min(1.0))
            })
            .enumerate()
            // Roots keep their positions.
            .map(|(k, p)| if k == 0 { points[0] } else { p })
            .collect()
    }
}
