//! Sphere map that widens ink lines (Fang 2006, §2, after Kang 2003): R = α(N·E)E − E with α = N·E, m = sqrt(Rx² + Ry²
//! + (Rz + 1)²), (u, v) = R/2m + 1/2.
//!
//! In the published form, R is parallel to E. All normals then map to a line, and in the middle of the picture to one
//! point. A normal perpendicular to the view maps to 0/0. Interpreted as a reflection, R = 2(N·E)N − E gives a map, but
//! one that is centred on the middle of the picture. Off the middle, the outline is not at the rim of the map. R = (0,
//! 0, −1), where m is 0, occurs on surfaces that face the eye. pelage uses the normal in the frame perpendicular to the
//! view direction. There, the distance from the centre is sin(N, E)/2 for any perspective.

use super::kajiya_kay;
use super::row::{Finding, Row};
use glam::{DVec3, Vec2, Vec3};
use pelage_import::BakeError;
use pelage_runtime::shared::ink::{ink_sphere_uv, ink_sphere_uv_reflected};

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "sphere map",
    cliff: "R = (0, 0, -1): m = 0; normals perpendicular to the view direction; perspective; missing normals",
    naive: "R = (N.E)(N.E) E - E as published, and reflection in view space",
    safe: "the normal in the frame perpendicular to the view direction: outlines map to the rim, \
           no division by m",
    drive,
};

/// Returns directions to the eye in view space: along the view axis, and to the side by up to half of a field of view
/// of 60 degrees.
fn eyes() -> [Vec3; 5] {
    let aside = |deg: f32, round: f32| {
        let (s, c) = deg.to_radians().sin_cos();
        Vec3::new(s * round.cos(), s * round.sin(), c)
    };
    [Vec3::Z, aside(5.0, 0.3), aside(15.0, 2.0), aside(30.0, 4.0), aside(30.0, 0.0)]
}

/// Returns normals that face the eye, including normals that are perpendicular to the eye direction up to f32 rounding.
fn normals(eye: Vec3) -> impl Iterator<Item = Vec3> {
    let (x, y) = eye.any_orthonormal_pair();
    let round = (0..720).map(move |i| Vec2::from_angle(i as f32 * 0.5f32.to_radians()));
    let rim = round.map(move |a| x * a.x + y * a.y);
    let facing = kajiya_kay::cases().map(|(normal, ..)| normal).filter(move |n| n.dot(eye) >= 0.0);
    // Includes the axes, for which R = (0, 0, −1) is exact.
    rim.chain(facing)
        .chain([eye, Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::NEG_Y].into_iter().filter(move |n| n.dot(eye) >= 0.0))
}

/// Returns the true distance of a normal from the centre of the map: half of the sine of its angle to the view
/// direction, computed in f64.
fn true_distance(normal: Vec3, eye: Vec3) -> f64 {
    let (n, e): (DVec3, DVec3) = (normal.as_dvec3().normalize(), eye.as_dvec3().normalize());
    0.5 * n.cross(e).length()
}

/// Evaluates the published form, with E towards the eye.
fn printed(normal: Vec3, eye: Vec3) -> Vec2 {
    let alpha = normal.dot(eye);
    let r = alpha * normal.dot(eye) * eye - eye;
    let m = (r.x * r.x + r.y * r.y + (r.z + 1.0) * (r.z + 1.0)).sqrt();
    Vec2::new(r.x / (2.0 * m) + 0.5, r.y / (2.0 * m) + 0.5)
}

/// Evaluates pelage's form, with the normal in the frame perpendicular to the view direction.
fn perpendicular(normal: Vec3, eye: Vec3) -> Vec2 {
    let (x, y) = eye.any_orthonormal_pair();
    ink_sphere_uv(Vec3::new(normal.dot(x), normal.dot(y), normal.dot(eye)), 1.0)
}

/// Returns the largest error of the distance from the centre; NaN if a position is NaN.
fn worst(form: fn(Vec3, Vec3) -> Vec2) -> f64 {
    let mut worst = 0.0f64;
    for eye in eyes() {
        for normal in normals(eye) {
            let found = f64::from(form(normal, eye).distance(Vec2::splat(0.5)));
            let error = (found - true_distance(normal, eye)).abs();
            if error.is_nan() {
                return f64::NAN;
            }
            worst = worst.max(error);
        }
    }
    worst
}

/// Counts positions that are not finite or are outside the map, over all normals and the zero normal of the background.
fn invalid_positions(form: fn(Vec3, Vec3) -> Vec2) -> f64 {
    let all = eyes().into_iter().flat_map(|eye| normals(eye).chain([Vec3::ZERO]).map(move |n| form(n, eye)));
    all.filter(|uv| !uv.is_finite() || uv.min_element() < 0.0 || uv.max_element() > 1.0).count() as f64
}

/// Counts the distinct positions on a grid of 64 by 64.
fn distinct_cells(form: fn(Vec3, Vec3) -> Vec2, eye: Vec3) -> usize {
    let cell = |uv: Vec2| (uv * 64.0).floor().as_ivec2();
    let cells: std::collections::BTreeSet<[i32; 2]> =
        normals(eye).map(|n| form(n, eye)).filter(|uv| uv.is_finite()).map(|uv| cell(uv).to_array()).collect();
    cells.len()
}

fn drive() -> Result<Vec<Finding>, BakeError> {
    let aside = eyes()[3];
    // Number of cells in the disc inscribed in the square of 64 × 64 cells. The measure is the fraction of the disc's
    // cells that no normal reaches.
    let disc = std::f64::consts::FRAC_PI_4 * 64.0 * 64.0;
    let empty = |form| (1.0 - distinct_cells(form, aside) as f64 / disc).max(0.0);
    Ok(vec![
        Finding {
            case: "normals that face the eye, over a view of 60 degrees, as published".into(),
            measure: "coordinates that are not a number or outside the map",
            naive: invalid_positions(printed),
            safe: invalid_positions(perpendicular),
            bound: 0.0,
            fails_above: 100.0,
        },
        Finding {
            case: "the same, 30 degrees off axis, as published".into(),
            measure: "fraction of the map's disc that no normal reaches",
            naive: empty(printed),
            safe: empty(perpendicular),
            // Allows for cells of the rim that are only partly in the disc, and for the sampling of normals.
            bound: 0.05,
            fails_above: 0.95,
        },
        Finding {
            case: "the same, by reflection in view space".into(),
            measure: "largest error of the distance from the centre, in map widths",
            naive: worst(ink_sphere_uv_reflected),
            safe: worst(perpendicular),
            // Allows for f32 rounding in dot products and a square root.
            bound: 1e-6,
            // Shrinking of the rim alone gives the naive form an error of (1 − cos(15°)) / 2 = 0.017.
            fails_above: 0.016,
        },
    ])
}
