//! Strokes along the combing direction.

use super::canvas::{Canvas, Place};
use glam::Vec3;

/// Distance between the points of a traced stroke, in units of the model's size.
const STEP: f32 = 0.008;
/// Share of the previous direction in the next one: a brush turns slowly.
const INERTIA: f32 = 0.8;
/// Cosine between the combing direction and the stroke below which the stroke keeps its direction.
const AGAINST: f32 = -0.2;

/// Follows the combing direction from a place, against it if `back`. It ends after `length` or where `goes_on` says
/// so. The starting place is included.
pub(super) fn follow(
    canvas: &Canvas,
    from: Place,
    back: bool,
    length: f32,
    mut goes_on: impl FnMut(&Place) -> bool,
) -> Vec<Place> {
    let sign = if back { -1.0 } else { 1.0 };
    let mut way = canvas.vector_at(&canvas.comb, &from) * sign;
    let mut places = vec![from];
    let mut at = from;
    for _ in 0..(length / STEP) as usize {
        let along = canvas.vector_at(&canvas.comb, &at) * sign;
        let along = if along.dot(way) < AGAINST { way } else { along };
        way = (way * INERTIA + along * (1.0 - INERTIA)).normalize_or_zero();
        let normal = canvas.vector_at(&canvas.skin.normals, &at);
        way = (way - normal * normal.dot(way)).normalize_or_zero();
        let Some(next) = canvas.nearest(at.position + way * STEP, normal) else { break };
        // The surface ends, or turns away.
        if way == Vec3::ZERO || next.position.distance_squared(at.position) < 0.04 * STEP * STEP || !goes_on(&next) {
            break;
        }
        at = next;
        places.push(at);
    }
    places
}

/// Follows the combing direction both ways from a place, at most half of `length` each.
pub(super) fn follow_both_ways(
    canvas: &Canvas,
    from: Place,
    length: f32,
    mut goes_on: impl FnMut(&Place) -> bool,
) -> Vec<Place> {
    let mut places = follow(canvas, from, true, length / 2.0, &mut goes_on);
    places.reverse();
    places.extend(follow(canvas, from, false, length / 2.0, goes_on).into_iter().skip(1));
    places
}

/// Returns the length of a curve.
pub(super) fn length(points: &[Vec3]) -> f32 {
    points.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

/// Returns positions along a curve at `count` equal distances: for each the index of the point before it, and the share
/// of the way to the next.
pub(super) fn evenly(points: &[Vec3], count: usize) -> Vec<(usize, f32)> {
    let all = length(points);
    let (mut k, mut before) = (0, 0.0);
    (0..count)
        .map(|i| {
            let wanted = all * i as f32 / (count - 1) as f32;
            while k + 2 < points.len() && before + points[k].distance(points[k + 1]) < wanted {
                before += points[k].distance(points[k + 1]);
                k += 1;
            }
            let piece = points[k].distance(points[(k + 1).min(points.len() - 1)]);
            (k, if piece > 0.0 { ((wanted - before) / piece).clamp(0.0, 1.0) } else { 0.0 })
        })
        .collect()
}
