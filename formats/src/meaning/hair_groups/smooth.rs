//! Smoothing of guides with few points into curves with many: Bézier curves through tangents, as in the Nalu demo (GPU
//! Gems 2, ch. 23).

use glam::Vec3;

/// Number of samples per curve segment for measuring its length.
const SAMPLES: usize = 16;

/// Weight of turning angles relative to length when points are distributed. Bending by a right angle counts as much as
/// this share of the curve's whole length.
const TURN: f32 = 0.25;

/// Returns `count` points of a curve through all points of a polyline. They include both ends, and are denser where the
/// curve bends.
///
/// * `points`: 2 or more, consecutive ones distinct
/// * `count`: 2 or more
pub fn smoothed(points: &[Vec3], count: usize) -> Vec<Vec3> {
    let tangents = tangents(points);
    let mut dense = vec![points[0]];
    for (i, ends) in points.windows(2).enumerate() {
        let third = ends[0].distance(ends[1]) / 3.0;
        let [a, d] = [ends[0], ends[1]];
        let (b, c) = (a + tangents[i] * third, d - tangents[i + 1] * third);
        dense.extend((1..=SAMPLES).map(|k| {
            let t = k as f32 / SAMPLES as f32;
            let s = 1.0 - t;
            a * (s * s * s) + b * (3.0 * s * s * t) + c * (3.0 * s * t * t) + d * (t * t * t)
        }));
    }
    spread(&dense, count)
}

/// Returns the direction of the curve at each point.
///
/// At inner points, this is the tangent of the parabola through the point and its neighbours, parameterised by segment
/// lengths. It is normalised so that long segments beside short ones do not overshoot. At the ends, it is the tangent
/// that makes the outermost segment a parabola.
fn tangents(points: &[Vec3]) -> Vec<Vec3> {
    let pieces: Vec<Vec3> = points.windows(2).map(|ends| ends[1] - ends[0]).collect();
    let unit = |v: Vec3, or: Vec3| v.try_normalize().or(or.try_normalize()).unwrap_or(Vec3::Y);
    let between = |pair: &[Vec3]| {
        let [before, after] = [pair[0].length(), pair[1].length()];
        unit(pair[0] * (after / before) + pair[1] * (before / after), pair[1])
    };
    let inner: Vec<Vec3> = pieces.windows(2).map(between).collect();
    let (Some(first), Some(last)) = (pieces.first(), pieces.last()) else { return vec![Vec3::Y; points.len()] };
    let end = |piece: &Vec3, next: Option<&Vec3>| {
        let along = unit(*piece, Vec3::Y);
        next.map_or(along, |next| unit(2.0 * along.dot(*next).max(0.0) * along - *next, along))
    };
    let start = end(first, inner.first());
    let stop = end(last, inner.last());
    std::iter::once(start).chain(inner.iter().copied()).chain(std::iter::once(stop)).collect()
}

/// Returns `count` points of a polyline, spaced equally in the sum of length and weighted turning angle.
fn spread(dense: &[Vec3], count: usize) -> Vec<Vec3> {
    let lengths: Vec<f32> = dense.windows(2).map(|ends| ends[0].distance(ends[1])).collect();
    let whole: f32 = lengths.iter().sum();
    let turn = |i: usize| match i {
        0 => 0.0,
        _ => (dense[i] - dense[i - 1]).angle_between(dense[i + 1] - dense[i]) / std::f32::consts::FRAC_PI_2,
    };
    let mut along = vec![0.0f32];
    for (i, length) in lengths.iter().enumerate() {
        let weight = length + TURN * whole * Some(turn(i)).filter(|t| t.is_finite()).unwrap_or(0.0);
        along.push(along[i] + weight);
    }
    let total = along[along.len() - 1];
    let at = |k: usize| {
        let wanted = total * k as f32 / (count - 1) as f32;
        let after = along.partition_point(|a| *a < wanted).clamp(1, along.len() - 1);
        let gap = along[after] - along[after - 1];
        let t = if gap > 0.0 { ((wanted - along[after - 1]) / gap).clamp(0.0, 1.0) } else { 0.0 };
        dense[after - 1].lerp(dense[after], t)
    };
    (0..count).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_guide_stays_straight_and_even() {
        // Segments of increasing length, as in guides.
        let points: Vec<Vec3> = [0.0, 1.0, 3.0, 6.0, 10.0].map(|x| Vec3::new(x, 0.5 * x, 0.0)).to_vec();
        let curve = smoothed(&points, 11);
        for (k, p) in curve.iter().enumerate() {
            assert!(p.distance(Vec3::new(k as f32, 0.5 * k as f32, 0.0)) < 1e-4, "{k}: {p}");
        }
        assert_eq!(smoothed(&points[..2], 2), points[..2]);
    }

    /// A smoothed curve through seven points of a semicircle is far closer to the arc than the chords between them.
    #[test]
    fn smoothed_arc_stays_an_arc() {
        let at = |angle: f32| Vec3::new(angle.cos(), angle.sin(), 0.0);
        let points: Vec<Vec3> = (0..7).map(|i| at(std::f32::consts::PI * i as f32 / 6.0)).collect();
        let off = |points: &[Vec3]| {
            let middles = points.windows(2).map(|ends| 0.5 * (ends[0] + ends[1]));
            points.iter().copied().chain(middles).map(|p| (p.length() - 1.0).abs()).fold(0.0, f32::max)
        };
        let curve = smoothed(&points, 36);
        assert!(off(&points) > 0.03 && off(&curve) < 0.004, "{} and {}", off(&points), off(&curve));
        assert!((curve[0] - points[0]).length() < 1e-6 && (curve[35] - points[6]).length() < 1e-5);
        // The curve passes through all points.
        for p in &points {
            let nearest = curve.windows(2).map(|e| {
                let along = e[1] - e[0];
                let t = ((*p - e[0]).dot(along) / along.length_squared()).clamp(0.0, 1.0);
                p.distance(e[0] + t * along)
            });
            assert!(nearest.fold(f32::MAX, f32::min) < 0.004);
        }
    }

    /// Points are denser where the curve bends: most points of a hook are in its bend.
    #[test]
    fn points_are_denser_at_bends() {
        let points = [(0.0, 0.0), (3.0, 0.0), (6.0, 0.0), (6.5, 0.3), (6.5, 1.0), (6.0, 1.3)];
        let points = points.map(|(x, y)| Vec3::new(x, y, 0.0));
        let curve = smoothed(&points, 20);
        let bow = curve.iter().filter(|p| p.x > 5.8).count();
        assert!(bow >= 9, "{bow} of 20 in the last quarter of the length: {curve:?}");
        // A reversal of direction gives finite points.
        let back = smoothed(&[Vec3::ZERO, Vec3::X, Vec3::ZERO, Vec3::X], 9);
        assert!(back.iter().all(|p| p.is_finite() && (-1.0..2.0).contains(&p.x)), "{back:?}");
    }
}
