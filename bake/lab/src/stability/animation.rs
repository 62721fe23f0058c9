//! Skeletons as found in files: joints that scale non-uniformly, mirror or collapse; unweighted joints with arbitrary
//! contents; weights that sum to zero. (Weights with other sums than 1 are normalised when a model is read, and
//! packages with such weights do not open.)

use super::measures::even_direction;
use super::row::{Finding, Row};
use glam::{EulerRot, Mat3, Mat4, Quat, Vec3, Vec4};
use pelage_import::BakeError;
use pelage_runtime::shared::skinning::{blend, transform_normal};
use pelage_runtime::shared::tile_frame::{any_perpendicular, orthonormal_tangent};

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "animation",
    cliff: "mirrored, flattened and collapsed joints; broken joints of weight 0; vertices without weight",
    naive: "normals: joint matrix, inverse transpose or cofactor matrix; blended matrix: plain weighted sum",
    safe: "normals: cofactor matrix corrected for mirroring, or the original normal if the result is zero; \
           joints of weight 0: skipped; vertices without weight: not moved",
    drive,
};

/// Returns joint matrices that occur in skeletons and that implementations easily overlook.
pub fn joints() -> Vec<(&'static str, Mat3)> {
    let turn = Mat3::from_quat(Quat::from_euler(EulerRot::XYZ, 0.3, 0.7, -0.4));
    let scales = [
        ("uneven", [0.05, 1.0, 20.0]),
        ("mirrored", [-1.0, 1.0, 1.0]),
        ("mirrored and non-uniform", [3.0, -0.2, 1.0]),
        ("flattened", [1.0, 0.0, 1.0]),
        ("a line", [0.0, 0.0, 1.0]),
        ("collapsed", [0.0, 0.0, 0.0]),
        ("tiny", [1e-12, 1e-12, 1e-12]),
        ("huge", [1e12, 1e12, 1e12]),
        ("centimetres", [0.01, 0.01, 0.01]),
    ];
    scales.into_iter().map(|(name, scale)| (name, turn * Mat3::from_diagonal(Vec3::from(scale)))).collect()
}

/// Returns unit vectors spread evenly over the sphere.
fn normals() -> impl Iterator<Item = Vec3> {
    const COUNT: u32 = 1000;
    (0..COUNT).map(|i| even_direction(i, COUNT).as_vec3().normalize())
}

fn cofactors(m: Mat3) -> Mat3 {
    Mat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
}

/// Counts normals that are NaN or not of unit length. The naive form transforms normals by the inverse transpose of the
/// joint matrix. In pelage's form, the tangent must also be of unit length and perpendicular to the normal.
fn not_unit() -> (f64, f64) {
    let (mut naive, mut safe) = (0, 0);
    let unit = |v: Vec3| (v.length() - 1.0).abs() < 1e-5;
    for (_, m) in joints() {
        for normal in normals() {
            naive += u32::from(!unit((m.inverse().transpose() * normal).normalize()));
            let posed = transform_normal(m, normal);
            let tangent = orthonormal_tangent(m * any_perpendicular(normal), posed);
            safe += u32::from(!unit(posed) || !unit(tangent) || tangent.dot(posed).abs() > 1e-4);
        }
    }
    (naive.into(), safe.into())
}

/// Counts normals that point inward: a step along them does not lead away from the posed tangent plane. Joints that
/// collapse the volume are excluded.
fn inward() -> (f64, f64) {
    let (mut naive, mut safe) = (0, 0);
    for (_, m) in joints().into_iter().filter(|(_, m)| m.determinant().abs() > 1e-6) {
        for normal in normals() {
            naive += u32::from((cofactors(m) * normal).dot(m * normal) <= 0.0);
            safe += u32::from(transform_normal(m, normal).dot(m * normal) <= 0.0);
        }
    }
    (naive.into(), safe.into())
}

/// Returns the distance of the transformed point (1, 2, 3) from its expected position; NaN if the result is NaN.
fn distance_from_expected(matrix: Mat4, belongs: Vec3) -> f64 {
    f64::from(matrix.transform_point3(Vec3::new(1.0, 2.0, 3.0)).distance(belongs))
}

/// Tests joint matrices that consist of NaN and have weight 0.
fn broken_joint() -> (f64, f64) {
    let (moved, broken) = (Mat4::from_translation(Vec3::X), Mat4::from_cols_array(&[f32::NAN; 16]));
    let weights = Vec4::new(1.0, 0.0, 0.0, 0.0);
    let naive = moved * weights.x + broken * weights.y + broken * weights.z + broken * weights.w;
    let belongs = Vec3::new(2.0, 2.0, 3.0);
    (
        distance_from_expected(naive, belongs),
        distance_from_expected(blend(moved, broken, broken, broken, weights), belongs),
    )
}

/// Tests a vertex without weights, which must keep its stored position. In the naive form, the weighted sum is a zero
/// matrix.
fn no_weight() -> (f64, f64) {
    let moved = Mat4::from_translation(Vec3::X);
    let stored = Vec3::new(1.0, 2.0, 3.0);
    (
        distance_from_expected(moved * 0.0, stored),
        distance_from_expected(blend(moved, moved, moved, moved, Vec4::ZERO), stored),
    )
}

fn drive() -> Result<Vec<Finding>, BakeError> {
    let finding = |case: &str, measure, (naive, safe), fails_above| Finding {
        case: case.into(),
        measure,
        naive,
        safe,
        bound: 0.0,
        fails_above,
    };
    Ok(vec![
        finding(
            "9 joints from non-uniform scale to collapsed, 1000 normals each",
            "normals and tangents that are NaN or not of unit length",
            not_unit(),
            1000.0,
        ),
        finding(
            "joints with |determinant| > 1e-6, mirrored ones included",
            "normals that point inward",
            inward(),
            1000.0,
        ),
        finding(
            "a joint of weight 0 whose matrix contains NaN",
            "distance from the correct position, metres",
            broken_joint(),
            1.0,
        ),
        finding("a vertex without any weight", "distance from the correct position, metres", no_weight(), 1.0),
    ])
}
