//! Tests of the stability table: our form of each method stays within its bound where the naive form fails. The inputs
//! are in `pelage_lab::stability`, which `pelage chart stability` prints. This module also tests further properties.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use super::silhouettes::texels as drawn;
use glam::Vec3;
use pelage_bake::recipe::HairParams;
use pelage_formats::TextureFormat;
use pelage_lab::stability;
use pelage_lab::stability::{Drawing, Finding, Row, grow, hair_simulation, natural_hair, opacity, slice, texels};
use pelage_tests::gpu::gpu;

/// Asserts that our form of a row stays within its bound, and that the naive form fails. Otherwise the input would
/// prove nothing.
#[track_caller]
fn assert_holds<D>(row: &Row<D>, findings: Vec<Finding>) {
    assert!(!findings.is_empty(), "{} has no findings", row.method);
    for f in &findings {
        println!("{}: {}: {}: naive {}, ours {}, bound {}", row.method, f.case, f.measure, f.naive, f.safe, f.bound);
    }
    for f in findings {
        assert!(f.holds(), "{}, {}: {} is {}, bound {}", row.method, f.case, f.measure, f.safe, f.bound);
        assert!(f.naive_fails(), "{}, {}: the naive form's {} is only {}", row.method, f.case, f.measure, f.naive);
    }
}

/// Generates one test per row, so that one failure does not hide another. If a row has no test,
/// `every_row_has_its_test` fails.
macro_rules! rows {
    ($($module:ident),+) => {
        $(
            #[test]
            fn $module() {
                assert_holds(&stability::$module::ROW, (stability::$module::ROW.drive)().unwrap());
            }
        )+

        #[test]
        fn every_row_has_its_test() {
            let tested = [$(stability::$module::ROW.method),+];
            let rows: Vec<_> = stability::ROWS.iter().map(|row| row.method).collect();
            assert_eq!(rows, tested);
        }
    };
}

rows!(
    surface,
    solver,
    hair_simulation,
    parting,
    opacity_product,
    layers,
    mip_levels,
    direction_textures,
    kajiya_kay,
    layer_shadows,
    short_fur,
    soft_shadow,
    animation,
    sphere_map,
    opacity_shadow,
    strand_order,
    hair_motion,
    scattering,
    light_in_fur,
    environment
);

/// Generates the tests of the rows that require pictures.
macro_rules! drawn_rows {
    ($($module:ident),+) => {
        $(
            #[test]
            fn $module() {
                let Some(gpu) = gpu(stringify!($module)) else { return };
                let mut draw = |drawing: &Drawing<'_>| Ok(drawn(gpu, drawing));
                assert_holds(&stability::$module::ROW, (stability::$module::ROW.drive)(&mut draw).unwrap());
            }
        )+

        #[test]
        fn every_drawn_row_has_its_test() {
            let tested = [$(stability::$module::ROW.method),+];
            assert_eq!(stability::DRAWN_ROWS.iter().map(|row| row.method).collect::<Vec<_>>(), tested);
        }
    };
}

drawn_rows!(shells, ink, painted_strokes, strand_width, strand_light);

/// Checks that the check of the rows can fail.
#[test]
fn broken_bounds_are_detected() {
    let spoil: [fn(&mut stability::Finding); 3] =
        [|f| f.safe = 2.0 * f.bound + 1.0, |f| f.safe = f64::NAN, |f| f.naive = f.fails_above];
    for (i, spoil) in spoil.into_iter().enumerate() {
        for mut finding in (stability::layers::ROW.drive)().unwrap() {
            spoil(&mut finding);
            assert!(!finding.holds() || !finding.naive_fails(), "fault {i} was not detected");
        }
    }
}

#[test]
fn cancelled_mean_direction_is_stored_as_isotropic() {
    use pelage_bake::stages::slice::direction::encode_mean;
    let noise = Vec3::new(3e-8, -6e-8, 0.0);
    assert_eq!(encode_mean(noise, TextureFormat::Rg8Unorm)[..2], [128, 128]);
    assert_eq!(encode_mean(noise, TextureFormat::Rgba8Unorm)[..3], [128, 128, 128]);
    // The naive form turns rounding noise into a unit direction.
    let naive = noise / noise.length();
    assert!((naive.length() - 1.0).abs() < 1e-3 && naive.z == 0.0);
}

/// Checks that mip levels keep the mean colour of the fur viewed from above over black. Premultiplied colours are
/// composited layer over layer.
#[test]
fn mip_levels_keep_the_mean_colour() {
    let set = slice(&grow(&HairParams { density: 250, ..natural_hair().unwrap() }, 0.4).unwrap(), 16, 64).unwrap();
    let seen = |level: usize| {
        let column = |texel: usize| {
            let (mut green, mut t) = (0.0, 1.0);
            for k in (0..16).rev() {
                green +=
                    t * f64::from(pelage_formats::meaning::srgb_to_linear(set.layers[k].color[level][4 * texel + 1]));
                t *= 1.0 - opacity(&set, k, level, texel);
            }
            green
        };
        stability::mean(&(0..texels(&set, level)).map(column).collect::<Vec<_>>())
    };
    let truth = seen(0);
    for level in 1..=6 {
        assert!((seen(level) / truth - 1.0).abs() < 0.03, "level {level}: {}, at level 0 {truth}", seen(level));
    }
}

#[test]
fn strands_under_extreme_forces_are_valid_and_within_their_height() {
    for extreme in hair_simulation::Extreme::all() {
        let strands = grow(&extreme.hair, extreme.height).unwrap();
        strands.validate().unwrap();
        assert!(strands.len() == 9 && strands.height <= extreme.height * 1.001, "{extreme:?}");
    }
}
