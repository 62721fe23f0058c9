//! The light of a strand's point: an eye sees the side that is towards it, and half of the hair about a strand lies behind its axis. Looked up on the axis,
//! the strand's own neighbours, and what of it lies before its axis, darken it.

use super::knot;
use super::row::{Finding, Row};
use crate::BakeError;
use crate::judge::chart::Errors;
use crate::judge::truth::{Lens, SeenStrand, TrueCamera, TrueLight, TrueScene};
use glam::{DVec3, Vec3, vec3};
use rayon::prelude::*;

/// The row of the table.
pub const ROW: Row = Row {
    method: "light of strands",
    cliff: "hair so dense that strands run into each other",
    naive: "shadow looked up on the axis",
    safe: "shadow looked up one radius towards the eye",
    drive,
};

/// Rays of the truth from a place.
const RAYS: u32 = 64;
/// Width and height of the picture whose pixels say which places are seen.
const SIZE: u32 = 160;

fn drive() -> Result<Vec<Finding>, BakeError> {
    let (curves, skin, shading) = knot::grown(700)?;
    let scene = TrueScene::new(curves, skin, None, shading)?;
    let camera = TrueCamera {
        eye_ws: knot::TOWARDS_EYE * 10.0,
        target_ws: Vec3::ZERO,
        up_ws: Vec3::Y,
        lens: Lens::Orthographic { height_m: knot::HEIGHT_M },
    };
    let places = scene.seen_strands(&camera, (SIZE, SIZE), 1);
    let light = TrueLight::Directional { towards_light_ws: vec3(-0.5, 0.8, 0.6), color: Vec3::ONE };
    // Mean light on what is seen, over the true one.
    let off = |from: &(dyn Fn(&SeenStrand) -> DVec3 + Sync)| {
        let pair = |at: &SeenStrand| {
            let truth = scene.light_on_strand(at, &light, RAYS)?;
            Some((f64::from(u8::from(scene.is_lit_past_strands(at, from(at), &light))), truth))
        };
        let pairs: Vec<(f64, f64)> = places.par_iter().filter_map(pair).collect();
        let truth: f64 = pairs.iter().map(|(_, truth)| truth).sum::<f64>() / pairs.len().max(1) as f64;
        Errors::of(pairs).mean().map_or(f64::NAN, |error| (error / truth).abs())
    };
    Ok(vec![Finding {
        case: format!("a knot in a thick coat, {} places of it", places.len()),
        measure: "mean error of t over its mean",
        naive: off(&|at| at.axis_ws),
        safe: off(&|at| at.axis_ws + at.to_eye * at.radius_m),
        bound: 0.03,
        fails_above: 0.05,
    }])
}
