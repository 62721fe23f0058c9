//! Scattering by a fibre: published or common formulas that are wrong for light along the fibre, where glints merge, or
//! in their absorption.

use super::measures::even_direction;
use super::row::{Finding, Row};
use glam::{DVec3, Vec3};
use pelage_formats::meaning::scattering::azimuthal::{GlintShape, PathContribution, over_section};
use pelage_formats::meaning::scattering::optics::Section;
use pelage_formats::meaning::scattering::{Angles, Fibre, colour};
use pelage_import::BakeError;
use std::f64::consts::PI;

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "scattering by a fibre",
    cliff: "light along the fibre, effective refractive indices crossing 2, glints, absorption, black and white fibres",
    naive: "a refraction angle for each effective index, absorption exp(-2 s (1 + cos 2 g)), lobes over cos^2, \
            tables over cos phi, caustics unchanged",
    safe: "one refraction angle in space, absorption along the chord, energy-conserving lobes, tables over phi, \
           caustics spread together with the light that they focus",
    drive,
};

const ETAS: [f64; 3] = [1.45, 1.55, 1.7];

fn cos_deg(degrees: f64) -> f64 {
    libm::cos(degrees.to_radians())
}

/// Returns sections at difference angles in whole degrees, for all refractive indices.
fn sections() -> impl Iterator<Item = Section> {
    ETAS.into_iter().flat_map(|eta| (0..84).map(move |degrees| Section::new(eta, cos_deg(f64::from(degrees)))))
}

fn largest(of: impl Iterator<Item = f64>) -> f64 {
    of.fold(0.0, |most, x| if x.is_nan() || most.is_nan() { f64::NAN } else { most.max(x) })
}

fn drive() -> Result<Vec<Finding>, BakeError> {
    Ok(vec![fresnel(), chord(), energy(), glints_in_tables(), through_two(), along_the_light(), inversion()])
}

/// Refracts a direction at a surface whose normal points to the incident side.
fn refracted(way: DVec3, normal: DVec3, eta: f64) -> DVec3 {
    let (ratio, cos) = (1.0 / eta, -way.dot(normal));
    way * ratio + normal * (ratio * cos - (1.0 - ratio * ratio * (1.0 - cos * cos)).sqrt())
}

/// Returns the normal and the light's direction at the point where light at a section's difference angle meets a
/// cylinder about z. `gamma` is the angle of that point.
fn incidence(section: &Section, gamma: f64) -> (DVec3, DVec3) {
    let normal = DVec3::new(libm::cos(gamma), libm::sin(gamma), 0.0);
    let sin_d = (1.0 - section.cos_d * section.cos_d).sqrt();
    (normal, DVec3::new(-section.cos_d, 0.0, sin_d))
}

fn fresnel() -> Finding {
    let gammas = || (0..90).map(|degrees| f64::from(degrees).to_radians());
    // The truth applies the Fresnel equations in three dimensions, to the angles between the light's directions and the
    // surface normal.
    let truth = |section: &Section, gamma: f64| {
        let (normal, way) = incidence(section, gamma);
        let (c, t) = (-way.dot(normal), -refracted(way, normal, section.eta).dot(normal));
        let (s, p) = ((c - section.eta * t) / (c + section.eta * t), (section.eta * c - t) / (section.eta * c + t));
        0.5 * (s * s + p * p)
    };
    let naive = |section: &Section, gamma: f64| {
        let double = section.eta * section.eta / section.across;
        let cos_of = |index: f64| (1.0 - (libm::sin(gamma) / index) * (libm::sin(gamma) / index)).max(0.0).sqrt();
        let (g, s, p) = (libm::cos(gamma), cos_of(section.across), cos_of(double));
        let (s, p) = ((g - section.across * s) / (g + section.across * s), (double * g - p) / (double * g + p));
        0.5 * (s * s + p * p)
    };
    let off = |form: &dyn Fn(&Section, f64) -> f64| {
        largest(sections().map(|s| largest(gammas().map(|gamma| (form(&s, gamma) - truth(&s, gamma)).abs()))))
    };
    Finding {
        case: "reflectance, three refractive indices, all angles".into(),
        measure: "largest absolute error of the reflectance",
        naive: off(&naive),
        safe: off(&|section, gamma| section.fresnel(libm::cos(gamma))),
        bound: 1e-9,
        fails_above: 0.3,
    }
}

fn chord() -> Finding {
    const SIGMA: f64 = 1.0;
    // The truth is the path of light through a cylinder about z, from wall to wall.
    let truth = |section: &Section, gamma: f64| {
        let (normal, way) = incidence(section, gamma);
        let inside = refracted(way, normal, section.eta);
        let across = inside.x * inside.x + inside.y * inside.y;
        libm::exp(SIGMA * 2.0 * (normal.x * inside.x + normal.y * inside.y) / across)
    };
    let light = |section: &Section, left: &dyn Fn(f64) -> f64| {
        over_section(|gamma| section.share(1, libm::cos(gamma)) * left(gamma))
    };
    let off = |form: &dyn Fn(&Section, f64) -> f64| {
        largest(sections().map(|section| {
            let found = light(&section, &|gamma| form(&section, gamma));
            (found / light(&section, &|gamma| truth(&section, gamma)) - 1.0).abs()
        }))
    };
    let printed = |section: &Section, gamma: f64| {
        let (_, cos) = section.refracted(libm::sin(gamma));
        libm::exp(-4.0 * SIGMA * cos * cos)
    };
    Finding {
        case: "light through a fibre with absorption 1 per radius, three refractive indices, all angles".into(),
        measure: "largest relative error of the transmitted light",
        naive: off(&printed),
        safe: off(&|section, gamma| {
            PathContribution { light: 1.0, length: section.chord(libm::sin(gamma)) }.attenuated(SIGMA)
        }),
        bound: 1e-9,
        fails_above: 0.5,
    }
}

fn energy() -> Finding {
    // Largest error of the light that the eye sees from a fibre without absorption under uniform light. The true value
    // is 1.
    let whole = |along: &dyn Fn(&Angles) -> f64| {
        let of = |degrees: f64| {
            let theta = degrees.to_radians();
            let to = (libm::sin(theta), libm::cos(theta));
            const STEPS: u32 = 20_000;
            let step = PI / f64::from(STEPS);
            let mut sum = 0.0;
            for k in 0..STEPS {
                let i = (f64::from(k) + 0.5) * step - PI / 2.0;
                let angles = Angles { from: (libm::sin(i), libm::cos(i)), to, phi: 0.0 };
                sum += along(&angles) * libm::cos(i) * step;
            }
            sum
        };
        largest([0.0, 60.0, 80.0, 85.0, 88.0, 89.5].map(|degrees| of(degrees) - 1.0).into_iter())
    };
    let fibre = Fibre { tilt: 0.0, ..Fibre::default() };
    let printed = |angles: &Angles| {
        let cos_d = angles.cos_d();
        let half = fibre.spread(0).by_half_angle(libm::asin(angles.from.0), libm::asin(angles.to.0));
        Some(half * angles.from.1 / (cos_d * cos_d)).filter(|x| x.is_finite()).unwrap_or_default()
    };
    Finding {
        case: "uniform light, seen at 0 to 89.5 degrees; widths of lobes halved as in Marschner 2003".into(),
        measure: "largest gain of light, as a share of the incident light",
        naive: whole(&printed),
        safe: whole(&|angles| fibre.along(angles)[0]),
        bound: 1e-4,
        fails_above: 0.5,
    }
}

fn glints_in_tables() -> Finding {
    const TEXELS: usize = 128;
    let glint = GlintShape { width: 5_f64.to_radians(), ..GlintShape::default() };
    // Returns the error of a table row. `phi_of` and `place_of` convert from texture coordinate to azimuth and back.
    // `inset` is the coordinate of the first texel: 0, or half a texel as in a published lookup from 0 to 1. The last
    // texel is at 1 − `inset`.
    let off = |inset: f64, phi_of: &dyn Fn(f64) -> f64, place_of: &dyn Fn(f64) -> f64| {
        largest(sections().step_by(4).map(|section| {
            let glints = section.glints(&glint);
            let light = |phi| section.glinting(phi, glints.as_ref()).map(|way| way.light).sum::<f64>();
            let last = (TEXELS - 1) as f64;
            let within = 1.0 - 2.0 * inset;
            let texels: Vec<f64> = (0..TEXELS).map(|i| light(phi_of(inset + within * i as f64 / last))).collect();
            let (mut error, mut peak) = (0.0_f64, 0.0_f64);
            for k in 0..720 {
                let phi = f64::from(k).to_radians() / 4.0;
                let x = ((place_of(phi) - inset) / within).clamp(0.0, 1.0) * last;
                let i = (x as usize).min(TEXELS - 2);
                let t = x - i as f64;
                let truth = light(phi);
                peak = peak.max(truth);
                error = error.max((texels[i] * (1.0 - t) + texels[i + 1] * t - truth).abs());
            }
            error / peak
        }))
    };
    Finding {
        case: "a table of 128 texels for glints 5 degrees wide".into(),
        measure: "largest error, relative to the highest value",
        naive: off(0.5 / TEXELS as f64, &|x| libm::acos((2.0 * x - 1.0).clamp(-1.0, 1.0)), &|phi| {
            0.5 + 0.5 * libm::cos(phi)
        }),
        safe: off(0.0, &|x| PI * x, &|phi| phi / PI),
        bound: 0.03,
        fails_above: 0.2,
    }
}

fn through_two() -> Finding {
    let glint = GlintShape::default();
    let most = |spread: bool| {
        largest((0..=2000).map(|k| {
            let section = Section::new(1.55, cos_deg(44.0 + 6.0 * f64::from(k) / 2000.0));
            let glints = section.glints(&glint).filter(|_| spread);
            let light = |phi| section.glinting(phi, glints.as_ref()).map(|way| way.light).sum::<f64>();
            largest((0..180).map(|k| light(f64::from(k).to_radians() / 2.0)))
        }))
    };
    Finding {
        case: "difference angles where the effective refractive index crosses 2".into(),
        measure: "most light per radian, relative to the incident light",
        naive: most(false),
        safe: most(true),
        bound: 0.2,
        fails_above: 1.0,
    }
}

fn along_the_light() -> Finding {
    const COUNT: u32 = 100_000;
    let cases = || {
        (0..COUNT).map(|i| {
            let tip = even_direction(i, COUNT).as_vec3().normalize();
            (tip, [tip, -tip][i as usize % 2], tip.any_orthonormal_vector())
        })
    };
    // Nalu computes the cosine of the azimuth from the perpendicular components, in f32.
    let nalu = |tip: Vec3, light: Vec3, eye: Vec3| {
        let (l, e) = (light - tip * tip.dot(light), eye - tip * tip.dot(eye));
        l.dot(e) / (l.dot(l) * e.dot(e)).sqrt()
    };
    let fibre = Fibre::default();
    let ours = |tip: Vec3, light: Vec3, eye: Vec3| {
        let angles = Angles::between(tip.as_dvec3(), light.as_dvec3(), eye.as_dvec3());
        angles.phi.abs() <= PI && fibre.along(&angles).iter().all(|x| x.is_finite())
    };
    let naive = cases().filter(|(t, l, e)| !(-1.0..=1.0).contains(&nalu(*t, *l, *e))).count();
    let safe = cases().filter(|(t, l, e)| !ours(*t, *l, *e)).count();
    Finding {
        case: "100000 fibres along the light".into(),
        measure: "azimuths that are not finite",
        naive: naive as f64,
        safe: safe as f64,
        bound: 0.0,
        fails_above: 1000.0,
    }
}

/// Tests the absorption computed for a fur colour, and the light left after path lengths of 0 and 2 radii.
fn inversion() -> Finding {
    let depth = colour::depth(0.12);
    let naive = |color: f64| {
        let root = libm::log(color) / depth;
        root * root
    };
    let ours = |color: f64| colour::absorption([color; 3], 0.12)[0];
    let wrong = |of: &dyn Fn(f64) -> f64| {
        let cases = (0..=1_000).flat_map(|i| [f64::from(i) / 1_000.0, 1.0 + f64::from(i) / 1_000.0]);
        let bad = cases.filter(|color| {
            let sigma = of(*color);
            let left = [0.0, 2.0].map(|length| libm::exp(-sigma * length));
            // White, and anything brighter, must have no absorption.
            let loses = *color >= 1.0 && sigma != 0.0;
            loses || !sigma.is_finite() || left.iter().any(|left| !(0.0..=1.0).contains(left))
        });
        bad.count() as f64
    };
    Finding {
        case: "colours from black through white to twice white".into(),
        measure: "colours that no fibre can have",
        naive: wrong(&naive),
        safe: wrong(&ours),
        bound: 0.0,
        fails_above: 100.0,
    }
}
