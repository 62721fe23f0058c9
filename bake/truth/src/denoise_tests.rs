use super::{Guide, denoise};
use glam::{DVec3, Vec3};
use pelage_bake::noise::uniform;
use pelage_formats::meaning::luminance;

const SIDE: u32 = 32;
const SAMPLES: u32 = 16;

/// Returns the light of pixels whose samples have the given light, a grey, and distance, before and after the filter.
fn pictures(light: impl Fn(u32, u32, u32) -> f64, distance: impl Fn(u32) -> f32) -> [Vec<f32>; 2] {
    let pixel = |i: u32| {
        let (x, y) = (i % SIDE, i / SIDE);
        let mut of = (DVec3::ZERO, 0, Guide::default());
        for n in 0..SAMPLES {
            let light = DVec3::splat(light(x, y, n));
            of.0 += light;
            of.1 += 1;
            let Guide { color, direction, distance: [sum, squares], squares: of_light } = &mut of.2;
            *color += Vec3::ONE;
            *direction += Vec3::Y;
            *sum += distance(x);
            *squares += distance(x).powi(2);
            *of_light += luminance(light).powi(2) as f32;
        }
        of
    };
    let sums: Vec<_> = (0..SIDE * SIDE).map(pixel).collect();
    let traced = sums.iter().map(|(light, met, _)| (light.x / f64::from(*met)) as f32).collect();
    let denoised = denoise((SIDE, SIDE), sums.into_iter()).iter().map(|light| light.x).collect();
    [traced, denoised]
}

/// Returns noise between 0 and 2 with the mean 1.
fn noise(x: u32, y: u32, n: u32) -> f64 {
    f64::from(2.0 * uniform(u64::from(y * SIDE + x), n.into()))
}

/// Returns mean and variance of the light in some columns.
fn mean_and_variance(picture: &[f32], columns: std::ops::Range<u32>) -> (f32, f32) {
    let pixels = picture.iter().zip(0..).filter(|(_, i)| columns.contains(&(i % SIDE)));
    let values: Vec<f32> = pixels.map(|(light, _)| *light).collect();
    let count = values.len() as f32;
    let mean = values.iter().sum::<f32>() / count;
    (mean, values.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / count)
}

#[test]
fn constant_pictures_stay_as_they_are() {
    let [traced, denoised] = pictures(|_, _, _| 0.5, |_| 2.0);
    let off = traced.iter().zip(&denoised).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f32::max) < 1e-6);
}

#[test]
fn noise_falls_and_the_mean_stays() {
    let [traced, denoised] = pictures(noise, |_| 2.0);
    let ((mean, before), (mean_after, after)) =
        (mean_and_variance(&traced, 0..SIDE), mean_and_variance(&denoised, 0..SIDE));
    assert!(after < 0.15 * before, "{before} {after}");
    assert!((mean_after / mean - 1.0).abs() < 0.01, "{mean} {mean_after}");
}

/// Checks that light does not pass between surfaces at different distances, although noise hides their difference.
#[test]
fn edges_of_depth_stay() {
    let is_left = |x: u32| x < SIDE / 2;
    let light = |x, y, n| noise(x, y, n) * if is_left(x) { 1.0 } else { 1.5 };
    let [_, denoised] = pictures(light, |x| if is_left(x) { 2.0 } else { 2.5 });
    let middle = SIDE / 2;
    let [left, right] = [middle - 1..middle, middle..middle + 1].map(|columns| mean_and_variance(&denoised, columns).0);
    let [all_left, all_right] = [0..middle, middle..SIDE].map(|columns| mean_and_variance(&denoised, columns).0);
    assert!((left / all_left - 1.0).abs() < 0.05 && (right / all_right - 1.0).abs() < 0.05, "{left} {right}");
    // A step of the light that exceeds the noise stays even where the distance is the same.
    let light = |x, y, n| noise(x, y, n) * if is_left(x) { 0.1 } else { 10.0 };
    let [_, denoised] = pictures(light, |_| 2.0);
    assert!(mean_and_variance(&denoised, middle - 1..middle).0 < 0.15);
}
