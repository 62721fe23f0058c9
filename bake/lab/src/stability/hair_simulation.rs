//! Hair simulation with large steps, stiff curls and strong lean.

use super::measures::grow;
use super::row::{Finding, Row};
use glam::Vec3;
use pelage_bake::recipe::{HairParams, Style};
use pelage_bake::stages::simulate::Strands;
use pelage_import::BakeError;

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "hair simulation",
    cliff: "large steps, stiff curls, strong lean",
    naive: "explicit Euler on position and velocity",
    safe: "integrate the direction only, with the exact solution of its relaxation",
    drive,
};

/// Extreme hair parameters.
#[derive(Clone, Debug)]
pub struct Extreme {
    /// Hair parameters of the recipe.
    pub hair: HairParams,
    /// Height of the volume, in tile widths.
    pub height: f32,
}

impl Extreme {
    /// Returns all extreme cases.
    pub fn all() -> Vec<Self> {
        let mut out = Vec::new();
        for style in Style::ALL.iter().copied() {
            for lean in [0.0, 0.5, 1.0] {
                for frizz in [0.0, 1.0] {
                    for (curl_radius, curl_pitch) in
                        [(0.0, 1e-3), (0.03, 0.18), (1.0, 1e-3), (1e-3, 1e-3), (1.0, 100.0)]
                    {
                        for height in [1e-3, 0.4, 50.0, 1e3] {
                            let hair = HairParams {
                                style,
                                lean,
                                frizz,
                                curl_radius,
                                curl_pitch,
                                density: 9,
                                length_variation: 0.0,
                                ..HairParams::default()
                            };
                            out.push(Self { hair, height });
                        }
                    }
                }
            }
        }
        out
    }
}

/// Returns the length of a curve.
fn arc(points: &[Vec3]) -> f32 {
    points.windows(2).map(|w| w[0].distance(w[1])).sum()
}

/// Returns the largest relative error in the length of strands that should be `height` long. Returns infinity if a
/// strand leaves the volume.
pub fn worst_stretch(strands: &Strands, height: f32) -> f64 {
    let slack = strands.height * 1e-5;
    let stretch = |strand: usize| {
        let points = &strands.points[strands.range(strand)];
        let inside = points.iter().all(|p| p.z >= -slack && p.z <= strands.height + slack);
        if inside { f64::from((arc(points) / height - 1.0).abs()) } else { f64::INFINITY }
    };
    // `f64::max` would discard NaN.
    (0..strands.len()).map(stretch).fold(0.0, |a, b| if b <= a { a } else { b })
}

/// Returns the stretch of a stiff curl simulated in 16 explicit steps. The velocity relaxes to a rotating target, and
/// the position follows the velocity.
fn explicit(stiffness: f32) -> f64 {
    let step = 1.0 / 16.0;
    let (mut p, mut v) = (Vec3::ZERO, Vec3::Z);
    let mut points = vec![p];
    for i in 0..16_u8 {
        let angle = f32::from(i) * 1.1;
        let target = Vec3::new(0.8 * libm::cosf(angle), 0.8 * libm::sinf(angle), 0.6);
        v += (target - v) * (stiffness * step);
        p += v * step;
        points.push(p);
    }
    f64::from((arc(&points) - 1.0).abs())
}

fn drive() -> Result<Vec<Finding>, BakeError> {
    let mut safe = 0.0_f64;
    let all = Extreme::all();
    for extreme in &all {
        let found = worst_stretch(&grow(&extreme.hair, extreme.height)?, extreme.height);
        safe = if found <= safe { safe } else { found };
    }
    let finding = |case: &str, naive: f64, fails_above: f64| Finding {
        case: format!("{case}; ours: {} extreme parameter sets", all.len()),
        measure: "relative stretch of strands",
        naive,
        safe,
        bound: 0.01,
        fails_above,
    };
    Ok(vec![finding("a soft curl", explicit(7.0), 0.01), finding("a stiff curl", explicit(60.0), 99.0)])
}
