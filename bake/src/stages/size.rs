//! Checks of a model's size, position and winding. A size unsuitable for fur is an error; other oddities are warnings.

use super::groom::Lengths;
use crate::recipe::{ModelParams, Recipe};
use glam::{DVec3, Vec3};
use pelage_formats::Bounds;
use pelage_import::BakeError;

/// Range of the longest side without a warning, metres; covers all furred animals from mouse to giraffe.
const ANIMALS_M: std::ops::RangeInclusive<f64> = 0.01..=5.0;
/// Radius of an animal between cat and horse, metres. A suggested unit brings the model near this size.
const ANIMAL_M: f64 = 0.5;
/// Distance from the origin, in radii, beyond which the precision of a position is worse than a thousandth of the
/// radius: a float has 24 bits.
const FAR_RADII: f64 = 10_000.0;
/// Largest length of the sum of area vectors, as a share of the total area, for which a surface counts as closed.
const CLOSED: f64 = 0.05;
/// Volume divided by area to the power of 1.5, below which a closed surface counts as inside out. A ball has 0.094.
const INSIDE_OUT: f64 = -0.002;

/// Returns the side lengths of the box along x, y and z, metres.
pub fn sides_m(bounds: &Bounds) -> [f64; 3] {
    std::array::from_fn(|axis| f64::from(bounds.max[axis]) - f64::from(bounds.min[axis]))
}

/// Formats side lengths: `0.42 x 0.25 x 0.61 m`.
pub fn format_sides(sides_m: [f64; 3]) -> String {
    format!("{} m", format_lengths(sides_m).join(" x "))
}

/// Formats lengths in metres, each with three significant digits.
pub fn format_lengths(lengths_m: [f64; 3]) -> [String; 3] {
    lengths_m.map(meters)
}

/// Formats a length in metres with three significant digits.
fn meters(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        let whole = libm::floor(libm::log10(value.abs().max(1e-3))) as i32;
        format!("{value:.*}", (2 - whole).clamp(0, 6) as usize)
    } else {
        format!("{value:.2e}")
    }
}

/// Rejects a model if its size leads to lengths outside the range of a recipe. Only settings that the recipe leaves
/// open are derived from the model.
///
/// Fails with [`BakeError::Input`] with the model's size, the derived value, and the unit that would give the model an
/// animal's size.
pub fn check(file: &str, recipe: &Recipe, bounds: &Bounds, lengths: &Lengths) -> Result<(), BakeError> {
    let mut told = recipe.clone();
    told.hair.length_m = Some(lengths.length_m);
    told.surface.tile_size_m = Some(lengths.tile_size_m);
    let Err(BakeError::Params { what, reason }) = told.validate() else { return Ok(()) };
    let size = format_sides(sides_m(bounds));
    let unit_m = recipe.model.unit_m;
    let unit = match fitting_unit_m(bounds, unit_m) {
        Some(fitting) => format!("set model.unit_m={fitting} if it was made in another unit (now {unit_m})"),
        None => "scale the model to its real size".to_owned(),
    };
    Err(BakeError::Input {
        file: file.to_owned(),
        place: "whole model".to_owned(),
        reason: format!(
            "it is {size} at rest, for which {what} cannot be chosen ({reason}); {unit}, or set hair.length_m and \
             surface.tile_size_m"
        ),
    })
}

/// Rejects hair that is longer than the model: one of the two has another unit, and the bake would take minutes.
///
/// Fails with [`BakeError::Params`] with both lengths, and the unit that would give the model an animal's size.
pub fn check_hair(recipe: &Recipe, bounds: &Bounds, lengths: &Lengths) -> Result<(), BakeError> {
    let longest = sides_m(bounds).into_iter().fold(0.0, f64::max);
    if f64::from(lengths.length_m) <= longest || longest == 0.0 {
        return Ok(());
    }
    let unit_m = recipe.model.unit_m;
    let unit = match fitting_unit_m(bounds, unit_m).filter(|fitting| *fitting != unit_m) {
        Some(fitting) => format!("model.unit_m={fitting}"),
        None => "model.unit_m".to_owned(),
    };
    let what = if recipe.hair.length_m.is_some() { "hair.length_m" } else { "hair.length_per_radius" };
    let reason = format!(
        "the hair is {} m long and the model {} m; expected hair shorter than the model, in metres, or {unit} if the \
         model was made in another unit (now {unit_m})",
        meters(lengths.length_m.into()),
        meters(longest)
    );
    Err(BakeError::Params { what, reason })
}

/// Returns the power of ten that, as a unit, brings the model's size nearest to an animal's; `None` if it is outside
/// the range of a recipe.
fn fitting_unit_m(bounds: &Bounds, unit_m: f32) -> Option<f32> {
    let radius = f64::from(bounds.radius);
    if !(radius.is_finite() && radius > 0.0) {
        return None;
    }
    // The number is parsed from its decimal form, so that it is printed as 0.001 and not as a product of floats.
    let power = libm::round(libm::log10(ANIMAL_M * f64::from(unit_m) / radius)) as i32;
    let unit_m: f32 = format!("1e{power}").parse().ok()?;
    ModelParams { unit_m, ..ModelParams::default() }.validate().ok().map(|()| unit_m)
}

/// Returns warnings about a model: a size unusual for an animal, a position far from the origin, or triangles that face
/// inwards.
///
/// * `positions`, `triangles`: mesh at rest, metres
pub fn warnings(recipe: &Recipe, bounds: &Bounds, positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<String> {
    let mut out = Vec::new();
    let sides = sides_m(bounds);
    let longest = sides.into_iter().fold(0.0, f64::max);
    if !ANIMALS_M.contains(&longest) {
        let unit = fitting_unit_m(bounds, recipe.model.unit_m).map_or_else(String::new, |unit_m| {
            format!("; if it was made in a unit other than metres, set model.unit_m={unit_m} or similar")
        });
        let size = if longest < *ANIMALS_M.start() { "small" } else { "large" };
        out.push(format!("the model is {} at rest, {size} for an animal{unit}", format_sides(sides)));
    }
    let away = DVec3::from(bounds.center.map(f64::from)).length();
    let radius = f64::from(bounds.radius);
    if away > FAR_RADII * radius {
        out.push(format!(
            "the model is {} m from the origin, {:.0} times its own radius: its positions are rounded to {} m; move \
             it to the origin",
            meters(away),
            away / radius,
            // Value of the last of a float's 24 bits at this distance.
            meters(away * libm::exp2(-24.0)),
        ));
    }
    if is_inside_out(bounds, positions, triangles) {
        out.push(
            "the triangles face inwards: the model's volume is negative, and its hair grows into it. Flip the faces \
             in a modelling tool (Blender: Mesh, Normals, Recalculate Outside)"
                .to_owned(),
        );
    }
    out
}

/// Returns whether the surface is closed and faces inwards. The sign of the volume has no meaning for an open surface.
fn is_inside_out(bounds: &Bounds, positions: &[Vec3], triangles: &[[u32; 3]]) -> bool {
    let center = DVec3::from(bounds.center.map(f64::from));
    let (mut vector, mut area, mut volume) = (DVec3::ZERO, 0.0, 0.0);
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| positions[v as usize].as_dvec3() - center);
        let normal = (b - a).cross(c - a) / 2.0;
        vector += normal;
        area += normal.length();
        volume += a.dot(normal) / 3.0;
    }
    vector.length() < CLOSED * area && volume < INSIDE_OUT * area * area.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stages::groom;
    use pelage_import::mesh::RestPose;

    fn ball(radius: f32, inwards: bool) -> (Bounds, Vec<Vec3>, Vec<[u32; 3]>) {
        let corners = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
        let positions: Vec<Vec3> = corners.iter().map(|p| *p * radius).collect();
        let mut triangles = Vec::new();
        for (x, y, z) in [0, 1, 2, 3, 4, 5, 6, 7].map(|i| (i & 1, i >> 1 & 1, i >> 2)) {
            let (a, b, c) = (3 * x, 1 + 3 * y, 2 + 3 * z);
            let outwards = (x + y + z) % 2 == 0;
            triangles.push(if outwards == inwards { [a, c, b] } else { [a, b, c] });
        }
        let rest = RestPose { normals: vec![Vec3::Z; 6], positions: positions.clone() };
        (groom::bounds(&rest), positions, triangles)
    }

    fn remarks_of((bounds, positions, triangles): (Bounds, Vec<Vec3>, Vec<[u32; 3]>)) -> Vec<String> {
        warnings(&Recipe::default(), &bounds, &positions, &triangles)
    }

    #[test]
    fn ordinary_sizes_give_no_warning() {
        assert_eq!(remarks_of(ball(0.5, false)), Vec::<String>::new());
    }

    #[test]
    fn implausible_sizes_are_reported_with_a_suitable_unit() {
        let found = remarks_of(ball(70.0, false));
        assert_eq!(
            found,
            ["the model is 140 x 140 x 140 m at rest, large for an animal; \
              if it was made in a unit other than metres, set model.unit_m=0.01 or similar"]
        );
        let stag = remarks_of(ball(2.7, false));
        assert!(stag[0].starts_with("the model is 5.40 x 5.40 x 5.40 m at rest, large for an animal; if"), "{stag:?}");
        assert!(
            remarks_of(ball(0.002, false))[0].contains("4.00e-3 m")
                || remarks_of(ball(0.002, false))[0].contains("0.00400")
        );
    }

    #[test]
    fn distant_and_inverted_models_are_reported() {
        let (_, mut positions, triangles) = ball(1.0, false);
        positions.iter_mut().for_each(|p| p.x += 1e6);
        let rest = RestPose { normals: vec![Vec3::Z; 6], positions: positions.clone() };
        let found = remarks_of((groom::bounds(&rest), positions, triangles));
        assert!(found.len() == 1 && found[0].contains("from the origin"), "{found:?}");
        let found = remarks_of(ball(1.0, true));
        assert!(found.len() == 1 && found[0].contains("face inwards"), "{found:?}");
        // An open sheet that faces down is correct, but has a negative volume below its middle.
        let (bounds, positions, triangles) = ball(1.0, true);
        assert!(remarks_of((bounds, positions, triangles[..4].to_vec())).is_empty());
    }

    #[test]
    fn hair_longer_than_the_model_is_refused() {
        let check_of = |radius: f32, set: &str| {
            let mut recipe = Recipe::default();
            recipe.set(set).unwrap_or_else(|e| panic!("{e}"));
            let (bounds, ..) = ball(radius, false);
            let lengths = Lengths::resolve(&recipe, &bounds);
            check_hair(&recipe, &bounds, &lengths).map_err(|error| error.to_string())
        };
        assert_eq!(check_of(0.02, "hair.length_m=0.04"), Ok(()));
        let expected = "hair.length_m: the hair is 200 m long and the model 5.40 m; expected hair shorter than the \
                        model, in metres, or model.unit_m=0.1 if the model was made in another unit (now 1)";
        assert_eq!(check_of(2.7, "hair.length_m=200"), Err(expected.to_owned()));
        let tiny = check_of(0.005, "hair.length_m=0.1").expect_err("longer than the model");
        assert!(tiny.contains("the model 0.01000 m") && tiny.contains("model.unit_m=100 if"), "{tiny}");
        let animal = check_of(0.5, "hair.length_m=7").expect_err("longer than the model");
        assert!(animal.contains("in metres, or model.unit_m if"), "{animal}");
    }

    #[test]
    fn sizes_that_no_hair_length_suits_are_refused() {
        let check_of = |radius: f32, recipe: &Recipe| {
            let (bounds, ..) = ball(radius, false);
            let lengths = Lengths::resolve(recipe, &bounds);
            check("big.obj", recipe, &bounds, &lengths).map_err(|e| e.to_string())
        };
        let mut recipe = Recipe::default();
        assert_eq!(check_of(1.0, &recipe), Ok(()));
        let error = check_of(3e4, &recipe).expect_err("too large");
        for word in ["big.obj: whole model", "60000 x 60000 x 60000 m", "surface.tile_size_m", "model.unit_m=0.00001"] {
            assert!(error.contains(word), "{error}");
        }
        assert!(check_of(1e-7, &recipe).is_err());
        assert!(check_of(1e30, &recipe).is_err());
        (recipe.hair.length_m, recipe.surface.tile_size_m) = (Some(0.02), Some(0.1));
        assert_eq!(check_of(3e4, &recipe), Ok(()));
    }
}
