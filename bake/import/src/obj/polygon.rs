//! Triangulation of polygons.
//!
//! A convex polygon becomes a fan, or is halved repeatedly if it has many corners. All others are triangulated by ear
//! clipping (Meisters, "Polygons Have Ears", American Mathematical Monthly 82(6), 1975). A polygon too large for that
//! is halved into pieces that are clipped: rounded coordinates make a circle of many corners slightly concave. Clipping
//! works in the plane of the normal by Newell's method, in double precision.

use glam::{DVec2, DVec3, Vec3};

/// A triangulated polygon.
#[derive(Debug, PartialEq)]
pub(super) struct Triangulation {
    /// Corner indices of each triangle, zero-based, in the polygon's own winding. There are always two fewer triangles
    /// than corners.
    pub triangles: Vec<[usize; 3]>,
    /// Whether the triangles cover the polygon exactly once. False if it crosses itself, or is too large to be checked.
    pub clean: bool,
}

/// Maximum number of corners for ear clipping, which takes cubic time in the worst case; and of a piece of a larger
/// polygon.
const MOST_CORNERS: usize = 512;
const PIECE_CORNERS: usize = 256;
/// Area that the triangles of a larger polygon may cover more than once, as a share of the polygon's. Rounded corners
/// are on the wrong side of the lines between the pieces by up to the rounding.
const ROUGHNESS: f64 = 1e-4;
/// Maximum number of corners of a fan. Triangles of a larger fan are slivers across the whole polygon, which every
/// search for nearby triangles finds.
const FAN_CORNERS: usize = 16;

/// Triangulates the polygon with corners at `points`, at least 3.
pub(super) fn triangulate(points: &[Vec3]) -> Triangulation {
    let n = points.len();
    if n <= 3 {
        return fan(n);
    }
    let flat = flatten(points);
    let corner = |i: usize| [flat[(i + n - 1) % n], flat[i], flat[(i + 1) % n]];
    // Left turns alone do not prove convexity: a five-pointed star has only left turns too, and winds around twice.
    let turns: f64 = (0..n).map(|i| turn(corner(i))).sum();
    if (0..n).all(|i| twice_area(corner(i)) >= 0.0) && turns < 3.0 * std::f64::consts::PI {
        return if n <= FAN_CORNERS { fan(n) } else { halve(&flat, 3) };
    }
    if n <= MOST_CORNERS {
        return cut_ears(&flat);
    }
    let cut = halve(&flat, PIECE_CORNERS);
    let areas = cut.triangles.iter().map(|t| twice_area(t.map(|i| flat[i])));
    // The signed areas always sum to that of the polygon, and triangles that are turned over are covered twice.
    let (covered, area) = areas.fold((0.0, 0.0), |(covered, area), of| (covered + of.abs(), area + of));
    Triangulation { clean: covered <= (1.0 + ROUGHNESS) * area, ..cut }
}

fn fan(n: usize) -> Triangulation {
    Triangulation { triangles: (2..n).map(|i| [0, i - 1, i]).collect(), clean: true }
}

/// Divides a polygon by a triangle from its first to its middle and last corner, and both halves in the same way.
/// Pieces of at most `piece` corners, at least 3, are triangulated by ear clipping.
fn halve(flat: &[DVec2], piece: usize) -> Triangulation {
    let mut out = Triangulation { triangles: Vec::with_capacity(flat.len() - 2), clean: true };
    let mut ranges = vec![(0, flat.len() - 1)];
    while let Some((first, last)) = ranges.pop() {
        if last - first < 2 {
            continue;
        }
        if last - first < piece {
            let cut = cut_ears(&flat[first..=last]);
            out.clean &= cut.clean;
            out.triangles.extend(cut.triangles.iter().map(|t| t.map(|i| first + i)));
            continue;
        }
        let middle = first.midpoint(last);
        let triangle = [first, middle, last];
        out.clean &= twice_area(triangle.map(|i| flat[i])) >= 0.0;
        out.triangles.push(triangle);
        ranges.extend([(first, middle), (middle, last)]);
    }
    out
}

/// Projects the polygon along its normal, so that its winding is counter-clockwise overall.
fn flatten(points: &[Vec3]) -> Vec<DVec2> {
    let n = points.len();
    let at = |i: usize| points[i % n].as_dvec3() - points[0].as_dvec3();
    // Newell's method: the sum is twice the vector area.
    let normal: DVec3 = (0..n).map(|i| at(i).cross(at(i + 1))).sum();
    let (x, y) = normal.try_normalize().unwrap_or(DVec3::Z).any_orthonormal_pair();
    (0..n).map(|i| DVec2::new(at(i).dot(x), at(i).dot(y))).collect()
}

/// Returns twice the signed area of a triangle: positive if the path through the three points turns left.
fn twice_area([a, b, c]: [DVec2; 3]) -> f64 {
    (b - a).perp_dot(c - b)
}

/// Returns the angle of the left turn at the second of three points, radians.
fn turn([a, b, c]: [DVec2; 3]) -> f64 {
    let (into, out) = (b - a, c - b);
    libm::atan2(into.perp_dot(out), into.dot(out))
}

fn cut_ears(flat: &[DVec2]) -> Triangulation {
    let mut left: Vec<usize> = (0..flat.len()).collect();
    let mut out = Triangulation { triangles: Vec::with_capacity(flat.len() - 2), clean: true };
    // The search for an ear starts where the last one was cut: this spreads the triangles, which otherwise fan around
    // one corner.
    let mut start = 0;
    while left.len() > 3 {
        let m = left.len();
        let ear = (0..m).map(|k| (start + k) % m).find(|i| is_ear(flat, &left, *i));
        // A polygon that crosses itself may have no ear. Its corners are removed nevertheless.
        out.clean &= ear.is_some();
        let i = ear.unwrap_or(start % m);
        out.triangles.push([left[(i + m - 1) % m], left[i], left[(i + 1) % m]]);
        left.remove(i);
        start = i;
    }
    // The last triangle of a bow tie has the opposite winding. The tolerance allows for rounding errors.
    let reach = flat.iter().map(|p| p.length_squared()).fold(0.0, f64::max);
    out.clean &= twice_area([left[0], left[1], left[2]].map(|i| flat[i])) >= -1e-9 * reach;
    out.triangles.push([left[0], left[1], left[2]]);
    out
}

/// Returns whether corner `i` of the remaining ones can be cut off: it turns left, and no other corner is inside its
/// triangle.
fn is_ear(flat: &[DVec2], left: &[usize], i: usize) -> bool {
    let m = left.len();
    let ear = [left[(i + m - 1) % m], left[i], left[(i + 1) % m]].map(|k| flat[k]);
    if twice_area(ear) < 0.0 {
        return false;
    }
    let [a, b, c] = ear;
    left.iter().map(|k| flat[*k]).filter(|p| !ear.contains(p)).all(|p| {
        let outside = twice_area([a, b, p]) < 0.0 || twice_area([b, c, p]) < 0.0 || twice_area([c, a, p]) < 0.0;
        // A corner on the boundary of a triangle without area does not count as inside.
        outside || twice_area(ear) == 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lift(points: &[(f32, f32)]) -> Vec<Vec3> {
        // Put the polygon into an oblique plane far from the origin.
        points.iter().map(|(x, y)| Vec3::new(*x + 100.0, *y, 0.5 * *x - 0.25 * *y)).collect()
    }

    /// Returns twice the total area of the triangles, and twice the area of the polygon, both in its plane.
    fn areas(points: &[(f32, f32)], cut: &Triangulation) -> (f64, f64) {
        let p: Vec<DVec2> = points.iter().map(|(x, y)| DVec2::new((*x).into(), (*y).into())).collect();
        let triangles = cut.triangles.iter().map(|t| twice_area(t.map(|i| p[i])));
        assert!(triangles.clone().all(|a| a >= -1e-9), "a triangle is turned over: {cut:?}");
        (triangles.map(f64::abs).sum(), (0..p.len()).map(|i| p[i].perp_dot(p[(i + 1) % p.len()])).sum())
    }

    #[test]
    fn polygons_are_covered_once() {
        let gear: Vec<(f32, f32)> = (0..80)
            .map(|i| {
                let (angle, radius) = (i as f32 * std::f32::consts::TAU / 80.0, if i % 4 < 2 { 1.0 } else { 2.0 });
                (radius * angle.cos(), radius * angle.sin())
            })
            .collect();
        let spiral: Vec<(f32, f32)> = [
            (0., 0.),
            (9., 0.),
            (9., 9.),
            (1., 9.),
            (1., 3.),
            (6., 3.),
            (6., 6.),
            (3., 6.),
            (3., 5.),
            (5., 5.),
            (5., 4.),
            (2., 4.),
        ]
        .into_iter()
        .chain([(2., 8.), (8., 8.), (8., 1.), (0., 1.)])
        .collect();
        let disc: Vec<(f32, f32)> = (0..100)
            .map(|i| (i as f32 * std::f32::consts::TAU / 100.0).sin_cos())
            .map(|(sin, cos)| (cos, sin))
            .collect();
        for points in [
            &[(0., 0.), (1., 0.), (0., 1.)][..],
            &[(0., 0.), (1., 0.), (1., 1.), (0., 1.)],
            // An arrow head, starting at each of its four corners: a fan from the wrong corner reverses a triangle.
            &[(0., 0.), (2., 2.), (0., 1.), (-2., 2.)],
            &[(2., 2.), (0., 1.), (-2., 2.), (0., 0.)],
            &[(0., 1.), (-2., 2.), (0., 0.), (2., 2.)],
            &[(-2., 2.), (0., 0.), (2., 2.), (0., 1.)],
            // A polygon with collinear corners.
            &[(0., 0.), (1., 0.), (2., 0.), (2., 2.), (1., 1.), (0., 2.)],
            // A hole joined to the outer boundary by a slit, as exporters write it.
            &[(0., 0.), (4., 0.), (4., 4.), (0., 4.), (0., 0.), (1., 1.), (1., 3.), (3., 3.), (3., 1.), (1., 1.)],
            &gear,
            &spiral,
            &disc,
        ] {
            let cut = triangulate(&lift(points));
            assert_eq!(cut.triangles.len(), points.len() - 2, "{points:?}");
            assert!(cut.clean, "{points:?}");
            let (found, expected) = areas(points, &cut);
            assert!((found - expected).abs() < 1e-4, "{points:?}: {found} for {expected}");
        }
    }

    #[test]
    fn area_check_rejects_a_fan_of_a_concave_polygon() {
        // Negative control: the same arrow head, cut as a fan.
        let points = [(2., 2.), (0., 1.), (-2., 2.), (0., 0.)];
        let wrong = std::panic::catch_unwind(|| areas(&points, &fan(4)));
        assert!(wrong.is_err());
    }

    #[test]
    fn triangulation_of_self_intersecting_polygons_terminates() {
        let pentagram: Vec<(f32, f32)> = (0..5)
            .map(|i| {
                let angle = i as f32 * 2.0 * std::f32::consts::TAU / 5.0;
                (angle.cos(), angle.sin())
            })
            .collect();
        for (points, clean) in [
            (&[(0., 0.), (1., 1.), (1., 0.), (0., 1.)][..], false),
            (&pentagram, false),
            (&[(0., 0.); 6], true),
            (&[(0., 0.), (1., 0.), (2., 0.), (3., 0.)], true),
        ] {
            let cut = triangulate(&lift(points));
            assert_eq!(cut.triangles.len(), points.len() - 2);
            assert_eq!(cut.clean, clean, "{points:?}");
        }
        // Rounded to six digits, the circle has concave corners.
        let place = |i: usize| libm::sincos(i as f64 * std::f64::consts::TAU / 20_000.0);
        let round = |x: f64| (x * 1e6).round() as f32 / 1e6;
        let circle: Vec<(f32, f32)> = (0..20_000).map(place).map(|(sin, cos)| (round(cos), round(sin))).collect();
        let flat: Vec<Vec3> = circle.iter().map(|(x, y)| Vec3::new(*x, *y, 0.0)).collect();
        let cut = triangulate(&flat);
        let p = |i: usize| DVec2::new(circle[i].0.into(), circle[i].1.into());
        let area: f64 = cut.triangles.iter().map(|t| twice_area(t.map(p)).abs()).sum();
        assert!(cut.clean && cut.triangles.len() == 19_998);
        assert!((area / std::f64::consts::TAU - 1.0).abs() < 1e-5, "{area}");
        // Rounded more coarsely, neighbouring corners are on the wrong side of the lines between the pieces.
        let coarse: Vec<Vec3> = flat.iter().map(|p| (p * 1e5).round() / 1e5).collect();
        let cut = triangulate(&coarse);
        let mut degree = vec![0; coarse.len()];
        cut.triangles.iter().flatten().for_each(|i| degree[*i] += 1);
        let highest = degree.iter().max();
        assert!(cut.clean && highest < Some(&PIECE_CORNERS), "{highest:?} triangles at a corner");
        let zigzag: Vec<Vec3> =
            (0..10_000).map(|i| Vec3::new(i as f32, if i % 2 == 0 { 0.0 } else { 5.0 }, 0.0)).collect();
        assert!(!triangulate(&zigzag).clean);
    }
}
