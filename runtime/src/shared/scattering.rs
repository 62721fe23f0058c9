use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3, Vec4};
use pelage_formats::FibreOptics;
use pelage_formats::meaning::scattering::colour;
use pelage_formats::meaning::scattering::means::FibreMeans;
use std::f32::consts::PI;

/// WGSL source; does not depend on other topics.
pub const WGSL: &str = include_str!("scattering.wgsl");

/// Table coordinates and cosines for a pair of light and eye directions, relative to a fibre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FibreAngles {
    /// Coordinates in the table of longitudinal scattering, 0..=1 (`FORMAT.md`, "FIBR", layer 0).
    pub along: Vec2,
    /// Coordinates in the table of azimuthal scattering, 0..=1 (`FORMAT.md`, "FIBR", layer 1).
    pub around: Vec2,
    /// Cosine of the light's inclination: the angle between the light and the normal plane of the fibre, 0..=1.
    pub cos_i: f32,
    /// Cosine of the difference angle, 0..=1.
    pub cos_d: f32,
}

/// Properties of a fibre that are not in its tables, in shader layout.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Fibre {
    /// Values: 1 / η²; 1 / d of `FORMAT.md`, "FIBR", times the root of the factor in "MEDU"; mean square offset of
    /// incidence, `FibreMeans::aside` of the package; longitudinal variance of the reflected lobe, in full angles.
    pub optics: [f32; 4],
    /// Coefficients of the shares scattered forward, `FibreMeans::on` of the package.
    pub on: [[f32; 4]; 3],
    /// Coefficients of the shares scattered backward, `FibreMeans::back` of the package.
    pub back: [[f32; 4]; 3],
}

impl Fibre {
    /// Creates the shader constants of a package's fibre.
    pub fn new(optics: &FibreOptics, means: &FibreMeans) -> Self {
        let around = optics.around.into();
        let darker = colour::medulla_absorption(&optics.medulla, around);
        let per_depth = (colour::depth(around).recip() * darker.sqrt()) as f32;
        Self {
            optics: [
                (optics.eta * optics.eta).recip(),
                per_depth,
                means.aside,
                optics.fibre().spread(0).variance() as f32,
            ],
            on: means.on,
            back: means.back,
        }
    }
}

const DRAWN_OUT: f32 = 0.3;
const LEAST_COS_D: f32 = 0.1;

/// Returns the table row for a cosine of the difference angle, as a coordinate 0..=1.
pub fn fibre_row(cos_d: f32) -> f32 {
    ((cos_d - LEAST_COS_D) / (1.0 - LEAST_COS_D)).clamp(0.0, 1.0)
}

/// Returns the angles for three unit vectors: the fibre towards its tip, towards the light, towards the eye. A
/// direction along the fibre has no azimuth, so an arbitrary one is used. The result is finite for all inputs.
pub fn fibre_angles(tip: Vec3, light: Vec3, eye: Vec3) -> FibreAngles {
    let sin_i = tip.dot(light).clamp(-1.0, 1.0);
    let sin_o = tip.dot(eye).clamp(-1.0, 1.0);
    let cos_i = (1.0 - sin_i * sin_i).sqrt();
    let cos_o = (1.0 - sin_o * sin_o).sqrt();
    let cos_d = (0.5 * (1.0 + cos_i * cos_o + sin_i * sin_o)).clamp(0.0, 1.0).sqrt();
    let sin_h = (0.5 * (sin_i + sin_o) / cos_d.max(1e-4)).clamp(-1.0, 1.0);
    let half_d = (1.0 - cos_d * cos_d).max(0.0).sqrt() / (1.0 + cos_d);
    let tilted = if sin_o >= sin_i { half_d } else { -half_d };
    let drawn_out = sin_h / (DRAWN_OUT + (1.0 - DRAWN_OUT) * sin_h.abs());
    let cos_phi = ((light.dot(eye) - sin_i * sin_o) / (cos_i * cos_o).max(1e-6)).clamp(-1.0, 1.0);
    FibreAngles {
        along: Vec2::new(0.5 + 0.5 * drawn_out, 0.5 + 0.5 * tilted),
        around: Vec2::new(cos_phi.acos() / PI, fibre_row(cos_d)),
        cos_i,
        cos_d,
    }
}

/// Returns the absorption per fibre radius at which deep fur has that colour, for each channel independently (Chiang
/// 2016, section 4.2). `per_depth`: 1 / d of `FORMAT.md`, "FIBR".
pub fn fibre_absorption(color: Vec3, per_depth: f32) -> Vec3 {
    let root = color.clamp(Vec3::splat(1e-3), Vec3::ONE).map(f32::ln) * per_depth;
    root * root
}

/// Returns the transmittance of one path through a fibre with that absorption per radius. `cos_d`: cosine of the
/// difference angle; `optics`: as in [`Fibre`].
pub fn fibre_transmittance(cos_d: f32, optics: Vec4, absorbed: Vec3) -> Vec3 {
    let c = cos_d.max(LEAST_COS_D);
    // Square of 1 / cos θt. The next line computes the square of the sine of the refraction angle in the cross-section,
    // at the mean square offset of incidence.
    let slant = 1.0 / (1.0 - (1.0 - c * c) * optics.x);
    let bent = optics.z * c * c * optics.x * slant;
    (-2.0 * (slant * (1.0 - bent)).sqrt() * absorbed).map(f32::exp)
}

/// Combines the longitudinal and azimuthal texels of a fibre's tables. Returns the scattered light per steradian,
/// divided by the irradiance and multiplied by the cosine of the light's inclination. `left`: from
/// [`fibre_transmittance`]. TRT crosses the fibre twice, and the remaining orders three times.
pub fn fibre_scatters(along: Vec4, around: Vec4, absorbed: Vec3, left: Vec3) -> Vec3 {
    let ways = along * around;
    let through = (-absorbed * around.w).map(f32::exp);
    Vec3::splat(ways.x) + ways.y * through + left * left * (Vec3::splat(ways.z) + along.w * left)
}

/// Returns the shares of light that a fibre without absorption scatters forward (to its far side) and backward. The
/// four components of each are for R, TT, TRT and the remaining orders. `cos_theta`: cosine of the light's inclination.
pub fn fibre_shares(fibre: &Fibre, cos_theta: f32) -> [Vec4; 2] {
    let u = 1.0 - cos_theta.max(LEAST_COS_D);
    let square = u * u;
    [&fibre.on, &fibre.back].map(|of| {
        let [first, second, third] = of.map(Vec4::from);
        first + square * (second + square * third)
    })
}

/// Returns the shares of light that an absorbing fibre scatters forward and backward.
pub fn absorbing_fibre_shares(fibre: &Fibre, cos_theta: f32, left: Vec3) -> [Vec3; 2] {
    fibre_shares(fibre, cos_theta).map(|share| {
        let share = share.to_array().map(Vec3::splat);
        share[0] + left * (share[1] + left * (share[2] + left * share[3]))
    })
}

/// Light in deep fur, relative to the incident light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DiffusedLight {
    /// Light that other fibres have scattered only forward; its direction is close to that of the incident light.
    pub sent_on: Vec3,
    /// Other light that arrives from the light's side.
    pub from_light: Vec3,
    /// Light that returns from below.
    pub from_below: Vec3,
}

/// Minimum share of light whose depth is computed; the depth of 0 is infinite.
const LEAST_DIRECT: f32 = 1e-30;
/// Minimum share of light from which the depth of a point in fur is computed. Baked visibility is fitted to 24 rays. If
/// none of them reaches the light, the expected share is not 0, and at the roots of most coats near this.
pub const LEAST_BAKED: f32 = 0.01;

/// Returns the light in deep fur at a point. `direct`: share of the light, 0..=1, that reaches the point past all
/// fibres. `least`: minimum of that share, above 0, from which the point's depth is computed. `on` and `back`: shares
/// that each fibre scatters forward and backward (Kubelka and Munk 1931). The result is never negative or infinite,
/// even without absorption.
pub fn diffused_light(on: Vec3, back: Vec3, direct: f32, least: f32) -> DiffusedLight {
    let lost = (Vec3::ONE - on - back).max(Vec3::splat(1e-4));
    let decrease = (lost * (lost + 2.0 * back)).map(f32::sqrt);
    let given_back = back / (lost + back + decrease);
    let depth = direct.clamp(least, 1.0).log2();
    let arrives = (decrease * depth).map(f32::exp2);
    let sent_on = ((Vec3::ONE - on) * depth).map(f32::exp2);
    DiffusedLight {
        sent_on: (sent_on - direct).max(Vec3::ZERO),
        from_light: (arrives - sent_on).max(Vec3::ZERO),
        from_below: given_back * arrives,
    }
}

/// Returns the multiply scattered light under a light at an elevation with that sine, 0..=1, relative to a light at the
/// zenith. Proportional to the excess of Hapke's H function over 1 (after Hapke 1981).
pub fn multiple_scattering_by_height(root_lost: Vec3, sine: f32) -> Vec3 {
    let root = 2.0 * root_lost;
    sine * (1.0 + root) / (1.0 + sine * root)
}

/// Share of forward-scattered light that turns back in a sheet of free hanging hair.
const TURNED_ON: f32 = 0.15;
/// Share of backward-scattered light that turns back in a sheet of free hanging hair.
const TURNED_BACK: f32 = 0.8;
/// Share of scattered light that leaves a sheet of hanging hair at its edges.
const LEAKS: f32 = 0.12;

/// Returns the forward and backward shares of a sheet of hanging fibres for [`diffused_light`], given those of one
/// fibre. The two differ: light deflected by many fibres finally turns back, and some of it leaves the sheet at its
/// edges.
pub fn hanging_sheet_shares(sides: [Vec3; 2]) -> [Vec3; 2] {
    let back = TURNED_ON * sides[0] + TURNED_BACK * sides[1];
    [(1.0 - LEAKS) * (sides[0] + sides[1]) - back, back]
}

/// Returns the light scattered from one inclination to another, relative to a uniform distribution over all
/// inclinations. Arguments: sines of both inclinations, and the `variance` of the lobe (d'Eon 2011). The approximation
/// of I0 has an error below 2 %.
pub fn along_cone(sin_i: f32, sin_o: f32, variance: f32) -> f32 {
    let k = variance.clamp(1e-3, 1e3).recip();
    let a = k * ((1.0 - sin_i * sin_i) * (1.0 - sin_o * sin_o)).max(0.0).sqrt();
    let i0e = (1.0 + 2.0 * a + 4.2832 * a * a / (a + 0.9183) - 0.6664 * a / (1.0 + 0.3884 * a * a)).sqrt().recip();
    2.0 * k * i0e * (a - k * (1.0 + sin_i * sin_o)).exp() / (1.0 - (-2.0 * k).exp())
}

/// Returns [`along_cone`] for hair that hangs side by side, twice: for light that was scattered only forward, and for
/// other light. Parallel fibres keep light near its cone of incidence, and each scattering widens the cone (after Zinke
/// 2008). `left`: grey value from [`fibre_transmittance`]; `direct`: share of the light that passes all fibres.
pub fn hanging_cones(fibre: &Fibre, cos_i: f32, left: f32, direct: f32, sin_i: f32, sin_o: f32) -> [f32; 2] {
    let [shares_on, shares_back] = fibre_shares(fibre, cos_i);
    let light = Vec4::new(1.0, left, left * left, left * left * left);
    // The lobe of TT is half as wide as that of R, and the lobe of TRT twice as wide.
    let wide = fibre.optics[3] * Vec4::new(1.0, 0.25, 4.0, 4.0);
    // For opaque fibres, the fitted shares may be zero or negative.
    let on = shares_on.dot(light).max(1e-4);
    let all = on + shares_back.dot(light).max(0.0);
    let width = (shares_on + shares_back).dot(light * wide) / all;
    let depth = -direct.clamp(LEAST_DIRECT, 1.0).ln();
    // Mean number of forward scatterings; `sent / (1 - exp(-sent))` is the mean given that there is at least one.
    let sent = (on * depth).max(1e-3);
    let sent_on = shares_on.dot(light * wide) / on * sent / (1.0 - (-sent).exp());
    // Mean number of scatterings of light that returns from the sheet, derived from the decrease of that light with
    // growing absorption.
    let back = TURNED_ON * on + TURNED_BACK * (all - on);
    let lost = (1.0 - (1.0 - LEAKS) * all).max(1e-4);
    let met = back / (lost * (lost + 2.0 * back)).sqrt();
    let times = 1.0 + depth * all + all / back * met * (1.0 + met / 1.5) / (1.0 + met);
    [sent_on + width, (times + 1.0) * width].map(|variance| along_cone(sin_i, sin_o, variance))
}
