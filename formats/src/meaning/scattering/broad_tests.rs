use super::*;
use crate::meaning::scattering::Around as Section;

/// Root of the mean square by which tables are off, over that of what they are of, over fibres, colours, looks and lights of that width.
fn off(tables: &[(BroadTables, BroadlyLit)], width_deg: f64, sigmas: [f64; 3]) -> f64 {
    let sharpness = f64::to_radians(width_deg).powi(-2);
    let (mut wrong, mut size) = (0.0, 0.0);
    for (tables, lit) in tables {
        for k in 0..80 {
            // Looks and lights that no texel lies on.
            let share = |step: f64| (step * (f64::from(k) + 0.5)).fract();
            let (theta_o, theta_j) = (2.6 * (share(0.754_877_67) - 0.5), 3.0 * (share(0.569_840_29) - 0.5));
            let phi = PI * share(0.819_172_5);
            let way = |theta: f64, phi: f64| {
                DVec3::new(libm::cos(theta) * libm::cos(phi), libm::sin(theta), libm::cos(theta) * libm::sin(phi))
            };
            let light = GaussianLight { towards: way(theta_j, phi), sharpness };
            let found = tables.scatter(sigmas, DVec3::Y, &light, way(theta_o, 0.0));
            let expected = lit.scatter(sigmas, DVec3::Y, &light, way(theta_o, 0.0));
            for (found, expected) in found.into_iter().zip(expected) {
                wrong += (found - expected) * (found - expected);
                size += expected * expected;
            }
        }
    }
    (wrong / size).sqrt()
}

#[test]
fn a_picture_holds_all_texels() {
    let size = BroadSize { means: 2, to: 3, from: 4, phi: 5 };
    let tables = BroadTables::new(&Fibre::default(), size);
    let (picture, [width, height]) = (tables.picture(), BroadTables::edges(size));
    assert_eq!((picture.len(), width, height), (size.texels(), 8, 15));
    // The second mean cosine, the third θo, the fourth φ, the second θj.
    let index = ((3 + 2) * 5 + 3) * 4 + 1;
    assert_eq!(picture[(2 * 5 + 3) * width + 4 + 1], tables.texels[index]);
}

#[test]
fn tables_are_what_they_were_made_of() {
    let smoother = Fibre { along: 0.12, around: Section::Rough(0.12), ..Fibre::default() };
    let rougher = Fibre { along: 0.25, tilt: 0.08, around: Section::Rough(0.3), ..Fibre::default() };
    let tables =
        [smoother, rougher].map(|fibre| (BroadTables::new(&fibre, BroadSize::default()), BroadlyLit::new(&fibre)));
    for (width, most) in [(12.0, 0.04), (20.0, 0.015), (30.0, 0.01), (45.0, 0.01), (70.0, 0.01)] {
        let [clear, dark] = [[0.0; 3], [0.1, 0.3, 0.8]].map(|sigmas| off(&tables, width, sigmas));
        assert!(clear < most && dark < most, "{width} degrees: {clear}, {dark}");
    }
}

/// Mean squares of cosines are near those of spherical Gaussians, whose across is r / κ.
#[test]
fn means_of_squares_are_those_of_the_light() {
    for mean in [0.01, 0.2, 0.5, 0.7, 0.9, 0.99] {
        let across = mean / sharpness_of(mean);
        for cosine in [-1.0, -0.3, 0.0, 0.6, 1.0] {
            let expected = across + (1.0 - 3.0 * across) * cosine * cosine;
            let found = mean_square(mean, cosine);
            assert!((found - expected).abs() < 0.02, "{mean} {cosine}: {found}, expected {expected}");
        }
    }
    assert!((mean_square(0.0, 0.7) - 1.0 / 3.0).abs() < 1e-12 && (mean_square(1.0, 0.7) - 0.49).abs() < 1e-12);
}
