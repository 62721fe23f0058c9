//! Reference for strand shadow maps: the light that reaches visible strands.

use super::camera::{RayCaster, TrueCamera};
use super::lighting::TrueLight;
use super::picture::TrueScene;
use super::tracer::{Hit, RayOrigin};
use super::{seed_of, stratified};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// A visible point of a strand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleStrand {
    /// Nearest point on the strand's axis, world space, metres.
    pub axis_ws: DVec3,
    /// Direction along the strand, unit length.
    pub tangent: DVec3,
    /// Direction towards the eye, unit length.
    pub to_eye: DVec3,
    /// Radius of the strand at this point, metres.
    pub radius_m: f64,
    strand: u32,
}

/// Range of ray origins along the strand in either direction, in radii of the strand. A shadow map cannot resolve less.
const ALONG: f64 = 4.0;

impl TrueScene {
    /// Returns the strands visible at the centre of every `step`th pixel of a picture of `size` pixels, row by row. A
    /// `step` of 0 counts as 1.
    pub fn visible_strands(&self, camera: &TrueCamera, size: (u32, u32), step: u32) -> Vec<VisibleStrand> {
        let (rays, step) = (RayCaster::new(camera, size), step.max(1));
        let rows: Vec<u32> = (0..size.1).step_by(step as usize).collect();
        let seen = |x: u32, y: u32| {
            let (origin, way) = rays.ray(DVec2::new(f64::from(x), f64::from(y)) + 0.5);
            let (Hit::Hair { point, share, strand }, _) = self.tracer.first_hit(origin, way)? else { return None };
            let (a, b) = (&self.curves().points[point], &self.curves().points[point + 1]);
            let (from, to) = (a.position_ws.as_dvec3(), b.position_ws.as_dvec3());
            Some(VisibleStrand {
                axis_ws: from.lerp(to, share),
                tangent: (to - from).normalize_or(DVec3::Y),
                to_eye: -way,
                radius_m: f64::from(a.radius_m) + f64::from(b.radius_m - a.radius_m) * share,
                strand,
            })
        };
        let row = |y: &u32| (0..size.0).step_by(step as usize).filter_map(|x| seen(x, *y)).collect::<Vec<_>>();
        rows.par_iter().flat_map_iter(row).collect()
    }

    /// Returns the fraction of a light that reaches a point of a strand past all other strands, 0..=1. `None` if the
    /// mesh surface hides the light.
    ///
    /// Casts `rays` rays, rounded up to a square number, as in [`TrueScene::picture`]. They start on the side of the
    /// strand that faces the eye. Their origins are spread over its width, and over four radii in both directions along
    /// it.
    pub fn light_on_strand(&self, at: &VisibleStrand, light: &TrueLight, rays: u32) -> Option<f64> {
        let start = RayOrigin { strand: Some(at.strand), triangle: None };
        let (way, reach) = light.direction_and_distance(at.axis_ws);
        if !self.tracer.is_lit(at.axis_ws, way, reach, start, (false, true)) {
            return None;
        }
        let across = at.to_eye.cross(at.tangent).normalize_or(at.to_eye.any_orthonormal_vector());
        let front = at.tangent.cross(across);
        let offsets = stratified(seed_of(&at.axis_ws.to_array()), rays);
        let count = offsets.len() as f64;
        let lit = offsets.filter(|offset| {
            let aside = 2.0 * *offset - 1.0;
            let on_round = across * aside.x + front * (1.0 - aside.x * aside.x).max(0.0).sqrt();
            let from = at.axis_ws + (on_round + at.tangent * (ALONG * aside.y)) * at.radius_m;
            self.tracer.is_lit(from, way, reach, start, (true, false))
        });
        Some(lit.count() as f64 / count)
    }
}
