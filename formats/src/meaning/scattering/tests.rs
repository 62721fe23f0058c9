use super::azimuthal::{GlintShape, over_section, wrapped};
use super::gaussian_light::{BroadlyLitFibre, GaussianLight};
use super::longitudinal::{Spread, i0e};
use super::means::FibreMeans;
use super::near::{FibreHit, SampledDirection};
use super::optics::{Medulla, Section};
use super::tables::ScatteringTables;
use super::*;
use core::f64::consts::{PI, TAU};

const ETAS: [f64; 3] = [1.45, 1.55, 1.7];

fn cos_deg(degrees: f64) -> f64 {
    libm::cos(degrees.to_radians())
}

/// Returns the integral of `f` over all azimuths, by the midpoint rule.
fn around(count: u32, f: impl Fn(f64) -> f64) -> f64 {
    (0..count).map(|k| f((f64::from(k) + 0.5) / f64::from(count) * TAU - PI)).sum::<f64>() * TAU / f64::from(count)
}

#[test]
fn three_paths_carry_nearly_all_light() {
    let expected = [[0.994, 0.992, 0.976, 0.890], [0.992, 0.990, 0.973, 0.886], [0.990, 0.987, 0.968, 0.882]];
    for (eta, expected) in ETAS.into_iter().zip(expected) {
        for (degrees, expected) in [0.0, 30.0, 60.0, 80.0].into_iter().zip(expected) {
            let section = Section::new(eta, cos_deg(degrees));
            let sum: f64 = (0..3).map(|p| section.energy(p)).sum();
            assert!((sum - expected).abs() < 6e-4, "eta {eta}, {degrees} degrees: {sum}, expected {expected}");
        }
    }
}

#[test]
fn oblique_fresnel_equals_the_formula_with_two_indices() {
    for eta in ETAS {
        for (degrees, gamma) in [(0.0, 0.3), (40.0, 0.9), (75.0, 0.56), (84.0, 1.5)] {
            let section = Section::new(eta, cos_deg(degrees));
            let (_, t) = section.refracted(libm::sin(gamma));
            let (g, double) = (libm::cos(gamma), eta * eta / section.across);
            let s = (g - section.across * t) / (g + section.across * t);
            let p = (double * g - t) / (double * g + t);
            assert!((section.fresnel(g) - 0.5 * (s * s + p * p)).abs() < 1e-14);
        }
        assert_eq!(Section::new(eta, 1.0).fresnel(0.0), 1.0);
    }
}

#[test]
fn azimuthal_scattering_conserves_energy() {
    for eta in ETAS {
        for degrees in [0.0, 30.0, 45.0, 50.0, 55.0, 60.0, 75.0] {
            let section = Section::new(eta, cos_deg(degrees));
            let at = format!("eta {eta}, {degrees} degrees");
            assert!((around(4000, |phi| section.reflected(phi)) - section.energy(0)).abs() < 1e-6, "{at}");
            assert!((around(40_000, |phi| section.transmitted(phi).light) - section.energy(1)).abs() < 1e-4, "{at}");
            let glints = section.glints(&GlintShape::default());
            let light = |phi: f64| section.glinting(phi, glints.as_ref()).map(|way| way.light).sum::<f64>();
            let off = around(20_000, light) / section.energy(2) - 1.0;
            assert!(off.abs() < 5e-3, "{at}: {off}");
            for p in 0..3 {
                let light = |phi: f64| section.rough(p, phi, 0.12).map(|way| way.light).sum::<f64>();
                let off = around(200, light) / section.energy(p) - 1.0;
                assert!(off.abs() < 1e-4, "{at}, path {p}: {off}");
            }
        }
    }
}

#[test]
fn exiting_light_matches_the_analytic_roots() {
    for eta in ETAS {
        for degrees in [0.0, 40.0, 52.0, 60.0, 80.0] {
            let section = Section::new(eta, cos_deg(degrees));
            // The contribution of a ray through the axis agrees with its closed form.
            let straight = section.transmitted(PI);
            let expected = section.share(1, 1.0) / (4.0 * (1.0 - 1.0 / section.across));
            assert!((straight.light - expected).abs() < 1e-9);
            assert!((straight.length - 2.0 / section.cos_t).abs() < 1e-9);
            if section.across > 2.05 {
                let back: f64 = section.reflected_inside(0.0).map(|way| way.light).sum();
                assert!(
                    (back - section.share(2, 1.0) / (4.0 * (1.0 - 2.0 / section.across))).abs() < 1e-9,
                    "{eta} {degrees}"
                );
            }
            // The light is continuous at φ = 0, where the contributions of both halves of the cross-section meet.
            let back = |phi: f64| section.reflected_inside(phi).map(|way| way.light).sum::<f64>();
            assert!((back(0.0) - back(1e-9)).abs() < 1e-6, "eta {eta}, {degrees} degrees");
            for k in 1..60 {
                let phi = f64::from(k) / 60.0 * PI;
                let count = section.reflected_inside(phi).count();
                let inside = section.caustic().is_some_and(|(_, at)| phi < at);
                let reach = -section.deviation(2, PI / 2.0);
                // The first half of the cross-section contributes only between φ = 0 and the caustic: expect two
                // contributions beyond −`reach`, else one. From the other half, expect one contribution up to `reach`.
                let expected = usize::from(inside) * if phi > -reach { 2 } else { 1 } + usize::from(phi <= reach);
                assert_eq!(count, expected, "eta {eta}, {degrees} degrees, phi {phi}, reach {reach}");
            }
        }
    }
    let at = ETAS.map(|eta| Section::new(eta, 1.0).caustic().unwrap().1.to_degrees());
    assert!(at.iter().zip([27.7, 18.6, 8.9]).all(|(found, expected)| (found - expected).abs() < 0.05), "{at:?}");
}

#[test]
fn published_glints_do_not_conserve_light() {
    let glint = GlintShape { width: 5_f64.to_radians(), ..GlintShape::default() };
    let off = |degrees: f64| {
        let section = Section::new(1.55, cos_deg(degrees));
        let light =
            |phi| section.glinting(phi, section.published_glints(&glint).as_ref()).map(|way| way.light).sum::<f64>();
        around(4000, light) / section.energy(2)
    };
    let found = [0.0, 20.0, 40.0, 46.0, 50.0].map(off);
    assert!(found.iter().any(|e| *e > 1.1) && found.iter().all(|e| (0.6..1.5).contains(e)), "{found:?}");
}

#[test]
fn longitudinal_lobes_conserve_energy() {
    for width in [2.0_f64, 5.0, 10.0, 20.0] {
        let spread = Spread { shift: -0.1, width: width.to_radians() };
        for theta in [0.0_f64, 30.0, 60.0, 85.0] {
            let to = (libm::sin(theta.to_radians()), libm::cos(theta.to_radians()));
            let whole: f64 = (0..8000)
                .map(|k| ((f64::from(k) + 0.5) / 8000.0 - 0.5) * PI)
                .map(|i| spread.conserving((libm::sin(i), libm::cos(i)), to) * libm::cos(i) * PI / 8000.0)
                .sum();
            assert!((whole - 1.0).abs() < 1e-5, "width {width}, {theta} degrees: {whole}");
        }
    }
    // Compare with exp(-x) I0(x) from its integral.
    for x in [0.0, 0.5, 3.74, 3.76, 20.0, 5000.0] {
        let whole: f64 = (0..20_000)
            .map(|k| (f64::from(k) + 0.5) / 20_000.0 * PI)
            .map(|a| libm::exp(x * (libm::cos(a) - 1.0)))
            .sum();
        assert!((i0e(x) * 20_000.0 / whole - 1.0).abs() < 1e-6, "{x}");
    }
}

/// Returns pseudo-random unit vectors.
fn directions(count: u32) -> impl Iterator<Item = [DVec3; 3]> {
    let chance = |i: u32, k: u32| {
        let mixed = (u64::from(i) * 6 + u64::from(k) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        ((mixed ^ mixed >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..count).map(move |i| {
        from_fn(|k| {
            let (z, turn) = (2.0 * chance(i, 2 * k as u32) - 1.0, TAU * chance(i, 2 * k as u32 + 1));
            let across = (1.0 - z * z).max(0.0).sqrt();
            DVec3::new(across * libm::cos(turn), across * libm::sin(turn), z)
        })
    })
}

#[test]
fn scattering_is_reciprocal() {
    let fibre = Fibre {
        around: AzimuthalScattering::Smooth(GlintShape::default()),
        keeps: LobeShape::Reciprocity,
        ..Fibre::default()
    };
    for [tip, light, eye] in directions(300) {
        let (there, back) = (Angles::between(tip, light, eye), Angles::between(tip, eye, light));
        let (a, b) = (fibre.scatter([0.2; 3], &there), fibre.scatter([0.2; 3], &back));
        assert!((a[0] / there.from.1 - b[0] / back.from.1).abs() < 1e-9, "{a:?} {b:?}");
    }
}

#[test]
fn scattering_is_finite_for_all_directions() {
    let fibres = [
        AzimuthalScattering::Rough(0.05),
        AzimuthalScattering::Rough(0.6),
        AzimuthalScattering::Smooth(GlintShape::default()),
    ]
    .into_iter()
    .flat_map(|around| {
        [LobeShape::Energy, LobeShape::Reciprocity].map(|keeps| Fibre { around, keeps, ..Fibre::default() })
    });
    let z = DVec3::Z;
    let odd =
        [[z, z, z], [z, -z, z], [z, z, DVec3::X], [z, DVec3::X, -z], [z, DVec3::X, DVec3::X], [z, DVec3::X, -DVec3::X]];
    for fibre in fibres {
        for [tip, light, eye] in directions(200).chain(odd) {
            let found = fibre.scatter([0.0, 1.0, 1e6], &Angles::between(tip, light, eye));
            assert!(found.iter().all(|x| x.is_finite() && *x >= 0.0), "{fibre:?} {light} {eye}: {found:?}");
            assert!(found[0] >= found[1] && found[1] >= found[2]);
        }
    }
    // Pass through η′ = 2, where the glints meet.
    for k in 0..=4000 {
        let section = Section::new(1.55, cos_deg(44.0 + 12.0 * f64::from(k) / 4000.0));
        let glints = section.glints(&GlintShape::default());
        let most = (0..90)
            .map(|j| section.glinting(f64::from(j).to_radians(), glints.as_ref()).map(|way| way.light).sum::<f64>());
        let most = most.fold(0.0, f64::max);
        assert!((0.02..0.2).contains(&most), "{} degrees: {most}", 44.0 + 12.0 * f64::from(k) / 4000.0);
    }
}

#[test]
fn mean_path_absorbs_as_the_sum_of_all_paths() {
    let section = Fibre::default().section(0.8);
    for p in 0..3 {
        for phi in [0.0, 0.5, 2.0, PI] {
            let way = section.mean_contribution(p, phi, 0.3);
            let mut left = 0.0;
            section.contributions(p, phi, &mut |way| left += way.attenuated(0.3));
            assert!((way.attenuated(0.3) - left).abs() < 1e-12 && way.length >= 0.0);
        }
    }
    assert!((over_section(|_| 1.0) - 2.0).abs() < 1e-12 && wrapped(3.0 * PI + 0.1) < -3.0);
}

/// Returns the relative RMS error of `found` against `fibre` over random directions and all colours.
fn off(fibre: &Fibre, sigma: [f64; 3], found: impl Fn(&Angles) -> [f64; 3]) -> f64 {
    let (mut error, mut whole) = (0.0, 0.0);
    for [tip, light, eye] in directions(3000) {
        let angles = Angles::between(tip, light, eye);
        for (a, b) in fibre.scatter(sigma, &angles).into_iter().zip(found(&angles)) {
            (error, whole) = (error + (a - b) * (a - b), whole + a * a);
        }
    }
    (error / whole).sqrt()
}

#[test]
fn scattering_tables_approximate_the_equations() {
    let check = |fibre: &Fibre, size: usize, most: f64| {
        let tables = ScatteringTables::new(fibre, size);
        let sigma = [0.1, 0.5, 2.0];
        let found = off(fibre, sigma, |angles| tables.scatter(sigma, angles));
        println!("{fibre:?} {size}: {found}");
        assert!(found < most, "{fibre:?} {size}: {found}");
    };
    for around in [AzimuthalScattering::Rough(0.12), AzimuthalScattering::Smooth(GlintShape::default())] {
        for keeps in [LobeShape::Energy, LobeShape::Reciprocity] {
            let fibre = Fibre { around, keeps, ..Fibre::default() };
            check(&fibre, 64, 0.02);
            check(&fibre, 128, 0.007);
        }
    }
    for medulla in [MEDULLAE[2], MEDULLAE[3]] {
        check(&Fibre { medulla, ..Fibre::default() }, 64, 0.04);
    }
}

/// Continuing and returning light add up to the light that the fibre does not absorb; in white fibres, to all light.
#[test]
fn table_means_split_light_into_forward_and_backward() {
    for medulla in [Medulla::NONE, MEDULLAE[2]] {
        assert_means_split_light(&Fibre { medulla, ..Fibre::default() });
    }
}

fn assert_means_split_light(fibre: &Fibre) {
    let tables = ScatteringTables::new(fibre, 64);
    for cos in [0.15, 0.4, 0.7, 1.0] {
        let sigmas = colour::absorption([1.0, 0.5, 0.1], 0.12);
        let [on, back] = tables.means.sides(cos, tables.eta, sigmas);
        assert!((on[0] + back[0] - 1.0).abs() < 1e-6, "cos θ {cos}: {on:?} {back:?}");
        let section = fibre.section(cos);
        for (c, sigma) in sigmas.into_iter().enumerate().skip(1) {
            let of_ways = |p: u32, phi: f64| {
                let mut sum = 0.0;
                section.contributions(p, phi, &mut |way| sum += way.attenuated(sigma));
                sum
            };
            let half = |from: f64| {
                let of = |k: u32| from + (f64::from(k) + 0.5) * PI / 200.0;
                let ways = |phi: f64| {
                    (0..3).map(|p| of_ways(p, phi)).sum::<f64>() + section.rest(sigma) + section.scattered(sigma)
                };
                (0..200).map(|k| ways(of(k))).sum::<f64>() * PI / 200.0
            };
            for (found, from, side) in [(on[c], 0.5 * PI, "on"), (back[c], -0.5 * PI, "back")] {
                let expected = half(from);
                assert!(
                    (found - expected).abs() < 0.02,
                    "cos θ {cos}, σ {sigma}, {side}: {found}, expected {expected}"
                );
            }
        }
    }
    let layers = tables.layers().map(<[_]>::to_vec);
    assert_eq!(ScatteringTables::of_layers(tables.eta, tables.means, layers).as_ref(), Some(&tables));
}

#[test]
fn colours_convert_to_absorption_and_pigments() {
    for roughness in [0.0, 0.1, 0.3, 0.5, 0.9, 1.0] {
        let scale = colour::scale_of(roughness);
        assert!((colour::roughness(scale) - roughness).abs() < 1e-9);
        for c in [colour::DARKEST, 0.05, 0.3, 0.9, 1.0] {
            let sigma = colour::absorption([c; 3], scale);
            assert!((colour::color(sigma, scale)[0] - c).abs() < 1e-9 && sigma[0].is_finite());
        }
        // White absorbs nothing. Black absorbs as much as the darkest colour.
        assert_eq!(colour::absorption([1.0, 1.5, 2.0], scale), [0.0; 3]);
        assert_eq!(colour::absorption([0.0; 3], scale), colour::absorption([colour::DARKEST; 3], scale));
    }
    let [r, g, b] = colour::color(colour::of_pigments(1.3, 0.0), colour::scale_of(0.3));
    assert!(r > g && g > b && r < 0.05, "brown hair: {r} {g} {b}");
    let [r, g, b] = colour::color(colour::of_pigments(0.1, 0.5), colour::scale_of(0.3));
    assert!(r > 1.4 * g && g > 1.4 * b, "red hair: {r} {g} {b}");
    assert_eq!(colour::of_pigments(-1.0, 0.0), [0.0; 3]);
}

/// Deep fur (Kubelka and Munk 1931) of fibres with a medulla has the colour of such fur without one.
#[test]
fn medullae_leave_the_colour_of_deep_fur() {
    for (roughness, medulla) in [(0.3, MEDULLAE[1]), (0.3, MEDULLAE[2]), (0.15, MEDULLAE[3]), (0.6, MEDULLAE[2])] {
        let scale = colour::scale_of(roughness);
        let reflected = |medulla: Medulla| {
            let fibre = Fibre { medulla, around: AzimuthalScattering::Rough(scale), ..Fibre::default() };
            let darker = colour::medulla_absorption(&medulla, scale);
            let sigma = colour::absorption([0.15, 0.3, 0.6], scale).map(|sigma| sigma * darker);
            let [on, back] = FibreMeans::new(&fibre).sides(0.8, fibre.eta, sigma);
            from_fn::<f64, 3, _>(|i| {
                let lost = 1.0 - on[i] - back[i];
                back[i] / (lost + back[i] + (lost * (lost + 2.0 * back[i])).sqrt())
            })
        };
        let (found, expected) = (reflected(medulla), reflected(Medulla::NONE));
        let off = found.iter().zip(expected).all(|(a, b)| (a / b - 1.0).abs() < 0.1);
        assert!(off, "roughness {roughness}, {medulla:?}: {found:?}, expected {expected:?}");
    }
}

/// Returns quasi-random numbers, uniform in 0..1: fractional parts of multiples of the powers of 1 / `ROOT` (Roberts
/// 2018).
fn even(i: u32) -> [f64; 5] {
    let mut step = 1.0;
    from_fn(|_| {
        step /= ROOT;
        let x = 0.5 + step * f64::from(i + 1);
        x - libm::floor(x)
    })
}

/// Positive root of x⁶ = x + 1.
const ROOT: f64 = 1.134_724_138_401_519_4;

/// Medullae: none, thin, wide, and wide and nearly opaque.
const MEDULLAE: [Medulla; 4] = [
    Medulla::NONE,
    Medulla { ratio: 0.3, scattering: 1.0 },
    Medulla { ratio: 0.7, scattering: 1.0 },
    Medulla { ratio: 0.95, scattering: 5.0 },
];

#[test]
fn white_fibre_is_invisible_under_uniform_light() {
    let shapes = [(3.0_f64, 0.05), (7.5, 0.12), (15.0, 0.5), (7.5, 0.12)].into_iter().zip(MEDULLAE);
    for ((along, scale), medulla) in shapes.chain([((7.5, 0.12), MEDULLAE[3])]) {
        let fibre = Fibre { along: along.to_radians(), medulla, ..Fibre::default() };
        for degrees in [0.0_f64, 30.0, -60.0, 80.0, 89.0] {
            let to = (libm::sin(degrees.to_radians()), libm::cos(degrees.to_radians()));
            const COUNT: u32 = 20_000;
            let (mut drawn, mut found) = (0.0, 0.0);
            for i in 0..COUNT {
                let [offset, numbers @ ..] = even(i);
                let hit = FibreHit::new(&fibre, scale, [0.0; 3], 2.0 * offset - 1.0, to);
                drawn += hit.sample(numbers).weight[1];
                // Repeat with incident directions distributed uniformly over the sphere.
                let sin_i = 2.0 * numbers[0] - 1.0;
                let from = (sin_i, (1.0 - sin_i * sin_i).max(0.0).sqrt());
                found += hit.value(from, TAU * numbers[1] - PI).0[1] * 2.0 * TAU;
            }
            let (drawn, found) = (drawn / f64::from(COUNT), found / f64::from(COUNT));
            assert!((drawn - 1.0).abs() < 0.002, "width {along}, scale {scale}, {degrees} degrees: {drawn}");
            // Few uniform directions fall into a narrow lobe close to the fibre's direction.
            let noise = if degrees.abs() > 70.0 { 0.2 } else { 0.05 };
            assert!((found - 1.0).abs() < noise, "width {along}, scale {scale}, {degrees} degrees: {found}");
        }
    }
}

#[test]
fn near_field_averaged_over_offsets_equals_the_far_field() {
    let scale = 0.12;
    let sigma = [0.1, 0.5, 2.0];
    let fibres = MEDULLAE.map(|medulla| Fibre { medulla, ..Fibre::default() });
    // On the cone of each path, the near and the distant fibre have the same cross-section.
    for (fibre, degrees) in fibres.iter().zip([0.0_f64, 20.0, 50.0, 35.0]) {
        let theta = degrees.to_radians();
        let (to, from) = ((libm::sin(theta), libm::cos(theta)), (-libm::sin(theta), libm::cos(theta)));
        for phi in [0.0, 0.7, 2.0, 3.0] {
            let afar = fibre.scatter(sigma, &Angles { from, to, phi });
            const COUNT: u32 = 4000;
            let mut near = [0.0; 3];
            for i in 0..COUNT {
                let offset = (2.0 * f64::from(i) + 1.0) / f64::from(COUNT) - 1.0;
                let (value, _) = FibreHit::new(fibre, scale, sigma, offset, to).value(from, phi);
                near.iter_mut().zip(value).for_each(|(sum, x)| *sum += x / f64::from(COUNT));
            }
            for (a, b) in afar.into_iter().zip(near) {
                assert!((a / b - 1.0).abs() < 2e-3, "{degrees} degrees, phi {phi}: {afar:?} {near:?}");
            }
        }
    }
}

#[test]
fn sampled_directions_follow_their_density() {
    let fibre = Fibre { medulla: MEDULLAE[2], ..Fibre::default() };
    let to = (0.5, 0.75_f64.sqrt());
    let hit = FibreHit::new(&fibre, 0.12, [0.3, 0.5, 1.0], 0.4, to);
    // Bins of sin θi and φ: number of samples in each, and its probability.
    const BOXES: usize = 8;
    const COUNT: u32 = 100_000;
    let mut fallen = [[0.0; BOXES]; BOXES];
    for i in 0..COUNT {
        let [_, numbers @ ..] = even(i);
        let SampledDirection { from, phi, .. } = hit.sample(numbers);
        let place = [0.5 + 0.5 * from.0, 0.5 + phi / TAU].map(|x| ((x * BOXES as f64) as usize).min(BOXES - 1));
        fallen[place[0]][place[1]] += 1.0 / f64::from(COUNT);
    }
    const FINE: usize = 64;
    for (a, row) in fallen.iter().enumerate() {
        for (b, fallen) in row.iter().enumerate() {
            let mut expected = 0.0;
            for (i, j) in (0..FINE * FINE).map(|k| (k / FINE, k % FINE)) {
                let at = |of: usize, k: usize| (of as f64 + (k as f64 + 0.5) / FINE as f64) / BOXES as f64;
                let sin_i = 2.0 * at(a, i) - 1.0;
                let from = (sin_i, (1.0 - sin_i * sin_i).sqrt());
                expected += hit.value(from, TAU * at(b, j) - PI).1;
            }
            expected *= 2.0 * TAU / (BOXES * BOXES * FINE * FINE) as f64;
            assert!((fallen - expected).abs() < 2e-3, "box {a} {b}: {fallen}, expected {expected}");
        }
    }
}

/// Returns the integral of the scattered light over all directions, on a fine grid.
fn by_grid(fibre: &Fibre, sigma: f64, tip: DVec3, light: &GaussianLight, eye: DVec3) -> f64 {
    const ROWS: usize = 120;
    const AROUND: usize = 96;
    let across = tip.any_orthonormal_vector();
    let beside = tip.cross(across);
    // Azimuths relative to the eye.
    let start = libm::atan2(eye.dot(beside), eye.dot(across));
    let phis: Vec<f64> = (0..AROUND).map(|j| TAU * (j as f64 + 0.5) / AROUND as f64 - PI).collect();
    let mut sum = 0.0;
    for i in 0..ROWS {
        let theta = PI * ((i as f64 + 0.5) / ROWS as f64 - 0.5);
        let (sin, cos) = (libm::sin(theta), libm::cos(theta));
        let angles = Angles { from: (sin, cos), ..Angles::between(tip, light.towards, eye) };
        let (along, section) = (fibre.along(&angles), fibre.section(angles.cos_d()));
        let scattered = fibre.path_along(4, &angles) * fibre.section(angles.to.1).scattered(sigma);
        let ways: [Vec<_>; 3] = from_fn(|p| section.mean_contributions(p as u32, &phis, sigma));
        let rest = section.rest(sigma);
        for (j, phi) in phis.iter().enumerate() {
            let from = tip * sin + (across * libm::cos(start + phi) + beside * libm::sin(start + phi)) * cos;
            let around: f64 = (0..3).map(|p| along[p] * ways[p][j].attenuated(sigma)).sum();
            sum += (around + along[3] * rest + scattered) * light.radiance(from) * cos;
        }
    }
    sum * PI / ROWS as f64 * TAU / AROUND as f64
}

#[test]
fn gaussian_lights_scatter_as_the_integral_over_their_directions() {
    let rough = Fibre { tilt: 0.1, ..Fibre::default() };
    let smooth = Fibre {
        around: AzimuthalScattering::Smooth(GlintShape { width: 0.2, ..GlintShape::default() }),
        ..Fibre::default()
    };
    let marschner = Fibre { keeps: LobeShape::Reciprocity, ..rough };
    let tip = DVec3::new(0.2, 0.9, 0.3).normalize();
    let eye = DVec3::new(0.5, 0.3, 0.8).normalize();
    let [before, behind, aside] = [(-0.2, 0.4, 0.9), (0.1, -0.3, -0.9), (0.9, 0.3, -0.3)].map(DVec3::from);
    let cases = [
        (rough, behind, 8.0),
        (rough, aside, 25.0),
        (rough, tip, 60.0),
        (smooth, behind, 25.0),
        (smooth, before, 60.0),
    ];
    let medullated = Fibre { medulla: MEDULLAE[2], ..rough };
    let cases = cases.into_iter().chain([(medullated, behind, 25.0), (medullated, before, 60.0)]);
    let others = [(marschner, behind, 25.0), (Fibre { eta: 1.8, ..rough }, before, 25.0)];
    for (fibre, towards, degrees) in cases.chain(others) {
        let sharpness = f64::to_radians(degrees).powi(-2);
        let light = GaussianLight { towards: towards.normalize(), sharpness };
        let found = BroadlyLitFibre::new(&fibre).scatter([0.2; 3], tip, &light, eye)[0];
        let expected = by_grid(&fibre, 0.2, tip, &light, eye);
        let off = (found - expected) / light.integral();
        assert!(off.abs() < 2e-5, "{fibre:?} {towards} {degrees}: {found}, expected {expected}");
    }
    // Under uniform light, a white fibre is as bright as its surroundings. As a distant fibre, it gains a little light,
    // because the tilt of the scales separates its lobes.
    let even = GaussianLight { towards: eye, sharpness: 0.0 };
    for fibre in [Fibre::default(), rough, smooth] {
        let found = BroadlyLitFibre::new(&fibre).scatter([0.0; 3], tip, &even, eye)[0];
        assert!((found - 1.0).abs() < 0.02, "{fibre:?}: {found}");
    }
    // Narrow lights do not overflow, and lights along the fibre have no azimuth.
    for (towards, sharpness) in [(tip, 1e6), (-tip, 3.0), (eye, 1e9), (behind.normalize(), 1e4)] {
        let found = BroadlyLitFibre::new(&rough).scatter([0.0; 3], tip, &GaussianLight { towards, sharpness }, eye);
        assert!(found.iter().all(|x| x.is_finite() && *x >= 0.0), "{towards} {sharpness}: {found:?}");
    }
}
