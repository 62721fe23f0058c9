use super::*;
use crate::meaning::scattering::AzimuthalScattering as Section;
use crate::meaning::scattering::gaussian_light::GaussianLight;
use crate::meaning::scattering::optics::Medulla;

/// Returns the relative RMS error of the tables over views and lights of one sharpness. `expected` returns the
/// reference value; its arguments are the index of a fibre, the light's axis and the direction to the eye.
fn off(
    tables: &[BroadTables],
    sharpness: f64,
    sigmas: [f64; 3],
    samples: u32,
    expected: impl Fn(usize, DVec3, DVec3) -> [f64; 3],
) -> f64 {
    let (mut wrong, mut size) = (0.0, 0.0);
    for (number, tables) in tables.iter().enumerate() {
        for k in 0..samples {
            // Use views and lights between texels.
            let share = |step: f64| (step * (f64::from(k) + 0.5)).fract();
            let (theta_o, theta_j) = (2.6 * (share(0.754_877_67) - 0.5), 3.0 * (share(0.569_840_29) - 0.5));
            let phi = PI * share(0.819_172_5);
            let way = |theta: f64, phi: f64| {
                DVec3::new(libm::cos(theta) * libm::cos(phi), libm::sin(theta), libm::cos(theta) * libm::sin(phi))
            };
            let light = CutGaussianLight { towards: way(theta_j, phi), mean: cut_gaussian_mean_cosine(sharpness) };
            let found = tables.scatter(sigmas, DVec3::Y, &light, way(theta_o, 0.0));
            let expected = expected(number, light.towards, way(theta_o, 0.0));
            for (found, expected) in found.into_iter().zip(expected) {
                wrong += (found - expected) * (found - expected);
                size += expected * expected;
            }
        }
    }
    (wrong / size).sqrt()
}

#[test]
fn table_image_holds_all_texels() {
    let size = BroadSize { means: 2, to: 3, from: 4, phi: 5 };
    let tables = BroadTables::new(&Fibre::default(), size);
    let (picture, [width, height]) = (tables.image(), BroadTables::image_size(size));
    assert_eq!((picture.len(), width, height), (size.texels(), 8, 15));
    // Index of the texel with the second mean cosine, the third θo, the fourth φ and the second θj.
    let index = ((3 + 2) * 5 + 3) * 4 + 1;
    assert_eq!(picture[(2 * 5 + 3) * width + 4 + 1], tables.texels[index]);
}

fn fibres() -> [Fibre; 2] {
    let smoother = Fibre { along: 0.12, around: Section::Rough(0.12), ..Fibre::default() };
    let rougher = Fibre { along: 0.25, tilt: 0.08, around: Section::Rough(0.3), ..Fibre::default() };
    [smoother, rougher]
}

/// For a narrow light, the cutoff makes no difference, so the reference is the scattering of a whole Gaussian.
#[test]
fn broad_tables_approximate_the_exact_scattering() {
    let tables = fibres().map(|fibre| BroadTables::new(&fibre, BroadSize::default()));
    let lit = fibres().map(|fibre| BroadlyLitFibre::new(&fibre));
    for (width, most) in [(8.0, 0.08), (12.0, 0.04), (20.0, 0.015), (25.0, 0.015)] {
        let sharpness = f64::to_radians(width).powi(-2);
        let [clear, dark] = [[0.0; 3], [0.1, 0.3, 0.8]].map(|sigmas| {
            off(&tables, sharpness, sigmas, 80, |number, towards, eye| {
                lit[number].scatter(sigmas, DVec3::Y, &GaussianLight { towards, sharpness }, eye)
            })
        });
        assert!(clear < most && dark < most, "{width} degrees: {clear}, {dark}");
    }
}

/// Directions distributed as evenly as possible over the sphere.
fn everywhere(count: usize) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |i| {
        let y = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
        let (sin, cos) = (2.399_963_229_728_653 * i as f64).sin_cos();
        let out = (1.0 - y * y).sqrt();
        DVec3::new(out * cos, y, out * sin)
    })
}

/// For wide lights, the tables agree with a sum over all directions above the cutoff.
#[test]
fn broad_tables_match_a_sum_over_directions_above_the_cutoff() {
    const DIRECTIONS: usize = 2500;
    let assert_matches = |fibres: &[Fibre], tables: &[BroadTables], sharpness: f64, sigmas: [f64; 3], most: f64| {
        let off = off(tables, sharpness, sigmas, 8, |number, towards, eye| {
            let share = 4.0 * PI / DIRECTIONS as f64;
            let of = |from: DVec3| {
                let light = (sharpness * (from.dot(towards) - 1.0)).exp() * share;
                fibres[number].scatter(sigmas, &Angles::between(DVec3::Y, from, eye)).map(|x| light * x)
            };
            let lit = everywhere(DIRECTIONS).filter(|from| from.dot(towards) > -HORIZON_SINE);
            lit.map(of).fold([0.0; 3], |sum, of| from_fn(|i| sum[i] + of[i]))
        });
        assert!(off < most, "{sharpness} {sigmas:?} {:?}: {off}", fibres[0].medulla);
    };
    let tables_of = |fibres: &[Fibre]| -> Vec<_> {
        fibres.iter().map(|fibre| BroadTables::new(fibre, BroadSize::default())).collect()
    };
    let (clear, tables) = (fibres(), tables_of(&fibres()));
    for (sharpness, sigmas) in [(0.0, [0.0; 3]), (0.0, [0.1, 0.3, 2.0]), (1.5, [0.1, 0.3, 2.0])] {
        assert_matches(&clear, &tables, sharpness, sigmas, 0.02);
    }
    let medullated = [Fibre { medulla: Medulla { ratio: 0.7, scattering: 1.0 }, ..clear[0] }];
    assert_matches(&medullated, &tables_of(&medullated), 1.5, [0.1, 0.3, 2.0], 0.05);
}

/// Means and mean squares of cosines agree with a sum over directions of the light.
#[test]
fn means_and_mean_squares_match_a_sum_over_directions() {
    for sharpness in [0.0, 0.3, 1.0, 3.0, 10.0, 50.0] {
        let lit = || {
            everywhere(20_000).filter(|way| way.y > -HORIZON_SINE).map(|way| (way, (sharpness * (way.y - 1.0)).exp()))
        };
        let whole: f64 = lit().map(|(_, light)| light).sum();
        let mean = lit().map(|(way, light)| light * way.y).sum::<f64>() / whole;
        assert!((cut_gaussian_mean_cosine(sharpness) - mean).abs() < 1e-3, "{sharpness}: {mean}");
        assert!(
            (cut_gaussian_sharpness(cut_gaussian_mean_cosine(sharpness)) - sharpness).abs() < 1e-3 * (1.0 + sharpness)
        );
        for cosine in [-1.0, -0.3, 0.0, 0.6, 1.0_f64] {
            let other = DVec3::new((1.0 - cosine * cosine).sqrt(), cosine, 0.0);
            let expected = lit().map(|(way, light)| light * way.dot(other).powi(2)).sum::<f64>() / whole;
            let found = mean_square(cut_gaussian_mean_cosine(sharpness), cosine);
            assert!((found - expected).abs() < 0.006, "{sharpness} {cosine}: {found}, expected {expected}");
        }
    }
}
