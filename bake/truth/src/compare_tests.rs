use super::*;
use image::Rgba;
use nv_flip::{FlipImageFloat, FlipPool};

const GREY: [u8; 3] = [128; 3];

/// Draws a hair-like test picture: strokes of two colours on a transparent background.
fn strokes(width: u32, height: u32, shift: u32) -> RgbaImage {
    RgbaImage::from_fn(width, height, |x, y| match (x + y / 3 + shift) % 7 {
        _ if x < width / 4 => Rgba([0; 4]),
        0 => Rgba([90, 70, 40, 255]),
        1 | 2 => Rgba([210, 180, 140, 200]),
        _ => Rgba([140, 110, 80, 255]),
    })
}

#[test]
fn equal_pictures_do_not_differ() {
    let a = strokes(64, 48, 0);
    let (c, map) = compare(&a, &a, GREY).unwrap();
    assert_eq!((c.flip, c.rmse, c.psnr_db, c.coverage), (FlipFigures::default(), 0.0, f64::INFINITY, 0.0));
    assert_eq!((map.width, map.height, map.values), (64, 48, vec![0.0; 64 * 48]));
}

#[test]
fn black_against_white_is_one() {
    let of = |byte: u8| RgbaImage::from_pixel(40, 30, Rgba([byte, byte, byte, 255]));
    let (c, map) = compare(&of(0), &of(255), GREY).unwrap();
    assert!((c.rmse - 1.0).abs() < 1e-6 && c.psnr_db.abs() < 1e-5 && c.coverage == 0.0, "{c:?}");
    // FLIP reaches its upper bound for the largest possible error.
    assert!(c.flip.mean > 0.95 && c.flip.max <= 1.0 && c.flip.covered == c.flip.mean, "{c:?}");
    let yellow = map.magma().get_pixel(20, 15).0;
    assert!(yellow[0] > 240 && yellow[1] > 220 && yellow[2] > 150, "{yellow:?}");
}

/// Negative control: checks that each kind of error raises the figures that should respond to it.
#[test]
fn differences_raise_the_error() {
    let a = strokes(96, 64, 0);
    let figures = |b: &RgbaImage| compare(&a, b, GREY).unwrap().0;
    let moved = figures(&strokes(96, 64, 1));
    assert!(moved.flip.mean > 0.05 && moved.rmse > 0.02 && moved.psnr_db < 35.0, "{moved:?}");
    // `covered` ignores pixels that are empty in both pictures; here a quarter of the picture is covered.
    let ratio = moved.flip.covered / moved.flip.mean;
    assert!((1.2..1.4).contains(&ratio), "{ratio}");
    assert!(moved.flip.mean < moved.flip.weighted_median && moved.flip.weighted_median < moved.flip.max);
    let mut thinner = a.clone();
    thinner.pixels_mut().for_each(|p| p.0[3] /= 2);
    let thinner = figures(&thinner);
    assert!(thinner.coverage > 0.3 && thinner.flip.mean > 0.02, "{thinner:?}");
    let mut one = a.clone();
    one.put_pixel(50, 30, Rgba([255, 0, 0, 255]));
    let one = figures(&one);
    assert!(one.flip.max > 0.2 && one.flip.mean < 0.01 && one.rmse > 0.0 && one.psnr_db.is_finite(), "{one:?}");
    // A small error raises FLIP, and a larger error raises it further.
    let brighter = |by: u8| {
        let mut b = a.clone();
        b.pixels_mut().for_each(|p| (0..3).for_each(|i| p.0[i] = p.0[i].saturating_add(by)));
        figures(&b).flip.mean
    };
    assert!(0.0 < brighter(4) && brighter(4) < brighter(16) && brighter(16) < brighter(64));
}

#[test]
fn background_affects_only_transparent_pixels() {
    let a = strokes(64, 48, 0);
    let mut outline = a.clone();
    outline.pixels_mut().for_each(|p| p.0[3] = if p.0[3] > 0 { p.0[3] } else { 40 });
    let flip = |over| compare(&a, &outline, over).unwrap().0.flip.mean;
    assert!(
        flip([255; 3]) > 1.5 * flip([20; 3]),
        "black haze must be visible on white: {} {}",
        flip([255; 3]),
        flip([20; 3])
    );
    let opaque = |shift| {
        let mut b = strokes(64, 48, shift);
        b.pixels_mut().for_each(|p| p.0[3] = 255);
        b
    };
    let on = |over| compare(&opaque(0), &opaque(1), over).unwrap().0;
    assert_eq!(on([255; 3]), on([0; 3]));
}

#[test]
fn flip_figures_match_the_library() {
    let (c, map) = compare(&strokes(120, 80, 0), &strokes(120, 80, 2), GREY).unwrap();
    let mut pool = FlipPool::from_image(&FlipImageFloat::with_data(map.width, map.height, &map.values));
    // The tolerance allows for the library's f32 sums.
    assert!((c.flip.mean - f64::from(pool.mean())).abs() < 1e-5);
    assert!((c.flip.weighted_median - f64::from(pool.get_percentile(0.5, true))).abs() < 1e-3);
    assert_eq!(c.flip.max, f64::from(pool.max_value()));
}

#[test]
fn coarser_pixels_raise_the_flip_error() {
    let (a, b) = (Picture::from(&strokes(96, 64, 0)), Picture::from(&strokes(96, 64, 3)));
    let at = |pixels_per_degree| {
        let params = CompareParams { pixels_per_degree, ..CompareParams::default() };
        compare_pictures(&a, &b, &params).unwrap().0.flip.mean
    };
    assert!(at(20.0) > 1.1 * at(67.0), "{} {}", at(20.0), at(67.0));
}

#[test]
fn pictures_of_two_sizes_are_refused() {
    let error = compare(&strokes(8, 8, 0), &strokes(8, 9, 0), GREY).map(|_| ());
    assert!(error.as_ref().is_err_and(|e| e.to_string().contains("8x8 and 8x9")), "{error:?}");
    // A picture of one pixel is valid.
    assert!(compare(&strokes(1, 1, 0), &strokes(1, 1, 0), GREY).is_ok());
}
