//! Light from an environment map: narrow lobes, light concentrated by fibres, light along a hair, fits that become
//! negative, a sun on an edge of the picture, and black or invalid pictures.

use super::measures::even_direction;
use super::row::{Finding, Row};
use crate::least_squares::least_squares;
use crate::printed_light::PrintedLight;
use glam::{DVec3, Vec3};
use pelage_formats::meaning::luminance;
use pelage_formats::meaning::scattering::azimuthal::GlintShape;
use pelage_formats::meaning::scattering::broad::{BroadSize, BroadTables, CutGaussianLight};
use pelage_formats::meaning::scattering::gaussian_light::{BroadlyLitFibre, GaussianLight};
use pelage_formats::meaning::scattering::longitudinal::i0e;
use pelage_formats::meaning::scattering::{Angles, AzimuthalScattering, Fibre};
use pelage_import::BakeError;
use pelage_stage::sky::{FitParams, LightLobe, Panorama};
use std::f64::consts::TAU;

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "light from a sky",
    cliff: "narrow lobes, effective refractive indices crossing 2, light along the hair, negative light, \
            a sun on the horizon and the seam, black and broken panoramas",
    naive: "exp(-k) I0(k) in 32 bits, Gaussians for TRT, azimuths from normalised components, \
            plain least squares, the sun as a mean of columns, means divided by a sum that may be 0",
    safe: "scaled I0, sums of cosines, a fixed azimuth where none is defined, non-negative lobes, \
           the sun as a mean of directions, invalid pixels replaced",
    drive,
};

fn drive() -> Result<Vec<Finding>, BakeError> {
    Ok(vec![
        narrow_lights(),
        merging_glints(),
        along_the_hair(),
        negative_light()?,
        sun_on_an_edge()?,
        black()?,
        broken()?,
    ])
}

fn painted(radiance: impl Fn(DVec3) -> DVec3) -> Result<Panorama, BakeError> {
    Panorama::from_fn((256, 128), radiance).map_err(|error| BakeError::Internal(error.to_string()))
}

/// Tests the integral of a light lobe over all azimuths around the fibre, for lobes of different widths.
fn narrow_lights() -> Finding {
    let truth = |k: f64| {
        const STEPS: usize = 20_000;
        let at = |i: usize| libm::exp(k * (libm::cos(TAU * i as f64 / STEPS as f64) - 1.0));
        (0..STEPS).map(at).sum::<f64>() / STEPS as f64
    };
    // Power series of the Bessel function, as a shader would evaluate it.
    let naive = |k: f64| {
        let quarter = 0.25 * (k * k) as f32;
        let (mut term, mut sum) = (1.0_f32, 1.0_f32);
        for i in 1..400 {
            term *= quarter / (i * i) as f32;
            sum += term;
        }
        f64::from(sum * (-k as f32).exp())
    };
    let wrong = |of: &dyn Fn(f64) -> f64| {
        let widths = (1..=120).map(|half| (0.5 * f64::from(half)).to_radians());
        let off = widths.map(|width| 1.0 / (width * width)).filter(|k| {
            let error = (of(*k) / truth(*k) - 1.0).abs();
            error >= 1e-3 || error.is_nan()
        });
        off.count() as f64
    };
    Finding {
        case: "lights of half a degree to 60 degrees".into(),
        measure: "lights whose strength is NaN, or wrong by a thousandth or more",
        naive: wrong(&naive),
        safe: wrong(&i0e),
        bound: 0.0,
        fails_above: 5.0,
    }
}

/// Tests the light that a smooth fibre scatters at difference angles around the one at which its two glints merge.
fn merging_glints() -> Finding {
    let fibre = Fibre {
        around: AzimuthalScattering::Smooth(GlintShape { width: 5_f64.to_radians(), ..GlintShape::default() }),
        ..Fibre::default()
    };
    let (exact, printed) = (BroadlyLitFibre::new(&fibre), PrintedLight::new(&fibre, 0.2));
    let sharpness = 10_f64.to_radians().powi(-2);
    let way = |theta: f64, phi: f64| {
        DVec3::new(libm::cos(theta) * libm::cos(phi), libm::sin(theta), libm::cos(theta) * libm::sin(phi))
    };
    // The light is at the centre of TRT's longitudinal lobe, so that both directions are at the difference angle.
    let cases: Vec<(DVec3, GaussianLight)> = (40..=56)
        .step_by(2)
        .flat_map(|degrees| [0.0, 0.4].map(|phi| (f64::from(degrees).to_radians(), phi)))
        .map(|(theta, phi)| {
            let towards = way(-theta + 3.0 * fibre.tilt, phi);
            (way(theta, 0.0), GaussianLight { towards, sharpness })
        })
        .collect();
    let truth = |eye: DVec3, light: &GaussianLight| {
        const STEPS: i32 = 40;
        let (a, b) = light.towards.any_orthonormal_pair();
        let step = 5.0 / sharpness.sqrt() / f64::from(STEPS);
        let mut sum = 0.0;
        for i in -STEPS..=STEPS {
            for k in -STEPS..=STEPS {
                // Equal steps in the plane tangent to the sphere at the light's direction.
                let from = light.towards + (a * f64::from(i) + b * f64::from(k)) * step;
                let long = from.length();
                let from = from / long;
                let scattered = fibre.scatter([0.2; 3], &Angles::between(DVec3::Y, from, eye))[0];
                sum += scattered * light.radiance(from) * step * step / (long * long * long);
            }
        }
        sum
    };
    let (mut naive, mut safe) = (0.0_f64, 0.0_f64);
    for (eye, light) in &cases {
        let truth = truth(*eye, light);
        naive = naive.max((printed.scatter(DVec3::Y, light, *eye) / truth - 1.0).abs());
        safe = safe.max((exact.scatter([0.2; 3], DVec3::Y, light, *eye)[0] / truth - 1.0).abs());
    }
    Finding {
        case: "a light of 10 degrees, difference angles where the effective refractive index crosses 2".into(),
        measure: "largest relative error of the light scattered to the eye",
        naive,
        safe,
        bound: 0.03,
        fails_above: 0.15,
    }
}

/// Tests broad light whose centre is along the hair, where its azimuth is undefined.
fn along_the_hair() -> Finding {
    const COUNT: u32 = 400;
    let cases = || {
        (0..COUNT).map(|i| {
            let tip = even_direction(i, COUNT).as_vec3().normalize();
            let (eye, aside) = tip.any_orthonormal_pair();
            (tip, [tip, -tip][i as usize % 2], eye, aside)
        })
    };
    // The naive form computes the cosine of the azimuth from the components perpendicular to the hair, in f32.
    let naive = |tip: Vec3, light: Vec3, eye: Vec3| {
        let (l, e) = (light - tip * tip.dot(light), eye - tip * tip.dot(eye));
        l.dot(e) / (l.dot(l) * e.dot(e)).sqrt()
    };
    let fibre = Fibre::default();
    let tables = BroadTables::new(&fibre, BroadSize { means: 4, to: 12, from: 12, phi: 8 });
    // If the light's direction changes by a small step to any side, pelage's result must not change by more than 1 %.
    let ours = |tip: Vec3, light: Vec3, eye: Vec3, aside: Vec3| {
        let of = |towards: Vec3| {
            let light = CutGaussianLight { towards: towards.as_dvec3().normalize(), mean: 0.8 };
            tables.scatter([0.2; 3], tip.as_dvec3(), &light, eye.as_dvec3())[0]
        };
        let there = of(light);
        there.is_finite()
            && [aside, -aside, eye, -eye].iter().all(|way| (of(light + 1e-4 * *way) / there - 1.0).abs() < 0.01)
    };
    let bad = cases().filter(|(tip, light, eye, _)| !(-1.0..=1.0).contains(&naive(*tip, *light, *eye))).count();
    let wrong = cases().filter(|(tip, light, eye, aside)| !ours(*tip, *light, *eye, *aside)).count();
    Finding {
        case: "400 hairs parallel to the central direction of a light of 27 degrees".into(),
        measure: "undefined azimuths, or jumps of the scattered light by 1 % or more",
        naive: bad as f64,
        safe: wrong as f64,
        bound: 0.0,
        fails_above: 50.0,
    }
}

/// Tests a lamp in a dark room with a wide pale wall behind it. Unconstrained least squares gives lobes with negative
/// light.
fn negative_light() -> Result<Finding, BakeError> {
    let lamp = DVec3::new(1.0, 0.3, 0.2).normalize();
    let room = painted(|way| {
        let cosine = way.dot(lamp);
        // The ring around the lamp is dark; everything beyond it is pale.
        let ring = if cosine > 0.75 { 0.0 } else { 1.0 };
        DVec3::splat(ring + 40.0 * libm::exp(60.0 * (cosine - 1.0)))
    })?;
    let fitted = room.fit(FitParams { sun: 2.0, ..FitParams::default() });
    // The naive form has the same lobes, with the strengths of an unconstrained fit.
    let cells = room.reduced((64, 32));
    let (width, height) = cells.size();
    let places: Vec<(u32, u32)> = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).collect();
    let shapes: Vec<GaussianLight> = fitted.environment.lobes.iter().map(LightLobe::light).collect();
    // Also tests a grid of wide lobes, as in a table of lobes shared by all maps.
    let grid = (0..24).map(|i| GaussianLight { towards: even_direction(i, 24), sharpness: 4.0 });
    let shapes: Vec<GaussianLight> = shapes.into_iter().chain(grid).collect();
    let weight = |y: u32| cells.solid_angle(y).sqrt();
    let column = |shape: Option<&GaussianLight>| {
        let light = |x, y| shape.map_or(1.0, |shape| shape.radiance(cells.towards(x, y)));
        places.iter().map(|(x, y)| weight(*y) * light(*x, *y)).collect::<Vec<f64>>()
    };
    let columns = shapes.iter().map(Some).chain([None]).map(column).collect();
    let found = least_squares(columns, places.iter().map(|(x, y)| weight(*y) * luminance(cells.at(*x, *y))).collect());
    let least = |of: &dyn Fn(DVec3) -> f64| {
        let darkest = (0..4000).map(|i| of(even_direction(i, 4000))).fold(f64::INFINITY, f64::min);
        (-darkest).max(0.0)
    };
    let naive = |way: DVec3| {
        let lobes: f64 = shapes.iter().enumerate().map(|(k, shape)| found[k] * shape.radiance(way)).sum();
        lobes + found[shapes.len()]
    };
    Ok(Finding {
        case: "a lamp of 7 degrees in a dark ring in a pale room".into(),
        measure: "most negative radiance; the walls have radiance 1",
        naive: least(&naive),
        safe: least(&|way| luminance(fitted.environment.radiance(way))),
        bound: 0.0,
        fails_above: 0.1,
    })
}

/// Tests a sun on the horizon and on the seam of the picture.
fn sun_on_an_edge() -> Result<Finding, BakeError> {
    let (mut naive, mut safe) = (0.0_f64, 0.0_f64);
    // The seam of the picture is at −x.
    for up in [0.0, 0.004, -0.004, 0.9999] {
        let sun = DVec3::new(-1.0, up, 0.0).normalize();
        let sky = painted(|way| DVec3::splat(if way.dot(sun) > libm::cos(2_f64.to_radians()) { 2000.0 } else { 0.5 }))?;
        let angle = |towards: DVec3| towards.normalize_or(DVec3::NEG_Y).dot(sun).clamp(-1.0, 1.0).acos().to_degrees();
        // The naive form is the mean row and column of bright pixels.
        let (width, height) = sky.size();
        let bright: Vec<(u32, u32)> = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .filter(|(x, y)| luminance(sky.at(*x, *y)) > 100.0)
            .collect();
        let mean = |of: &dyn Fn(&(u32, u32)) -> u32| {
            bright.iter().map(|pixel| f64::from(of(pixel))).sum::<f64>() / bright.len().max(1) as f64
        };
        let (column, row) = (mean(&|pixel| pixel.0), mean(&|pixel| pixel.1));
        naive = naive.max(angle(sky.towards(column as u32, row as u32)));
        let found = sky.fit(FitParams::default()).environment.sun;
        safe = safe.max(found.map_or(180.0, |sun| angle(DVec3::from(sun.towards.map(f64::from)))));
    }
    Ok(Finding {
        case: "a sun of 4 degrees on the horizon and the seam, and near the zenith".into(),
        measure: "error of the sun's position, degrees",
        naive,
        safe,
        bound: 1.0,
        fails_above: 20.0,
    })
}

/// Counts the values that are infinite or NaN.
fn count_not_finite(of: impl IntoIterator<Item = f64>) -> f64 {
    of.into_iter().filter(|x| !x.is_finite()).count() as f64
}

fn numbers_of(panorama: &Panorama) -> Vec<f64> {
    let fitted = panorama.fit(FitParams::default());
    let environment = &fitted.environment;
    let lobes =
        environment.lobes.iter().flat_map(|lobe| [&lobe.towards[..], &lobe.radiance, &[lobe.width_deg]].concat());
    let sun = environment.sun.into_iter().flat_map(|sun| [sun.towards, sun.color].concat());
    let numbers = environment.even.into_iter().chain(lobes).chain(sun).map(f64::from);
    numbers
        .chain(environment.mean_direction().to_array())
        .chain([fitted.energy, fitted.error, fitted.sun_share])
        .collect()
}

fn black() -> Result<Finding, BakeError> {
    let black = painted(|_| DVec3::ZERO)?;
    // The naive form computes the mean direction of the black map's light, and the factor that converts light to
    // fractions of the total.
    let (width, height) = black.size();
    let (mut all, mut middle) = (0.0, DVec3::ZERO);
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let light = luminance(black.at(x, y)) * black.solid_angle(y);
        all += light;
        middle += black.towards(x, y) * light;
    }
    let naive = (middle / all).to_array().into_iter().chain([1.0 / all]);
    Ok(Finding {
        case: "a black picture".into(),
        measure: "values of its lights that are not finite",
        naive: count_not_finite(naive),
        safe: count_not_finite(numbers_of(&black)),
        bound: 0.0,
        fails_above: 2.0,
    })
}

fn broken() -> Result<Finding, BakeError> {
    let plain = painted(|way| DVec3::splat(1.0 + 0.5 * way.y))?;
    let mut pixels = plain.pixels().to_vec();
    let count = pixels.len();
    for (i, x) in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -3.0].into_iter().enumerate() {
        pixels[(2 * i + 1) * count / 11] = [x; 3];
    }
    // The naive form sums the light of each colour over unrepaired pixels.
    let sum = |i: usize| pixels.iter().map(|pixel| f64::from(pixel[i])).sum::<f64>();
    let naive = count_not_finite([0, 1, 2].map(sum));
    let (width, height) = plain.size();
    let mended = Panorama::new(width, height, pixels).map_err(|error| BakeError::Internal(error.to_string()))?;
    let numbers = numbers_of(&mended);
    // Counts results that are not finite, and invalid pixels that were not reported as repaired.
    Ok(Finding {
        case: "a panorama with NaN, infinities and negative light".into(),
        measure: "invalid values in its lights, plus invalid pixels that are not reported",
        naive,
        safe: count_not_finite(numbers) + f64::from(4 - mended.mended().min(4)),
        bound: 0.0,
        fails_above: 2.0,
    })
}
